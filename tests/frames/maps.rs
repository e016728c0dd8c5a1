//! Pictures of parameters and normals: does each place look as they say, and is reuse exact?

use std::fs;
use std::path::Path;

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{self, Shot};
use afterimage::settings::Settings;
use afterimage::trace::BackendKind;
use tempfile::TempDir;

use crate::toy;

/// A square in the plane y = 0 that looks up, from -2 to 2, with a picture on it as seen from above.
const FLOOR: &str = "mtllib m.mtl\nv -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                     usemtl m\nf 1/1 2/2 3/3 4/4\n";

/// A folder with the floor and its material.
fn folder(mtl: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("floor.obj"), FLOOR).unwrap();
    fs::write(folder.path().join("m.mtl"), format!("newmtl m\n{mtl}")).unwrap();
    folder
}

fn picture(folder: &TempDir, name: &str, width: u32, texels: &[[u8; 3]]) {
    let height = texels.len() as u32 / width;
    let image = image::RgbImage::from_raw(width, height, texels.concat()).unwrap();
    image.save(folder.path().join(name)).unwrap();
}

fn load(folder: &Path, rest: &str) -> Shot {
    let path = folder.join("s.toml");
    let camera = "[[camera.key]]\nframe = 1\neye = [0, 5, 0.01]\ntarget = [0, 0, 0]\nfov = 60\n";
    fs::write(&path, format!("{camera}{rest}")).unwrap();
    scene::load(&path, true).unwrap()
}

fn render(folder: &TempDir, rest: &str) -> Finished {
    toy::render(&load(folder.path(), rest).scene, &toy::audited(1), 1).pop().unwrap()
}

const STILL: &str = "[[model]]\nobj = \"floor.obj\"\n";

fn sun(direction: [i32; 3]) -> String {
    format!("[[light]]\ntype = \"directional\"\ndirection = {direction:?}\npower = 1\n")
}

/// The normal leans by 3 in 5 along the first texture coordinate, or along the second.
#[test]
fn normals_lean_where_the_picture_says() {
    let (right, up) = ([204, 128, 230], [128, 204, 230]);
    let turned = "[[model]]\nobj = \"floor.obj\"\nrotate = [0, 180, 0]\n";
    let mirrored = "[[model]]\nobj = \"floor.obj\"\nscale = [-1, 1, 1]\n";
    let moves = "[[model]]\nobj = \"floor.obj\"\n[[model.key]]\nframe = 1\nrotate = [0, 90, 0]\n[[model.key]]\nframe = 2\n";
    let deforms = "[[model]]\nobj = \"floor.obj\"\n[model.shapes]\nobj = \"floor.##.obj\"\n";
    // from the right, from the left, from above in the picture, from below in it
    let suns = [[-1, -1, 0], [1, -1, 0], [0, -1, 1], [0, -1, -1]];
    for (name, texel, model, brightest) in [
        ("to the right", right, STILL, 0),
        ("upwards", up, STILL, 2),
        ("turned by half", right, turned, 1),
        ("mirrored", right, mirrored, 1),
        ("mirrored, upwards", up, mirrored, 2),
        ("moves", right, moves, 2),
        ("deforms", right, deforms, 2),
        ("deforms, upwards", up, deforms, 1),
    ] {
        let folder = folder("Kd 1 1 1\nKa 0 0 0\nnorm n.png\n");
        picture(&folder, "n.png", 1, &[texel]);
        // the same, turned by a quarter: what is its right goes up
        let turned =
            FLOOR.replace("v -2 0 2\nv 2 0 2\nv 2 0 -2\nv -2 0 -2", "v 2 0 2\nv 2 0 -2\nv -2 0 -2\nv -2 0 2");
        for number in 1..3 {
            fs::write(folder.path().join(format!("floor.{number:02}.obj")), &turned).unwrap();
        }
        let brightness = suns.map(|direction| {
            let frame = render(&folder, &format!("{model}{}", sun(direction)));
            assert_eq!(toy::differing(&frame), 0, "{name}");
            toy::color(&frame, 48, 36).x
        });
        let (near, far) = (1.4 * 0.5_f32.sqrt(), 0.2 * 0.5_f32.sqrt());
        let aside = 0.8 * 0.5_f32.sqrt();
        for (number, shown) in brightness.into_iter().enumerate() {
            let opposite = brightest ^ 1;
            let expected = if number == brightest {
                near
            } else if number == opposite {
                far
            } else {
                aside
            };
            assert!((shown - expected).abs() < 0.02, "{name}, sun {number}: {shown}, not {expected}");
        }
    }
}

#[test]
fn heights_are_slopes() {
    // two texels up, two down, a fifth of the range each
    let heights = [0, 51, 102, 51].map(|height| [height; 3]);
    let level = folder("Kd 1 1 1\nKa 0 0 0\n");
    let bumpy = folder("Kd 1 1 1\nKa 0 0 0\nbump -bm 2 h.png\n");
    picture(&bumpy, "h.png", 4, &heights);
    let light = format!("{STILL}{}", sun([-1, -1, 0]));
    let [level, bumpy] = [&level, &bumpy].map(|folder| render(folder, &light));
    let share = |x| toy::color(&bumpy, x, 36).x / toy::color(&level, x, 36).x;
    // light from the right: at the centres of the second texel and the last the slope is 2 / 5, up and down
    let columns = [48 - 6, 48 + 18];
    let [rises, falls] = columns.map(share);
    let lit = |slope: f32| (1.0 - slope) / (1.0 + slope * slope).sqrt();
    assert!((rises - lit(0.4)).abs() < 0.12 && (falls - lit(-0.4)).abs() < 0.12, "{rises} {falls}");
    assert!(rises < 0.75 && falls > 1.15, "{rises} {falls}");
}

/// Half of the floor has the value of one texel, and looks like a floor that has it all over.
#[test]
fn each_half_looks_like_a_material_of_its_own() {
    let light = format!(
        "{STILL}[[light]]\ntype = \"sphere\"\nposition = [0, 3, 2]\nradius = 0.5\npower = 9\nsamples = 1\n"
    );
    for (name, base, map, left, right) in [
        ("roughness", "Kd .5 .5 .5\nPm 1\n", "map_Pr -clamp on p.png", "Pr 0.333333", "Pr 1"),
        ("metal", "Kd .5 .5 .5\nPr .5\n", "map_Pm -clamp on p.png", "Pm 0.333333", "Pm 1"),
        ("emission", "Kd 0 0 0\n", "map_Ke -clamp on p.png", "Ke 0.0908417 0.0908417 0.0908417", "Ke 1 1 1"),
        (
            "highlights",
            "Kd .1 .1 .1\nNs 20\nillum 2\n",
            "map_Ks -clamp on p.png",
            "Ks 0.0908417 0.0908417 0.0908417",
            "Ks 1 1 1",
        ),
    ] {
        let with = |statement: &str| {
            let folder = folder(&format!("{base}{statement}\n"));
            picture(&folder, "p.png", 2, &[[85; 3], [255; 3]]);
            render(&folder, &light)
        };
        let [both, left, right] = [map, left, right].map(with);
        for (x, one) in [(30, &left), (66, &right)] {
            for y in [20, 50] {
                let [shown, expected] = [&both, one].map(|frame| toy::color(frame, x, y));
                assert!((shown - expected).abs().max_element() < 2e-3, "{name} {x} {y}: {shown} {expected}");
            }
        }
        assert_ne!(toy::color(&left, 44, 50), toy::color(&right, 44, 50), "{name}");
        assert_eq!(toy::differing(&both), 0, "{name}");
    }
}

/// Maps of all kinds on what rests, moves and deforms, under a light that gives kept shadows and paths.
#[test]
fn reuse_is_exact_with_maps_of_all_kinds() {
    let folder =
        folder("Kd .6 .6 .6\nmap_Pr p.png\nmap_Pm p.png\nmap_Ke -s 3 3 p.png\nKe 2 1 .5\nnorm -bm 2 n.png\n");
    let noise = |seed: u32| (0..64).map(move |i: u32| (i * seed % 251) as u8);
    let grey: Vec<[u8; 3]> = noise(77).map(|value| [value; 3]).collect();
    let normals: Vec<[u8; 3]> = noise(45).zip(noise(91)).map(|(x, y)| [x, y, 220]).collect();
    picture(&folder, "p.png", 8, &grey);
    picture(&folder, "n.png", 8, &normals);
    for (number, lift) in [(1, "0.3"), (2, "-0.2"), (3, "0.1")] {
        let bent = FLOOR.replacen("v 2 0 2", &format!("v 2 {lift} 2"), 1);
        fs::write(folder.path().join(format!("floor.{number:02}.obj")), bent).unwrap();
    }
    let text = "[[model]]\nobj = \"floor.obj\"\nscale = [2, 1, 2]\n\
        [[model]]\nobj = \"floor.obj\"\nscale = 0.3\n\
        [[model.key]]\nframe = 1\ntranslate = [-1, 1, 0]\n[[model.key]]\nframe = 3\ntranslate = [1, 1.5, 0]\nrotate = [40, 0, 30]\n\
        [[model]]\nobj = \"floor.obj\"\nscale = 0.4\ntranslate = [0, 0.7, 1]\n[model.shapes]\nobj = \"floor.##.obj\"\n\
        [[light]]\ntype = \"sphere\"\nposition = [1, 4, 2]\nradius = 0.5\npower = 9\nsamples = 4\n\
        [[camera.key]]\nframe = 3\neye = [0.3, 4.5, 1]\ntarget = [0, 0, 0]\nfov = 60\n";
    let scene = load(folder.path(), text).scene;
    for backend in [BackendKind::Embree, BackendKind::Rust] {
        let settings = Settings { paths: 2, reflections: 1, ..toy::audited(1) };
        let mut renderer = Renderer::with(backend, &scene, &settings).unwrap();
        for frame in 1..=3 {
            let finished = renderer.render(frame, true).unwrap();
            let audit = finished.stats.audit.unwrap();
            assert_eq!(audit.differing, 0, "{backend:?}, frame {frame}: {audit:?}");
            assert!(frame == 1 || finished.stats.samples.good > 1000, "something is reused");
        }
    }
    assert!(scene.materials.len() > 20, "a material by value");
}
