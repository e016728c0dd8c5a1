//! Is a bare glTF file a shot, with its own camera and lights?

use super::*;

#[test]
fn a_whole_file_is_a_shot() {
    let mut file = bent();
    file.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": FRAC_PI_2, "aspectRatio": 2, "znear": 0.1}}]);
    file.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "point", "intensity": 40, "color": [1, 0.5, 0.25]}, {"type": "directional", "name": "sun"},
        {"type": "spot", "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}}]}});
    let eye = file.root(json!({"camera": 0, "translation": [0, 1, 8]}));
    let light = |number: usize| json!({"KHR_lights_punctual": {"light": number}});
    file.root(json!({"translation": [0, 5, 0], "extensions": light(0)}));
    // -Z comes to lie along -Y
    file.root(json!({"rotation": [-FRAC_1_SQRT_2, 0, 0, FRAC_1_SQRT_2], "extensions": light(1)}));
    file.root(json!({"translation": [0, 0, 3], "extensions": light(2)}));
    let there = file.vectors(&[[0.0, 1.0, 8.0], [0.0, 1.0, 4.0]]);
    file.animate(eye, "translation", "LINEAR", &[0.0, 0.5], there);
    let folder = folder(&file);
    let shot = scene::load(&folder.path().join("m.gltf"), true).unwrap();
    let settings = &shot.settings;
    assert_eq!((settings.width, settings.height, shot.frames.to_string().as_str()), (1440, 720, "1-13"));
    let pose = Pose::new(&shot.scene, 7);
    assert!(
        pose.camera.eye.abs_diff_eq(Vec3::new(0.0, 1.0, 6.0), 1e-5)
            && (pose.camera.half_height - 1.0).abs() < 1e-6
    );
    assert!(pose.camera.forward.abs_diff_eq(Vec3::NEG_Z, 1e-6) && pose.camera.up.abs_diff_eq(Vec3::Y, 1e-6));
    let lights: Vec<(&str, &str, Vec3)> = shot
        .scene
        .lights
        .iter()
        .zip(&pose.lights)
        .map(|(light, pose)| (light.name.as_str(), light.kind.name(), pose.strength))
        .collect();
    assert_eq!(lights.len(), 3);
    assert_eq!((lights[0].1, lights[1].1, lights[1].0, lights[2].1), ("point", "directional", "sun", "spot"));
    assert!(lights[0].2.abs_diff_eq(Vec3::new(40.0, 20.0, 10.0) / PI, 1e-4));
    let scene::LightKind::Directional { direction } = &shot.scene.lights[1].kind else { panic!("the sun") };
    assert_near(direction.at(1.0), DVec3::NEG_Y);
    let scene::LightKind::Spot { cone, soft, .. } = &shot.scene.lights[2].kind else { panic!("the spot") };
    assert!((cone - 0.8_f64.to_degrees()).abs() < 1e-4 && (soft - 0.5).abs() < 1e-6);
    // of Blender: watts, made lumens
    file.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5");
    fs::write(folder.path().join("m.gltf"), file.text()).unwrap();
    let shot = scene::load(&folder.path().join("m.gltf"), true).unwrap();
    let strength = Pose::new(&shot.scene, 1).lights[0].strength;
    assert!((strength.x - 40.0 / 683.0 / PI).abs() < 1e-6);
    assert!(shot.notes.iter().any(|note| note.contains("683")), "{:?}", shot.notes);
}

#[test]
fn cameras_look_as_their_nodes_are_turned() {
    for [x, y, z] in [[0.0, 0.0, 0.0], [0.3, -2.0, 0.8], [-1.2, 0.5, 3.0], [0.0, 3.0, -0.4]] {
        let mut file = File::new();
        let mesh = file.triangle();
        file.root(json!({"mesh": mesh}));
        let turn = DQuat::from_euler(glam::EulerRot::YXZ, y, x, z);
        file.json["cameras"] =
            json!([{"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2, "znear": 0, "zfar": 9}}]);
        file.root(
            json!({"camera": 0, "translation": [1, 2, 3], "rotation": turn.to_array(), "scale": [2, 2, 2]}),
        );
        let shot = scene::load(&folder(&file).path().join("m.gltf"), true).unwrap();
        let camera = Pose::new(&shot.scene, 1).camera;
        assert_near(camera.forward.as_dvec3(), turn * DVec3::NEG_Z);
        assert_near(camera.up.as_dvec3(), turn * DVec3::Y);
        assert_near(camera.eye.as_dvec3(), DVec3::new(1.0, 2.0, 3.0));
        assert!(camera.is_orthographic() && camera.half_height == 2.0 && shot.settings.width == 1440);
    }
}

#[test]
fn a_file_without_camera_and_lights_goes_on_a_turntable() {
    let mut file = File::new();
    let mesh = file.triangle();
    file.root(json!({"mesh": mesh, "translation": [10, 0, 0]}));
    let folder = folder(&file);
    fs::write(folder.path().join("m.glb"), file.glb()).unwrap();
    for name in ["m.gltf", "m.glb"] {
        let shot = scene::load(&folder.path().join(name), true).unwrap();
        assert!(shot.says_orbit && shot.frames.to_string() == "1-120" && shot.scene.lights.len() == 2);
        assert_eq!(shot.scene.models.len(), 2, "it stands on a floor");
        let looked_at = Pose::new(&shot.scene, 1).camera;
        let across = looked_at.forward.cross(Vec3::new(10.3, 0.5, 0.0) - looked_at.eye);
        assert!(across.length() < 1.0, "{looked_at:?}");
        assert_eq!(shot.files.len(), 1);
    }
}
