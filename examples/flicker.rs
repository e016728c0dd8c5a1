//! Measures how much points that stay in view change from frame to frame, as rendered and denoised; with reuse, and with all
//! frames traced in full: `cargo run --release --example flicker -- SHOT.toml [FRAMES [PATHS]]`.
//!
//! A point's change is the difference of what two frames show of it, over the mean of both. A pixel of one frame is looked
//! for in the next one where its point (layer `P`) is seen then, between four pixels; it counts if the same point is there,
//! with the same albedo. In a frame with reuse a sample stays on its surface and keeps its light; in a full one it is a new
//! one, with noise of its own.

use std::error::Error;
use std::path::Path;

use afterimage::denoise::{Denoiser, PLANES, with_guides};
use afterimage::film::{Film, Plane};
use afterimage::frame::Renderer;
use afterimage::layers::Layers;
use afterimage::scene::{self, Shot};
use afterimage::settings::{DenoiseQuality, Mode, Settings};
use glam::{Mat4, Vec3};

/// How far from a point what is seen in its place may be, as a share of its distance along the view axis.
const SAME_PLACE: f32 = 0.01;

/// How far the albedo may be off.
const SAME_ALBEDO: f32 = 0.005;

/// Radiance below which changes hardly matter.
const DARK: f32 = 1e-3;

/// `Z` of the background is greater.
const FARTHEST: f32 = 1e9;

/// What is looked at of a frame: pixels in rows.
struct Shown {
    size: [usize; 2],
    world_to_ndc: Mat4,
    point: Vec<Vec3>,
    depth: Vec<f32>,
    albedo: Vec<Vec3>,
    /// As rendered, and denoised.
    pictures: [Vec<Vec3>; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let path = words.next().ok_or("which shot? flicker SHOT.toml [FRAMES [PATHS]]")?;
    let frames: i32 = words.next().map_or(Ok(6), |word| word.parse())?;
    let shot = scene::load(Path::new(&path), false)?;
    let paths = words.next().map_or(Ok(shot.settings.paths), |word| word.parse())?;
    println!("mean change of a point from frame to frame, percent: rendered, denoised; of points in view");
    for (name, mode) in [("with reuse", Mode::Reproject), ("in full", Mode::Full)] {
        let layers = Layers::parse("P,Z")?;
        let settings = Settings { width: 640, height: 360, paths, mode, layers, ..shot.settings.clone() };
        let ([rendered, denoised], share) = measure(&shot, &with_guides(&settings), frames)?;
        println!("{name:<12}{rendered:>8.2}{denoised:>8.2}{share:>8.1}");
    }
    Ok(())
}

/// The mean change, rendered and denoised, and how many of the pixels were compared; all in percent.
fn measure(shot: &Shot, settings: &Settings, frames: i32) -> Result<([f64; 2], f64), Box<dyn Error>> {
    let mut renderer = Renderer::new(&shot.scene, settings)?;
    let mut denoiser = Denoiser::new(rayon::current_num_threads(), DenoiseQuality::High)?;
    let aspect = settings.width as f32 / settings.height as f32;
    let (mut before, mut sums, mut compared, mut pixels): (Option<Shown>, _, _, _) = (None, [0.0; 2], 0, 0);
    for frame in (shot.frames.first()..).take(frames as usize) {
        let finished = renderer.render(frame, settings.mode == Mode::Reproject)?;
        let denoised = denoiser.denoise(&finished.film)?;
        let now = shown(&finished.film, &denoised, finished.camera.world_to_ndc(aspect))
            .ok_or("a plane is missing")?;
        if let Some(before) = &before {
            let changes = (0..before.point.len()).filter_map(|pixel| change(before, pixel, &now));
            for change in changes {
                sums.iter_mut().zip(change).for_each(|(sum, change)| *sum += f64::from(change));
                compared += 1;
            }
            pixels += before.point.len();
        }
        before = Some(now);
    }
    let mean = sums.map(|sum| 100.0 * sum / f64::from(compared.max(1)));
    Ok((mean, 100.0 * f64::from(compared) / pixels.max(1) as f64))
}

fn shown(film: &Film, denoised: &[Plane; 3], world_to_ndc: Mat4) -> Option<Shown> {
    let triples = |values: [Vec<f32>; 3]| -> Vec<Vec3> {
        (0..values[0].len()).map(|i| Vec3::new(values[0][i], values[1][i], values[2][i])).collect()
    };
    let of_film = |[x, y, z]: [&str; 3]| Some(triples([film.values(x)?, film.values(y)?, film.values(z)?]));
    debug_assert!(denoised.iter().map(|plane| &*plane.name).eq(PLANES));
    Some(Shown {
        size: [film.width as usize, film.height as usize],
        world_to_ndc,
        point: of_film(["P.X", "P.Y", "P.Z"])?,
        depth: film.values("Z")?,
        albedo: of_film(["denoise_albedo.R", "denoise_albedo.G", "denoise_albedo.B"])?,
        pictures: [of_film(["R", "G", "B"])?, triples(denoised.each_ref().map(|p| p.values.to_floats()))],
    })
}

/// How much what is seen at a pixel of `before` changes, rendered and denoised; `None` where it is not in view now, or close
/// to something else.
fn change(before: &Shown, pixel: usize, now: &Shown) -> Option<[f32; 2]> {
    let (point, depth) = (before.point[pixel], before.depth[pixel]);
    if depth > FARTHEST {
        return None;
    }
    let ndc = now.world_to_ndc.project_point3(point);
    let [width, height] = now.size.map(|side| side as f32);
    let at = [(ndc.x * 0.5 + 0.5) * width - 0.5, (0.5 - ndc.y * 0.5) * height - 0.5];
    let is_inside = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < width - 1.0 && at[1] < height - 1.0;
    if !is_inside || now.between(&now.point, at).distance(point) > SAME_PLACE * depth {
        return None;
    }
    if (now.between(&now.albedo, at) - before.albedo[pixel]).abs().max_element() > SAME_ALBEDO {
        return None;
    }
    Some([0, 1].map(|picture| {
        let (was, is) = (before.pictures[picture][pixel], now.between(&now.pictures[picture], at));
        (was - is).abs().element_sum() / (0.5 * (was + is).element_sum() + 3.0 * DARK)
    }))
}

impl Shown {
    /// Between the four pixels around a place, which is in pixels from the first one's centre.
    fn between(&self, values: &[Vec3], at: [f32; 2]) -> Vec3 {
        let [x, y] = at.map(|at| at as usize);
        let [right, down] = at.map(f32::fract);
        let row = |y: usize| {
            let first = y * self.size[0] + x;
            values[first].lerp(values[first + 1], right)
        };
        row(y).lerp(row(y + 1), down)
    }
}
