//! Objects and groups of an OBJ file as models: is each what the file says, and the file read once?

use std::path::Path;
use std::sync::Arc;

use afterimage::scene::{Model, Shot, Triangles};

use crate::small_shot::{folder, load_in};

const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";

/// Two objects, of which the second has two groups; a face before all of them; the first one goes on at the end.
const SCENE: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 0 1\nv 2 1 1\n\
                     f 1 2 3\no Cube\nusemtl wood\nf 2 4 3\no Ball\nusemtl clear\nf 2 5 4\ng top\nusemtl wood\nf 4 5 6\n\
                     o Cube\nf 1 2 4\n";

fn scene_folder() -> tempfile::TempDir {
    let folder = folder();
    std::fs::write(folder.path().join("scene.obj"), SCENE).unwrap();
    folder
}

fn shot(models: &str) -> Shot {
    load_in(scene_folder().path(), &format!("{CAMERA}{models}"), true).unwrap()
}

fn error(models: &str) -> String {
    let folder = scene_folder();
    let error = load_in(folder.path(), &format!("{CAMERA}{models}"), true).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}

/// Name, number of triangles and of vertices of each model.
fn told(shot: &Shot) -> Vec<(&str, usize, usize)> {
    let count = |model: &Model| (model.mesh.count(), model.mesh.triangles().positions.as_slice().len());
    shot.scene.models.iter().map(|model| (model.name.as_str(), count(model).0, count(model).1)).collect()
}

#[test]
fn a_group_is_what_stands_below_its_name() {
    for (group, triangles, vertices) in [("Cube", 2, 4), ("Ball", 2, 4), ("top", 1, 3), ("default", 1, 3)] {
        let shot = shot(&format!("[[model]]\nobj = \"scene.obj\"\ngroup = \"{group}\"\n"));
        assert_eq!(told(&shot), [(format!("scene/{group}").as_str(), triangles, vertices)]);
    }
}

#[test]
fn a_file_is_split_by_its_objects_or_its_groups() {
    let by = |by: &str| shot(&format!("[[model]]\nobj = \"scene.obj\"\nsplit = \"{by}\"\n"));
    assert_eq!(told(&by("objects")), [("scene/default", 1, 3), ("scene/Cube", 2, 4), ("scene/Ball", 2, 4)]);
    assert_eq!(
        told(&by("groups")),
        [("scene/default", 1, 3), ("scene/Cube", 2, 4), ("scene/Ball", 1, 3), ("scene/top", 1, 3)]
    );
}

#[test]
fn parts_are_where_they_are_in_the_whole() {
    let corners = |shot: &Shot| {
        let of_model = |model: &Model| -> Vec<[[f32; 3]; 3]> {
            let Triangles { positions, corners, .. } = model.mesh.triangles();
            corners.iter().map(|corners| corners.map(|i| positions.as_slice()[i as usize])).collect()
        };
        let mut all: Vec<_> = shot.scene.models.iter().flat_map(of_model).collect();
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    let whole = corners(&shot("[[model]]\nobj = \"scene.obj\"\n"));
    assert_eq!(corners(&shot("[[model]]\nobj = \"scene.obj\"\nsplit = \"objects\"\n")), whole);
}

#[test]
fn parts_keep_their_materials_groups_and_shadows() {
    let shot = shot("[[model]]\nobj = \"scene.obj\"\nsplit = \"objects\"\n");
    let ball = &shot.scene.models[2].mesh;
    let materials = ball.material_of.iter().map(|of| shot.scene.materials[usize::from(*of)].name.as_str());
    // what is clear casts no shadow, and comes last
    assert_eq!(materials.collect::<Vec<_>>(), ["wood", "clear"]);
    assert_eq!(ball.shadow_casting, 1);
    let group = |triangle| ball.groups.names()[ball.groups.of(triangle)].as_str();
    assert_eq!([group(0), group(1)], ["top", "Ball"]);
}

#[test]
fn places_keys_and_names_go_on_top() {
    let shot = shot(
        "[[model]]\nobj = \"scene.obj\"\ngroup = \"Cube\"\nname = \"box\"\n[[model.key]]\nframe = 1\n\
         [[model.key]]\nframe = 3\ntranslate = [0, 4, 0]\n\
         [[model]]\nobj = \"scene.obj\"\nsplit = \"groups\"\nname = \"all\"\ntranslate = [9, 0, 0]\nreflection_map = 8\n",
    );
    let names: Vec<&str> = told(&shot).iter().map(|(name, ..)| *name).collect();
    assert_eq!(names, ["box", "all/default", "all/Cube", "all/Ball", "all/top"]);
    assert!((shot.scene.models[0].track.map_at(2.0).translation.y - 2.0).abs() < 1e-9);
    assert!(shot.scene.models[1..].iter().all(|model| model.reflection_map == Some(8)));
}

#[test]
fn the_file_is_read_once_and_copies_of_a_part_share_its_mesh() {
    let part = |group: &str, x: i32| {
        format!(
            "[[model]]\nobj = \"scene.obj\"\ngroup = \"{group}\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 2\n\
             translate = [{x}, 0, 0]\n"
        )
    };
    let shot = shot(&[part("Cube", 1), part("Cube", 2), part("Ball", 3)].concat());
    let [first, copy, other] = &shot.scene.models[..] else { panic!("three models") };
    assert!(Arc::ptr_eq(&first.mesh, &copy.mesh) && !Arc::ptr_eq(&first.mesh, &other.mesh));
    let is_scene = |file: &&std::path::PathBuf| file.file_name() == Path::new("scene.obj").file_name();
    assert_eq!(shot.files.iter().filter(is_scene).count(), 1);
}

#[test]
fn parts_that_are_not_there_are_told_with_the_nearest_names() {
    let with = |keys: &str| error(&format!("[[model]]\nobj = \"scene.obj\"\n{keys}"));
    for (keys, expected) in [
        (
            "group = \"cubes\"\n",
            "s.toml:7:9: `group` is `cubes`, and there is no such object (`o`) or group (`g`): did you mean `Cube`? \
             (there: `default`, `Cube`, `Ball`, `top`)",
        ),
        ("split = \"object\"\n", "s.toml:7:9: `split`: unknown value `object`: did you mean `objects`?"),
        ("group = \"Cube\"\nsplit = \"objects\"\n", "s.toml:7:9: `group` and `split` exclude each other"),
        (
            "split = \"objects\"\nshapes = { obj = \"scene.#.obj\" }\n",
            "s.toml:7:9: `split` and `shapes` exclude each other",
        ),
    ] {
        let message = with(keys);
        assert!(message.starts_with(expected), "for\n{keys}\nexpected {expected}\ngot      {message}");
    }
    let message = error("[[model]]\nquadric = { type = \"sphere\" }\ngroup = \"a\"\n");
    assert!(message.starts_with("s.toml:7:9: `group` goes with `obj`"), "{message}");
}

#[test]
fn a_file_without_parts_says_what_to_do() {
    let message = error("[[model]]\nobj = \"m.obj\"\nsplit = \"objects\"\n");
    assert!(message.starts_with("s.toml:7:9: `split` divides a file"), "{message}");
    let folder = scene_folder();
    let text = SCENE.replace("o Cube", "g Cube").replace("o Ball", "g Ball");
    std::fs::write(folder.path().join("scene.obj"), text).unwrap();
    let shot = format!("{CAMERA}[[model]]\nobj = \"scene.obj\"\nsplit = \"objects\"\n");
    let message = load_in(folder.path(), &shot, true).unwrap_err().to_string();
    assert!(message.contains("the file has none (`o`): write \"groups\" for its 4 groups"), "{message}");
}
