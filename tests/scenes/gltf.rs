//! glTF files: is the geometry that of the file, does each node stand where its parents put it at all times, and is every damaged file
//! an error?

use std::f32::consts::PI;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};
use std::fs;
use std::path::Path;
use std::sync::Arc;

use afterimage::frame::Renderer;
use afterimage::pose::Pose;
use afterimage::scene::material::Optics;
use afterimage::scene::{self, Material, Model, Shot};
use afterimage::settings::{Mode, Settings};
use glam::{DQuat, DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use tempfile::TempDir;

const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n";

/// A glTF file in the making: what is added to its lists is known by the number that comes back.
struct File {
    json: Value,
    bytes: Vec<u8>,
}

impl File {
    fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0, "scenes": [{"nodes": []}],
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [], "materials": [],
        });
        Self { json, bytes: Vec::new() }
    }

    fn add(&mut self, list: &str, entry: Value) -> usize {
        if self.json.get(list).is_none() {
            self.json[list] = json!([]);
        }
        let entries = self.json[list].as_array_mut().unwrap();
        entries.push(entry);
        entries.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.add("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.add(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    fn floats(&mut self, kind: &str, width: usize, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, numbers.len() / width)
    }

    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        self.floats("VEC3", 3, vectors.as_flattened())
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
        self.accessor(&bytes, 5123, "SCALAR", indices.len())
    }

    /// A mesh of one primitive.
    fn mesh(&mut self, primitive: Value) -> usize {
        self.add("meshes", json!({"primitives": [primitive]}))
    }

    /// A mesh of one triangle in the plane z = 0.
    fn triangle(&mut self) -> usize {
        let positions = self.vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        self.mesh(json!({"attributes": {"POSITION": positions}}))
    }

    fn node(&mut self, node: Value) -> usize {
        self.add("nodes", node)
    }

    fn root(&mut self, node: Value) -> usize {
        let number = self.node(node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(number));
        number
    }

    /// Adds a channel to the first animation; times in seconds.
    fn animate(&mut self, node: usize, path: &str, curve: &str, times: &[f32], output: usize) {
        if self.json.get("animations").is_none() {
            self.json["animations"] = json!([{"name": "first", "channels": [], "samplers": []}]);
        }
        let input = self.floats("SCALAR", 1, times);
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": curve}));
        let sampler = samplers.len() - 1;
        let channel = json!({"sampler": sampler, "target": {"node": node, "path": path}});
        animation["channels"].as_array_mut().unwrap().push(channel);
    }

    fn text(&self) -> String {
        let mut json = self.json.clone();
        let uri = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{"byteLength": self.bytes.len(), "uri": uri}]);
        }
        json.to_string()
    }

    /// The same as a binary file.
    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.bytes.len();
        let word = |number: usize| (number as u32).to_le_bytes().to_vec();
        [
            b"glTF".to_vec(),
            word(2),
            word(length),
            word(text.len()),
            b"JSON".to_vec(),
            text,
            word(self.bytes.len()),
            b"BIN\0".to_vec(),
            self.bytes.clone(),
        ]
        .concat()
    }
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let bits =
            three.iter().fold(0_u32, |bits, byte| bits << 8 | u32::from(*byte)) << (8 * (3 - three.len()));
        let digit = |place: usize| char::from(DIGITS[(bits >> (18 - 6 * place)) as usize & 63]);
        text.extend((0..4).map(|place| if place <= three.len() { digit(place) } else { '=' }));
    }
    text
}

fn folder(file: &File) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.gltf"), file.text()).unwrap();
    folder
}

fn load_in(folder: &Path, text: &str, strict: bool) -> Result<Shot, String> {
    let path = folder.join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(&path, strict)
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.display()), ""))
}

/// Loads a shot of the file, with these keys of its table.
fn load(file: &File, keys: &str) -> Shot {
    load_in(folder(file).path(), &format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n{keys}"), false).unwrap()
}

fn error(file: &File) -> String {
    load_in(folder(file).path(), &format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n"), false).unwrap_err()
}

/// Place of a point of a model at a frame.
fn place(model: &Model, frame: f64, point: Vec3) -> DVec3 {
    model.track.map_at(frame).transform_point3(point.as_dvec3())
}

fn assert_near(found: DVec3, wanted: DVec3) {
    assert!(found.abs_diff_eq(wanted, 1e-5), "{found} and not {wanted}");
}

#[test]
fn geometry_is_that_of_the_same_obj() {
    let mut file = File::new();
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.5], [0.0, 1.0, 0.5]];
    let positions = file.vectors(&corners);
    let normals = file.vectors(&[[0.0, -0.4472136, 0.8944272]; 4]);
    let uvs = file.floats("VEC2", 2, &[0.0, 1.0, 1.0, 1.0, 1.0, 0.25, 0.0, 0.25]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3]);
    let attributes = json!({"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs});
    let mesh = file.mesh(json!({"attributes": attributes, "indices": indices}));
    file.root(json!({"mesh": mesh, "name": "board"}));
    let folder = folder(&file);
    fs::write(folder.path().join("m.glb"), file.glb()).unwrap();
    let obj = "v 0 0 0\nv 2 0 0\nv 2 1 .5\nv 0 1 .5\nvt 0 0\nvt 1 0\nvt 1 .75\nvt 0 .75\nvn 0 -0.4472136 0.8944272\n\
               f 1/1/1 2/2/1 3/3/1 4/4/1\n";
    fs::write(folder.path().join("m.obj"), obj).unwrap();
    let shot = |key: &str| load_in(folder.path(), &format!("{CAMERA}[[model]]\n{key}\n"), true).unwrap();
    let expected = shot("obj = \"m.obj\"");
    for key in ["gltf = \"m.gltf\"", "gltf = \"m.glb\""] {
        let shot = shot(key);
        let [found, same] = [&shot, &expected].map(|shot| &shot.scene.models[0].mesh);
        assert_eq!(found.positions.as_slice(), same.positions.as_slice());
        assert_eq!(found.triangles, same.triangles);
        assert_eq!(found.uvs, same.uvs);
        let near = |(a, b): (&Vec3, &Vec3)| a.abs_diff_eq(*b, 1e-6);
        assert!(found.normals.iter().zip(&same.normals).all(near));
        assert_eq!(shot.scene.models[0].name, "m/board");
        assert_eq!(shot.warnings, expected.warnings, "nothing but that there is no light");
        assert_eq!(shot.files.iter().filter(|file| !file.ends_with("s.toml")).count(), 1);
    }
}

#[test]
fn accessors_may_be_of_any_type() {
    let mut file = File::new();
    // as bytes that stand for -1 to 1, strided, and with an element replaced
    let view = file.view(&[0, 0, 0, 99, 127, 0, 0, 99, 0, 127, 0, 99]);
    file.json["bufferViews"][view]["byteStride"] = json!(4);
    let (places, values) = (file.view(&[2, 0]), file.view(&[0, 129, 0]));
    let positions = file.add(
        "accessors",
        json!({"bufferView": view, "componentType": 5120, "normalized": true, "type": "VEC3", "count": 3, "sparse": {
            "count": 1, "indices": {"bufferView": places, "componentType": 5121}, "values": {"bufferView": values}}}),
    );
    let halves = file.accessor(&[255, 255, 0, 0, 0, 0, 255, 255, 0, 0, 0, 0], 5123, "VEC2", 3);
    file.json["accessors"][halves]["normalized"] = json!(true);
    let mesh = file.mesh(json!({"attributes": {"POSITION": positions, "TEXCOORD_0": halves}}));
    file.root(json!({"mesh": mesh}));
    file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let shot = load(&file, "");
    let mesh = &shot.scene.models[0].mesh;
    assert_eq!(mesh.positions.as_slice(), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]);
    assert_eq!(mesh.uvs, [Vec2::new(1.0, 1.0), Vec2::new(0.0, 0.0), Vec2::new(0.0, 1.0)]);
    assert!(mesh.normals.is_empty(), "faces have their own");
}

#[test]
fn strips_and_fans_become_triangles_and_lines_are_told_once() {
    let mut file = File::new();
    let positions =
        file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
    let primitive = |mode: u32| json!({"attributes": {"POSITION": positions}, "mode": mode});
    let mesh =
        file.add("meshes", json!({"primitives": [primitive(5), primitive(6), primitive(1), primitive(0)]}));
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let expected = [[0, 1, 2], [1, 3, 2], [0, 1, 2], [0, 2, 3]];
    assert_eq!(*shot.scene.models[0].mesh.triangles, expected, "and none without an area");
    assert_eq!(shot.scene.models[0].mesh.positions.as_slice().len(), 5, "vertices are shared");
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert_eq!(
        told.iter().filter(|text| text.contains("points and lines are left out")).count(),
        1,
        "{told:?}"
    );
}

#[test]
fn nodes_stand_where_their_parents_put_them() {
    let mut file = File::new();
    let mesh = file.triangle();
    let tip = file.node(json!({"mesh": mesh, "name": "tip", "translation": [0, 1, 0]}));
    let arm = file.node(json!({"mesh": mesh, "name": "arm", "translation": [2, 0, 0], "children": [tip],
        "rotation": [0, 0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]}));
    file.root(json!({"children": [arm], "scale": [-2, 2, 2]}));
    // and what is below no scene is not there
    file.node(json!({"mesh": mesh}));
    let shot = load(&file, "translate = [0, 0, 5]\n");
    let names: Vec<&str> = shot.scene.models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names, ["m/arm", "m/tip"]);
    // (1, 0, 0) is (1, 1, 0) of the arm, turned to (-1, 1, 0), moved to (1, 1, 0), mirrored
    let [arm, tip] = &shot.scene.models[..] else { panic!("two models") };
    let corners = |model: &Model| -> Vec<DVec3> {
        model.mesh.positions.as_slice().iter().map(|at| place(model, 1.0, Vec3::from(*at))).collect()
    };
    assert_near(corners(tip)[1], DVec3::new(-2.0, 2.0, 5.0));
    assert_near(corners(arm)[0], DVec3::new(-4.0, 0.0, 5.0));
    // the outside stays outside: of a mirror image the corners come in the other order
    let facing = |model: &Model| {
        let at = corners(model);
        let [a, b, c] = model.mesh.triangles[0].map(|corner| at[corner as usize]);
        (b - a).cross(c - a).normalize()
    };
    assert_near(facing(tip), DVec3::Z);
}

#[test]
fn nodes_of_one_mesh_share_it_and_tables_move_it_as_a_whole() {
    let mut file = File::new();
    let mesh = file.triangle();
    for x in 0..3 {
        file.root(json!({"mesh": mesh, "translation": [x, 0, 0]}));
    }
    let keys = "[[model.key]]\nframe = 1\n[[model.key]]\nframe = 3\ntranslate = [0, 4, 0]\n";
    let shot = load(&file, keys);
    let [first, second, third] = &shot.scene.models[..] else { panic!("three models") };
    assert!(Arc::ptr_eq(&first.mesh, &second.mesh) && Arc::ptr_eq(&second.mesh, &third.mesh));
    assert_near(place(third, 2.0, Vec3::X), DVec3::new(3.0, 2.0, 0.0));
    assert_eq!((first.name.as_str(), third.name.as_str()), ("m/node 0", "m/node 2"));
    let hidden = load(&file, "name = \"all\"\nvisible = false\n[[model.key]]\nframe = 3\nvisible = true\n");
    let there =
        [1, 3].map(|frame| Pose::new(&hidden.scene, frame).models.iter().filter(|at| at.is_visible).count());
    assert_eq!((there, hidden.scene.models[0].name.as_str()), ([0, 3], "all/node 0"));
}

#[test]
fn copies_of_a_node_are_models_of_their_own() {
    let mut file = File::new();
    let mesh = file.triangle();
    let at = file.vectors(&[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    let scale = file.vectors(&[[1.0; 3], [3.0; 3]]);
    let attributes = json!({"TRANSLATION": at, "SCALE": scale});
    file.root(json!({"mesh": mesh, "name": "tree", "translation": [0, 5, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}}));
    let shot =
        load_in(folder(&file).path(), &format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n"), true).unwrap();
    let places: Vec<[f32; 3]> =
        shot.scene.models.iter().map(|model| model.mesh.positions.as_slice()[1]).collect();
    assert_eq!(places, [[2.0, 5.0, 0.0], [5.0, 5.0, 0.0]]);
    assert_eq!(shot.scene.models[1].name, "m/tree/1");
}

#[test]
fn motion_goes_through_the_hierarchy_at_all_times() {
    let mut file = File::new();
    let mesh = file.triangle();
    let child = file.node(json!({"mesh": mesh, "name": "child", "translation": [1, 0, 0]}));
    let parent = file.root(json!({"children": [child]}));
    // a quarter turn about Z in one second, and the child moves up meanwhile; 8 frames a second
    let turn = file.floats("VEC4", 4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.70710677, 0.70710677]);
    file.animate(parent, "rotation", "LINEAR", &[0.0, 1.0], turn);
    let up = file.vectors(&[[1.0, 0.0, 0.0], [1.0, 0.0, 2.0]]);
    file.animate(child, "translation", "LINEAR", &[0.0, 1.0], up);
    let rate = "[render]\nrate = 8\n";
    let text = format!("{rate}{CAMERA}[[model]]\ngltf = \"m.gltf\"\n");
    let shot = load_in(folder(&file).path(), &text, true).unwrap();
    let model = &shot.scene.models[0];
    for frame in [1.0, 2.0, 4.0, 6.0, 6.25, 9.0, 12.0] {
        let share = f64::min((frame - 1.0) / 8.0, 1.0);
        let turned = DQuat::from_rotation_z(FRAC_PI_2 * share);
        assert_near(place(model, frame, Vec3::ZERO), turned * DVec3::new(1.0, 0.0, 2.0 * share));
    }
    // between its keys it is off the circle by less than a thousandth
    let between = place(model, 4.1, Vec3::ZERO);
    assert!((DVec3::new(between.x, between.y, 0.0).length() - 1.0).abs() < 1e-3);
    assert!(!model.track.is_constant());
}

#[test]
fn curves_are_those_of_the_standard() {
    let mut file = File::new();
    let mesh = file.triangle();
    let [cubic, step] = [0, 1].map(|_| file.root(json!({"mesh": mesh})));
    // from 0 to (4, 0, 0) in two seconds, leaving at (3, 0, 0) a second and arriving at (0, 1, 0) a second
    let zero = [0.0; 3];
    let spline = file.vectors(&[zero, zero, [3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [4.0, 0.0, 0.0], zero]);
    file.animate(cubic, "translation", "CUBICSPLINE", &[0.0, 2.0], spline);
    let jumps = file.vectors(&[zero, [0.0, 7.0, 0.0]]);
    file.animate(step, "translation", "STEP", &[0.0, 1.0], jumps);
    let text = format!("[render]\nrate = 10\n{CAMERA}[[model]]\ngltf = \"m.gltf\"\n");
    let shot = load_in(folder(&file).path(), &text, true).unwrap();
    let [cubic, step] = &shot.scene.models[..] else { panic!("two models") };
    for frame in [1.0, 4.0, 11.0, 17.0, 21.0, 30.0] {
        let t = f64::min((frame - 1.0) / 20.0, 1.0);
        let (t2, t3) = (t * t, t * t * t);
        let x = 2.0 * 3.0 * (t3 - 2.0 * t2 + t) + 4.0 * (3.0 * t2 - 2.0 * t3);
        assert_near(place(cubic, frame, Vec3::ZERO), DVec3::new(x, 2.0 * (t3 - t2), 0.0));
    }
    let heights = [1.0, 10.0, 10.9, 11.0, 12.0].map(|frame| place(step, frame, Vec3::ZERO).y);
    assert_eq!(heights, [0.0, 0.0, 0.0, 7.0, 7.0]);
}

#[test]
fn what_is_scaled_to_nothing_is_not_there() {
    let mut file = File::new();
    let mesh = file.triangle();
    let [shrinks, never] =
        [json!([1, 1, 1]), json!([0, 0, 0])].map(|scale| file.root(json!({"mesh": mesh, "scale": scale})));
    let scale = file.vectors(&[[1.0; 3], [0.0; 3]]);
    file.animate(shrinks, "scale", "LINEAR", &[0.0, 0.5], scale);
    assert_eq!(never, 1);
    let shot = load(&file, "");
    assert_eq!(shot.scene.models.len(), 1);
    let there = [1, 7, 12, 13, 20].map(|frame| Pose::new(&shot.scene, frame).models[0].is_visible);
    assert_eq!(there, [true, true, true, false, false]);
    assert_near(place(&shot.scene.models[0], 7.0, Vec3::X), DVec3::X * 0.5);
}

#[test]
fn animations_are_chosen_by_name() {
    let mut file = File::new();
    let mesh = file.triangle();
    let node = file.root(json!({"mesh": mesh}));
    let there = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0]]);
    file.animate(node, "translation", "LINEAR", &[0.0, 1.0], there);
    let mut walk = file.json["animations"][0].clone();
    walk["name"] = json!("Walk");
    let far = file.vectors(&[[0.0; 3], [9.0, 0.0, 0.0]]);
    walk["samplers"][0]["output"] = json!(far);
    file.add("animations", walk);
    // and one of another node, which goes with the first
    let other = file.root(json!({"mesh": mesh}));
    let mut apart = file.json["animations"][1].clone();
    (apart["name"], apart["channels"][0]["target"]["node"]) = (json!("other"), json!(other));
    file.add("animations", apart);
    let shot = load(&file, "");
    assert_near(place(&shot.scene.models[1], 25.0, Vec3::ZERO), DVec3::X * 9.0);
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    assert!(
        told.iter().any(|text| text.contains("1 animations are not shown") && text.contains("(`Walk`)")),
        "{told:?}"
    );
    let end = |keys: &str| place(&load(&file, keys).scene.models[0], 25.0, Vec3::ZERO).x;
    assert_eq!((end(""), end("animation = \"Walk\"\n")), (1.0, 9.0));
    let folder = folder(&file);
    let error =
        |keys: &str| load_in(folder.path(), &format!("{CAMERA}[[model]]\n{keys}\n"), false).unwrap_err();
    let unknown = error("gltf = \"m.gltf\"\nanimation = \"Wolk\"");
    assert!(unknown.contains("it has no animation `Wolk`: did you mean `Walk`?"), "{unknown}");
    assert!(
        error("quadric = { type = \"sphere\" }\nanimation = \"Walk\"")
            .contains("`animation` goes with `gltf`")
    );
    assert!(
        error("quadric = { type = \"sphere\" }\ngltf = \"m.gltf\"")
            .contains("`gltf` and `quadric` exclude each other")
    );
    assert!(error("obj = \"m.obj\"\ngltf = \"m.gltf\"").contains("`obj` and `gltf` exclude each other"));
    assert!(error("gltf = \"m.gltf\"\nshapes = { obj = \"a.#.obj\" }").contains("a glTF file has its own"));
    assert!(error("gltf = \"n.gltf\"").contains("`gltf`: there is no file `n.gltf`"));
}

/// A strip from y = 0 to 2, of which the upper half follows a joint that turns at y = 1.
fn bent() -> File {
    let mut file = File::new();
    let positions = file.vectors(&[
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
    ]);
    let indices = file.indices(&[0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5]);
    let joints = file.accessor(
        &[[0, 0, 0, 0]; 4].concat().into_iter().chain([1, 0, 0, 0, 1, 0, 0, 0]).collect::<Vec<u8>>(),
        5121,
        "VEC4",
        6,
    );
    let weights = file.floats("VEC4", 4, &[1.0, 0.0, 0.0, 0.0].repeat(6));
    let attributes = json!({"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights});
    let mesh = file.mesh(json!({"attributes": attributes, "indices": indices}));
    let upper = file.node(json!({"translation": [0, 1, 0]}));
    let lower = file.root(json!({"children": [upper]}));
    let mut identity = [0.0; 16];
    (0..4).for_each(|i| identity[5 * i] = 1.0);
    let mut down = identity;
    down[13] = -1.0;
    let binds = file.floats("MAT4", 16, &[identity, down].concat());
    let skin = file.add("skins", json!({"joints": [lower, upper], "inverseBindMatrices": binds}));
    // the place of a node with a skin counts for nothing
    file.root(json!({"mesh": mesh, "skin": skin, "name": "strip", "translation": [50, 0, 0]}));
    let turn = file.floats("VEC4", 4, &[0.0, 0.0, 0.0, 1.0, 0.70710677, 0.0, 0.0, 0.70710677]);
    file.animate(upper, "rotation", "LINEAR", &[0.0, 0.5], turn);
    file
}

/// Positions of a model's vertices at a frame, as its shapes are.
fn deformed(shot: &Shot, model: usize, frame: i32) -> Vec<[f32; 3]> {
    let shapes = shot.scene.models[model].mesh.shapes.as_ref().unwrap();
    shapes.positions(&Pose::new(&shot.scene, frame).models[model].shape)
}

#[test]
fn skins_follow_their_joints() {
    let shot = load(&bent(), "");
    for frame in [1, 4, 7, 13, 30] {
        let angle = f64::min(f64::from(frame - 1) / 12.0, 1.0) * FRAC_PI_2;
        let at = deformed(&shot, 0, frame);
        assert_near(Vec3::from(at[2]).as_dvec3(), DVec3::new(1.0, 1.0, 0.0));
        let tip = DVec3::new(1.0, 1.0, 0.0) + DVec3::new(0.0, angle.cos(), angle.sin());
        assert_near(Vec3::from(at[4]).as_dvec3(), tip);
    }
    assert_eq!(shot.scene.models.len(), 1);
    assert!(shot.scene.models[0].track.map_at(3.0).translation == DVec3::ZERO);
}

#[test]
fn morph_targets_add_up_by_their_weights() {
    let mut file = File::new();
    let positions = file.vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let up = file.vectors(&[[0.0, 0.0, 0.0], [0.0; 3], [0.0, 2.0, 0.0]]);
    let aside = file.vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]);
    let targets = json!([{"POSITION": up}, {"POSITION": aside}]);
    let mesh = file.mesh(json!({"attributes": {"POSITION": positions}, "targets": targets}));
    file.json["meshes"][mesh]["weights"] = json!([0.5, 0]);
    let [animated, _] = [0, 1].map(|_| file.root(json!({"mesh": mesh})));
    let weights = file.floats("SCALAR", 1, &[0.0, 1.0, 1.0, 0.0]);
    file.animate(animated, "weights", "LINEAR", &[0.0, 0.5], weights);
    let shot = load(&file, "");
    assert_eq!(deformed(&shot, 0, 1), [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(deformed(&shot, 0, 4), [[0.0, 0.0, 0.0], [1.75, 0.0, 0.0], [0.0, 1.5, 0.0]]);
    assert_eq!(deformed(&shot, 0, 13), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
    let still = &shot.scene.models[1].mesh;
    assert!(
        still.shapes.is_none() && still.positions.as_slice()[2] == [0.0, 2.0, 0.0],
        "half of the first one"
    );
}

/// Settles a material.
fn material(json: Value) -> (Material, Vec<String>) {
    let mut file = File::new();
    let mesh = file.triangle();
    file.json["meshes"][mesh]["primitives"][0]["material"] = json!(0);
    file.add("materials", json);
    file.root(json!({"mesh": mesh}));
    let shot = load(&file, "");
    let told = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    (shot.scene.materials[0].clone(), told)
}

#[test]
fn materials_are_metal_rough() {
    let pbr = json!({"baseColorFactor": [0.5, 0.25, 1, 0.3], "metallicFactor": 0.25, "roughnessFactor": 0.5});
    let (plain, told) = material(json!({"name": "paint", "pbrMetallicRoughness": pbr}));
    let layer = plain.metal_rough.unwrap();
    assert_eq!((layer.base, layer.roughness, layer.metallic), (Vec3::new(0.5, 0.25, 1.0), 0.5, 0.25));
    assert!((layer.head_on - 0.04).abs() < 1e-6 && layer.solid == 1.0 && plain.optics == Optics::Opaque);
    assert_eq!((plain.name.as_str(), plain.emission), ("paint", Vec3::ZERO));
    assert!(!told.iter().any(|text| text.contains("not used")), "{told:?}");
    let (veil, _) = material(json!({"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}));
    assert!((veil.metal_rough.unwrap().solid - 0.3).abs() < 1e-6 && veil.name == "material 0");
    assert!(matches!(veil.optics, Optics::Glass { index: 1.0, .. }));
    let extensions =
        json!({"KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_ior": {"ior": 2}});
    let (lamp, _) = material(json!({"emissiveFactor": [1, 0.5, 0], "extensions": extensions}));
    assert_eq!(lamp.emission, Vec3::new(4.0, 2.0, 0.0));
    assert!((lamp.metal_rough.unwrap().head_on - 1.0 / 9.0).abs() < 1e-6);
    let (unlit, _) =
        material(json!({"pbrMetallicRoughness": pbr, "extensions": {"KHR_materials_unlit": {}}}));
    assert_eq!(
        (unlit.emission, unlit.diffuse, unlit.metal_rough),
        (Vec3::new(0.5, 0.25, 1.0), Vec3::ZERO, None)
    );
}

#[test]
fn what_transmits_is_glass() {
    let glass = |extensions: Value| {
        let pbr = json!({"baseColorFactor": [1, 0.5, 1, 1], "metallicFactor": 0, "roughnessFactor": 0});
        material(json!({"pbrMetallicRoughness": pbr, "extensions": extensions})).0
    };
    let thin = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 1}}));
    let transmission = Vec3::new(1.0, 0.5, 1.0);
    assert_eq!(thin.optics, Optics::Glass { transmission, index: 1.0, reflection: Vec3::ONE });
    assert_eq!((thin.diffuse, thin.metal_rough), (Vec3::ZERO, None));
    let solid = glass(
        json!({"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.25},
        "KHR_materials_volume": {"thicknessFactor": 1}}),
    );
    assert_eq!(solid.optics, Optics::Glass { transmission, index: 1.25, reflection: Vec3::ONE });
    let half = glass(json!({"KHR_materials_transmission": {"transmissionFactor": 0.5}}));
    assert!(half.diffuse.abs_diff_eq(Vec3::new(0.5, 0.25, 0.5), 1e-6), "{}", half.diffuse);
}

/// A picture of two texels, as PNG.
fn png(texels: [[u8; 4]; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(texels.as_flattened()).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn pictures_may_be_in_the_file_or_beside_it() {
    let picture = png([[255, 0, 0, 255], [0, 102, 51, 255]]);
    let mut file = File::new();
    let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    let view = file.view(&picture);
    let uri = format!("data:image/png;base64,{}", base64(&picture));
    file.json["images"] =
        json!([{"bufferView": view, "mimeType": "image/png"}, {"uri": uri}, {"uri": "maps/my%20wood.png"}]);
    file.json["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    file.json["textures"] = json!([{"source": 0}, {"source": 1}, {"source": 2, "sampler": 0}]);
    let transform = json!({"KHR_texture_transform": {"offset": [0.25, 0.5], "scale": [2, 4]}});
    let of = |texture: usize| json!({"index": texture, "extensions": transform});
    for texture in 0..3 {
        let pbr = json!({"baseColorTexture": of(texture), "metallicRoughnessTexture": {"index": 1}});
        let json = json!({"name": format!("paint {texture}"), "pbrMetallicRoughness": pbr, "emissiveTexture": {"index": 0},
            "emissiveFactor": [1, 1, 1], "normalTexture": {"index": 0}});
        let material = file.add("materials", json);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        let mesh = file.mesh(json!({"attributes": attributes, "material": material}));
        file.root(json!({"mesh": mesh}));
    }
    let folder = folder(&file);
    fs::create_dir(folder.path().join("maps")).unwrap();
    fs::write(folder.path().join("maps/my wood.png"), &picture).unwrap();
    let text = format!("{CAMERA}[[model]]\ngltf = \"m.gltf\"\n[[material]]\nname = \"paint 1\"\npr = 0.75\n");
    let shot = load_in(folder.path(), &text, true).unwrap();
    let materials = &shot.scene.materials;
    assert_eq!(shot.scene.textures.len(), 3);
    for (material, clamp) in materials.iter().zip([false, false, true]) {
        let texture = &shot.scene.textures[material.diffuse_map.unwrap() as usize];
        assert_eq!(
            (texture.width, texture.height, texture.texels[1], texture.clamp),
            (2, 1, [0, 102, 51, 255], clamp)
        );
        assert_eq!((texture.scale, texture.offset), (Vec2::new(2.0, 4.0), Vec2::new(0.25, -3.5)));
        // green is roughness, blue is metal
        let layer = material.metal_rough.unwrap();
        assert!((layer.metallic - 0.1).abs() < 1e-6);
        assert!(material.emission.abs_diff_eq(Vec3::new(0.5, 0.132_87 / 2.0, 0.033_1 / 2.0), 1e-4));
    }
    let roughness: Vec<f32> =
        materials.iter().map(|material| material.metal_rough.unwrap().roughness).collect();
    assert!((roughness[0] - 0.2).abs() < 1e-6 && roughness[1] == 0.75, "{roughness:?}");
    let name =
        |index: usize| shot.scene.textures[index].path.file_name().unwrap().to_string_lossy().into_owned();
    assert_eq!([name(0), name(1), name(2)], ["m.gltf#image 0", "m.gltf#image 1", "my wood.png"]);
    assert_eq!(shot.files.len(), 3, "the shot, the file and one picture: {:?}", shot.files);
    let told: Vec<String> = shot.warnings.iter().map(|warning| warning.0.to_string()).collect();
    for part in ["normal maps", "the mean counts", "emission is one colour"] {
        assert!(told.iter().any(|text| text.contains(part)), "{part}: {told:?}");
    }
    fs::remove_file(folder.path().join("maps/my wood.png")).unwrap();
    let error = load_in(folder.path(), &text, true).unwrap_err();
    assert!(error.contains("the texture `maps/my wood.png` cannot be found"), "{error}");
}

#[test]
fn alpha_cuts_out_what_is_below_the_cutoff() {
    let cutout = |alpha: [u8; 2], json: Value| {
        let mut file = File::new();
        let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let uvs = file.floats("VEC2", 2, &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let attributes = json!({"POSITION": positions, "TEXCOORD_0": uvs});
        let mesh = file.mesh(json!({"attributes": attributes, "material": 0}));
        let uri = base64(&png(alpha.map(|alpha| [255, 255, 255, alpha])));
        file.json["images"] = json!([{"uri": format!("data:image/png;base64,{uri}")}]);
        file.json["textures"] = json!([{"source": 0}]);
        file.add("materials", json);
        file.root(json!({"mesh": mesh}));
        let shot = load(&file, "");
        let cut = shot.scene.models[0].mesh.cut.is_some();
        let least = shot.scene.materials[0].cutout.map(|cutout| cutout.least);
        assert_eq!(cut, least.is_some());
        least
    };
    let with = |factor: f64, mode: &str, cutoff: Option<f64>| {
        let pbr = json!({"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, factor]});
        let mut json = json!({"pbrMetallicRoughness": pbr, "alphaMode": mode});
        if let Some(cutoff) = cutoff {
            json["alphaCutoff"] = json!(cutoff);
        }
        json
    };
    for (alpha, json, expected) in [
        ([255, 0], with(1.0, "MASK", None), Some(0.5)),
        ([255, 100], with(1.0, "MASK", Some(0.25)), None),
        // as large as a fourth of what the texture says
        ([255, 100], with(0.25, "MASK", Some(0.125)), Some(0.5)),
        ([255, 0], with(1.0, "MASK", Some(0.0)), None),
        ([255, 0], with(1.0, "OPAQUE", None), None),
        ([255, 0], with(1.0, "BLEND", None), Some(0.5)),
    ] {
        assert_eq!(cutout(alpha, json.clone()), expected, "{alpha:?} {json}");
    }
}

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

#[test]
fn reuse_is_exact_where_nodes_move_and_skins_bend() {
    let mut file = bent();
    let mesh = file.triangle();
    let pivot = file.root(json!({"children": [], "translation": [0, 0, -1]}));
    let turning = file.node(json!({"mesh": mesh, "translation": [1, 0, 0]}));
    file.json["nodes"][pivot]["children"] = json!([turning]);
    let turn = file.floats("VEC4", 4, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.70710677, 0.0, 0.70710677]);
    file.animate(pivot, "rotation", "LINEAR", &[0.0, 0.5], turn);
    let light = "[[light]]\ntype = \"point\"\nposition = [2, 3, 6]\npower = 30\n[floor]\nheight = -0.5\n";
    let text = format!("[render]\nsize = [64, 48]\n{CAMERA}[[model]]\ngltf = \"m.gltf\"\n{light}");
    let shot = load_in(folder(&file).path(), &text, true).unwrap();
    let settings = Settings { audit: true, mode: Mode::Reproject, ..shot.settings.clone() };
    let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
    for frame in 1..=4 {
        let finished = renderer.render(frame, true).unwrap();
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.differing, 0, "frame {frame}: {audit:?}");
    }
}

#[test]
fn what_is_damaged_is_an_error_that_says_so() {
    let good = || {
        let mut file = File::new();
        let positions = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        let indices = file.indices(&[0, 1, 2]);
        let mesh =
            file.mesh(json!({"attributes": {"POSITION": positions}, "indices": indices, "material": 0}));
        file.add("materials", json!({}));
        let node = file.root(json!({"mesh": mesh}));
        let there = file.vectors(&[[0.0; 3], [1.0, 0.0, 0.0]]);
        file.animate(node, "translation", "LINEAR", &[0.0, 1.0], there);
        file
    };
    assert_eq!(load(&good(), "").scene.models.len(), 1);
    let mut others = Vec::new();
    for (pointer, value, expected) in [
        ("/nodes/0/children", json!([7]), "it names node 7, and there are 1 of them"),
        ("/nodes/0/children", json!([0]), "node 0 stands below itself"),
        ("/nodes/0/mesh", json!(3), "it names mesh 3"),
        ("/nodes/0/skin", json!(0), "it names skin 0, and there are 0"),
        (
            "/nodes/0/matrix",
            json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "node 0 has a place that is not finite",
        ),
        ("/nodes/0/translation", json!([1e300, 0, 0]), "node 0 has a place that is not finite"),
        ("/nodes/0/scale", json!([0, 0, 0]), "it shows no triangles"),
        ("/scenes/0/nodes", json!([4]), "it names node 4"),
        ("/scenes/0/nodes", json!([]), "it shows no triangles"),
        ("/scene", json!(2), "it names scene 2"),
        ("/meshes/0/primitives/0/attributes", json!({}), "a mesh has no positions (POSITION)"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(70), "it names accessor 70"),
        (
            "/meshes/0/primitives/0/attributes/NORMAL",
            json!(2),
            "mesh 0 has 3 positions and 2 entries of NORMAL",
        ),
        ("/meshes/0/primitives/0/indices", json!(3), "accessor 3 has indices that are no whole numbers"),
        ("/meshes/0/primitives/0/mode", json!(9), "mesh 0 has the mode 9"),
        ("/meshes/0/primitives/0/material", json!(9), "it names material 9"),
        ("/accessors/0/count", json!(4), "accessor 0 ends behind its bufferView"),
        ("/accessors/0/count", json!(1_u64 << 62), "accessor 0 has too many elements"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "accessor 0 ends behind its bufferView"),
        ("/accessors/0/componentType", json!(7), "accessor 0 has the componentType 7"),
        ("/accessors/0/type", json!("VEC2"), "accessor 0 is of type VEC2, and 3 numbers are needed"),
        ("/accessors/0/bufferView", json!(40), "it names bufferView 40"),
        ("/accessors/0/count", json!(2), "mesh 0 has a triangle at vertex 2, and 2 vertices"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "bufferView 0 ends behind buffer 0"),
        ("/bufferViews/0/buffer", json!(1), "it names buffer 1"),
        ("/animations/0/channels/0/sampler", json!(1), "it names animation sampler 1"),
        ("/animations/0/channels/0/target/node", json!(5), "node 5, and there are 1"),
        ("/animations/0/samplers/0/input", json!(0), "accessor 0 is of type VEC3, and 1 numbers are needed"),
        ("/animations/0/samplers/0/output", json!(0), "has not as many values as times"),
        ("/animations/0/samplers/0/interpolation", json!("X"), "has an unknown interpolation"),
        ("/materials/0/emissiveFactor", json!([-1, 0, 0]), "has a colour that is negative"),
        (
            "/materials/0/pbrMetallicRoughness",
            json!({"baseColorTexture": {"index": 3}}),
            "it names texture 3",
        ),
        (
            "/materials/0/extensions",
            json!({"KHR_materials_ior": {"ior": "x"}}),
            "the extension `KHR_materials_ior` makes no sense",
        ),
        ("/asset/version", json!("1.0"), "it is no glTF file of version 2 but of version 1.0"),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "its geometry is packed with `KHR_draco_mesh_compression`",
        ),
        ("/extensionsRequired", json!(["EXT_new"]), "it requires the extension `EXT_new`"),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "../a.bin"}]),
            "buffer 0 `../a.bin` leads out of its folder",
        ),
        ("/buffers", json!([{"byteLength": 4, "uri": "/a.bin"}]), "leads out of its folder"),
        ("/buffers", json!([{"byteLength": 4, "uri": "http://a.b/c"}]), "is no file beside it"),
        (
            "/buffers",
            json!([{"byteLength": 4, "uri": "a.bin"}]),
            "buffer 0 is the file `a.bin`, which cannot be found",
        ),
        (
            "/buffers",
            json!([{"byteLength": 40, "uri": "data:;base64,AAAA"}]),
            "buffer 0 has 3 bytes, and should have 40",
        ),
        ("/buffers", json!([{"byteLength": 4, "uri": "data:;base64,A*"}]), "buffer 0 is not base64"),
        ("/buffers", json!([{"byteLength": 4}]), "buffer 0 has no bytes"),
        ("/nodes", json!(7), "the JSON of this glTF file cannot be read"),
    ] {
        let mut file = good();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match file.json.pointer_mut(parent).unwrap() {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
            object => object[key] = value,
        }
        let error = error(&file);
        if !(error.starts_with("m.gltf: ") && error.contains(expected)) {
            others.push(format!("{pointer}: {error}"));
        }
    }
    assert!(others.is_empty(), "{others:#?}");
    // numbers that are none
    for (bytes, expected) in [
        (f32::NAN.to_le_bytes(), "a position of mesh 0 is not finite"),
        (1e30_f32.to_le_bytes(), "a position of mesh 0 is not finite"),
    ] {
        let mut file = good();
        file.bytes[..4].copy_from_slice(&bytes);
        assert!(error(&file).contains(expected));
    }
    for times in [[1.0, 1.0], [-1.0, 1.0], [0.0, f32::NAN], [0.0, 1e30]] {
        let mut file = good();
        let input = file.floats("SCALAR", 1, &times);
        file.json["animations"][0]["samplers"][0]["input"] = json!(input);
        assert!(error(&file).contains("has times that do not rise from 0 on"), "{times:?}");
    }
}

/// However a file is cut off or changed, it is read or refused, and nothing else.
#[test]
fn no_damage_stops_the_program() {
    let glb = bent().glb();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.glb");
    let mut refused = 0;
    let mut try_out = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        refused += usize::from(scene::load(&path, false).is_err());
    };
    (0..glb.len()).step_by(61).for_each(|end| try_out(&glb[..end]));
    for at in (0..glb.len()).step_by(17) {
        let mut changed = glb.clone();
        changed[at] ^= 0x11;
        try_out(&changed);
    }
    assert!(refused > 50, "{refused}");
}
