use std::path::PathBuf;

use glam::{DAffine3, Vec3};

use super::*;

fn seed(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb").join(name);
    std::fs::read(path).expect("it is there")
}

fn named(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_string()).collect()
}

/// What the files have at a point.
fn value(at: IVec3) -> f32 {
    let value = (31 * at.x + 17 * at.y + 7 * at.z).rem_euclid(11) as f32 * 0.25;
    let is_there = at.cmpge(IVec3::new(-5, -3, 0)).all() && at.cmplt(IVec3::new(7, 13, 10)).all();
    if is_there && value > 0.5 { value } else { 0.0 }
}

fn points() -> impl Iterator<Item = IVec3> {
    (-9..34).flat_map(|x| (-9..18).flat_map(move |y| (-9..18).map(move |z| IVec3::new(x, y, z))))
}

/// Files that OpenVDB 12 wrote (Blosc): of floats, with tiles.
#[test]
fn numbers_and_tiles_are_read() {
    let volume = of_bytes(&seed("plain.vdb"), None).expect("it is whole");
    let density = volume.grid("density").expect("it is in it");
    for at in points() {
        let is_tile = at.cmpge(IVec3::new(16, 0, 0)).all() && at.cmple(IVec3::new(31, 15, 15)).all();
        let wanted = if is_tile { 2.0 } else { value(at) };
        assert_eq!(density.value(at), Vec3::splat(wanted), "{at}");
    }
    assert_eq!(
        density.to_lattice.inverse().transform_point3(DVec3::new(2.0, 0.0, -4.0)),
        DVec3::new(2.0, 2.0, 1.0)
    );
}

/// Of halves and of vectors, in a grid that is turned and stretched.
#[test]
fn halves_and_vectors_are_read() {
    let all = seed("turned.vdb");
    let names: Vec<String> =
        of_bytes(&all, None).expect("it is whole").grids.into_iter().map(|of| of.name).collect();
    assert_eq!(names, ["temperature"], "those of numbers, if none are named");
    let volume = of_bytes(&all, Some(&named(&["color", "temperature"]))).expect("it is whole");
    let grid = |name| volume.grid(name).expect("it is in it");
    for at in points() {
        let value = value(at);
        assert_eq!(grid("temperature").value(at), Vec3::splat(value), "{at}");
        assert_eq!(grid("color").value(at), Vec3::new(value, 2.0 * value, 0.0), "{at}");
    }
    let to_object = grid("color").to_lattice.inverse();
    let wanted = [DVec3::new(1.0, 0.25, -1.0), DVec3::new(0.75, 0.0, -1.0), DVec3::new(1.0, 0.0, -0.5)];
    for (at, wanted) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(wanted) {
        assert!((to_object.transform_point3(at) - wanted).length() < 1e-12, "{at}");
    }
}

#[test]
fn other_files_are_told() {
    let told =
        |bytes: &[u8], wanted: Option<&[String]>| of_bytes(bytes, wanted).expect_err("no grid of numbers");
    assert!(told(&seed("mask.vdb"), None).contains("`mask` (Tree_bool_5_4_3)"));
    assert!(told(&seed("mask.vdb"), Some(&named(&["mask"]))).contains("Tree_bool_5_4_3"));
    assert!(
        told(&seed("plain.vdb"), Some(&named(&["heat"]))).contains("no grid `heat`: there are `density`")
    );
    assert!(told(b"v 0 0 0\n", None).contains("no OpenVDB file"));
    let mut old = seed("plain.vdb");
    old[8] = 221;
    assert!(told(&old, None).contains("version 221"));
}

/// What is cut off or damaged is an error or another volume, and never a panic or endless.
#[test]
fn damage_is_told() {
    for name in ["plain.vdb", "turned.vdb"] {
        let whole = seed(name);
        let names = named(if name == "plain.vdb" { &["density"] } else { &["temperature", "color"] });
        let step = whole.len() / 150;
        for length in (0..whole.len() - 100).step_by(step).chain(0..400) {
            assert!(of_bytes(&whole[..length], Some(&names)).is_err(), "{name} {length}");
        }
        // the headers byte by byte, and some of the rest
        let mut told = 0;
        for at in (0..800).chain((0..whole.len()).step_by(step)) {
            for flip in [1, 0x80] {
                let mut bytes = whole.clone();
                bytes[at] ^= flip;
                told += i32::from(of_bytes(&bytes, Some(&names)).is_err());
            }
        }
        assert!(told > 400, "{told}");
    }
}

#[test]
fn the_mesh_is_the_box_around_what_is_there() {
    let mut import = Import::default();
    import.surfaces.add(crate::scene::Material::fallback()).expect("it is the first");
    let volume = of_bytes(&seed("plain.vdb"), None).expect("it is whole");
    let mesh = mesh_of(&import, volume, 0).expect("it is small");
    let (low, high) = mesh.bounds();
    assert_eq!((low, high), (DVec3::new(-2.0, 0.0, 2.5), DVec3::new(17.0, 10.0, 11.0)));
    let empty = Grid::new(String::from("density"), DAffine3::IDENTITY, false);
    assert_eq!(mesh_of(&import, Volume { grids: vec![empty] }, 0).map(|mesh| mesh.count()), Ok(12));
    let mut wide = Grid::new(String::from("density"), DAffine3::IDENTITY, false);
    [IVec3::ZERO, IVec3::new(0, 2000, 0)].into_iter().for_each(|at| wide.set_even_block(at, Vec3::ONE));
    let refused = mesh_of(&import, Volume { grids: vec![wide] }, 0).expect_err("it is wide");
    assert!(refused.contains("16009"), "{refused}");
}
