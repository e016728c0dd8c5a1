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
    let scene::LightKind::Spot { cone, soft, fall, .. } = &shot.scene.lights[2].kind else {
        panic!("the spot")
    };
    assert!((cone.at(1.0) - 0.8_f64.to_degrees()).abs() < 1e-4 && (soft.at(1.0) - 0.5).abs() < 1e-6);
    assert_eq!(*fall, scene::SpotFall::Square, "as the extension recommends");
    // of Blender: watts, made lumens
    file.json["asset"]["generator"] = json!("Khronos glTF Blender I/O v5");
    fs::write(folder.path().join("m.gltf"), file.text()).unwrap();
    let shot = scene::load(&folder.path().join("m.gltf"), true).unwrap();
    let strength = Pose::new(&shot.scene, 1).lights[0].strength;
    assert!((strength.x - 40.0 / 683.0 / PI).abs() < 1e-6);
    assert!(shot.notes.iter().any(|note| note.contains("683")), "{:?}", shot.notes);
}

/// What a bare file is rendered by is what `init` writes of it.
#[test]
fn a_bare_file_is_the_shot_that_is_written_of_it() {
    let lenses = [
        json!({"type": "perspective", "perspective": {"yfov": 1, "aspectRatio": 2, "znear": 0.5, "zfar": 8.25}}),
        json!({"type": "orthographic", "orthographic": {"xmag": 4, "ymag": 2, "znear": 0, "zfar": 9}}),
    ];
    let told = ["\nnear = 0.5\nfar = 8.25\n", "\n[camera]\nprojection = \"orthographic\"\n"];
    for (lens, told) in lenses.into_iter().zip(told) {
        let is_orthographic = lens["type"] == "orthographic";
        let mut file = bent();
        file.json["cameras"] = json!([lens]);
        file.json["extensions"] =
            json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 40}]}});
        let eye = file.root(json!({"camera": 0, "translation": [0, 1, 8]}));
        file.root(json!({"translation": [0, 5, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
        let turns: Vec<f32> = [0.0, 0.7]
            .iter()
            .flat_map(|roll| DQuat::from_rotation_z(*roll).to_array().map(|number| number as f32))
            .collect();
        let turns = file.floats("VEC4", 4, &turns);
        file.animate(eye, "rotation", "LINEAR", &[0.0, 0.5], turns);
        let folder = folder(&file);
        let path = folder.path().join("m.gltf");
        let text = scene::gltf::text(&path, "m.gltf", &scene::turntable::Options::default()).unwrap().text;
        assert!(
            text.contains("\n[render]\nsize = [1440, 720]\nsamples = 2\nframes = \"1-13\"\nrate = 24\n"),
            "{text}"
        );
        assert!(
            text.contains(told) && text.contains("\nroll = ") && text.contains("\n[[light]]\n"),
            "{text}"
        );
        assert_eq!(text.contains("\nheight = 4\n"), is_orthographic, "{text}");
        fs::write(folder.path().join("s.toml"), text).unwrap();
        let [bare, shot] = [path, folder.path().join("s.toml")].map(|path| scene::load(&path, true).unwrap());
        assert_eq!(bare.content.shot, shot.content.shot);
        assert_eq!(bare.scene.camera, shot.scene.camera);
        assert_eq!((bare.settings, bare.frames), (shot.settings, shot.frames));
        assert_eq!(bare.says_frames, shot.says_frames);
    }
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

/// Places of points in the picture at a frame: 1 is the edge.
fn seen(shot: &Shot, frame: i32, points: &[Vec3]) -> Vec<Vec2> {
    let camera = Pose::new(&shot.scene, frame).camera;
    let aspect = shot.settings.width as f32 / shot.settings.height as f32;
    let right = camera.forward.cross(camera.up);
    let place = |point: &Vec3| {
        let to = *point - camera.eye;
        let depth = to.dot(camera.forward) * camera.half_height;
        Vec2::new(to.dot(right) / (depth * aspect), to.dot(camera.up) / depth)
    };
    points.iter().map(place).collect()
}

#[test]
fn a_bare_file_is_framed_for_all_that_it_shows_at_any_time() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let [far, turned] = [Vec3::new(0.0, 12.0, 0.0), Vec3::new(-20.0, 3.0, 1.0)];
    let mut moving = File::new();
    let mesh = moving.triangle();
    let node = moving.root(json!({"mesh": mesh}));
    let way = moving.vectors(&[[0.0; 3], far.to_array()]);
    moving.animate(node, "translation", "LINEAR", &[0.0, 0.5], way);
    let mut copied = File::new();
    let mesh = copied.triangle();
    let places = copied.vectors(&[[0.0; 3], far.to_array(), turned.to_array()]);
    let attributes = json!({"TRANSLATION": places});
    copied.root(json!({"mesh": mesh, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}));
    let at = |place: Vec3| corners.map(|corner| corner + place).to_vec();
    for (file, all) in
        [(moving, [at(Vec3::ZERO), at(far)].concat()), (copied, [at(far), at(turned)].concat())]
    {
        let shot = scene::load(&folder(&file).path().join("m.gltf"), true).unwrap();
        for frame in [1, 13, 40, 77, 120] {
            let places = seen(&shot, frame, &all);
            assert!(places.iter().all(|at| at.abs().max_element() < 1.0), "frame {frame}: {places:?}");
        }
    }
    // what bends is framed by its shapes: the joint swings the tip from the top to the left
    let shot = scene::load(&folder(&bent()).path().join("m.gltf"), true).unwrap();
    let last = shot.scene.models[0].track.shapes.as_ref().unwrap().ends()[1] as i32;
    for frame in [1, last] {
        let points: Vec<Vec3> = deformed(&shot, 0, frame).into_iter().map(Vec3::from).collect();
        for turn in [1, 31, 61, 91] {
            let places = seen(&shot, turn, &points);
            assert!(places.iter().all(|at| at.abs().max_element() < 1.0), "{frame} {turn}: {places:?}");
        }
    }
}

#[test]
fn a_camera_in_a_closed_box_is_told_of_it() {
    let mut file = File::new();
    let corner = |i: u8| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 5.0 } else { -5.0 });
    let positions = file.vectors(&std::array::from_fn::<_, 8, _>(|i| corner(i as u8)));
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<u16> = faces.iter().flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d]).collect();
    file.add("materials", json!({}));
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    let shown = |mut file: File, triangles: &[u16], emits: f32, eye: f32| {
        file.json["materials"][0]["emissiveFactor"] = json!([emits, emits, emits]);
        let indices = file.indices(triangles);
        let mesh =
            file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0}));
        file.root(json!({"mesh": mesh, "name": "sky box"}));
        file.root(json!({"camera": 0, "translation": [eye, 0, 1]}));
        let shot = scene::load(&folder(&file).path().join("m.gltf"), true).unwrap();
        shot.notes.iter().filter(|note| note.contains("`sky box` lies all around the camera")).count()
    };
    let again = || File { json: file.json.clone(), bytes: file.bytes.clone() };
    assert_eq!(shown(again(), &triangles, 0.0, 2.0), 1);
    assert_eq!(shown(again(), &triangles, 0.0, 7.0), 0, "from without");
    assert_eq!(shown(again(), &triangles, 0.5, 2.0), 0, "it gives light itself");
    assert_eq!(shown(again(), &triangles[6..], 0.0, 2.0), 0, "one side is open");
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    let mut file = File::new();
    let mesh = file.triangle();
    file.root(json!({"mesh": mesh}));
    let folder = folder(&file);
    let path = folder.path().join("m.gltf");
    fs::write(&path, format!("\u{feff}{}", file.text())).unwrap();
    assert_eq!(scene::load(&path, true).unwrap().scene.models[0].mesh.count(), 1);
}
