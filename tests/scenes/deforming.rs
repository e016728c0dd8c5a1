//! Shapes of deforming models in shot files: is every key read, and every mistake told with its place?

use std::fs;
use std::path::Path;

use afterimage::animation::Chord;
use afterimage::pose::Pose;
use afterimage::scene::{self, Shot};
use tempfile::TempDir;

const SHOT: &str =
    "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"rest.obj\"\n";

/// A square of two triangles, each with texture coordinates of its own: six vertices at four places.
const REST: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1/2/1 3/2/1 4/2/1\n";

/// Its positions alone, moved; with other parts, that are not read.
fn moved(by: f32) -> String {
    let at = |x: f32, y: f32| format!("v {} {} {}\n", x, y, by);
    format!("# a shape\nvn 1 0 0\n{}{}{}{}f 4 3 2\n", at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0))
}

/// The square with shapes 3, 4 and 8, at heights 1, 2 and 1.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rest.obj"), REST).unwrap();
    fs::create_dir(folder.path().join("shapes")).unwrap();
    for (number, by) in [(3, 1.0), (4, 2.0), (8, 1.0)] {
        fs::write(folder.path().join(format!("shapes/flag.{number:04}.obj")), moved(by)).unwrap();
    }
    folder
}

fn load(folder: &Path, shapes: &str) -> Result<Shot, String> {
    let path = folder.join("s.toml");
    fs::write(&path, format!("{SHOT}{shapes}\n")).unwrap();
    scene::load(&path, true).map_err(|error| error.to_string())
}

/// The height of the square's corners at a frame.
fn height(shot: &Shot, frame: i32) -> f32 {
    let mesh = &shot.scene.models[0].mesh;
    let shape = Pose::new(&shot.scene, frame).models[0].shape;
    let heights = mesh.shapes().unwrap().positions(&shape.ends[0]);
    assert_eq!((heights.len(), mesh.triangles().positions.as_slice().len()), (6, 6));
    assert!(heights.iter().all(|at| at[2] == heights[0][2]));
    heights[0][2]
}

#[test]
fn shapes_are_those_of_the_numbered_files() {
    let folder = folder();
    let shot = load(folder.path(), "shapes = { obj = \"shapes/flag.####.obj\" }").unwrap();
    let heights = [1, 3, 4, 5, 6, 8, 9].map(|frame| height(&shot, frame));
    assert_eq!(heights, [1.0, 1.0, 2.0, 1.75, 1.5, 1.0, 1.0], "the gap is bridged");
    assert_eq!(
        Pose::new(&shot.scene, 3).models[0].shape,
        Pose::new(&shot.scene, 9).models[0].shape,
        "they are equal"
    );
    assert!(!shot.scene.models[0].track.is_constant());
    assert_eq!(shot.scene.models[0].mesh.shapes().unwrap().list().len(), 2);
    assert_eq!(shot.files.iter().filter(|file| file.to_string_lossy().contains("flag.")).count(), 3);
}

#[test]
fn they_begin_and_follow_each_other_as_the_shot_says() {
    let folder = folder();
    let heights = |keys: &str, frames: [i32; 4]| {
        let shot =
            load(folder.path(), &format!("shapes = {{ obj = \"shapes/flag.####.obj\", {keys} }}")).unwrap();
        frames.map(|frame| height(&shot, frame))
    };
    assert_eq!(heights("first = 10", [9, 10, 11, 13]), [1.0, 1.0, 2.0, 1.5]);
    assert_eq!(heights("first = 10, every = 2", [10, 11, 12, 16]), [1.0, 1.5, 2.0, 1.5]);
    // 3 to 8, and one on to the first again
    assert_eq!(heights("repeat = true", [8, 9, 10, 12]), [1.0, 1.0, 2.0, 1.5]);
    assert_eq!(heights("repeat = true", [3000 * 6 + 3, 3000 * 6 + 4, 2, -90]), [1.0, 2.0, 1.0, 1.0]);
}

#[test]
fn a_group_of_digits_means_files_as_wide_as_it() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rest.obj"), REST).unwrap();
    for name in ["w_09.obj", "w_10.obj", "w_100.obj", "w_0101.obj", "w_1x.obj", "w_9.obj", "w_11.obj.bak"] {
        fs::write(folder.path().join(name), moved(1.0)).unwrap();
    }
    let shot = load(folder.path(), "shapes = { obj = \"w_##.obj\" }").unwrap();
    let ends = shot.scene.models[0].track.shapes.as_ref().unwrap().ends();
    assert_eq!((ends, shot.files.len()), ([9.0, 100.0], 5));
    assert_eq!(Pose::new(&shot.scene, 50).models[0].shape, Chord::FIRST);
}

#[test]
fn models_of_the_same_files_share_them() {
    let folder = folder();
    let shapes = "shapes = { obj = \"shapes/flag.####.obj\" }";
    let shot = load(
        folder.path(),
        &format!("{shapes}\n[[model]]\nobj = \"rest.obj\"\nshapes = {{ obj = \"shapes/flag.####.obj\", first = 7 }}\n[[model]]\nobj = \"rest.obj\""),
    )
    .unwrap();
    let [one, other, rigid] = &shot.scene.models[..] else { panic!("three models") };
    assert!(std::sync::Arc::ptr_eq(&one.mesh, &other.mesh) && rigid.mesh.shapes().is_none());
    assert!(rigid.track.is_constant());
}

/// What makes other pictures makes another digest: a shape that is edited, comes or goes, or gets another number.
#[test]
fn a_shot_is_another_when_its_shapes_are() {
    let folder = folder();
    let inputs =
        || load(folder.path(), "shapes = { obj = \"shapes/flag.####.obj\" }").unwrap().content.inputs;
    let file = |number: u32| folder.path().join(format!("shapes/flag.{number:04}.obj"));
    let mut known = vec![inputs()];
    let mut is_new = || {
        let now = inputs();
        let new = !known.contains(&now);
        known.push(now);
        new
    };
    assert!(!is_new());
    fs::write(file(4), moved(3.0)).unwrap();
    assert!(is_new());
    fs::rename(file(8), file(9)).unwrap();
    assert!(is_new());
    fs::remove_file(file(9)).unwrap();
    assert!(is_new());
}

#[test]
fn what_makes_no_sense_is_told_with_its_place() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("short.1.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n");
    write("far.1.obj", "v 0 0 0\nv 1 0 0\n\nv 1 1e30 0\nv 0 1 0\n");
    write("nan.1.obj", "v 0 0 0\nv nan 0 0\nv 1 1 0\nv 0 1 0\n");
    write("odd.1.obj", "v 0 0 0\nv 1 0\n");
    for (shapes, expected) in [
        ("shapes = { obj = \"flag.obj\" }", "s.toml:7:18: `obj` must have one group of `#`"),
        ("shapes = { obj = \"f#l#.obj\" }", "s.toml:7:18: `obj` must have one group of `#`"),
        ("shapes = { obj = \"f.##.obj\" }", "s.toml:7:18: `obj` means no file in"),
        ("shapes = { obj = \"none/f.##.obj\" }", "cannot be read"),
        (
            "shapes = { first = 1 }",
            "s.toml:7:10: `shapes`: the key `obj` is missing: shapes are OBJ files, or a point cache",
        ),
        (
            "shapes = { obj = \"shapes/flag.####.obj\", every = 0 }",
            "`every` is 0: it must be from 1e-6 to 1e6 frames",
        ),
        ("shapes = { obj = \"shapes/flag.####.obj\", first = nan }", "it must be a frame's number"),
        (
            "shapes = { obj = \"shapes/flag.####.obj\", last = 5 }",
            "unknown key `last` (known here: obj, cache, curves, first, every, repeat)",
        ),
        ("shapes = { obj = \"short.#.obj\" }", "short.1.obj: this shape has 3 positions, and"),
        (
            "shapes = { obj = \"far.#.obj\" }",
            "far.1.obj:4: the position [1.0, 1e30, 0.0] is not finite, or farther",
        ),
        ("shapes = { obj = \"nan.#.obj\" }", "nan.1.obj:2: the position [NaN, 0.0, 0.0] is not finite"),
        ("shapes = { obj = \"odd.#.obj\" }", "odd.1.obj:2: `v` takes three numbers"),
        (
            "[[model]]\nquadric = { type = \"sphere\" }\nshapes = { obj = \"a.#.obj\" }",
            "s.toml:9:10: `shapes` are those of an OBJ file",
        ),
    ] {
        let error = load(folder.path(), shapes).unwrap_err();
        assert!(error.contains(expected), "{shapes}: {error}");
    }
}

/// A square at these heights as a point cache.
fn mdd(heights: &[f32]) -> Vec<u8> {
    let mut bytes = [heights.len() as i32, 4].map(i32::to_be_bytes).concat();
    bytes.extend((0..heights.len()).flat_map(|sample| (sample as f32 / 24.0).to_be_bytes()));
    bytes.extend(points(heights).into_iter().flat_map(f32::to_be_bytes));
    bytes
}

fn pc2(heights: &[f32], first: f32, every: f32) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend([1, 4].into_iter().flat_map(i32::to_le_bytes));
    bytes.extend([first, every].into_iter().flat_map(f32::to_le_bytes));
    bytes.extend((heights.len() as i32).to_le_bytes());
    bytes.extend(points(heights).into_iter().flat_map(f32::to_le_bytes));
    bytes
}

fn points(heights: &[f32]) -> Vec<f32> {
    let square = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [1.0, 1.0, z], [0.0, 1.0, z]].concat();
    heights.iter().flat_map(|height| square(*height)).collect()
}

#[test]
fn point_caches_have_a_shape_a_sample() {
    let folder = folder();
    let heights = |file: &str, bytes: Vec<u8>, keys: &str, frames: [i32; 4]| {
        fs::write(folder.path().join(file), bytes).unwrap();
        let shot = load(folder.path(), &format!("shapes = {{ cache = \"{file}\"{keys} }}")).unwrap();
        frames.map(|frame| height(&shot, frame))
    };
    let three = [1.0, 2.0, 4.0];
    assert_eq!(heights("a.mdd", mdd(&three), "", [0, 1, 2, 9]), [1.0, 1.0, 2.0, 4.0]);
    assert_eq!(heights("a.mdd", mdd(&three), ", first = 5, every = 2", [5, 6, 7, 8]), [1.0, 1.5, 2.0, 3.0]);
    assert_eq!(heights("a.pc2", pc2(&three, 3.0, 2.0), "", [3, 4, 5, 9]), [1.0, 1.5, 2.0, 4.0]);
    assert_eq!(
        heights("a.pc2", pc2(&three, 3.0, 0.0), ", repeat = true", [3, 4, 5, 7]),
        [1.0, 2.0, 4.0, 2.0]
    );
}

#[test]
fn point_caches_that_do_not_fit_are_refused() {
    let folder = folder();
    let three = [1.0, 2.0, 4.0];
    let mut long = pc2(&three, 1.0, 1.0);
    long.push(0);
    let mut points = mdd(&three);
    points[7] = 5;
    let mut nan = mdd(&three);
    let end = nan.len();
    nan[end - 4..].copy_from_slice(&f32::NAN.to_be_bytes());
    let other = [&2_i32.to_be_bytes()[..], &1_i32.to_be_bytes(), &[0; 32]].concat();
    for (bytes, expected) in [
        (
            mdd(&three)[..100].to_vec(),
            "a.cache: the point cache says that it has 3 samples of 4 points, which take 164 bytes, and it has 100",
        ),
        (long, "which take 176 bytes, and it has 177: it is cut off"),
        (points, "samples of 5 points"),
        (other, "a.cache: this shape has 1 positions, and"),
        (nan, "NaN] is not finite"),
        (vec![], "a.cache: this is no point cache"),
        (b"POINTCACHE2\0".to_vec(), "a.cache: this is no point cache"),
        (pc2(&[], 1.0, 1.0), "a.cache: the point cache is empty"),
        (pc2(&three, 1.0, 1e-9), "the cache has a sample every 0.000000000999"),
        (vec![255; 64], "a.cache: this is no point cache"),
    ] {
        fs::write(folder.path().join("a.cache"), bytes).unwrap();
        let error = load(folder.path(), "shapes = { cache = \"a.cache\" }").unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    let error = load(folder.path(), "shapes = { cache = \"no.mdd\" }").unwrap_err();
    assert!(error.contains("`cache`: there is no file `no.mdd`"), "{error}");
    let error = load(folder.path(), "shapes = { cache = \"a.cache\", obj = \"a.#.obj\" }").unwrap_err();
    assert!(error.contains("`cache` and `obj` exclude each other"), "{error}");
}

#[test]
fn a_model_is_as_large_as_all_its_shapes() {
    let folder = folder();
    fs::write(folder.path().join("shapes/flag.0008.obj"), moved(50.0)).unwrap();
    let shot = load(folder.path(), "shapes = { obj = \"shapes/flag.####.obj\" }").unwrap();
    let (low, high) = shot.scene.models[0].mesh.bounds();
    assert_eq!((low.z, high.z), (1.0, 50.0), "the shape at rest is seen nowhere");
}

#[test]
fn numbers_of_shapes_may_be_negative() {
    let folder = folder();
    for (number, by) in [("-002", 5.0), ("-0001", 7.0), ("0000", 3.0)] {
        fs::write(folder.path().join(format!("shapes/flag.{number}.obj")), moved(by)).unwrap();
    }
    let shot = load(folder.path(), "shapes = { obj = \"shapes/flag.####.obj\" }").unwrap();
    assert_eq!([-3, -2, -1, 0, 3].map(|frame| height(&shot, frame)), [5.0, 5.0, 7.0, 3.0, 1.0]);
    fs::write(folder.path().join("shapes/flag.-001.obj"), moved(1.0)).unwrap();
    let error = load(folder.path(), "shapes = { obj = \"shapes/flag.####.obj\" }").unwrap_err();
    assert!(error.contains("s.toml:7") && error.contains("the number -1, `flag.-00"), "{error}");
}
