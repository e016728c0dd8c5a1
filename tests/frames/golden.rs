//! Did anything change? Frames against pictures that lie beside their scenes, in `golden/`.
//!
//! A golden picture is a sheet: the panels of [`PANELS`], one below the other. Where a frame is not as its
//! sheet, `target/golden/` gets what came, what was wanted and eight times the difference, side by side.
//! `AFTERIMAGE_GOLDEN=write cargo test --test frames golden` makes all of them anew: look at them before they
//! are committed.

use std::path::{Path, PathBuf};

use afterimage::film::Film;
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::output::png::srgb_byte;
use afterimage::scene;
use image::{Rgb, RgbImage};

/// Bytes by which a channel may differ in any pixel: rounding, and sums in another order.
const SLIGHT: u8 = 2;

/// Share of a panel's pixels that may differ by more: Embree has other kernels on other processors, which
/// give the few samples on an edge to the other side.
const MOST_PIXELS: f64 = 0.005;

/// Mean difference, in bytes, of the pixels that differ slightly at most: a shift of all of them by little
/// is a change too.
const MOST_MEAN: f64 = 0.1;

/// N, for N x N samples a pixel. Odd: of an even number no sample is nearest to a pixel's centre, and
/// rounding would choose the one that `Z` and `N` tell of.
const SAMPLES: u32 = 3;

/// How a value becomes a byte.
#[derive(Clone, Copy)]
enum Scale {
    /// Linear light.
    Color,
    /// -1 to 1.
    Direction,
    /// 0 to 1.
    Share,
    /// From 0 to beyond any limit.
    Distance,
}

/// Three planes as red, green and blue, from the sheet's top.
const PANELS: [([&str; 3], Scale); 9] = [
    (["R", "G", "B"], Scale::Color),
    (["diffuse.R", "diffuse.G", "diffuse.B"], Scale::Color),
    (["specular.R", "specular.G", "specular.B"], Scale::Color),
    (["reflection.R", "reflection.G", "reflection.B"], Scale::Color),
    (["refraction.R", "refraction.G", "refraction.B"], Scale::Color),
    (["albedo.R", "albedo.G", "albedo.B"], Scale::Color),
    (["N.X", "N.Y", "N.Z"], Scale::Direction),
    (["Z", "object.V", "status_age.V"], Scale::Distance),
    (["status_good.V", "status_missed.V", "status_obscured.V"], Scale::Share),
];

fn byte(value: f32, scale: Scale) -> u8 {
    let share = match scale {
        Scale::Color => return srgb_byte(value),
        Scale::Direction => value * 0.5 + 0.5,
        Scale::Share => value,
        Scale::Distance => value / (value + 4.0),
    };
    (share * 255.0).round() as u8 // `as` saturates, and takes NaN to 0
}

fn sheet(film: &Film) -> RgbImage {
    let (width, height) = (film.width, film.height);
    RgbImage::from_fn(width, height * PANELS.len() as u32, |x, y| {
        let (names, scale) = PANELS[(y / height) as usize];
        let at = (y % height * width + x) as usize;
        Rgb(names.map(|name| byte(film.values(name).unwrap()[at], scale)))
    })
}

/// What is wrong with each panel of `got`; nothing where it is as `wanted`.
fn differences(got: &RgbImage, wanted: &RgbImage) -> Vec<String> {
    if got.dimensions() != wanted.dimensions() {
        return vec![format!("{:?} instead of {:?} pixels", got.dimensions(), wanted.dimensions())];
    }
    let panel_bytes = got.as_raw().len() / PANELS.len();
    let panels = got.as_raw().chunks(panel_bytes).zip(wanted.as_raw().chunks(panel_bytes));
    let mut found = Vec::new();
    for ((got, wanted), (names, _)) in panels.zip(PANELS) {
        let bytes: Vec<u8> = got.iter().zip(wanted).map(|(a, b)| a.abs_diff(*b)).collect();
        let (slight, off): (Vec<_>, Vec<_>) =
            bytes.chunks(3).partition(|pixel| pixel.iter().all(|byte| *byte <= SLIGHT));
        let share = off.len() as f64 / (slight.len() + off.len()) as f64;
        let sum: u64 = slight.iter().flat_map(|pixel| pixel.iter()).map(|byte| u64::from(*byte)).sum();
        let mean = sum as f64 / (3 * slight.len()).max(1) as f64;
        if share > MOST_PIXELS || mean > MOST_MEAN {
            found.push(format!(
                "{names:?}: {} pixels ({:.2} %) differ, the others by {mean:.3}/255 on average",
                off.len(),
                share * 100.0
            ));
        }
    }
    found
}

/// What came, what was wanted, and eight times the difference.
fn three_panels(got: &RgbImage, wanted: &RgbImage) -> RgbImage {
    let (width, height) = (got.width().max(wanted.width()), got.height().max(wanted.height()));
    let at = |picture: &RgbImage, x, y| picture.get_pixel_checked(x, y).map_or([0; 3], |pixel| pixel.0);
    RgbImage::from_fn(width * 3, height, |x, y| {
        let (panel, x) = (x / width, x % width);
        let (a, b) = (at(got, x, y), at(wanted, x, y));
        Rgb(match panel {
            0 => a,
            1 => b,
            _ => [0, 1, 2].map(|i| a[i].abs_diff(b[i]).saturating_mul(8)),
        })
    })
}

fn compare(got: &RgbImage, golden: &Path) {
    if std::env::var_os("AFTERIMAGE_GOLDEN").is_some_and(|value| value == "write") {
        std::fs::create_dir_all(golden.parent().unwrap()).unwrap();
        got.save(golden).unwrap();
        println!("wrote {}", golden.display());
        return;
    }
    let wanted = image::open(golden)
        .unwrap_or_else(|error| panic!("{}: {error}; AFTERIMAGE_GOLDEN=write makes it", golden.display()))
        .into_rgb8();
    let found = differences(got, &wanted);
    if !found.is_empty() {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden");
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join(golden.file_name().unwrap());
        three_panels(got, &wanted).save(&path).unwrap();
        panic!(
            "{} is no longer what is rendered: {}\n(got, wanted, difference x 8: {})",
            golden.display(),
            found.join("; "),
            path.display()
        );
    }
}

/// Renders frames 1 to `last` of a shot and compares the last.
fn golden(shot: &str, size: (u32, u32), last: i32) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(shot);
    let shot = scene::load(&path, true).unwrap();
    let mut settings = shot.settings.clone();
    (settings.width, settings.height, settings.samples) = (size.0, size.1, SAMPLES);
    settings.layers = Layers::ALL;
    let mut renderer = Renderer::new(&shot.scene, &settings).unwrap();
    for frame in 1..last {
        renderer.render(frame, frame > 1).unwrap();
    }
    let film = renderer.render(last, last > 1).unwrap().film;
    let name: PathBuf = format!("{}.{last:04}.png", path.file_stem().unwrap().to_string_lossy()).into();
    compare(&sheet(&film), &path.with_file_name("golden").join(name));
}

#[test]
fn a_base_frame() {
    golden("analytic/analytic.toml", (64, 36), 1);
}

#[test]
fn a_moving_camera() {
    golden("analytic/analytic.toml", (64, 36), 8);
}

#[test]
fn changing_lights() {
    golden("analytic/lights.toml", (64, 36), 8);
}

#[test]
fn soft_shadows() {
    golden("analytic/panel.toml", (64, 36), 8);
}

#[test]
fn textures_mirrors_and_glass() {
    golden("city/city.toml", (128, 72), 3);
}

#[test]
fn a_turning_mirror() {
    golden("spin/spin.toml", (128, 72), 3);
}

#[test]
fn what_differs_is_found() {
    let plain = RgbImage::from_pixel(100, 10 * PANELS.len() as u32, Rgb([100; 3]));
    let mut edges = plain.clone();
    (0..5).for_each(|x| edges.put_pixel(x, 0, Rgb([160, 100, 100])));
    assert_eq!(differences(&edges, &plain), [""; 0]);
    edges.put_pixel(5, 0, Rgb([103, 100, 100]));
    assert!(differences(&edges, &plain)[0].contains("6 pixels"));
    let mut shifted = plain.clone();
    (0..100).for_each(|x| (10..20).for_each(|y| shifted.put_pixel(x, y, Rgb([101, 100, 100]))));
    assert!(differences(&shifted, &plain)[0].contains("diffuse.R"));
    let sheet = three_panels(&edges, &plain);
    assert_eq!((sheet.width(), sheet.get_pixel(200, 0).0), (300, [255, 0, 0]));
}
