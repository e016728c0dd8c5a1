//! Is a PLY file a model as an OBJ file is: in a shot, bare, and with a material?

use std::fs;
use std::path::Path;

use afterimage::frame::Renderer;
use afterimage::scene::{self, Shot};
use afterimage::settings::{Mode, Settings};
use glam::Vec3;

use afterimage::scene::on_mesh::OnMesh;

use crate::small_shot::{folder, load_in};

const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0 255 0 0 0 0\n1 0 0 255 0 0 1 0\n1 1 0 0 0 0 1 1\n0 1 0 0 0 0 0 1\n4 0 1 2 3\n";

fn ply_folder() -> tempfile::TempDir {
    let folder = folder();
    fs::write(folder.path().join("square.ply"), PLY).unwrap();
    folder
}

fn shot(models: &str) -> Shot {
    load_in(ply_folder().path(), &format!("{CAMERA}{models}"), true).unwrap()
}

fn error(models: &str) -> String {
    let folder = ply_folder();
    let error = load_in(folder.path(), &format!("{CAMERA}{models}"), true).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}

#[test]
fn a_file_is_a_model() {
    let shot = shot("[[model]]\nply = \"square.ply\"\n[[model]]\nply = \"square.ply\"\nname = \"copy\"\n");
    let names: Vec<&str> = shot.scene.models.iter().map(|model| model.name.as_str()).collect();
    assert_eq!(names, ["square", "copy"]);
    let mesh = &shot.scene.models[0].mesh;
    assert_eq!((mesh.count(), mesh.triangles().uvs.len()), (2, 4));
}

/// Bytes are as screens show them, and a file without a material shows them alone.
#[test]
fn colours_of_vertices_are_those_of_the_surface() {
    let shot = shot("[[model]]\nply = \"square.ply\"\n");
    let mesh = &shot.scene.models[0].mesh;
    let colors: Vec<_> = mesh.details.colors.iter().map(|color| color.map(f32::from)).collect();
    assert_eq!(colors, [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
    let material = &shot.scene.materials[usize::from(mesh.material_of[0])];
    assert!(material.has_vertex_colors && material.diffuse == Vec3::ONE);
    let place = OnMesh::new(mesh, 0, [0.25, 0.5]);
    assert_eq!(place.reflectance(&shot.scene, material), Vec3::new(0.5, 0.0, 0.0));
}

#[test]
fn its_material_has_its_name() {
    let with = |material: &str| shot(&format!("[[model]]\nply = \"square.ply\"\n{material}"));
    let plain = with("");
    let red = with("[[material]]\nname = \"square\"\nkd = [1, 0, 0]\n");
    let of =
        |shot: &Shot| shot.scene.materials[usize::from(shot.scene.models[0].mesh.material_of[0])].clone();
    assert!(of(&plain).is_fallback());
    assert_eq!((of(&red).name.as_str(), of(&red).diffuse), ("square", Vec3::X));
}

#[test]
fn faces_have_materials_by_their_numbers() {
    let folder = folder();
    let file = "ply\nformat ascii 1.0\ncomment material Dark red\ncomment material blue\nelement vertex 4\n\
                property float x\nproperty float y\nproperty float z\nelement face 3\n\
                property list uchar int vertex_indices\nproperty uchar material_index\nend_header\n\
                0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 1\n3 0 2 3 0\n3 0 1 3 1\n";
    fs::write(folder.path().join("two.ply"), file).unwrap();
    let text = "[[model]]\nply = \"two.ply\"\n[[material]]\nname = \"Dark red\"\nkd = [0.5, 0, 0]\n\
                [[material]]\nname = \"blue\"\nkd = [0, 0, 1]\n";
    let shot = load_in(folder.path(), &format!("{CAMERA}{text}"), true).unwrap();
    let names = |shot: &Shot| {
        let of = |id: &u16| shot.scene.materials[usize::from(*id)].name.clone();
        shot.scene.models[0].mesh.material_of.iter().map(of).collect::<Vec<_>>()
    };
    assert_eq!(
        (shot.scene.models.len(), names(&shot)),
        (1, ["blue", "Dark red", "blue"].map(String::from).to_vec())
    );
    let wrong = file.replace("3 0 2 3 0", "3 0 2 3 2");
    fs::write(folder.path().join("two.ply"), wrong).unwrap();
    let error = load_in(folder.path(), &format!("{CAMERA}{text}"), true).unwrap_err().to_string();
    assert!(error.contains("face 1 has material 2, and 2 are named"), "{error}");
}

#[test]
fn a_bare_file_is_a_turntable() {
    let folder = ply_folder();
    let shot = scene::load(&folder.path().join("square.ply"), true).unwrap();
    assert_eq!(shot.scene.models[0].name, "square");
    assert_eq!(shot.files.iter().filter(|file| file.ends_with(Path::new("square.ply"))).count(), 1);
}

#[test]
fn what_goes_with_other_files_is_refused() {
    for (keys, expected) in [
        ("ply = \"square.ply\"\nobj = \"m.obj\"\n", "s.toml:6:7: `ply` and `obj` exclude each other"),
        ("ply = \"square.ply\"\nsplit = \"objects\"\n", "s.toml:7:9: `split` goes with `obj`"),
        (
            "ply = \"square.ply\"\nshapes = { obj = \"a.#.obj\" }\n",
            "s.toml:7:10: `shapes` are those of an OBJ file",
        ),
        ("ply = \"none.ply\"\n", "s.toml:6:7: `ply`: there is no file `none.ply`"),
        ("ply = \"m.obj\"\n", "s.toml:6:7: `ply` is `m.obj`: PLY files end in .ply"),
        ("obj = \"square.ply\"\n", "s.toml:6:7: `obj` is a PLY file, by its ending: write `ply` instead"),
    ] {
        let message = error(&format!("[[model]]\n{keys}"));
        assert!(message.starts_with(expected), "for\n{keys}\nexpected {expected}\ngot      {message}");
    }
    let folder = ply_folder();
    fs::write(folder.path().join("square.ply"), PLY.replace("1 1 0 0", "1 x 0 0")).unwrap();
    let message =
        load_in(folder.path(), &format!("{CAMERA}[[model]]\nply = \"square.ply\"\n"), true).unwrap_err();
    assert!(message.to_string().contains("square.ply:17: `x` is no number"), "{message}");
}

#[test]
fn reuse_is_exact_on_parts_and_ply_files() {
    let parts = "[[model]]\nobj = \"parts.obj\"\nsplit = \"objects\"\ntranslate = [-1, 0, 0]\n";
    let moving = "[[model]]\nply = \"square.ply\"\n[[model.key]]\nframe = 1\n[[model.key]]\nframe = 4\ntranslate = [1, 0, 1]\n";
    let light = "[[light]]\ntype = \"point\"\nposition = [2, 3, 4]\n";
    let folder = ply_folder();
    let obj = crate::small_shot::OBJ;
    fs::write(folder.path().join("parts.obj"), obj.replace("usemtl", "o part\nusemtl")).unwrap();
    let text = format!("[render]\nsize = [48, 27]\n{CAMERA}{parts}{moving}{light}");
    let shot = load_in(folder.path(), &text, true).unwrap();
    let settings = Settings { audit: true, mode: Mode::Reproject, ..shot.settings.clone() };
    let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
    for frame in 1..=4 {
        let audit = renderer.render(frame, true).unwrap().stats.audit.unwrap();
        assert_eq!(audit.differing, 0, "frame {frame}: {audit:?}");
    }
}
