//! Meshes that are given, and what is refused of them.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use glam::{DAffine3, DVec3, Vec3};

use super::*;
use crate::scene::material::Optics;

const TEXT: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n\n[[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\n";

/// A square of two faces, the second of which is `material_of`'s.
fn square() -> GivenMesh {
    GivenMesh {
        name: String::from("square"),
        points: vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
        corners: vec![0, 1, 2, 0, 2, 3],
        ..GivenMesh::default()
    }
}

fn at(x: f64) -> Vec<(f64, DAffine3)> {
    vec![(1.0, DAffine3::from_translation(DVec3::X * x))]
}

fn one(mesh: GivenMesh) -> Given {
    let model = GivenModel {
        name: String::from("one"),
        mesh: 0,
        places: at(0.0),
        is_visible: true,
        ray_visibility: Default::default(),
        linked: Default::default(),
        visible: Vec::new(),
    };
    Given { meshes: vec![Arc::new(mesh)], models: vec![model] }
}

#[test]
fn a_polygon_becomes_triangles_and_corners_become_vertices() {
    let mut mesh = square();
    (mesh.corners, mesh.counts) = (vec![0, 1, 2, 3], Some(vec![4]));
    mesh.check().unwrap();
    let shot = shot(TEXT, one(mesh), false).unwrap();
    assert_eq!(shot.scene.models[0].mesh.count(), 2);
    assert_eq!(shot.scene.models[0].name, "one");
    // two corners of one point with different coordinates are two vertices
    let mut mesh = square();
    mesh.uvs = vec![[0., 0.], [1., 0.], [1., 1.], [0.5, 0.5], [1., 1.], [0., 1.]];
    mesh.check().unwrap();
    let shot = super::shot(TEXT, one(mesh), false).unwrap();
    assert_eq!(shot.scene.models[0].mesh.triangles().uvs.len(), 5);
}

#[test]
fn faces_find_their_materials() {
    let mut mesh = square();
    mesh.materials = vec![String::from("red"), String::from("glow")];
    mesh.material_of = vec![1, 0];
    let text = format!(
        "{TEXT}\n[[material]]\nname = \"red\"\nkd = [1, 0, 0]\n\n[[material]]\nname = \"glow\"\nke = [2, 2, 2]\n"
    );
    let shot = shot(&text, one(mesh.clone()), true).unwrap();
    let of = &shot.scene.models[0].mesh.material_of;
    let names: Vec<&str> =
        of.iter().map(|number| shot.scene.materials[usize::from(*number)].name.as_str()).collect();
    assert_eq!(names, ["red", "glow"]);
    mesh.materials[1] = String::from("glwo");
    let error = super::shot(&text, one(mesh), true).unwrap_err().to_string();
    assert_eq!(error, "scene: mesh `square`: there is no material `glwo`: did you mean `glow`?: add it");
}

#[test]
fn a_material_that_transmits_is_glass() {
    let material = |keys: &str| {
        let text = format!("{TEXT}\n[[material]]\nname = \"glass\"\n{keys}\n");
        let mesh = GivenMesh { materials: vec![String::from("glass")], ..square() };
        shot(&text, one(mesh), true).unwrap().scene.materials[0].clone()
    };
    let half = material("kd = [1, 0.5, 0.5]\nni = 1.5\ntransmission = 0.5");
    let Optics::Glass { transmission, index, .. } = half.optics else { panic!("{half:?}") };
    assert_eq!((transmission, index, half.metal_rough), (Vec3::new(0.5, 0.25, 0.25), 1.5, None));
    // what does not go through is reflected as by any other surface
    assert!(half.diffuse.abs_diff_eq(Vec3::new(0.5, 0.25, 0.25), 1e-6), "{half:?}");
    assert_eq!(material("kd = [1, 0.5, 0.5]\npr = 0.3\ntransmission = 0").optics, Optics::Opaque);
    let rough = material("ni = 1.5\npr = 0.3\ntransmission = 1");
    assert!(
        rough.is_rough_glass() && rough.metal_rough.is_some_and(|layer| layer.roughness == 0.3),
        "{rough:?}"
    );
}

#[test]
fn errors_name_the_table_instead_of_a_line() {
    let text = format!("{TEXT}\n[[material]]\nname = \"red\"\npr = 7\n");
    let error = shot(&text, one(square()), false).unwrap_err().to_string();
    assert!(error.starts_with("scene: material `red`: `pr` is 7"), "{error}");
    let text = TEXT.replace("direction = [0, 0, -1]", "directoin = [0, 0, -1]");
    let error = shot(&text, one(square()), false).unwrap_err().to_string();
    assert!(
        error.starts_with("scene: light 1: unknown key `directoin`: did you mean `direction`?"),
        "{error}"
    );
}

#[test]
fn copies_share_a_mesh_and_shapes_deform_it() {
    let mut given = one(square());
    given.models.push(GivenModel { name: String::from("two"), places: at(3.0), ..given.models[0].clone() });
    let mut keys = at(5.0);
    keys.push((9.0, DAffine3::from_translation(DVec3::X * 9.0)));
    given.models.push(GivenModel { places: keys, ..given.models[0].clone() });
    given.models.push(GivenModel { is_visible: false, ..given.models[0].clone() });
    let shot = shot(TEXT, given, true).unwrap();
    assert_eq!(shot.scene.models.len(), 3, "one is never visible");
    let mut mesh = square();
    mesh.shapes = vec![(1.0, mesh.points.clone()), (5.0, vec![[0., 0., 2.]; 4])];
    mesh.shapes[1].1[1] = [7., 0., 2.];
    let shot = super::shot(TEXT, one(mesh), true).unwrap();
    assert_eq!(shot.scene.models[0].mesh.shapes().map(|shapes| shapes.list().len()), Some(2));
    assert!(shot.scene.models[0].track.shapes.is_some());
}

#[test]
fn meshes_that_make_no_sense_are_refused() {
    let wrong = |change: &dyn Fn(&mut GivenMesh)| {
        let mut mesh = square();
        change(&mut mesh);
        mesh.check().unwrap_err()
    };
    for (error, words) in [
        (wrong(&|mesh| mesh.corners.clear()), "no faces"),
        (wrong(&|mesh| mesh.corners[0] = 4), "a face is at vertex 4, and there are 4 vertices"),
        (wrong(&|mesh| mesh.counts = Some(vec![3, 4])), "do not add up to its 6 corners"),
        (wrong(&|mesh| mesh.corners.truncate(5)), "5 corners make no triangles"),
        (wrong(&|mesh| mesh.points[2][1] = f32::NAN), "a vertex is not finite"),
        (
            wrong(&|mesh| mesh.shapes = vec![(2.0, vec![[0.0; 3]])]),
            "1 vertices at frame 2 do not fit to its 4",
        ),
        (wrong(&|mesh| mesh.uvs = vec![[0.0; 2]; 5]), "`uv` has 5 entries"),
        (wrong(&|mesh| mesh.normals = vec![[f32::INFINITY; 3]; 4]), "`normals` has a number"),
        (wrong(&|mesh| mesh.material_of = vec![0]), "1 numbers of materials do not fit to 2 faces"),
        (wrong(&|mesh| mesh.material_of = vec![0, 1]), "a face has material 1, and there are 1"),
    ] {
        assert!(error.starts_with("mesh `square`: ") && error.contains(words), "{error}");
    }
    let mut flat = square();
    flat.points = vec![[1.0; 3]; 4];
    flat.check().unwrap();
    let error = shot(TEXT, one(flat), false).unwrap_err().to_string();
    assert!(error.contains("no mesh has a face with an area"), "{error}");
    let error = shot(TEXT, Given::default(), false).unwrap_err().to_string();
    assert!(error.contains("there is nothing to see"), "{error}");
}
