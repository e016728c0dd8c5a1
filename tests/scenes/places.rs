//! Places of a model's copies: is each copy where the array says, and every mistake told with its place?

use std::fs;
use std::path::Path;

use afterimage::scene::{self, Shot};
use glam::DVec3;
use tempfile::TempDir;

const SHOT: &str =
    "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"one.obj\"\n";

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// Rows of a matrix that moves by `x` along X.
fn moved(x: f64) -> [f64; 12] {
    [1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]
}

const AWAY: [f64; 12] = [0.0; 12];

/// A file as numpy.save writes it.
fn npy(shape: &str, matrices: &[[f64; 12]]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(matrices.as_flattened().iter().flat_map(|number| number.to_le_bytes()));
    bytes
}

fn folder(array: &[u8]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("one.obj"), OBJ).unwrap();
    fs::write(folder.path().join("at.npy"), array).unwrap();
    fs::write(folder.path().join("names.txt"), "left\nright\n").unwrap();
    folder
}

fn load(folder: &Path, more: &str) -> Result<Shot, String> {
    let path = folder.join("s.toml");
    fs::write(&path, format!("{SHOT}{more}\n")).unwrap();
    scene::load(&path, true).map_err(|error| error.to_string())
}

/// Where the mesh's origin is at a frame, along X and in the units of the files; none while the copy is not there.
fn along_x(shot: &Shot, copy: usize, frame: f64) -> Option<f64> {
    let track = &shot.scene.models[copy].track;
    let at = |point| track.map_at(frame).transform_point3(point);
    track.visible.at(frame).then(|| {
        let unit = at(DVec3::X).distance(at(DVec3::ZERO));
        let first = shot.scene.models[0].track.map_at(1.0).transform_point3(DVec3::ZERO);
        ((at(DVec3::ZERO).x - first.x) / unit * 1e6).round() / 1e6
    })
}

#[test]
fn a_copy_is_in_each_place_of_an_array() {
    let folder = folder(&npy("(2, 3, 4)", &[moved(0.0), moved(2.5)]));
    let shot = load(folder.path(), "places = { file = \"at.npy\" }").unwrap();
    let names: Vec<&str> = shot.scene.models.iter().map(|model| &*model.name).collect();
    assert_eq!(names, ["one/1", "one/2"]);
    assert!(shot.files.iter().any(|file| file.ends_with("at.npy")));
    let named = load(folder.path(), "places = { file = \"at.npy\", names = \"names.txt\" }").unwrap();
    assert_eq!(named.scene.models[1].name, "right");
    // resting copies may be baked, so that their vertices are what is moved
    let least = |copy: usize| {
        let model = &shot.scene.models[copy];
        let x = model.mesh.bounds().0.x;
        model.track.map_at(1.0).transform_point3(DVec3::X * x).x
    };
    let width = |copy: usize| {
        let (low, high) = shot.scene.models[copy].mesh.bounds();
        high.x - low.x
    };
    assert!(((least(1) - least(0)) / width(0) - 2.5).abs() < 1e-5);
}

#[test]
fn a_copy_moves_through_its_keys_and_is_away_where_they_are_zero() {
    let keys =
        [moved(0.0), moved(1.0), AWAY, moved(8.0), moved(9.0), AWAY, AWAY, AWAY, moved(3.0), moved(4.0)];
    let folder = folder(&npy("(2, 5, 3, 4)", &keys));
    let shot = load(folder.path(), "places = { file = \"at.npy\", first = 10, every = 2 }").unwrap();
    let frames = [1.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.5, 16.0, 17.0, 18.0, 40.0];
    let left = frames.map(|frame| along_x(&shot, 0, frame));
    let there = [0.0, 0.0, 0.5, 1.0, 1.0].map(Some);
    let back = [8.0, 8.5, 9.0, 9.0].map(Some);
    assert_eq!(left, [&there[..], &[None, None], &back].concat()[..], "it stays until it is gone");
    let right = frames.map(|frame| along_x(&shot, 1, frame));
    assert_eq!(right[..7], [None; 7]);
    assert_eq!(right[7..], [3.0, 3.5, 4.0, 4.0].map(Some));
}

#[test]
fn copies_go_along_with_what_moves_the_model() {
    let folder = folder(&npy("(1, 2, 3, 4)", &[moved(0.0), moved(1.0)]));
    let shot = load(folder.path(), "places = { file = \"at.npy\" }\nscale = 3\nvisible = true").unwrap();
    assert_eq!(along_x(&shot, 0, 2.0), Some(1.0), "in the units of what is scaled");
    let gone = load(folder.path(), "places = { file = \"at.npy\" }\nvisible = false").unwrap();
    assert!(gone.scene.models.is_empty());
}

#[test]
fn places_that_make_no_sense_are_told() {
    let two = [moved(0.0), moved(2.5)];
    let mirrored = [-1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut nan = moved(0.0);
    nan[5] = f64::NAN;
    let flat = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    for (array, more, expected) in [
        (npy("(24,)", &two), "", "at.npy: the array's shape is [24]: it must be (copies, 3, 4)"),
        (npy("(1, 2, 12)", &two), "", "the array's shape is [1, 2, 12]"),
        (npy("(2, 0, 3, 4)", &[]), "", "the array's shape is [2, 0, 3, 4]"),
        (npy("(3, 3, 4)", &two), "", "at.npy: the array says that its shape is [3, 3, 4]"),
        (b"no array".to_vec(), "", "at.npy: this is no array of NumPy's"),
        (
            npy("(1, 2, 3, 4)", &[two[0], mirrored]),
            "",
            "at.npy: copy 0, counted from 0: it is flat, or turned inside out, at frame 2",
        ),
        (
            npy("(2, 3, 4)", &[two[0], nan]),
            "",
            "copy 1, counted from 0: the matrix of frame 1 must have finite numbers alone",
        ),
        (npy("(1, 3, 4)", &[flat]), "", "the matrix of frame 1 makes the model flat"),
        (npy("(2, 3, 4)", &two), ", every = 2", "`every` goes with an array of copies x keys x 3 x 4"),
        (npy("(1, 2, 3, 4)", &two), ", every = 0", "`every` is 0: it must be from 1e-6 to 1e6 frames"),
        (npy("(1, 2, 3, 4)", &two), ", first = 2147483647", "the frames of the keys are too large"),
        (
            npy("(1, 2, 3, 4)", &two),
            ", names = \"names.txt\"",
            "names.txt: it has 2 lines, and there are 1 copies",
        ),
        (npy("(1, 2, 3, 4)", &two), ", names = \"none.txt\"", "there is no file `none.txt`"),
    ] {
        let folder = folder(&array);
        let error = load(folder.path(), &format!("places = {{ file = \"at.npy\"{more} }}")).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let folder = folder(&npy("(2, 3, 4)", &two));
    for (more, expected) in [
        (
            "places = { file = \"at.npy\" }\nmatrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]",
            "s.toml:8:10: `matrix` and `places` exclude each other",
        ),
        ("places = { file = \"at.npy\" }\n[[model.key]]\nframe = 1", "`key` and `places` exclude each other"),
        ("places = { }", "the key `file` is missing"),
    ] {
        let error = load(folder.path(), more).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
}
