//! Smooth meshes of few triangles: does light end on them where it would on the surface that they stand for, and is reuse exact there?

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{self, Scene};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use glam::Vec3;
use tempfile::TempDir;

use crate::toy;

/// A ball of radius 1 about the origin with 12 sides, which has the normals of a sphere.
fn ball() -> String {
    let (sides, rings) = (12, 6);
    let mut text = String::from("mtllib m.mtl\nusemtl m\n");
    for ring in 0..=rings {
        for side in 0..=sides {
            let (up, around) = (ring as f32 / rings as f32, side as f32 / sides as f32);
            let (sin, cos) = (up * std::f32::consts::PI).sin_cos();
            let (z, x) = (around * std::f32::consts::TAU).sin_cos();
            let [x, y, z] = [sin * x, cos, sin * z];
            writeln!(text, "v {x} {y} {z}\nvn {x} {y} {z}\nvt {around} {up}").unwrap();
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let first = ring * (sides + 1) + side + 1;
            let [a, b, c, d] = [first, first + 1, first + sides + 1, first + sides + 2];
            let corner = |i: i32| format!("{i}/{i}/{i}");
            if ring > 0 {
                writeln!(text, "f {} {} {}", corner(a), corner(b), corner(d)).unwrap();
            }
            if ring + 1 < rings {
                writeln!(text, "f {} {} {}", corner(a), corner(d), corner(c)).unwrap();
            }
        }
    }
    text
}

fn folder(material: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("ball.obj", &ball());
    for shape in 1..3 {
        write(&format!("ball.{shape:02}.obj"), &ball());
    }
    write("m.mtl", &format!("newmtl m\nKd 1 1 1\nKa 0 0 0\n{material}"));
    write(
        "mirror.obj",
        "mtllib mirror.mtl\nusemtl mirror\nv -9 -9 0\nv 9 -9 0\nv 9 9 0\nv -9 9 0\nf 1 2 3 4\n",
    );
    write("mirror.mtl", "newmtl mirror\nKd 0 0 0\nKs 1 1 1\nNs 1000\nillum 3\n");
    write("pole.obj", "v -.1 -2 0\nv .1 -2 0\nv .1 2 0\nv -.1 2 0\nf 1 2 3 4\n");
    folder
}

fn load(folder: &Path, text: &str) -> Scene {
    let path = folder.join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(&path, true).unwrap().scene
}

const BEFORE: &str = "[background]\ncolor = [0, 0, 0]\n[[camera.key]]\nframe = 1\neye = [0, 0, 6]\ntarget = [0, 0, 0]\nfov = 24\n";
/// From behind, straight and by way of a mirror: the eye is between the two, and its mirror image where the other eye is.
const BEHIND: &str = "[background]\ncolor = [0, 0, 0]\n[[camera.key]]\nframe = 1\neye = [0, 0, -6]\ntarget = [0, 0, 0]\nfov = 24\n";
const IN_MIRROR: &str = "[background]\ncolor = [0, 0, 0]\n[[camera.key]]\nframe = 1\neye = [0, 0, -4]\ntarget = [0, 0, -5]\nfov = 24\n\
                         [[model]]\nobj = \"mirror.obj\"\ntranslate = [0, 0, -5]\n";
const SUN: &str = "[[light]]\ntype = \"directional\"\ndirection = [-0.6, -0.75, -0.3]\npower = 1\n";
/// To the light of the sun.
const TO_SUN: Vec3 = Vec3::new(0.6, 0.75, 0.3);

fn render(scene: &Scene, settings: &Settings) -> Finished {
    render_with(BackendKind::Embree, scene, settings)
}

fn render_with(kind: BackendKind, scene: &Scene, settings: &Settings) -> Finished {
    let frame = Renderer::with(kind, scene, settings).unwrap().render(1, true).unwrap();
    assert_eq!(toy::differing(&frame), 0);
    frame
}

fn settings() -> Settings {
    Settings { width: 120, height: 120, ..toy::audited(1) }
}

/// Colours and normals of the pixels that the ball covers.
fn pixels(frame: &Finished) -> impl Iterator<Item = (Vec3, Vec3)> {
    let (width, height) = (frame.film.width, frame.film.height);
    let all = (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
    all.filter_map(move |(x, y)| {
        let normal = Vec3::new(
            toy::pixel(frame, "N.X", x, y),
            toy::pixel(frame, "N.Y", x, y),
            toy::pixel(frame, "N.Z", x, y),
        );
        (normal != Vec3::ZERO).then(|| (toy::color(frame, x, y), normal))
    })
}

/// Share of the ball's pixels whose light is not that of a sphere with their normals.
fn wrong(frame: &Finished) -> f32 {
    let to_sun = TO_SUN.normalize();
    let (mut all, mut wrong) = (0.0, 0.0);
    for (color, normal) in pixels(frame) {
        all += 1.0;
        wrong += f32::from((color.x - normal.dot(to_sun).max(0.0)).abs() > 0.01);
    }
    assert!(all > 4000.0, "{all} pixels");
    wrong / all
}

#[test]
fn light_ends_where_it_would_on_a_sphere() {
    let folder = folder("");
    let at_rest = "[[model]]\nobj = \"ball.obj\"\n";
    for (name, model) in [
        ("at rest", at_rest),
        ("turned, mirrored", "[[model]]\nobj = \"ball.obj\"\nrotate = [10, 40, 20]\nscale = [-1, 1, 1]\n"),
        ("smaller", "[[model]]\nobj = \"ball.obj\"\nscale = [0.9, 1, 1]\nrotate = [0, 0, 30]\n"),
        ("deforms", "[[model]]\nobj = \"ball.obj\"\n[model.shapes]\nobj = \"ball.##.obj\"\n"),
    ] {
        let scene = load(folder.path(), &format!("{BEFORE}{model}{SUN}"));
        for kind in [BackendKind::Embree, BackendKind::Rust] {
            let frame = render_with(kind, &scene, &settings());
            assert!(wrong(&frame) < 0.004, "{name}, {kind:?}: {}", wrong(&frame));
        }
    }
}

/// The light that a mirror shows is made by other code.
#[test]
fn mirrors_show_the_same() {
    let folder = folder("");
    let model = "[[model]]\nobj = \"ball.obj\"\n";
    let straight = render(&load(folder.path(), &format!("{BEHIND}{model}{SUN}")), &settings());
    let mirrored = render(&load(folder.path(), &format!("{IN_MIRROR}{model}{SUN}")), &settings());
    let light = |frame: &Finished| -> f32 {
        let all = (0..120).flat_map(|y| (0..120).map(move |x| (x, y)));
        all.map(|(x, y)| toy::color(frame, x, y).x).sum()
    };
    let share = light(&mirrored) / light(&straight);
    assert!((share - 1.0).abs() < 0.01, "{share}");
}

/// A lamp that is a small ball, far away, by one ray a sample and by sixteen; the sky's sun; and light that paths gather: all reach as
/// far as the sun of a shot does.
#[test]
fn all_lights_end_there() {
    let folder = folder("");
    let model = "[[model]]\nobj = \"ball.obj\"\n";
    let lamp = |samples: u32| {
        format!(
            "[[light]]\ntype = \"sphere\"\nposition = [600, 750, 300]\nradius = 1\npower = 1012500\nsamples = {samples}\n"
        )
    };
    for (name, light) in [("one ray", lamp(1)), ("sixteen rays", lamp(16))] {
        let frame = render(&load(folder.path(), &format!("{BEFORE}{model}{light}")), &settings());
        assert!(wrong(&frame) < 0.006, "{name}: {}", wrong(&frame));
    }
    // an emitting square instead of the lamp
    let shines = "newmtl shines\nKd 0 0 0\nKe 1 1 1\n";
    fs::write(folder.path().join("shines.mtl"), shines).unwrap();
    let square = "mtllib shines.mtl\nusemtl shines\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 4 3 2 1\n";
    fs::write(folder.path().join("shines.obj"), square).unwrap();
    let panel = "[[model]]\nobj = \"shines.obj\"\ntranslate = [0, 9, 0]\n";
    let scene = load(folder.path(), &format!("{BEFORE}{panel}{model}"));
    let frame = render(&scene, &Settings { paths: 16, bounces: 1, ..settings() });
    // from straight above it ends at the equator, all around
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for (color, normal) in pixels(&frame) {
        let light = color.x;
        if normal.y > 0.1 && normal.y < 0.2 {
            above.push(light / normal.y);
        }
        if normal.y < -0.12 {
            below.push(light);
        }
    }
    let mean = |all: &[f32]| all.iter().sum::<f32>() / all.len() as f32;
    let dark = above.iter().filter(|light| **light < 0.2 * mean(&above)).count();
    assert!(above.len() > 300 && dark * 50 < above.len(), "{dark} of {} are dark", above.len());
    assert!(mean(&below) < 0.05 * mean(&above), "{} {}", mean(&below), mean(&above));
}

/// A normal map that leans to the light everywhere: light fades out towards the edge of the smooth ball, and is cut off nowhere.
#[test]
fn bent_normals_fade_out() {
    let folder = folder("norm n.png\n");
    let texel = [128, 204, 230];
    let image = image::RgbImage::from_raw(1, 1, texel.to_vec()).unwrap();
    image.save(folder.path().join("n.png")).unwrap();
    let model = "[[model]]\nobj = \"ball.obj\"\n";
    // from below or from above, whichever way the map leans
    for direction in ["[0, -1, 0.0]", "[0, 1, 0.0]"] {
        let sun = format!("[[light]]\ntype = \"directional\"\ndirection = {direction}\npower = 1\n");
        let frame = render(&load(folder.path(), &format!("{BEFORE}{model}{sun}")), &settings());
        let column = |x: u32| (20..100).map(|y| toy::color(&frame, x, y).x).collect::<Vec<f32>>();
        for x in [40, 50, 60, 70, 80] {
            let light = column(x);
            let steepest = light.windows(2).map(|two| (two[1] - two[0]).abs()).fold(0.0, f32::max);
            let [least, most] = [f32::min, f32::max].map(|of| light.iter().copied().reduce(of).unwrap());
            assert!(least == 0.0 && most > 0.2, "{direction}, column {x}: {least} to {most}");
            assert!(steepest < 0.12, "{direction}, column {x}: a step of {steepest}");
        }
    }
}

/// A pole that goes by throws its shadow on the ball, also where light reaches that no triangle faces.
#[test]
fn shadows_that_move_there_are_found() {
    let folder = folder("");
    let pole = "[[model]]\nname = \"pole\"\nobj = \"pole.obj\"\nrotate = [0, 60, 40]\n[[model.key]]\nframe = 1\ntranslate = [0.2, 1.5, 0.4]\n\
                [[model.key]]\nframe = 8\ntranslate = [1.6, 0.6, 0.4]\n";
    let ball = "[[model]]\nobj = \"ball.obj\"\n";
    for light in [
        SUN.to_owned(),
        "[[light]]\ntype = \"sphere\"\nposition = [6, 7.5, 3]\nradius = 1\npower = 90\n".to_owned(),
    ] {
        let scene = load(folder.path(), &format!("{BEFORE}{pole}{ball}{light}"));
        let settings = Settings { samples: 2, ..settings() };
        for frame in toy::render(&scene, &settings, 8) {
            assert_eq!(toy::differing(&frame), 0, "frame {}", frame.stats.frame);
        }
    }
}
