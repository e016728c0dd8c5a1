//! Cages of OBJ files, dicing and displacement: do the triangles lie on the limit surface, as finely as the shot's cameras see them, and
//! without cracks?

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use afterimage::scene::{self, Mesh, Shot, Triangles};
use glam::{DVec3, Vec3};
use tempfile::TempDir;

/// A cube from -1 to 1 with texture coordinates that have seams. Points from 0: x, then y, then z.
const CUBE: &str = "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\n\
    f 1/1 5/2 7/3 3/4\nf 2/1 4/2 8/3 6/4\nf 1/1 2/2 6/3 5/4\nf 3/1 7/2 8/3 4/4\nf 1/1 3/2 4/3 2/4\nf 5/1 6/2 8/3 7/4\n";

const CAMERA: &str = "[[camera.key]]\nframe = 1\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nfov = 30\n";

fn load_in(folder: &Path, shot: &str) -> Result<Shot, String> {
    let path = folder.join("s.toml");
    fs::write(&path, shot).unwrap();
    scene::load(&path, true).map_err(|error| error.to_string())
}

/// A folder with the cube, and tags behind it.
fn folder(tags: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("m.mtl"), "newmtl m\nKd .5 .5 .5\n").unwrap();
    fs::write(folder.path().join("cube.obj"), format!("mtllib m.mtl\n{CUBE}{tags}")).unwrap();
    folder
}

/// The cube with these tags, keys of its model and of the table `[render]`.
fn cube(tags: &str, model: &str, render: &str) -> Result<Shot, String> {
    let folder = folder(tags);
    load_in(
        folder.path(),
        &format!("[render]\nsize = [64, 64]\n{render}\n{CAMERA}[[model]]\nobj = \"cube.obj\"\n{model}\n"),
    )
}

const SMOOTH: &str = "subdivision = \"catmull-clark\"";

fn mesh(shot: &Shot) -> &Mesh {
    &shot.scene.models[0].mesh
}

fn positions(mesh: &Mesh) -> Vec<Vec3> {
    mesh.triangles().positions.as_slice().iter().map(|place| Vec3::from(*place)).collect()
}

/// Edges by the places of their ends, whatever vertices are there, that two triangles do not go along in opposite directions.
fn cracks(triangles: &Triangles, positions: &[[f32; 3]]) -> usize {
    let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for corners in triangles.corners.iter() {
        let places = corners.map(|corner| positions[corner as usize].map(|x| (x + 0.0).to_bits()));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (places[from], places[to]);
            *edges.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
        }
    }
    edges.values().filter(|count| **count != 0).count()
}

#[test]
fn a_cube_is_round_whole_and_smooth() {
    let shot = cube("", SMOOTH, "dicing = 4").unwrap();
    let (mesh, all) = (mesh(&shot), positions(mesh(&shot)));
    assert!(mesh.count() >= 6 * 2 * 16, "{}", mesh.count());
    // the corner of a cube goes half of its way to the middle, that of a face to the known place above it
    let nearest = |place: Vec3| all.iter().map(|at| at.distance(place)).fold(f32::MAX, f32::min);
    assert!(nearest(Vec3::splat(0.5)) < 1e-6);
    assert!(all.iter().all(|at| (0.8..1.0).contains(&at.length())), "it is about a ball");
    assert_eq!(cracks(mesh.triangles(), mesh.triangles().positions.as_slice()), 0);
    for (at, normal) in all.iter().zip(&mesh.triangles().normals) {
        assert!(normal.is_normalized() && normal.dot(at.normalize()) > 0.95, "{at} {normal}");
    }
    // each face has texture coordinates of its own, whose corners stay
    let uvs = &mesh.triangles().uvs;
    assert!(uvs.iter().all(|uv| uv.min_element() >= 0.0 && uv.max_element() <= 1.0));
    assert!([glam::Vec2::ZERO, glam::Vec2::ONE].iter().all(|corner| uvs.contains(corner)));
    let plain = cube("", "", "").unwrap();
    assert_eq!(self::mesh(&plain).count(), 12);
}

#[test]
fn creases_keep_their_edges() {
    let top = "t crease 5/1/0 4 5 7 6 4 10\nt corner 4/1/0 4 5 6 7 10\n";
    let shot = cube(top, SMOOTH, "dicing = 4").unwrap();
    let mesh = mesh(&shot);
    let flat: Vec<(Vec3, Vec3)> = positions(mesh)
        .into_iter()
        .zip(mesh.triangles().normals.iter().copied())
        .filter(|(at, _)| at.z == 1.0)
        .collect();
    assert!(flat.iter().any(|(at, _)| *at == Vec3::ONE), "corners stay");
    let inside = |at: &Vec3| at.x.abs() < 0.99 && at.y.abs() < 0.99;
    assert!(flat.iter().filter(|(at, _)| inside(at)).all(|(_, normal)| normal.abs_diff_eq(Vec3::Z, 1e-6)));
    // on an edge there are two normals, one a side
    let on_edge = |(at, normal): &&(Vec3, Vec3)| at.x == 1.0 && at.y.abs() < 0.9 && normal.z < 0.5;
    assert!(flat.iter().filter(on_edge).count() > 2);
    assert_eq!(cracks(mesh.triangles(), mesh.triangles().positions.as_slice()), 0);
    // less sharp ones are between
    let semi = cube(&top.replace("10", "0.5"), SMOOTH, "dicing = 4").unwrap();
    let highest = |shot: &Shot| positions(self::mesh(shot)).iter().map(|at| at.z).fold(0.0, f32::max);
    let round = cube("", SMOOTH, "dicing = 4").unwrap();
    assert!(highest(&round) < highest(&semi) && highest(&semi) < highest(&shot));
}

/// It is the nearest frame of the shot that counts, whichever is rendered, and the size of the picture.
#[test]
fn a_shot_is_diced_for_its_nearest_frame() {
    let comes = |frames: &str, last: f64| {
        let folder = folder("");
        let key = |frame: u32, z: f64| {
            format!("[[camera.key]]\nframe = {frame}\neye = [0, 0, {z}]\ntarget = [0, 0, 0]\nfov = 30\n")
        };
        let (first, last) = (key(1, 40.0), key(9, last));
        let shot = format!(
            "[render]\nsize = [64, 64]\n{frames}\n{first}{last}[[model]]\nobj = \"cube.obj\"\n{SMOOTH}\n"
        );
        mesh(&load_in(folder.path(), &shot).unwrap()).count()
    };
    let (far, near) = (comes("", 40.0), comes("", 2.5));
    assert!(near >= 16 * far, "{near} {far}");
    assert_eq!(comes("frames = \"1-9\"", 2.5), near);
    assert!(comes("frames = \"1-2\"", 2.5) < near);
    let count = |render: &str| mesh(&cube("", SMOOTH, render).unwrap()).count();
    assert!(count("dicing = 1") > count("dicing = 40"));
    let large = cube("", SMOOTH, "").unwrap();
    assert!(large.content.inputs != cube("", SMOOTH, "dicing = 40").unwrap().content.inputs);
}

#[test]
fn bounds_are_told_when_they_are_met() {
    let shot = cube("", SMOOTH, "dicing = 0.1\ndicing_triangles = 100");
    let told = shot.err().unwrap();
    assert!(told.contains("48 triangles") && told.contains("dicing_triangles"), "{told}");
}

/// Cages of triangles by the rules of Loop: a cube whose faces are cut, with texture coordinates, diced as finely as any other cage.
#[test]
fn triangles_are_subdivided_by_their_own_rules() {
    let folder = folder("");
    let cut = CUBE.lines().flat_map(|line| {
        match line.strip_prefix("f ").map(|face| face.split(' ').collect::<Vec<_>>()) {
            Some(face) => {
                vec![
                    format!("f {} {} {}", face[0], face[1], face[2]),
                    format!("f {} {} {}", face[0], face[2], face[3]),
                ]
            }
            None => vec![String::from(line)],
        }
    });
    let cut: Vec<String> = cut.collect();
    fs::write(folder.path().join("cube.obj"), format!("mtllib m.mtl\n{}\n", cut.join("\n"))).unwrap();
    let shot = |render: &str| {
        let shot = format!(
            "[render]\nsize = [64, 64]\n{render}\n{CAMERA}[[model]]\nobj = \"cube.obj\"\nsubdivision = \"loop\"\n"
        );
        load_in(folder.path(), &shot).unwrap()
    };
    let (coarse, fine) = (shot("dicing = 40"), shot("dicing = 2"));
    assert!(mesh(&fine).count() >= 16 * mesh(&coarse).count());
    assert_eq!(mesh(&fine).count() % 12, 0, "each triangle becomes four");
    let all = positions(mesh(&fine));
    // a corner of six triangles goes to its half and a twelfth of its neighbours: three at the ends of edges, three across faces
    let nearest = |place: Vec3| all.iter().map(|at| at.distance(place)).fold(f32::MAX, f32::min);
    assert!(nearest(Vec3::splat(-0.5)) < 1e-6, "{}", nearest(Vec3::splat(-0.5)));
    assert!(all.iter().all(|at| (0.5..1.2).contains(&at.length())), "it is about a ball");
    assert_eq!(cracks(mesh(&fine).triangles(), mesh(&fine).triangles().positions.as_slice()), 0);
    for (at, normal) in all.iter().zip(&mesh(&fine).triangles().normals) {
        assert!(normal.is_normalized() && normal.dot(at.normalize()) > 0.5, "{at} {normal}");
    }
    let uvs = &mesh(&fine).triangles().uvs;
    assert!([glam::Vec2::ZERO, glam::Vec2::ONE].iter().all(|corner| uvs.contains(corner)));
}

#[test]
fn mistakes_are_told() {
    for (tags, model, words) in [
        ("t crease 2/1/0 0 99 3\n", SMOOTH, "point 99, and there are 8"),
        ("t crease 2/1/0 0\n", SMOOTH, "makes no sense"),
        ("t crease 2/1/0 0 1 -3\n", SMOOTH, "makes no sense"),
        ("f 1 5 5 7\n", SMOOTH, "two at one point"),
        ("f 1 5 2\n", SMOOTH, "more than two faces"),
        ("t smoothtriangles 1/0/0 1\n", SMOOTH, "smoothtriangles"),
        ("", "subdivision = \"butterfly\"", "catmull-clark"),
        ("", "subdivision = \"loop\"", "6 of its faces are no triangles"),
        ("g a\nf 1 2 3\n", "subdivision = \"bilinear\"\ngroup = \"a\"", "goes with whole OBJ files"),
    ] {
        let shot = cube(tags, model, "dicing = 40");
        let told = match shot {
            Err(told) => told,
            Ok(shot) => shot.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        };
        assert!(told.contains(words), "{tags}{model}: {told}");
    }
    let folder = folder("");
    let quadric = format!("{CAMERA}[[model]]\nquadric = {{ type = \"sphere\" }}\n{SMOOTH}\n");
    assert!(load_in(folder.path(), &quadric).err().unwrap().contains("goes with `obj`"));
}

/// The same triangles in each shape, which lie on the limit surface of that.
#[test]
fn cages_that_deform_are_diced_once() {
    let folder = folder("");
    for (number, by) in [(1, 0.0), (2, 3.0)] {
        let moved: String = CUBE
            .lines()
            .map(|line| match line.strip_prefix("v ") {
                Some(place) => {
                    let place: Vec<f64> = place.split(' ').map(|x| x.parse().unwrap()).collect();
                    format!("v {} {} {}\n", place[0] * (1.0 + by), place[1], place[2])
                }
                None => format!("{line}\n"),
            })
            .collect();
        fs::write(folder.path().join(format!("cube.{number:02}.obj")), moved).unwrap();
    }
    let shot = format!(
        "[render]\nsize = [64, 64]\n{CAMERA}[[model]]\nobj = \"cube.obj\"\nshapes = {{ obj = \"cube.##.obj\" }}\n{SMOOTH}\n"
    );
    let shot = load_in(folder.path(), &shot).unwrap();
    let mesh = mesh(&shot);
    let list = mesh.shapes().unwrap().list();
    assert_eq!(list.len(), 2);
    for (rest, wide) in list[0].iter().zip(&list[1]) {
        // the surface of a cage that is stretched is that surface, stretched
        assert!(Vec3::new(4.0 * rest[0], rest[1], rest[2]).abs_diff_eq(Vec3::from(*wide), 1e-5));
    }
    assert_eq!(cracks(mesh.triangles(), &list[1]), 0);
}

/// A picture of two greys, white on the left.
fn picture(path: &Path, left: u8, right: u8) {
    let mut bytes = Vec::from(*b"BM");
    for word in [54 + 8_u32, 0, 54, 40, 2, 1] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend(24_u16.to_le_bytes());
    bytes.extend([0; 24]);
    bytes.extend([left, left, left, right, right, right, 0, 0]);
    fs::write(path, bytes).unwrap();
}

#[test]
fn heights_move_what_is_diced_and_nothing_cracks() {
    let folder = folder("");
    let shot = |material: &str| {
        let text = format!(
            "[render]\nsize = [64, 64]\ndicing = 4\n{CAMERA}[[model]]\nobj = \"cube.obj\"\nsubdivision = \"bilinear\"\n\
             [[material]]\nname = \"m\"\nmap_displacement = \"h.bmp\"\n{material}\n"
        );
        load_in(folder.path(), &text)
    };
    picture(&folder.path().join("h.bmp"), 255, 255);
    let even = shot("displacement = 0.5").unwrap();
    let all = positions(mesh(&even));
    // half of a half, along the normal in the middle of faces
    let highest = all.iter().map(|at| at.z).fold(0.0, f32::max);
    assert!((highest - 1.25).abs() < 1e-5, "{highest}");
    assert_eq!(cracks(mesh(&even).triangles(), mesh(&even).triangles().positions.as_slice()), 0);
    let corner = Vec3::ONE + Vec3::splat(0.25 / 3_f32.sqrt());
    assert!(all.iter().any(|at| at.abs_diff_eq(corner, 1e-3)), "corners go outwards");
    picture(&folder.path().join("h.bmp"), 255, 0);
    let uneven = shot("displacement = 0.3\ndisplacement_middle = 0.25").unwrap();
    let mesh = mesh(&uneven);
    assert_eq!(cracks(mesh.triangles(), mesh.triangles().positions.as_slice()), 0);
    let heights: Vec<f32> = positions(mesh).iter().map(|at| at.z).filter(|z| *z > 0.8).collect();
    let [low, high] =
        [heights.iter().copied().fold(9.0, f32::min), heights.iter().copied().fold(0.0, f32::max)];
    assert!((high - 1.225).abs() < 1e-3 && low < 0.95, "{low} {high}");
    assert!(mesh.triangles().normals.iter().all(|normal| normal.is_normalized()));
    let alone = load_in(
        folder.path(),
        &format!("{CAMERA}[[model]]\nobj = \"cube.obj\"\n[[material]]\nname = \"m\"\ndisplacement = 1\n"),
    );
    assert!(alone.err().unwrap().contains("goes with `map_displacement`"));
}

/// Vectors and heights of graphs; a mesh that is not diced moves as well.
#[test]
fn graphs_displace_along_normals_and_as_vectors() {
    let folder = folder("");
    let shot = |node: &str| {
        let mtlx = format!(
            "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<open_pbr_surface name=\"S\" type=\"surfaceshader\"/>\n{node}\n\
             <surfacematerial name=\"m\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\
             <input name=\"displacementshader\" type=\"displacementshader\" nodename=\"D\"/></surfacematerial>\n</materialx>\n"
        );
        fs::write(folder.path().join("m.mtlx"), mtlx).unwrap();
        let text =
            format!("{CAMERA}[[model]]\nobj = \"cube.obj\"\n[[material]]\nname = \"m\"\nmtlx = \"m.mtlx\"\n");
        load_in(folder.path(), &text).unwrap()
    };
    let along = shot(
        "<displacement name=\"D\" type=\"displacementshader\"><input name=\"displacement\" type=\"float\" value=\"0.5\"/>\
         <input name=\"scale\" type=\"float\" value=\"2\"/></displacement>",
    );
    let far = positions(mesh(&along)).iter().map(|at| at.length()).fold(0.0, f32::max);
    assert!((far - (3_f32.sqrt() + 1.0)).abs() < 1e-4, "{far}");
    let aside = shot(
        "<blender_displacement name=\"D\" type=\"displacementshader\"><input name=\"displacement\" type=\"vector3\" value=\"0, 2, 0\"/>\
         <input name=\"space\" type=\"string\" value=\"object\"/></blender_displacement>",
    );
    let middle: DVec3 = positions(mesh(&aside)).iter().map(|at| at.as_dvec3()).sum::<DVec3>();
    let middle = middle / positions(mesh(&aside)).len() as f64;
    assert!(middle.abs_diff_eq(DVec3::new(0.0, 2.0, 0.0), 1e-5), "{middle}");
}
