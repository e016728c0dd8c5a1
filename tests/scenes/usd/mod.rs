//! USD files: does each mesh stand where its parents put it, in metres and with Y up, with its materials, cameras and lights?

mod curves;
mod damage;
mod implicit;
mod materials;
mod networks;
mod pipeline;
mod reads;
mod skeletons;
mod subdivision;
mod volumes;
mod whole;

use std::fs;
use std::sync::Arc;

use afterimage::scene::{self, Mesh, Model, SceneError, Shot};
use glam::{DVec3, Vec2, Vec3};
use tempfile::TempDir;

/// A triangle at (0, 0, 0), (1, 0, 0) and (0, 1, 0), up to its last brace.
const TRIANGLE: &str = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n\
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\nuniform token subdivisionScheme = \"none\"\n";

/// Camera of a shot file.
const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\n";

/// Metadata of a file in metres with Y up.
const METRES: &str = "metersPerUnit = 1\nupAxis = \"Y\"\n";

fn folder(metadata: &str, prims: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.usda"), format!("#usda 1.0\n(\n{metadata})\n{prims}")).unwrap();
    folder
}

fn load(metadata: &str, prims: &str) -> Result<Shot, SceneError> {
    scene::load(&folder(metadata, prims).path().join("m.usda"), false)
}

/// Shot of these prims, which need no warning.
fn shown(metadata: &str, prims: &str) -> Shot {
    let shot = load(metadata, prims).unwrap();
    let told: Vec<String> = shot.warnings.iter().map(ToString::to_string).collect();
    assert!(told.is_empty(), "{told:?}");
    shot
}

/// Place of a corner of a model's mesh in the world.
fn corner(model: &Model, frame: f64, corner: usize) -> DVec3 {
    let position = Vec3::from(model.mesh.triangles().positions.as_slice()[corner]);
    model.track.map_at(frame).transform_point3(position.as_dvec3())
}

/// Names of the models, without that of the floor of a turntable.
fn names(shot: &Shot) -> Vec<&str> {
    let names = shot.scene.models.iter().map(|model| model.name.as_str());
    names.filter(|name| *name != "floor").collect()
}

fn model<'a>(shot: &'a Shot, name: &str) -> &'a Model {
    let found = shot.scene.models.iter().find(|model| model.name == name);
    found.unwrap_or_else(|| panic!("{name}: {:?}", names(shot)))
}

fn assert_near(a: DVec3, b: DVec3) {
    assert!(a.abs_diff_eq(b, 1e-6), "{a} {b}");
}

#[test]
fn prims_stand_where_their_parents_put_them_with_y_up_in_metres() {
    let prims = format!(
        "def Xform \"A\" {{\n double3 xformOp:translate = (100, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n\
         def Mesh \"M\" {{\n {TRIANGLE} float xformOp:rotateZ = 90\n float3 xformOp:scale = (2, 2, 2)\n\
         uniform token[] xformOpOrder = [\"xformOp:rotateZ\", \"xformOp:scale\"]\n}}\n\
         def Mesh \"N\" {{\n {TRIANGLE} uniform token[] xformOpOrder = [\"!resetXformStack!\"]\n}} }}\n"
    );
    let shot = shown("metersPerUnit = 0.01\nupAxis = \"Z\"\n", &prims);
    let place = |name: &str, number| corner(model(&shot, name), 1.0, number);
    assert_near(place("m/A/M", 1), DVec3::new(1.0, 0.0, -0.02));
    assert_near(place("m/A/M", 2), DVec3::new(0.98, 0.0, 0.0));
    assert_near(place("m/A/N", 2), DVec3::new(0.0, 0.0, -0.01));
}

#[test]
fn time_codes_are_frames_and_turned_things_stay_on_their_circles() {
    let prims = format!(
        "def Mesh \"M\" {{\n {TRIANGLE} float xformOp:rotateY.timeSamples = {{ 10: 0, 14: 180 }}\n\
         uniform token[] xformOpOrder = [\"xformOp:rotateY\"]\n\
         token visibility.timeSamples = {{ 10: \"inherited\", 13: \"invisible\" }}\n}}\n"
    );
    let file = format!(
        "{METRES}startTimeCode = 10\nendTimeCode = 14\ntimeCodesPerSecond = 48\nframesPerSecond = 24\n"
    );
    let shot = shown(&file, &prims);
    let model = &shot.scene.models[0];
    assert_near(corner(model, 6.0, 1), DVec3::NEG_Z);
    assert!((corner(model, 5.25, 1).length() - 1.0).abs() < 1e-9);
    assert!(model.track.visible.at(6.0) && !model.track.visible.at(6.5));
}

#[test]
fn points_with_times_are_shapes() {
    let prims = "def Mesh \"M\" {\n int[] faceVertexCounts = [4]\n int[] faceVertexIndices = [0, 1, 2, 3]\n\
        uniform token subdivisionScheme = \"none\"\n point3f[] points.timeSamples = {\n\
        1: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],\n 3: [(0, 0, 0), (1, 0, 0), (1, 1, 2), (0, 1, 2)] }\n}\n";
    let shot = shown(METRES, prims);
    let model = &shot.scene.models[0];
    let shapes = model.mesh.shapes().unwrap();
    let half = shapes.positions(&model.track.shapes.as_ref().unwrap().at(2.0));
    assert_eq!((half[2], model.mesh.count()), ([1.0, 1.0, 1.0], 2));
}

#[test]
fn purpose_and_visibility_say_what_is_shown() {
    let prims = format!(
        "def Xform \"Proxy\" {{\n uniform token purpose = \"proxy\"\n def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Xform \"Guide\" {{\n uniform token purpose = \"guide\"\n def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Xform \"Render\" {{\n uniform token purpose = \"render\"\n def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Xform \"Away\" {{\n token visibility = \"invisible\"\n def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def Mesh \"Off\" (active = false) {{ {TRIANGLE} }}\nclass Mesh \"Class\" {{ {TRIANGLE} }}\n"
    );
    let shot = shown(METRES, &prims);
    assert_eq!(names(&shot), ["m/Render/M"]);
}

fn shared<'a>(shot: &'a Shot, names: &[&str]) -> &'a Arc<Mesh> {
    let meshes: Vec<&Arc<Mesh>> = names.iter().map(|name| &model(shot, name).mesh).collect();
    assert!(meshes.windows(2).all(|pair| Arc::ptr_eq(pair[0], pair[1])), "{names:?}");
    meshes[0]
}

#[test]
fn instances_and_copies_share_their_mesh() {
    let prims = format!(
        "class \"Proto\" {{ def Mesh \"M\" {{ {TRIANGLE} }} }}\n\
         def \"A\" (instanceable = true\n references = </Proto>) {{}}\ndef \"B\" (instanceable = true\n references = </Proto>) {{}}\n\
         def Mesh \"C\" {{ {TRIANGLE} }}\n\
         def PointInstancer \"P\" {{\n rel prototypes = [</P/T>]\n int[] protoIndices = [0, 0, 0]\n int64[] invisibleIds = [1]\n\
         point3f[] positions = [(1, 0, 0), (2, 0, 0), (3, 0, 0)]\n float3[] scales = [(2, 2, 2), (1, 1, 1), (1, 1, 1)]\n\
         quath[] orientations = [(0.7071068, 0, 0, 0.7071068), (1, 0, 0, 0), (1, 0, 0, 0)]\n\
         over Xform \"T\" {{ def Mesh \"M\" {{ {TRIANGLE} }} }} }}\n"
    );
    let folder = folder(METRES, &prims);
    let path = folder.path().join("s.toml");
    fs::write(&path, format!("{CAMERA}[[model]]\nusd = \"m.usda\"\n")).unwrap();
    let shot = scene::load_sharing(&path, false, 0).unwrap();
    assert_eq!(shot.scene.models.len(), 5);
    shared(&shot, &["m/A/M", "m/B/M", "m/C", "m/P/0/T/M", "m/P/2/T/M"]);
    let turned = corner(model(&shot, "m/P/0/T/M"), 1.0, 1);
    assert!(turned.abs_diff_eq(DVec3::new(1.0, 2.0, 0.0), 2e-3), "half floats: {turned}");
}

#[test]
fn a_shot_file_names_and_moves_a_usd_file() {
    let folder = folder(METRES, &format!("def Mesh \"M\" {{ {TRIANGLE} }}"));
    let shot = format!("{CAMERA}[[model]]\nusd = \"m.usda\"\nname = \"set\"\ntranslate = [5, 0, 0]\n");
    let path = folder.path().join("s.toml");
    fs::write(&path, &shot).unwrap();
    let loaded = scene::load(&path, true).unwrap();
    let model = model(&loaded, "set/M");
    assert_near(corner(model, 1.0, 0), DVec3::X * 5.0);
    fs::write(&path, format!("{shot}gltf = \"a.glb\"\n")).unwrap();
    let why = scene::load(&path, true).err().unwrap().message;
    assert!(why.contains("`gltf` and `usd` exclude each other"), "{why}");
}

#[test]
fn normals_and_sides_are_those_of_the_file() {
    let mesh = |more: &str| {
        let triangle = TRIANGLE.replace("uniform token subdivisionScheme = \"none\"\n", "");
        load(METRES, &format!("def Mesh \"M\" {{ {triangle} {more} }}")).unwrap()
    };
    let none = "uniform token subdivisionScheme = \"none\"\n";
    let normals =
        "normal3f[] normals = [(0, 0, 2), (0, 1, 0), (0, 1, 0)] ( interpolation = \"faceVarying\" )\n";
    let polygons = mesh(&format!("{none}{normals}"));
    assert_eq!(polygons.scene.models[0].mesh.triangles().normals, [Vec3::Z, Vec3::Y, Vec3::Y]);
    let left = mesh(&format!("{none} uniform token orientation = \"leftHanded\"\n"));
    let [a, b, c] = left.scene.models[0].mesh.triangles().positions_of(0);
    assert!((b - a).cross(c - a).z < 0.0);
    // subdivided, unless it says otherwise: the surface has normals of its own
    let cage = mesh(normals);
    let own = &cage.scene.models[0].mesh.triangles().normals;
    assert!(own.len() > 3 && own.iter().all(|normal| normal.abs_diff_eq(Vec3::Z, 1e-6)));
    assert!(cage.warnings.is_empty());
}
