//! Is the camera of a shot the one of a glTF file that it names, or that the command line names?

use super::*;
use afterimage::scene::turntable::Options;

/// A triangle, and two cameras that both animations move.
fn filmed() -> File {
    let mut file = File::new();
    let mesh = file.triangle();
    file.root(json!({"mesh": mesh}));
    let lens = |yfov: f64| json!({"yfov": yfov, "aspectRatio": 2, "znear": 0.1});
    file.json["cameras"] = json!([
        {"type": "perspective", "perspective": lens(1.0), "name": "wide"},
        {"type": "perspective", "perspective": lens(0.5), "name": "Lens#2"}]);
    let eye = file.root(json!({"camera": 0, "name": "Eye", "translation": [0, 0, 8]}));
    file.root(json!({"camera": 1, "name": "Side", "translation": [9, 0, 0]}));
    let [near, far] = [2.0, 20.0].map(|z| file.vectors(&[[0.0, 0.0, 8.0], [0.0, 0.0, z]]));
    file.animate(eye, "translation", "LINEAR", &[0.0, 1.0], near);
    let mut other = file.json["animations"][0].clone();
    (other["name"], other["samplers"][0]["output"]) = (json!("Far"), json!(far));
    file.add("animations", other);
    file
}

fn shot_with(camera: &str) -> Result<Shot, String> {
    let folder = folder(&filmed());
    let text =
        format!("[render]\nrate = 10\n[camera]\n{camera}\n[[model]]\nquadric = {{ type = \"sphere\" }}\n");
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(&path, true)
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn eye_at(shot: &Shot, frame: i32) -> Vec3 {
    Pose::new(&shot.scene, frame).camera.eye
}

#[test]
fn a_shot_takes_a_camera_with_its_motion() {
    for (camera, fov, at_first, at_last) in [
        ("from = \"m.gltf\"", 1.0, Vec3::Z * 8.0, Vec3::Z * 2.0),
        ("from = \"m.gltf#Eye\"", 1.0, Vec3::Z * 8.0, Vec3::Z * 2.0),
        ("from = \"m.gltf#Eye\"\nanimation = \"Far\"", 1.0, Vec3::Z * 8.0, Vec3::Z * 20.0),
        ("from = \"m.gltf#Side\"", 0.5, Vec3::X * 9.0, Vec3::X * 9.0),
        // by its own name, where no node has it
        ("from = \"m.gltf#Lens#2\"", 0.5, Vec3::X * 9.0, Vec3::X * 9.0),
    ] {
        let shot = shot_with(camera).unwrap();
        let half = Pose::new(&shot.scene, 1).camera.half_height;
        assert!((half - f32::tan(fov / 2.0)).abs() < 1e-5, "{camera}: {half}");
        // a second has ten frames
        let found = [1, 11].map(|frame| eye_at(&shot, frame));
        assert!(found[0].abs_diff_eq(at_first, 1e-4), "{camera}: {found:?}");
        assert!(found[1].abs_diff_eq(at_last, 1e-4), "{camera}: {found:?}");
        assert!(shot.files.iter().any(|file| file.ends_with("m.gltf")));
    }
}

#[test]
fn cameras_that_are_not_there_are_told_with_the_nearest_name() {
    for (camera, expected) in [
        (
            "from = \"m.gltf#eyes\"",
            "s.toml:4:8: `from` names the camera `eyes`, which is not there: did you mean `Eye`? (there: `Eye`, `Side`)",
        ),
        ("from = \"m.glb\"", "s.toml:4:8: `from`: there is no file `m.glb`"),
        ("from = \"m.obj#Eye\"", "s.toml:4:8: `from` must be a glTF file"),
        ("from = \"m.gltf\"\nprojection = \"orthographic\"", "s.toml:4:8: `from` says all of the camera"),
        (
            "from = \"m.gltf\"\n[[camera.key]]\nframe = 1\neye = [0, 0, 1]\ntarget = [0, 0, 0]",
            "s.toml:4:8: `from` says all of the camera",
        ),
        ("from = \"m.gltf\"\nanimation = \"Fat\"", "m.gltf: it has no animation `Fat`: did you mean `Far`?"),
        ("animation = \"Far\"", "s.toml:4:13: `animation` goes with `from`"),
    ] {
        let message = shot_with(camera).unwrap_err();
        assert!(message.starts_with(expected), "for\n{camera}\nexpected {expected}\ngot      {message}");
    }
}

#[test]
fn a_bare_file_is_seen_through_the_camera_that_is_asked_for() {
    let folder = folder(&filmed());
    let load = |camera: Option<&str>, animation: Option<&str>| {
        let [camera, animation] = [camera, animation].map(|name| name.map(String::from));
        let options = Options { camera, animation, ..Options::default() };
        scene::load_turntable(&folder.path().join("m.gltf"), true, &options).map_err(|error| error.message)
    };
    assert!(eye_at(&load(None, None).unwrap(), 25).abs_diff_eq(Vec3::Z * 2.0, 1e-4));
    assert!(eye_at(&load(None, Some("Far")).unwrap(), 25).abs_diff_eq(Vec3::Z * 20.0, 1e-4));
    assert!(eye_at(&load(Some("Side"), None).unwrap(), 25).abs_diff_eq(Vec3::X * 9.0, 1e-4));
    let message = load(Some("Sid"), None).unwrap_err();
    assert!(message.starts_with("--camera names the camera `Sid`, which is not there: did you mean `Side`?"));
    let message = load(None, Some("Faar")).unwrap_err();
    assert!(message.starts_with("it has no animation `Faar`: did you mean `Far`?"), "{message}");
}

#[test]
fn clipping_planes_are_those_of_the_file() {
    let clip = |planes: Value, moves_to: f32| {
        let mut file = File::new();
        let mesh = file.triangle();
        file.root(json!({"mesh": mesh}));
        let mut camera = json!({"type": "perspective", "perspective": {"yfov": 1.0}});
        if planes.get("xmag").is_some() {
            camera = json!({"type": "orthographic", "orthographic": {}});
        }
        let kind = camera["type"].as_str().unwrap().to_string();
        let lens = camera[&kind].as_object_mut().unwrap();
        lens.extend(planes.as_object().unwrap().clone());
        file.json["cameras"] = json!([camera]);
        let eye = file.root(json!({"camera": 0, "translation": [0, 0, 8]}));
        let there = file.vectors(&[[0.0, 0.0, 8.0], [0.0, 0.0, moves_to]]);
        file.animate(eye, "translation", "LINEAR", &[0.0, 1.0], there);
        let shot = scene::load(&folder(&file).path().join("m.gltf"), false).unwrap();
        let told = shot.warnings.iter().any(|warning| warning.0.message.contains("znear, zfar"));
        let clip = Pose::new(&shot.scene, 25).camera.clip;
        (clip.near, clip.far, told)
    };
    let none = f32::INFINITY;
    for (planes, moves_to, wanted) in [
        // what exporters write cuts nothing off
        (json!({"znear": 0.1, "zfar": 1000}), 8.0, (0.0, none, false)),
        (json!({"znear": 0.1}), 8.0, (0.0, none, false)),
        (json!({"znear": 9, "zfar": 1000}), 8.0, (9.0, none, false)),
        (json!({"znear": 0.1, "zfar": 10}), 8.0, (0.0, none, false)),
        (json!({"znear": 0.1, "zfar": 10}), 12.0, (0.0, 10.0, false)),
        (json!({"xmag": 1, "ymag": 1, "znear": 0, "zfar": 7}), 8.0, (0.0, 7.0, false)),
        (json!({"xmag": 1, "ymag": 1, "znear": -5, "zfar": 70}), 8.0, (0.0, none, false)),
        (json!({"znear": 0.1, "zfar": 0}), 8.0, (0.0, none, true)),
        (json!({"znear": 3, "zfar": 2}), 8.0, (0.0, none, true)),
    ] {
        assert_eq!(clip(planes.clone(), moves_to), wanted, "{planes}");
    }
}
