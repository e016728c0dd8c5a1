//! Is reuse exact where single floats come to their limits? Far from the origin, at tiny scales, on slivers, and with
//! the eye on a surface; with both tracers.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::scene;
use afterimage::settings::{Mode, Settings};
use afterimage::trace::BackendKind;
use glam::DVec3;
use tempfile::TempDir;

const BACKENDS: [BackendKind; 2] = [BackendKind::Embree, BackendKind::Rust];

/// Frames of each shot.
const FRAMES: i32 = 3;

/// Of a frame's samples, how many may hold only within the audit's tolerance for edges.
const MOST_ON_EDGE: f64 = 0.01;

/// A shot file of one camera that moves from `eyes[0]` to `eyes[1]`, under a sun.
fn shot(eyes: [DVec3; 2], target: DVec3, models: &str) -> String {
    let [from, to, target] = [eyes[0], eyes[1], target].map(|at| format!("{:?}", at.to_array()));
    format!(
        "[[camera.key]]\nframe = 1\neye = {from}\ntarget = {target}\n\
         [[camera.key]]\nframe = {FRAMES}\neye = {to}\ntarget = {target}\n\
         [[light]]\ntype = \"directional\"\ndirection = [-0.5, -1, -0.6]\n\
         [ambient]\ncolor = [0.2, 0.2, 0.2]\n{models}"
    )
}

/// Renders all frames with an audit that must find no difference; gives the last one's film.
#[track_caller]
fn audited(folder: &TempDir, shot: &str, kind: BackendKind, what: &str) -> Arc<Film> {
    audited_in([192, 108], folder, shot, kind, what)
}

/// The same in a picture of so many pixels.
#[track_caller]
fn audited_in(size: [u32; 2], folder: &TempDir, shot: &str, kind: BackendKind, what: &str) -> Arc<Film> {
    let [width, height] = size;
    let path = folder.path().join("shot.toml");
    std::fs::write(&path, shot).unwrap();
    let shot = scene::load(&path, true).unwrap();
    let (mode, audit) = (Mode::Reproject, true);
    let layers = Layers::Z.with(Layers::POSITION);
    let settings = Settings { width, height, samples: 1, mode, audit, layers, ..shot.settings };
    let mut renderer = Renderer::with(kind, &shot.scene, &settings).unwrap();
    let frames = (1..=FRAMES).map(|frame| {
        let finished = renderer.render(frame, frame > 1).unwrap();
        let audit = finished.stats.audit.unwrap();
        assert_eq!(audit.wrong(), 0, "{what}, {}, frame {frame}: {audit:?}", kind.name());
        assert!(
            audit.on_edge as f64 <= MOST_ON_EDGE * audit.checked as f64,
            "{what}, {}: {audit:?}",
            kind.name()
        );
        finished.film
    });
    frames.last().unwrap()
}

/// The project's city, textures and all, at `origin` and `unit` times as large.
fn city(origin: DVec3, unit: f64) -> String {
    let at = |x: f64, y: f64, z: f64| origin + unit * DVec3::new(x, y, z);
    let eyes = [at(-16.0, 63.0, 165.0), at(-14.0, 62.0, 163.0)];
    let obj = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/city/city.obj");
    let place = format!("translate = {:?}\nscale = {unit:?}\n", origin.to_array());
    shot(eyes, at(4.0, 48.0, 0.0), &format!("[[model]]\nobj = {obj:?}\n{place}"))
}

/// Of the pixels' colours, the share that differs by more than the rounding of an edge, or of the place over which textures are filtered, explains.
fn differing(a: &Film, b: &Film) -> f64 {
    let [a, b] = [a, b].map(|film| film.values("G").unwrap());
    let count = a.iter().zip(&b).filter(|(a, b)| (**a - **b).abs() > 0.1).count();
    count as f64 / a.len() as f64
}

#[test]
fn a_shot_far_from_the_origin_is_the_same_shot() {
    let folder = TempDir::new().unwrap();
    let origin = DVec3::new(1e5, -3e5, 1e6);
    for kind in BACKENDS {
        let [near, far] = [DVec3::ZERO, origin].map(|at| audited(&folder, &city(at, 1.0), kind, "moved"));
        assert!(differing(&near, &far) < 0.01, "{}", differing(&near, &far));
        let position = |film: &Film| {
            ["P.X", "P.Y", "P.Z"].map(|plane| f64::from(film.plane(plane).unwrap().values.get(96 + 90 * 192)))
        };
        let moved = DVec3::from(position(&far)) - origin;
        assert!(moved.distance(position(&near).into()) < 0.1, "P is where the files have it: {moved}");
    }
}

#[test]
fn a_tiny_shot_keeps_its_shadows() {
    let folder = TempDir::new().unwrap();
    for kind in BACKENDS {
        let usual = audited(&folder, &city(DVec3::ZERO, 1.0), kind, "usual");
        let tiny = audited(&folder, &city(DVec3::ZERO, 1e-6), kind, "tiny");
        assert!(differing(&usual, &tiny) < 0.02, "{}", differing(&usual, &tiny));
        let depth = |film: &Film| film.plane("Z").unwrap().values.get(96 + 90 * 192);
        assert!((depth(&tiny) / depth(&usual) / 1e-6 - 1.0).abs() < 1e-3, "Z is in the files' units");
    }
}

/// The extent of such a shot keeps it where it is: positions are rounded to a good part of a texel.
#[test]
fn textures_far_from_the_middle_of_a_shot_are_exact() {
    let folder = TempDir::new().unwrap();
    let far = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\n";
    std::fs::write(folder.path().join("origin.obj"), far).unwrap();
    for kind in BACKENDS {
        let shot = city(DVec3::splat(1e5), 1.0) + "[[model]]\nobj = \"origin.obj\"\n";
        audited(&folder, &shot, kind, "textures");
    }
}

/// Numbers from 0 to 1 that look random, the same in each run (SplitMix64).
fn dice() -> impl FnMut() -> f64 {
    let mut state = 7u64;
    move || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (state ^ state >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn write_obj(folder: &TempDir, triangles: &[[DVec3; 3]]) {
    let mut text = String::new();
    for corner in triangles.iter().flatten() {
        writeln!(text, "v {} {} {}", corner.x, corner.y, corner.z).unwrap();
    }
    for first in (1..).step_by(3).take(triangles.len()) {
        writeln!(text, "f {first} {} {}", first + 1, first + 2).unwrap();
    }
    std::fs::write(folder.path().join("model.obj"), text).unwrap();
}

const MODEL: &str = "[[model]]\nobj = \"model.obj\"\n";

#[test]
fn needles_are_exact() {
    let mut dice = dice();
    let mut vector = || DVec3::from([(); 3].map(|()| 2.0 * dice() - 1.0));
    let needles: Vec<[DVec3; 3]> = (0..3000)
        .map(|_| {
            let (middle, along, across) = (vector() * 100.0, vector().normalize(), vector().normalize());
            let (from, to) = (middle - along * 206.0, middle + along * 206.0);
            [from, to, to + across * 0.03]
        })
        .collect();
    let folder = TempDir::new().unwrap();
    write_obj(&folder, &needles);
    let eyes = [DVec3::new(0.0, 20.0, 300.0), DVec3::new(10.0, 22.0, 290.0)];
    for kind in BACKENDS {
        audited(&folder, &shot(eyes, DVec3::ZERO, MODEL), kind, "needles");
    }
}

/// A floor, and some boxes on it.
fn boxes() -> Vec<[DVec3; 3]> {
    let quad = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| [[a, b, c], [a, c, d]];
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut all = Vec::from(quad(at(-50., 0., 50.), at(50., 0., 50.), at(50., 0., -50.), at(-50., 0., -50.)));
    for (x, z, h) in [(-4.0, 3.0, 2.0), (3.0, 1.0, 3.0), (-1.0, -5.0, 4.0), (6.0, -8.0, 2.5)] {
        let corner = |i: usize, y: f64| {
            at([x - 0.7, x + 0.7, x + 0.7, x - 0.7][i % 4], y, [z - 0.7, z - 0.7, z + 0.7, z + 0.7][i % 4])
        };
        for i in 0..4 {
            all.extend(quad(corner(i + 1, 0.0), corner(i, 0.0), corner(i, h), corner(i + 1, h)));
        }
        all.extend(quad(corner(3, h), corner(2, h), corner(1, h), corner(0, h)));
    }
    all
}

#[test]
fn an_eye_on_a_surface_is_exact() {
    let folder = TempDir::new().unwrap();
    write_obj(&folder, &boxes());
    for height in [1e-4, 1e-5, 1e-6, 0.0] {
        for (ahead, down) in [(-12.0, 0.0), (-0.1, -1.0)] {
            for from in [DVec3::new(0.5, height, 12.0), DVec3::new(0.0, height, 0.0)] {
                let eyes = [from, from + DVec3::new(0.2, 0.0, -0.1)];
                let target = from + DVec3::new(0.0, down, ahead);
                for kind in BACKENDS {
                    audited(&folder, &shot(eyes, target, MODEL), kind, &format!("{height} above {from}"));
                }
            }
        }
    }
}

/// A square of tiny triangles amid boxes of usual size.
#[test]
fn tiny_triangles_in_a_usual_scene_are_exact() {
    for unit in [1e-6, 1e-7] {
        let mut dice = dice();
        let heights: Vec<f64> = (0..101 * 101).map(|_| 0.3 * dice()).collect();
        let at =
            |i: usize, j: usize| DVec3::new(i as f64 - 50.0, heights[i * 101 + j], j as f64 - 50.0) * unit;
        let mut triangles: Vec<[DVec3; 3]> =
            boxes().into_iter().map(|corners| corners.map(|corner| corner - DVec3::Y)).collect();
        for (i, j) in (0..100).flat_map(|i| (0..100).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        let folder = TempDir::new().unwrap();
        write_obj(&folder, &triangles);
        let eyes = [DVec3::new(0.0, 20.0, 60.0) * unit, DVec3::new(10.0, 20.0, 58.0) * unit];
        for kind in BACKENDS {
            // the tracer of our own meets most of the triangles with every ray
            audited_in([96, 54], &folder, &shot(eyes, DVec3::ZERO, MODEL), kind, &format!("{unit}"));
        }
    }
}
