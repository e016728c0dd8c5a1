//! Pictures of parameters and normals: does each place look as they say, and is reuse exact?

use std::fs;
use std::path::Path;

use afterimage::frame::{Finished, Renderer};
use afterimage::scene::{self, Shot};
use afterimage::settings::{Filter, Mode, Settings};
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
        // what leans to the light is dimmed: the floor itself is not as bright
        let share = 1.0 / (1.4 * 0.8_f32);
        let fading = share + share * share - share.powi(3);
        let (near, far) = (1.4 * 0.5_f32.sqrt() * fading, 0.2 * 0.5_f32.sqrt());
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
            assert_eq!(audit.wrong(), 0, "{backend:?}, frame {frame}: {audit:?}");
            assert!(frame == 1 || finished.stats.samples.good > 1000, "something is reused");
        }
    }
    assert!(
        scene.materials.len() <= 2,
        "pictures of parameters make no materials: {}",
        scene.materials.len()
    );
}

/// A floor of 4 x 4 with squares of 1/64, black and white, lit from all around alike.
fn chequered() -> TempDir {
    let folder = folder("Kd 0 0 0\nKa 1 1 1\nillum 1\nmap_Kd -s 64 64 c.png\n");
    picture(
        &folder,
        "c.png",
        4,
        &(0..16).map(|i| [if (i + i / 4) % 2 == 0 { 0 } else { 255 }; 3]).collect::<Vec<_>>(),
    );
    folder
}

/// Keys of a camera that looks down on the floor from these heights, frame by frame.
fn from_heights(heights: &[f64]) -> String {
    let key = |(frame, height): (usize, &f64)| {
        format!(
            "[[camera.key]]\nframe = {}\neye = [0, {height}, 0.01]\ntarget = [0, 0, 0]\nfov = 40\n",
            frame + 1
        )
    };
    let keys: String = heights.iter().enumerate().map(key).collect();
    format!("{keys}[ambient]\ncolor = [1, 1, 1]\n{STILL}")
}

fn load_as_it_is(folder: &TempDir, text: &str) -> Shot {
    let path = folder.path().join("s.toml");
    fs::write(&path, text).unwrap();
    scene::load(&path, true).unwrap()
}

/// Reds of the pixels in the middle of the picture.
fn middle(frame: &Finished) -> Vec<f32> {
    (30..66).flat_map(|x| (24..48).map(move |y| (x, y))).map(|(x, y)| toy::color(frame, x, y).x).collect()
}

#[test]
fn fine_textures_are_smooth_in_the_distance_and_sharp_near_by() {
    let folder = chequered();
    let seen_from = |height: f64| {
        let scene = load_as_it_is(&folder, &from_heights(&[height])).scene;
        middle(&toy::render(&scene, &toy::audited(1), 1).pop().unwrap())
    };
    let far = seen_from(5.0);
    assert!(far.iter().all(|red| (red - 0.5).abs() < 0.06), "{far:?}");
    let near = seen_from(0.15);
    let (darkest, brightest) =
        near.iter().fold((1.0, 0.0), |(a, b): (f32, f32), red| (a.min(*red), b.max(*red)));
    assert!(darkest < 0.1 && brightest > 0.9, "{darkest} to {brightest}");
}

/// Levels that textures are filtered in are chosen by chance, but not by what tracers round differently.
#[test]
fn both_tracers_filter_alike() {
    let folder = chequered();
    let leans = "[[camera.key]]\nframe = 1\neye = [0.7, 0.45, 0.9]\ntarget = [0.1, 0, 0.2]\nfov = 40\n";
    let scene = load_as_it_is(&folder, &format!("{leans}[ambient]\ncolor = [1, 1, 1]\n{STILL}")).scene;
    let [embree, rust] = [BackendKind::Embree, BackendKind::Rust].map(|kind| {
        let mut renderer = Renderer::with(kind, &scene, &toy::audited(1)).unwrap();
        middle(&renderer.render(1, false).unwrap())
    });
    let differ = embree.iter().zip(&rust).filter(|(embree, rust)| (*embree - *rust).abs() > 0.005).count();
    let greys = embree.iter().filter(|red| (0.1..0.9).contains(*red)).count();
    assert!(differ <= 2 && greys > 300, "{differ} differ, {greys} are filtered");
}

/// Heights from which the eye comes twice as near or goes twice as far away.
const NEARER: [f64; 8] = [0.8, 0.65, 0.53, 0.43, 0.35, 0.28, 0.23, 0.19];
const FARTHER: [f64; 8] = [0.3, 0.37, 0.46, 0.57, 0.7, 0.87, 1.1, 1.4];

/// Primary rays of the frames after the first one, and the share of their samples that were traced anew.
fn traced(folder: &TempDir, heights: &[f64]) -> Vec<(u64, u64)> {
    let scene = load_as_it_is(folder, &from_heights(heights)).scene;
    let frames = toy::render(&scene, &toy::audited(1), heights.len() as i32);
    assert!(frames.iter().all(|frame| toy::differing(frame) == 0), "{heights:?}");
    let of = |frame: &Finished| {
        (frame.stats.rays.primary, frame.stats.samples.missed + frame.stats.samples.obscured)
    };
    frames.iter().skip(1).map(of).collect()
}

/// What is kept is looked up anew, which takes no ray.
#[test]
fn colours_follow_the_eye_without_a_ray() {
    let (plain, textured) = (folder("Kd 0 0 0\nKa 1 1 1\nillum 1\n"), chequered());
    for heights in [NEARER, FARTHER] {
        assert_eq!(traced(&plain, &heights), traced(&textured, &heights), "{heights:?}");
    }
}

/// Light depends on normals: where the place changes over which a picture of normals is filtered, samples end.
#[test]
fn samples_with_bent_normals_end_one_after_the_other() {
    let bent = folder("Kd 0.5 0.5 0.5\nillum 1\nmap_Kd c.png\nnorm n.png\n");
    picture(&bent, "c.png", 2, &[[50; 3], [200; 3], [90; 3], [10; 3]]);
    picture(&bent, "n.png", 2, &[[128, 128, 255], [140, 120, 250], [110, 128, 255], [128, 150, 250]]);
    let plain = folder("Kd 0 0 0\nKa 1 1 1\nillum 1\n");
    let (with, without) = (traced(&bent, &NEARER), traced(&plain, &NEARER));
    for ((_, with), (_, without)) in with.iter().zip(&without) {
        // of all samples; in the end each is traced again where the eye is nearer by the root of 2
        assert!(*with > without + 96 * 72 / 8 && *with < 96 * 72, "{with}, {without}");
    }
}

/// Mean square of the difference to the pixel on the right and to the one below.
fn sharpness(frame: &Finished) -> f32 {
    let red = frame.film.values("R").unwrap();
    let at = |x: usize, y: usize| red[y * 96 + x];
    let pixels = (8..87).flat_map(|x| (8..63).map(move |y| (x, y)));
    pixels.map(|(x, y)| (at(x, y) - at(x + 1, y)).powi(2) + (at(x, y) - at(x, y + 1)).powi(2)).sum()
}

/// Textures to which the eye comes nearer, of squares of a few pixels and of less than a cell: frames are as sharp as those that are traced in full.
#[test]
fn inferred_frames_are_as_sharp_as_those_that_are_traced_in_full() {
    let heights: Vec<f64> = (0..24).map(|frame| 4.0 * 0.985_f64.powi(frame)).collect();
    for (squares, filter, samples, most_off) in [
        (32, Filter::Box, 2, 0.05),
        (32, Filter::Gaussian, 2, 0.05),
        (32, Filter::Area, 2, 0.05),
        (32, Filter::Area, 4, 0.05),
        (400, Filter::Box, 2, 0.15),
        (400, Filter::Gaussian, 2, 0.15),
    ] {
        let folder = folder("Kd 0 0 0\nKa 1 1 1\nillum 1\nmap_Kd c.png\n");
        let greys = (0..squares * squares)
            .map(|at: u32| at.wrapping_mul(0x9e37_79b9) ^ at << 7)
            .map(|at| at.wrapping_mul(0x85eb_ca6b) >> 24);
        picture(&folder, "c.png", squares, &greys.map(|grey| [grey as u8; 3]).collect::<Vec<_>>());
        let scene = load_as_it_is(&folder, &from_heights(&heights)).scene;
        let of = |mode| {
            let settings = Settings { filter, mode, ..toy::settings(samples) };
            toy::render(&scene, &settings, 24).iter().map(sharpness).collect::<Vec<f32>>()
        };
        let pairs = of(Mode::Reproject).into_iter().zip(of(Mode::Full));
        let ratios: Vec<f32> = pairs.map(|(inferred, full)| inferred / full).collect();
        // in single frames cells may all lie alike on texels, or samples on cells: the middle one of three is not that
        let middle = |three: &[f32]| {
            let mut sorted = [three[0], three[1], three[2]];
            sorted.sort_by(f32::total_cmp);
            sorted[1]
        };
        let ratios: Vec<f32> = ratios.windows(3).map(middle).collect();
        assert!(
            ratios.iter().all(|ratio| (ratio - 1.0).abs() <= most_off),
            "{squares}, {filter:?}, {samples}: {ratios:.3?}"
        );
    }
}

/// Textures in pages look like textures in memory, to the bit, in both modes.
#[test]
fn pages_hold_what_memory_holds() {
    let side = 200_u32;
    let texel = |i: u32| [(i * 7) as u8, ((i * i) >> 5) as u8, (i / side) as u8];
    let folder = folder("Kd 1 1 1\nPr 0.4\nPm 0.5\nmap_Kd c.png\nmap_Pr c.png\nnorm -bm 0.2 c.png\n");
    picture(&folder, "c.png", side, &(0..side * side).map(texel).collect::<Vec<_>>());
    let frames = |memory: u32| {
        let rest = format!("{STILL}{}[render]\ntexture_memory = {memory}\n", sun([-1, -1, 0]));
        let shot = load(folder.path(), &rest);
        let paged = shot.scene.textures.iter().filter(|texture| texture.image.pager().is_some()).count();
        let settings = Settings { audit: true, ..toy::settings(1) };
        let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
        let frames: Vec<Finished> = (1..=2).map(|frame| renderer.render(frame, false).unwrap()).collect();
        assert!(frames.iter().all(|frame| toy::differing(frame) == 0));
        let pages = renderer.memory().texture_pages;
        (frames.into_iter().map(|frame| frame.film).collect::<Vec<_>>(), paged, pages)
    };
    let (whole, none, no_pages) = frames(1024);
    let (paged, all, pages) = frames(0);
    assert_eq!((none, no_pages), (0, None));
    assert!(all >= 3 && pages.is_some_and(|pages| pages.read > 0 && pages.asked > pages.read));
    for (whole, paged) in whole.iter().zip(&paged) {
        for (whole, paged) in whole.planes.iter().zip(&paged.planes) {
            assert!(whole == paged, "{}", whole.name);
        }
    }
}
