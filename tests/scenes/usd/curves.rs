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
