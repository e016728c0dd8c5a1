//! Curves of USD files: are they where their points and widths say, whatever their basis?

use super::*;

const FOUR: &str =
    "point3f[] points = [(0, 0, 0), (0, 1, 0), (0, 2, 0), (0, 3, 0)]\nint[] curveVertexCounts = [4]\n";

fn curves(more: &str) -> String {
    format!("def BasisCurves \"Hair\" {{\n{FOUR}{more}\n}}\n")
}

#[test]
fn curves_of_all_bases_are_shown() {
    for (how, low, high) in [
        ("uniform token type = \"linear\"", 0.0, 3.0),
        ("uniform token type = \"cubic\"", 0.0, 3.0),
        ("uniform token basis = \"bspline\"", 1.0, 2.0),
        ("uniform token basis = \"catmullRom\"", 1.0, 2.0),
        ("uniform token basis = \"catmullRom\"\nuniform token wrap = \"pinned\"", 0.0, 3.0),
    ] {
        let widths = "float[] widths = [0.5] (interpolation = \"constant\")\n";
        let shot = shown(METRES, &curves(&format!("{widths}{how}")));
        let mesh = &shot.scene.models[0].mesh;
        let (found_low, found_high) = mesh.bounds();
        let off = (found_low.y - (low - 0.25)).abs().max((found_high.y - (high + 0.25)).abs());
        assert!(mesh.is_curved() && off < 1e-5, "{how}: {found_low} {found_high}");
    }
}

#[test]
fn widths_and_colours_are_theirs() {
    let more = "uniform token type = \"linear\"\nfloat[] widths = [1, 0.5, 0.5, 0.2] (interpolation = \"vertex\")\n\
        color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1)] (interpolation = \"vertex\")\n";
    let shot = shown(METRES, &curves(more));
    let mesh = &shot.scene.models[0].mesh;
    let (low, high) = mesh.bounds();
    assert!((low.x + 0.5).abs() < 1e-5 && (high.y - 3.1).abs() < 1e-5, "{low} {high}");
    assert_eq!(mesh.details.colors.len(), 4);
}

/// Hairs with times of their points and of their widths.
fn with_times(points: &str, more: &str) -> String {
    format!(
        "def BasisCurves \"Hair\" {{\nuniform token type = \"linear\"\npoint3f[] points.timeSamples = {{ {points} }}\n{more}\n}}\n"
    )
}

#[test]
fn what_deforms_has_shapes_at_all_its_times() {
    let points = "1: [(0, 0, 0), (0, 1, 0)], 3: [(0, 0, 0), (0, 2, 0)]";
    let more = "int[] curveVertexCounts = [2]\n\
        float[] widths.timeSamples = { 1: [0.5, 0.5], 2: [0.5, 1] }";
    let shot = shown(METRES, &with_times(points, more));
    let hairs: Vec<_> = shot.scene.models.iter().filter(|model| model.mesh.is_curved()).collect();
    let model = hairs[0];
    let curves = model.mesh.as_curved().unwrap();
    assert_eq!((hairs.len(), curves.shapes()), (1, 3));
    let track = model.track.shapes.as_ref().unwrap();
    assert_eq!(track.ends(), [1.0, 3.0]);
    let highest = |frame: f64| {
        let shape = track.at(frame);
        curves.between(&[shape; 2], &[0.0])[0].bounds(0).high.y
    };
    for (frame, wanted) in [(1.0, 1.25), (1.5, 1.625), (2.0, 2.0), (3.0, 2.5), (9.0, 2.5)] {
        assert!((highest(frame) - wanted).abs() < 1e-5, "{frame}: {}", highest(frame));
    }
}

#[test]
fn hairs_that_become_others_are_models_of_their_own() {
    let points = "1: [(0, 0, 0), (0, 1, 0)], 2: [(0, 0, 0), (0, 2, 0)], 3: [(0, 0, 0), (0, 2, 0), (0, 3, 0)]";
    let more = "int[] curveVertexCounts.timeSamples = { 1: [2], 3: [3] }\n\
        float[] widths = [0.5] (interpolation = \"constant\")";
    let shot = load(METRES, &with_times(points, more)).unwrap();
    let hairs: Vec<_> = shot.scene.models.iter().filter(|model| model.mesh.is_curved()).collect();
    let there = |frame: f64| -> Vec<bool> { hairs.iter().map(|one| one.track.visible.at(frame)).collect() };
    assert_eq!(
        (there(1.0), there(2.9), there(3.0)),
        (vec![true, false], vec![true, false], vec![false, true])
    );
    assert_eq!(hairs[0].mesh.as_curved().unwrap().shapes(), 2);
    assert!(shot.warnings.iter().any(|told| told.to_string().contains("changes with time")));
}

#[test]
fn points_are_balls_of_their_widths() {
    let points = "def Points \"Beads\" {\npoint3f[] points = [(0, 0, 0), (3, 0, 0)]\nfloat[] widths = [1, 0.5]\n\
        color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (interpolation = \"vertex\")\n}\n";
    let shot = shown(METRES, points);
    let mesh = &shot.scene.models[0].mesh;
    let curved = mesh.as_curved().unwrap();
    let (low, high) = mesh.bounds();
    assert!(low.abs_diff_eq(DVec3::new(-0.5, -0.5, -0.5), 1e-5), "{low}");
    assert!(high.abs_diff_eq(DVec3::new(3.25, 0.5, 0.5), 1e-5), "{high}");
    assert_eq!((curved.count(), mesh.details.colors.len()), (2, 4));
    let three = points.replace("(3, 0, 0)]", "(3, 0, 0), (6, 0, 0)]").replace("[1, 0.5]", "[1, 0.5, 3]");
    let plain = load(METRES, &three).unwrap();
    let told: Vec<String> = plain.warnings.iter().map(ToString::to_string).collect();
    assert!(
        told.len() == 1 && told[0].contains("`primvars:displayColor` of /Beads does not fit its points"),
        "{told:?}"
    );
}

/// Sparks that come and go: each list of them goes on by its velocities until the next one is there.
#[test]
fn points_that_come_and_go_move_by_their_velocities() {
    let points = "def Points \"Sparks\" {\npoint3f[] points.timeSamples = { 1: [(0, 0, 0)], 2: [(1, 0, 0), (5, 0, 0)] }\n\
        vector3f[] velocities.timeSamples = { 1: [(24, 0, 0)], 2: [(0, 48, 0), (0, 0, 0)] }\n\
        float[] widths = [1] (interpolation = \"constant\")\n}\n";
    let shot = load(METRES, points).unwrap();
    let sparks: Vec<_> = shot.scene.models.iter().filter(|model| model.mesh.is_curved()).collect();
    let at = |number: usize, frame: f64| {
        let model = sparks[number];
        let shape = model.track.shapes.as_ref().unwrap().at(frame);
        let ball = model.mesh.as_curved().unwrap().between(&[shape; 2], &[0.0])[0].bounds(0);
        ((ball.low + ball.high) * 0.5).as_dvec3()
    };
    // a unit a frame, at 24 frames a second, and two
    for (number, frame, place) in [
        (0, 1.0, DVec3::ZERO),
        (0, 1.5, DVec3::X * 0.5),
        (1, 2.0, DVec3::X),
        (1, 2.5, DVec3::new(1.0, 1.0, 0.0)),
    ] {
        assert!(at(number, frame).abs_diff_eq(place, 1e-5), "{number} {frame}: {}", at(number, frame));
    }
    assert!(!sparks[0].track.visible.at(2.0) && sparks[1].track.visible.at(2.0));
    let bad = load(METRES, &points.replace("(0, 48, 0), (0, 0, 0)", "(0, 48, 0)")).unwrap();
    assert!(
        bad.warnings
            .iter()
            .any(|told| told.to_string().contains("`velocities` of /Sparks does not fit its points"))
    );
}

#[test]
fn curves_with_normals_are_strips() {
    let more = "uniform token type = \"linear\"\nfloat[] widths = [1] (interpolation = \"constant\")\n\
        normal3f[] normals = [(0, 0, 1)] (interpolation = \"constant\")\n";
    let shot = shown(METRES, &curves(more));
    let mesh = &shot.scene.models[0].mesh;
    let (low, high) = mesh.bounds();
    let wanted = [[-0.5, 0.0, 0.0], [0.5, 3.0, 0.0]];
    assert_eq!([low.to_array(), high.to_array()], wanted);
    let triangles = mesh.as_triangles().unwrap();
    assert!(triangles.normals.iter().all(|normal| *normal == glam::Vec3::Z), "{:?}", triangles.normals);
    let left_handed = shown(METRES, &curves(&format!("{more}uniform token orientation = \"leftHanded\"\n")));
    let normals = &left_handed.scene.models[0].mesh.as_triangles().unwrap().normals;
    assert!(normals.iter().all(|normal| *normal == -glam::Vec3::Z));
}

#[test]
fn strips_deform() {
    let points = "1: [(0, 0, 0), (0, 1, 0)], 3: [(0, 0, 0), (0, 2, 0)]";
    let more = "int[] curveVertexCounts = [2]\nfloat[] widths = [1] (interpolation = \"constant\")\n\
        normal3f[] normals = [(0, 0, 1)] (interpolation = \"constant\")";
    let shot = shown(METRES, &with_times(points, more));
    assert_eq!(shot.scene.models[0].mesh.shapes().unwrap().list().len(), 2);
}

#[test]
fn lists_that_do_not_fit_are_told() {
    let shot = load(METRES, &curves("float[] widths = [1, 2] (interpolation = \"vertex\")")).unwrap();
    assert!(shot.warnings.iter().any(|told| told.to_string().contains("no widths that fit")));
    let wrong = "def BasisCurves \"Hair\" {\npoint3f[] points = [(0, 0, 0), (0, 1, 0)]\nint[] curveVertexCounts = [9]\n}\n";
    assert!(load(METRES, wrong).is_err(), "there is nothing else to see");
}
