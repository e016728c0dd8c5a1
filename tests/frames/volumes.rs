//! Is what volumes of files leave of light what formulas say, and is what is kept of them what would be made anew?

use std::path::Path;

use afterimage::scene::{Background, Environment, Scene};
use afterimage::settings::{Backdrop, Settings};
use glam::{DVec3, Vec3};

use crate::toy;
use crate::toy::worlds::*;

/// What `plain.vdb` has at a point of its lattice.
fn density(x: i32, y: i32, z: i32) -> f64 {
    if (16..32).contains(&x) && (0..16).contains(&y) && (0..16).contains(&z) {
        return 2.0;
    }
    let value = f64::from((31 * x + 17 * y + 7 * z).rem_euclid(11)) * 0.25;
    let is_there = (-5..7).contains(&x) && (-3..13).contains(&y) && (0..10).contains(&z);
    if is_there && value > 0.5 { value } else { 0.0 }
}

/// A shot of that file, whose points are half a unit apart and whose origin is at (1, 2, 3).
fn shot(model: &str, material: &str, rest: &str) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/vdb/plain.vdb");
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(file, folder.path().join("plain.vdb")).unwrap();
    let camera = "[camera]\nprojection = \"orthographic\"\n[[camera.key]]\nframe = 1\neye = [7, 5, 40]\ntarget = [7, 5, 0]\nheight = 16\n";
    let volume = format!("[[model]]\nvdb = {{ file = \"plain.vdb\", material = \"cloud\" }}\n{model}");
    let material = format!("[[material]]\nname = \"cloud\"\nsurface = false\n{material}\n");
    let path = folder.path().join("s.toml");
    std::fs::write(
        &path,
        format!("[background]\ncolor = [1, 1, 1]\n[environment]\n{camera}{volume}{material}{rest}"),
    )
    .unwrap();
    let shot = afterimage::scene::load(&path, true).unwrap();
    assert!(shot.warnings.is_empty(), "{:?}", shot.warnings);
    shot.scene
}

fn visible() -> Settings {
    Settings { background: Backdrop::Visible, ..toy::audited(1) }
}

/// Between points of the lattice density is linear: along an axis its integral is a sum.
#[test]
fn what_is_left_of_light_is_exact() {
    const SIZE: u32 = 64;
    for is_turned in [false, true] {
        // a quarter turn about the view's axis, around the point that is looked at
        let turn = "[[model.key]]\nframe = 1\nrotate = [0, 0, 90]\ntranslate = [12, -2, 0]\n[[model.key]]\nframe = 2\nrotate = [0, 0, 80]\n";
        let scene = shot(if is_turned { turn } else { "" }, "volume_absorb = [0.02, 0.1, 0.2]", "");
        let finished = toy::render(&scene, &Settings { width: SIZE, height: SIZE, ..visible() }, 1).remove(0);
        assert_eq!(toy::differing(&finished), 0);
        let mut dark = 0;
        for row in 0..SIZE {
            for column in 0..SIZE {
                let at = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(SIZE) * 16.0 - 8.0;
                let (right, up) = (at(column), -at(row));
                let (x, y) = if is_turned { (7.0 + up, 5.0 - right) } else { (7.0 + right, 5.0 + up) };
                let (x, y) = (2.0 * (x - 1.0), 2.0 * (y - 2.0));
                let (first, [right, up]) = ([x.floor(), y.floor()], [x - x.floor(), y - y.floor()]);
                let sum = |i: f64, j: f64| -> f64 {
                    (-1..17).map(|z| density((first[0] + i) as i32, (first[1] + j) as i32, z)).sum()
                };
                let depth = 0.5
                    * ((sum(0.0, 0.0) * (1.0 - right) + sum(1.0, 0.0) * right) * (1.0 - up)
                        + (sum(0.0, 1.0) * (1.0 - right) + sum(1.0, 1.0) * right) * up);
                let wanted =
                    Vec3::new(0.02, 0.1, 0.2).map(|extinction| (-f64::from(extinction) * depth).exp() as f32);
                let found = toy::color(&finished, column, row);
                assert!((found - wanted).abs().max_element() < 1e-3, "{column} {row}: {found} for {wanted}");
                dark += i32::from(wanted.z < 0.5);
            }
        }
        assert!(dark > 200, "{dark}");
    }
}

/// A graph sees the grids of a volume: here it makes nothing of what is thin.
#[test]
fn graphs_see_grids() {
    let plain = shot("", "volume_absorb = [0.1, 0.1, 0.1]", "");
    assert_eq!(plain.models[0].mesh.count(), 12, "a box");
    let folder = tempfile::tempdir().unwrap();
    let graph = folder.path().join("graph.mtlx");
    let text = "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\">\n<nodegraph name=\"G\">\
        <blender_volume_grid name=\"d\" type=\"multioutput\"><input name=\"grid\" type=\"string\" value=\"density\"/></blender_volume_grid>\
        <multiply name=\"m\" type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"d\" output=\"value\"/><input name=\"in2\" type=\"float\" value=\"0.1\"/></multiply>\
        <output name=\"out\" type=\"vector3\" nodename=\"m\"/></nodegraph>\n\
        <anisotropic_vdf name=\"V\" type=\"VDF\"><input name=\"absorption\" type=\"vector3\" nodegraph=\"G\" output=\"out\"/></anisotropic_vdf>\n\
        <volume name=\"S\" type=\"volumeshader\"><input name=\"vdf\" type=\"VDF\" nodename=\"V\"/></volume>\n\
        <volumematerial name=\"cloud\" type=\"material\"><input name=\"volumeshader\" type=\"volumeshader\" nodename=\"S\"/></volumematerial>\n</materialx>\n";
    std::fs::write(&graph, text).unwrap();
    let computed = shot("", &format!("mtlx = \"{}\"", graph.display()), "");
    let [one, other] = [&plain, &computed].map(|scene| toy::render(scene, &visible(), 1).remove(0));
    for (x, y) in (0..96).step_by(7).flat_map(|x| (0..72).step_by(5).map(move |y| (x, y))) {
        let [one, other] = [&one, &other].map(|finished| toy::color(finished, x, y));
        assert!((one - other).abs().max_element() < 1e-4, "{x} {y}: {one} {other}");
    }
}

#[test]
fn reuse_in_volumes_is_exact() {
    let moves = "[[model.key]]\nframe = 1\nscale = 0.3\n[[model.key]]\nframe = 4\nscale = 0.3\nrotate = [0, 40, 10]\ntranslate = [0.5, 0.2, 0]\n";
    for model in ["scale = 0.3\n", moves] {
        let light = "[[light]]\ntype = \"point\"\nposition = [1, 6, 5]\npower = 90\n";
        let medium = "volume_scatter = [0.3, 0.25, 0.2]\nvolume_absorb = [0.05, 0.1, 0.15]\nvolume_emit = [0.01, 0, 0]\nvolume_anisotropy = 0.4\n";
        let mut scene = shot(model, medium, light);
        scene.materials.push(toy::matt(0.5));
        let floor = toy::floor(9.0, scene.materials.len() as u16 - 1);
        scene.models.push(toy::still("floor", floor, Vec3::Y * -0.2));
        scene.background = Background::uniform(Vec3::splat(0.3));
        scene.environment = Some(Environment::from_background(&scene.background));
        scene.camera = toy::camera(
            goes(DVec3::new(2.0, 2.0, 9.0), DVec3::new(3.0, 2.5, 9.0)),
            rests(DVec3::new(2.0, 1.0, 0.0)),
        );
        for finished in
            toy::render(&scene, &Settings { paths: 2, width: 48, height: 36, ..toy::audited(1) }, 4)
        {
            assert_eq!(toy::differing(&finished), 0, "{model}");
        }
    }
}
