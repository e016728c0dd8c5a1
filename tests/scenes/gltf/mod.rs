//! glTF files: is the geometry that of the file, and does each node stand where its parents put it at all times?

mod alpha;
mod cameras;
mod damage;
mod materials;
mod two_sets;
mod whole;

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
        let [found, same] = [&shot, &expected].map(|shot| shot.scene.models[0].mesh.triangles());
        assert_eq!(found.positions.as_slice(), same.positions.as_slice());
        assert_eq!(found.corners, same.corners);
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
    let mesh = shot.scene.models[0].mesh.triangles();
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
    assert_eq!(*shot.scene.models[0].mesh.triangles().corners, expected, "and none without an area");
    assert_eq!(shot.scene.models[0].mesh.triangles().positions.as_slice().len(), 5, "vertices are shared");
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
        let positions = model.mesh.triangles().positions.as_slice();
        positions.iter().map(|at| place(model, 1.0, Vec3::from(*at))).collect()
    };
    assert_near(corners(tip)[1], DVec3::new(-2.0, 2.0, 5.0));
    assert_near(corners(arm)[0], DVec3::new(-4.0, 0.0, 5.0));
    // the outside stays outside: of a mirror image the corners come in the other order
    let facing = |model: &Model| {
        let at = corners(model);
        let [a, b, c] = model.mesh.triangles().corners[0].map(|corner| at[corner as usize]);
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
        shot.scene.models.iter().map(|model| model.mesh.triangles().positions.as_slice()[1]).collect();
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
    let shapes = shot.scene.models[model].mesh.shapes().unwrap();
    shapes.positions(&Pose::new(&shot.scene, frame).models[model].shape.ends[0])
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

/// Where frames are blurred, joints bend along arcs between them as well: the chord of a quarter of a frame is all but the arc.
#[test]
fn skins_bend_between_frames_that_are_blurred() {
    let lies_off = |shutter: &str| {
        let shot = load(&bent(), shutter);
        let Model { mesh, track, .. } = &shot.scene.models[0];
        let (shapes, track) = (mesh.shapes().unwrap(), track.shapes.as_ref().unwrap());
        let off = |quarter: u32| {
            let frame = 4.0 + f64::from(quarter) / 4.0;
            let tip = Vec3::from(shapes.positions(&track.at(frame))[4]).as_dvec3();
            let angle = (frame - 1.0) / 12.0 * FRAC_PI_2;
            (tip - DVec3::new(1.0, 1.0, 0.0) - DVec3::new(0.0, angle.cos(), angle.sin())).length()
        };
        (0..=4).map(off).fold(0.0, f64::max)
    };
    let [sharp, blurred] = ["", "[shutter]\nopen = 0\nclose = 0.5\n"].map(lies_off);
    // half of the angle of a frame, in radians, squared and halved
    assert!(blurred < 1e-6 && (sharp - 0.00214).abs() < 1e-4, "{sharp} {blurred}");
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
        still.shapes().is_none() && still.triangles().positions.as_slice()[2] == [0.0, 2.0, 0.0],
        "half of the first one"
    );
}

/// Faces that are closed up in the file, and opened by a target, are there: in motion, and where a weight holds them open.
#[test]
fn targets_open_what_is_closed_at_rest() {
    let mut file = File::new();
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    let positions = file.vectors(&corners);
    let up = file.vectors(&[[0.0; 3], [0.0; 3], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]]);
    // the last one is closed for ever
    let indices = file.indices(&[0, 1, 2, 0, 2, 3, 0, 1, 4]);
    let attributes = json!({"POSITION": positions});
    let mesh = json!({"attributes": attributes, "indices": indices, "targets": [{"POSITION": up}]});
    let [moving, held] = [0.0, 1.0].map(|weight| {
        let mesh = file.mesh(mesh.clone());
        file.json["meshes"][mesh]["weights"] = json!([weight]);
        file.root(json!({"mesh": mesh}))
    });
    let weights = file.floats("SCALAR", 1, &[0.0, 1.0]);
    file.animate(moving, "weights", "LINEAR", &[0.0, 0.5], weights);
    let shot = load(&file, "");
    for model in [moving, held] {
        let mesh = shot.scene.models[model].mesh.triangles();
        assert_eq!(mesh.corners.len(), 2, "{model}");
        assert!(mesh.positions.as_slice()[2][1] > 0.0, "samples are kept where it is open");
    }
    assert_eq!(deformed(&shot, moving, 1)[2], [1.0, 0.0, 0.0]);
    assert_eq!(deformed(&shot, moving, 13)[2], [1.0, 1.0, 0.0]);
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

/// A file with a skin, an animation and a camera, as text and as binary.
pub fn whole_files() -> (String, Vec<u8>) {
    let mut file = bent();
    file.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    let eye = file.root(json!({"camera": 0, "translation": [0, 1, 8]}));
    let there = file.vectors(&[[0.0, 1.0, 8.0], [0.0, 1.0, 4.0]]);
    file.animate(eye, "translation", "LINEAR", &[0.0, 0.5], there);
    (file.text(), file.glb())
}
