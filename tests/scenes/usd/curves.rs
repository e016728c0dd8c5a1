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

#[test]
fn what_deforms_is_shown_at_each_of_its_times() {
    let prims = "def BasisCurves \"Hair\" {\nuniform token type = \"linear\"\nint[] curveVertexCounts = [2]\n\
        float[] widths = [0.5] (interpolation = \"constant\")\n\
        point3f[] points.timeSamples = { 1: [(0, 0, 0), (0, 1, 0)], 2: [(0, 0, 0), (0, 2, 0)] }\n}\n";
    let shot = load(METRES, prims).unwrap();
    let there = |frame: f64| -> Vec<bool> {
        let curves = shot.scene.models.iter().filter(|model| model.mesh.is_curved());
        curves.map(|model| model.track.visible.at(frame)).collect()
    };
    assert_eq!((there(1.0), there(2.0)), (vec![true, false], vec![false, true]));
    assert!(shot.warnings.iter().any(|told| told.to_string().contains("curves that deform")));
}

#[test]
fn lists_that_do_not_fit_are_told() {
    let shot = load(METRES, &curves("float[] widths = [1, 2] (interpolation = \"vertex\")")).unwrap();
    assert!(shot.warnings.iter().any(|told| told.to_string().contains("no widths that fit")));
    let wrong = "def BasisCurves \"Hair\" {\npoint3f[] points = [(0, 0, 0), (0, 1, 0)]\nint[] curveVertexCounts = [9]\n}\n";
    assert!(load(METRES, wrong).is_err(), "there is nothing else to see");
}
