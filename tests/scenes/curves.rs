//! Curves and hair in shot files: what they mean, and what is said about mistakes in them.

use std::fs;

use afterimage::scene::{self, SceneError, Shot};
use glam::{DVec3, Vec3};
use tempfile::TempDir;

const REST: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n";

/// Two hairs: one of three points, and one of two with a sharp tip.
const TWO: &str = "radius 0.1\ncurve\n0 0 0\n0 1 0\n0 2 0\ncurve\n1 0 0\n1 2 0 0\n";

fn folder(curves: &str, more: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("two.curves"), TWO).unwrap();
    fs::write(folder.path().join("wrong.curves"), "curve\n0 0 zero\n").unwrap();
    fs::write(folder.path().join("short.curves"), "radius 1\ncurve\n0 0 0\ncurve\n0 0 0\n1 0 0\n").unwrap();
    let numbers = |shape: &str, values: &[f64]| {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
        let header = format!("{header:<117}\n");
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        [b"\x93NUMPY\x01\x00".as_slice(), &(header.len() as u16).to_le_bytes(), header.as_bytes()]
            .concat()
            .into_iter()
            .chain(bytes)
            .collect::<Vec<u8>>()
    };
    let points: Vec<f64> = (0..12).map(f64::from).collect();
    fs::write(folder.path().join("points.npy"), numbers("(4, 3)", &points)).unwrap();
    fs::write(folder.path().join("counts.npy"), numbers("(2,)", &[1.0, 3.0])).unwrap();
    fs::write(folder.path().join("uvs.npy"), numbers("(2, 2)", &[0.5, 0.25, 0.75, 1.0])).unwrap();
    let text = format!("{REST}[[model]]\ncurves = {{ {curves} }}\n{more}[ambient]\ncolor = [1, 1, 1]\n");
    fs::write(folder.path().join("shot.toml"), text).unwrap();
    folder
}

fn load(curves: &str, more: &str) -> Result<Shot, SceneError> {
    scene::load(&folder(curves, more).path().join("shot.toml"), false)
}

fn said(shot: &Shot) -> Vec<String> {
    shot.warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn texts_and_arrays_are_read() {
    let shot = load("file = \"two.curves\"", "").unwrap();
    let model = &shot.scene.models[0];
    assert_eq!((model.name.as_str(), model.mesh.as_curved().unwrap().count()), ("two", 3));
    let (low, high) = model.mesh.bounds();
    assert!((low - DVec3::new(-0.1, -0.1, -0.1)).abs().max_element() < 1e-5, "{low}");
    assert!((high - DVec3::new(1.1, 2.1, 0.1)).abs().max_element() < 1e-5, "{high}");
    assert_eq!(said(&shot), [""; 0]);
    let pairs = "file = \"points.npy\", counts = 2, radius = 0.5, tip = 0.1, basis = \"catmull-rom\"";
    assert_eq!(load(pairs, "").unwrap().scene.models[0].mesh.as_curved().unwrap().count(), 2);
    let shot =
        load("file = \"points.npy\", counts = \"counts.npy\", uvs = \"uvs.npy\", radius = 0.5", "").unwrap();
    let curved = shot.scene.models[0].mesh.as_curved().unwrap();
    assert_eq!((curved.count(), curved.uv(0, [0.3, 0.0]).to_array()), (2, [0.75, 1.0]));
    let told = said(&shot);
    assert!(told[0].contains("1 curve is left out: with another number of points"), "{told:?}");
}

#[test]
fn hair_has_the_colour_of_its_pigments() {
    let of = |hair: &str| {
        let more = format!("[[material]]\nname = \"hair\"\nkd = [0.9, 0.5, 0.2]\nhair = {{ {hair} }}\n");
        let shot = load("file = \"two.curves\", material = \"hair\"", &more).unwrap();
        let material = &shot.scene.materials[usize::from(shot.scene.models[0].mesh.material_of[0])];
        (material.hair.unwrap(), material.metal_rough.unwrap().base, material.diffuse)
    };
    let (hair, color, diffuse) = of("roughness = 0.5, offset = 3");
    assert_eq!((hair.roughness, hair.radial_roughness, diffuse), (0.5, 0.3, Vec3::ZERO));
    assert!((hair.offset - 3.0_f32.to_radians()).abs() < 1e-6);
    assert!((color - Vec3::new(0.9, 0.5, 0.2)).abs().max_element() < 1e-6);
    // what absorbs nothing is white, and melanin darkens blue most of all
    assert!((of("absorption = [0, 0, 0]").1 - Vec3::ONE).abs().max_element() < 1e-6);
    let [fair, dark] = [0.2, 0.8].map(|melanin| of(&format!("melanin = {melanin}")).1);
    assert!(fair.x > fair.y && fair.y > fair.z && fair.x > 2.0 * dark.x, "{fair} {dark}");
    let dyed = of("melanin = 0.2, tint = [0.1, 0.9, 0.9]").1;
    assert!(dyed.x < 0.5 * fair.x && dyed.z > 0.5 * fair.z, "{dyed}");
}

#[test]
fn mistakes_are_told_with_their_place() {
    for (curves, more, wanted) in [
        ("file = \"none.curves\"", "", "shot.toml:6:19: `file`: there is no file `none.curves`"),
        ("file = \"wrong.curves\"", "", "wrong.curves:2: `zero` is no number"),
        ("file = \"two.curves\", counts = 2", "", "`counts` goes with an array of points"),
        ("file = \"two.curves\", tip = 0.1", "", "`tip` goes with `radius`"),
        ("file = \"points.npy\", radius = 1", "", "the key `counts` is missing"),
        ("file = \"points.npy\", counts = 3, radius = 1", "", "`counts` is 3, and the array has 4 points"),
        ("file = \"points.npy\", counts = 2", "", "the key `radius` is missing"),
        ("file = \"points.npy\", counts = \"uvs.npy\", radius = 1", "", "the counts must be whole numbers"),
        (
            "file = \"points.npy\", counts = 2, uvs = \"counts.npy\", radius = 1",
            "",
            "two finite numbers a curve",
        ),
        ("file = \"counts.npy\", counts = 2", "", "it must be (points, 3), or (points, 4) with radii"),
        ("file = \"two.curves\", material = \"fur\"", "", "there is no [[material]] `fur`"),
        ("file = \"two.curves\"", "obj = \"a.obj\"\n", "`obj` and `curves` exclude each other"),
        ("file = \"two.curves\"", "shapes = { obj = \"a.##.obj\" }\n", "and curves have none"),
        (
            "file = \"two.curves\"",
            "[[material]]\nname = \"a\"\nhair = { tint = [1, 1, 1] }\n",
            "`tint` goes with `melanin`",
        ),
        (
            "file = \"two.curves\"",
            "[[material]]\nname = \"a\"\nhair = { melanin = 0.5, absorption = [1, 1, 1] }\n",
            "`melanin` exclude each other",
        ),
        ("file = \"two.curves\"", "[[material]]\nname = \"a\"\nhair = { roughness = 2 }\n", "from 0 to 1"),
    ] {
        let error = load(curves, more).map(|_| ()).expect_err(curves).to_string();
        assert!(error.contains(wanted), "{curves} {more}: {error}");
    }
    let told = said(&load("file = \"short.curves\"", "").unwrap());
    assert!(told.len() == 1 && told[0].contains("1 curve is left out"), "{told:?}");
}
