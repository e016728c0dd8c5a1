//! Surfaces that are diced and displaced: is reuse exact on them, do they go with their cages, and do both tracers see the same?

use std::fs;
use std::path::Path;

use afterimage::frame::Renderer;
use afterimage::scene::{self, Scene};
use afterimage::settings::{Mode, Settings};
use afterimage::trace::BackendKind;

use crate::toy;

/// A house with a gable: quadrilaterals and pentagons, with texture coordinates.
fn house(lean: f64) -> String {
    let mut text = String::from("mtllib m.mtl\n");
    for z in [-1.0, 1.0] {
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 0.6), (0.0, 1.4), (-1.0, 0.6)] {
            text.push_str(&format!(
                "v {} {y} {z}\nvt {} {}\n",
                x + lean * y,
                x * 0.5 + 0.5,
                y * 0.4 + 0.1 * z + 0.5
            ));
        }
    }
    text.push_str("usemtl m\nf 5/5 4/4 3/3 2/2 1/1\nf 6/6 7/7 8/8 9/9 10/10\n");
    for (a, b) in [(1, 2), (2, 3), (3, 4), (4, 5), (5, 1)] {
        text.push_str(&format!("f {a}/{a} {b}/{b} {}/{} {}/{}\n", b + 5, b + 5, a + 5, a + 5));
    }
    text + "t crease 3/1/0 0 1 6 10\nt crease 2/1/0 3 8 1.5\nt corner 1/1/0 7 2.2\n"
}

/// Cuts the faces of an OBJ file into triangles, fans from their first corners on.
fn cut(text: &str) -> String {
    let mut cut = String::new();
    for line in text.lines() {
        match line.strip_prefix("f ").map(|face| face.split(' ').collect::<Vec<_>>()) {
            Some(face) => {
                face[1..].windows(2).for_each(|two| cut += &format!("f {} {} {}\n", face[0], two[0], two[1]))
            }
            None => cut += &format!("{line}\n"),
        }
    }
    cut
}

/// The house above a floor, beside a lamp and below a sun, seen by a camera that goes around it.
fn load(folder: &Path, scheme: &str, model: &str, material: &str) -> Scene {
    let house = |lean| if scheme == "loop" { cut(&house(lean)) } else { house(lean) };
    fs::write(folder.join("m.mtl"), "newmtl m\nKd .7 .6 .5\nnewmtl n\nKd .5 .5 .5\n").unwrap();
    fs::write(folder.join("house.obj"), house(0.0)).unwrap();
    for (number, lean) in [(1, 0.0), (2, 0.4), (3, -0.2)] {
        fs::write(folder.join(format!("house.{number}.obj")), house(lean)).unwrap();
    }
    fs::write(
        folder.join("floor.obj"),
        "mtllib m.mtl\nv -5 -1.3 5\nv 5 -1.3 5\nv 5 -1.3 -5\nv -5 -1.3 -5\nusemtl n\nf 1 2 3 4\n",
    )
    .unwrap();
    let mut picture = Vec::from(*b"BM");
    for word in [54 + 48_u32, 0, 54, 40, 4, 4] {
        picture.extend(word.to_le_bytes());
    }
    picture.extend(1_u16.to_le_bytes());
    picture.extend(24_u16.to_le_bytes());
    picture.extend([0; 24]);
    picture.extend((0..16).flat_map(|texel: u8| [(u32::from(texel) * 57 % 251) as u8; 3]));
    fs::write(folder.join("h.bmp"), picture).unwrap();
    let shot = format!(
        "[render]\nsize = [64, 48]\nframes = \"1-4\"\ndicing = 3\n\
         [[camera.key]]\nframe = 1\neye = [2, 1.5, 5]\ntarget = [0, 0, 0]\nfov = 45\n[[camera.key]]\nframe = 4\neye = [2.5, 1.6, 4.6]\ntarget = [0, 0, 0]\n\
         [[light]]\ntype = \"directional\"\ndirection = [-1, -2, -1]\npower = 0.7\n[[light]]\ntype = \"point\"\nposition = [3, 2, 2]\npower = 4\n\
         [[model]]\nobj = \"house.obj\"\nsubdivision = \"{scheme}\"\n{model}\n[[model]]\nobj = \"floor.obj\"\n[[material]]\nname = \"m\"\n{material}\n"
    );
    fs::write(folder.join("s.toml"), shot).unwrap();
    scene::load(&folder.join("s.toml"), true).unwrap().scene
}

const BUMPY: &str = "map_displacement = \"h.bmp\"\ndisplacement = 0.3\n";
const LEANS: &str = "shapes = { obj = \"house.#.obj\" }\n";
const TURNS: &str =
    "[[model.key]]\nframe = 1\nrotate = [0, 0, 0]\n[[model.key]]\nframe = 4\nrotate = [0, 20, 0]\n";

/// Resting, turning and deforming; smooth and displaced: frames that reuse samples, audited, by both tracers.
#[test]
fn reuse_is_exact_on_what_is_diced() {
    let quads = "catmull-clark";
    for (scheme, model, material) in [
        (quads, "", ""),
        (quads, "", BUMPY),
        (quads, TURNS, BUMPY),
        (quads, LEANS, ""),
        (quads, LEANS, BUMPY),
        ("loop", TURNS, ""),
        ("loop", LEANS, BUMPY),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let scene = load(folder.path(), scheme, model, material);
        assert!(scene.models[0].mesh.count() > 200, "{}", scene.models[0].mesh.count());
        let settings =
            Settings { width: 64, height: 48, audit: true, mode: Mode::Reproject, ..toy::settings(2) };
        let mut of_tracers = Vec::new();
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let mut renderer = Renderer::with(kind, &scene, &settings).unwrap();
            for frame in 1..=3 {
                let finished = renderer.render(frame, true).unwrap();
                let audit = finished.stats.audit.unwrap();
                assert_eq!(audit.wrong(), 0, "{kind:?} {scheme} {model}{material} frame {frame}: {audit:?}");
                assert!(frame == 1 || finished.stats.samples.reused() > 1000);
                of_tracers.push(finished.film.values("R").unwrap());
            }
        }
        let (embree, rust) = of_tracers.split_at(3);
        for (one, other) in embree.iter().zip(rust) {
            let differ = one.iter().zip(other).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
            assert!(differ * 100 < one.len(), "{scheme} {model}{material}: {differ} pixels differ");
        }
    }
}
