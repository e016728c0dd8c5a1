//! Measures the seam between segments: how much the error of points that stay in sight changes where a base frame follows an inferred
//! frame, beside the change within a segment. `cargo run --release --example seam -- SHOT.toml [--border 25,49] [--size 320x180]
//! [--samples 2] [--paths 4] [--reference 6]`.
//!
//! Three ways lead from the frame before a border to the border: the chain goes on (as if there were no border), a base frame follows, or
//! both frames are traced in full. The error is relative to a reference of the same frame, so that light and textures that
//! change by themselves do not count. All are compared as rendered and denoised.

use std::error::Error;
use std::path::{Path, PathBuf};

use afterimage::denoise::{Denoiser, with_guides};
use afterimage::film::Film;
use afterimage::frame::{RenderError, Renderer};
use afterimage::layers::Layers;
use afterimage::scene::{self, Scene, Shot};
use afterimage::settings::{DenoiseQuality, Mode, Settings};
use clap::Parser;
use glam::{Mat4, Vec3};

/// Difference of two places up to which they are the same point, as a share of its depth.
const SAME_PLACE: f32 = 0.02;

/// Difference of albedo up to which the light at a point can be compared: a pixel at an edge or on a texture shows something else when
/// it moves by a part of itself.
const SAME_ALBEDO: f32 = 0.005;

/// Radiance below which errors are not counted as larger shares of it.
const DARK: f32 = 0.1;

/// Planes of albedo, which denoisers want.
const ALBEDO: [&str; 3] = ["denoise_albedo.R", "denoise_albedo.G", "denoise_albedo.B"];

/// `Z` of the background is greater.
const FARTHEST: f32 = 1e9;

/// Paths of a sample of references, over those of the pictures.
const REFERENCE_PATHS: u32 = 4;

/// Measures the seam between segments
#[derive(Debug, Parser)]
struct Arguments {
    /// A shot
    shot: PathBuf,

    /// Frames at which a segment begins; the one before it begins with the shot
    #[arg(long, value_delimiter = ',', default_value = "25", value_parser = clap::value_parser!(i32).range(3..))]
    border: Vec<i32>,

    /// Size of the pictures
    #[arg(long, value_parser = size, default_value = "320x180", value_name = "WxH")]
    size: [u32; 2],

    /// Samples along a pixel's edge
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=16))]
    samples: u32,

    /// Paths of a sample
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    paths: u32,

    /// Samples along a pixel's edge in references, which have four times as many paths a sample
    #[arg(long, default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=16))]
    reference: u32,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides =
        text.split_once('x').and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]));
    sides
        .filter(|sides| sides.iter().all(|side| (1..=4000).contains(side)))
        .ok_or_else(|| String::from("write 320x180"))
}

/// A picture as rendered, and denoised.
type Pictures = [Vec<Vec3>; 2];

/// Pictures around a border, as one way makes them.
struct Around {
    before: Pictures,
    border: Pictures,
    after: Pictures,
}

/// A reference, and what is seen in it.
struct Truth {
    pictures: Pictures,
    points: Vec<Vec3>,
    depths: Vec<f32>,
    albedo: Vec<Vec3>,
    world_to_ndc: Mat4,
}

/// Names of the rows: the kind of picture, and which points count.
const ROWS: [&str; 4] =
    ["rendered", "denoised", "rendered, points of the same albedo", "denoised, points of the same albedo"];

/// Root mean squares, percent; of pictures as rendered, and denoised.
#[derive(Debug, Clone, Copy, Default)]
struct Figures {
    /// Error of the border's frame in the chain.
    error: f64,
    /// Change of the error from the frame before to the border: within the chain, to a base frame, and if both are traced in full.
    inside: f64,
    to_base: f64,
    full: f64,
    /// Change from the base frame to the frame after it.
    from_base: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let shot = scene::load(Path::new(&arguments.shot), false)?;
    let mut all = Vec::new();
    for border in &arguments.border {
        let (figures, share) = measure(&shot, &arguments, *border)?;
        println!("border {border}: {share:.0} % of the points stay in sight");
        print(&figures);
        all.push(figures);
    }
    if all.len() > 1 {
        println!("all borders");
        print(&mean(&all));
    }
    Ok(())
}

/// Prints a row for each kind of picture.
fn print(figures: &[Figures; 4]) {
    println!(
        "| | error % | change % within | to a base frame | from it | in full | to a base frame, over within |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for (name, Figures { error, inside, to_base, full, from_base }) in ROWS.iter().zip(figures) {
        let ratio = to_base / inside;
        println!(
            "| {name} | {error:.2} | {inside:.2} | {to_base:.2} | {from_base:.2} | {full:.2} | {ratio:.2} |"
        );
    }
}

/// Root mean square over borders.
fn mean(all: &[[Figures; 4]]) -> [Figures; 4] {
    std::array::from_fn(|kind| {
        let of = |value: fn(&Figures) -> f64| {
            (all.iter().map(|figures| value(&figures[kind]).powi(2)).sum::<f64>() / all.len() as f64).sqrt()
        };
        Figures {
            error: of(|figures| figures.error),
            inside: of(|figures| figures.inside),
            to_base: of(|figures| figures.to_base),
            full: of(|figures| figures.full),
            from_base: of(|figures| figures.from_base),
        }
    })
}

/// Measures one border. Returns also how many of the pixels before it are in sight at it, percent.
fn measure(shot: &Shot, arguments: &Arguments, border: i32) -> Result<([Figures; 4], f64), Box<dyn Error>> {
    let [width, height] = arguments.size;
    let (samples, paths, mode) = (arguments.samples, arguments.paths, Mode::Reproject);
    let settings =
        Settings { width, height, samples, paths, mode, layers: Layers::NONE, ..shot.settings.clone() };
    let mut denoiser = Denoiser::new(rayon::current_num_threads(), DenoiseQuality::High)?;
    let [chain, segment, full] = [
        |frame: i32, first: i32, _: i32| frame != first,
        |frame, first, border| frame != first && frame != border,
        |_, _, _| false,
    ]
    .map(|reuses: fn(i32, i32, i32) -> bool| {
        around(&shot.scene, &settings, &mut denoiser, (shot.frames.first(), border), reuses)
    });
    let (chain, segment, full) = (chain?, segment?, full?);
    let truth = [border - 1, border, border + 1].map(|frame| {
        let samples = arguments.reference;
        let settings = Settings { samples, paths: paths * REFERENCE_PATHS, ..settings.clone() };
        truth(&shot.scene, &settings, &mut denoiser, frame)
    });
    let [before, at, after] = truth;
    let (before, at, after) = (before?, at?, after?);
    let pairs = |one: &Truth, other: &Truth| {
        let all = one.pairs(other, width as usize);
        let even = all.iter().copied().filter(|pair| one.has_same_albedo(other, *pair)).collect();
        [all, even]
    };
    let (to_border, on_from_it) = (pairs(&before, &at), pairs(&at, &after));
    let share = 100.0 * to_border[0].len() as f64 / before.points.len() as f64;
    let figures = std::array::from_fn(|row| {
        let (kind, points) = (row % 2, row / 2);
        let (pairs, later) = (&to_border[points], &on_from_it[points]);
        let error = |picture: &Pictures, truth: &Truth| relative(&picture[kind], &truth.pictures[kind]);
        let change = |was: &Pictures, is: &Pictures| {
            let (was, is) = (error(was, &before), error(is, &at));
            rms(pairs.iter().map(|[from, to]| is[*to] - was[*from]))
        };
        let (base, next) = (error(&segment.border, &at), error(&segment.after, &after));
        let of_chain = error(&chain.border, &at);
        Figures {
            error: rms(pairs.iter().map(|[_, to]| of_chain[*to])),
            inside: change(&chain.before, &chain.border),
            to_base: change(&segment.before, &segment.border),
            full: change(&full.before, &full.border),
            from_base: rms(later.iter().map(|[from, to]| next[*to] - base[*from])),
        }
    });
    Ok((figures, share))
}

/// Renders the frames around a border; `reuses` says which are inferred, from the frame, the first frame and the border.
fn around(
    scene: &Scene,
    settings: &Settings,
    denoiser: &mut Denoiser,
    (first, border): (i32, i32),
    reuses: fn(i32, i32, i32) -> bool,
) -> Result<Around, Box<dyn Error>> {
    let mut renderer = Renderer::new(scene, &with_guides(settings))?;
    let mut pictures = Vec::new();
    for frame in first..=border + 1 {
        let is_wanted = frame >= border - 1;
        let reuses = reuses(frame, first, border);
        if !is_wanted && !reuses && frame != first {
            continue; // nothing is made of it
        }
        let film = renderer.render(frame, reuses)?.film;
        if is_wanted {
            pictures.push(shown(&film, denoiser)?);
        }
    }
    let [before, border, after] =
        <[Pictures; 3]>::try_from(pictures).map_err(|_| "the border is too early")?;
    Ok(Around { before, border, after })
}

/// Renders the reference of `frame`.
fn truth(
    scene: &Scene,
    settings: &Settings,
    denoiser: &mut Denoiser,
    frame: i32,
) -> Result<Truth, Box<dyn Error>> {
    let layers = Layers::parse("P,Z")?;
    let settings = with_guides(&Settings { layers, ..settings.clone() });
    let finished = Renderer::new(scene, &settings).and_then(|mut renderer| renderer.render(frame, false));
    let finished = finished.map_err(|error: RenderError| error.to_string())?;
    let aspect = settings.width as f32 / settings.height as f32;
    Ok(Truth {
        pictures: shown(&finished.film, denoiser)?,
        points: triples(["P.X", "P.Y", "P.Z"].map(|name| finished.film.values(name).unwrap_or_default())),
        albedo: triples(ALBEDO.map(|name| finished.film.values(name).unwrap_or_default())),
        depths: finished.film.values("Z").unwrap_or_default(),
        world_to_ndc: finished.camera.world_to_ndc(aspect),
    })
}

fn shown(film: &Film, denoiser: &mut Denoiser) -> Result<Pictures, Box<dyn Error>> {
    let denoised = denoiser.denoise(film)?;
    let rendered = ["R", "G", "B"].map(|name| film.values(name).unwrap_or_default());
    Ok([triples(rendered), triples(denoised.each_ref().map(|plane| plane.values.to_floats()))])
}

fn triples([x, y, z]: [Vec<f32>; 3]) -> Vec<Vec3> {
    x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vec3::new(x, y, z)).collect()
}

/// Relative error of a picture, pixel by pixel. What is brighter than white counts as white.
fn relative(picture: &[Vec3], truth: &[Vec3]) -> Vec<Vec3> {
    let [is, right] = [picture, truth].map(|all| all.iter().map(|value| value.clamp(Vec3::ZERO, Vec3::ONE)));
    is.zip(right).map(|(is, right)| (is - right) / (right + DARK)).collect()
}

/// Root mean square over pixels and channels, percent.
fn rms(values: impl Iterator<Item = Vec3>) -> f64 {
    let (sum, count) =
        values.fold((0.0, 0), |(sum, count), value| (sum + f64::from(value.length_squared()), count + 1));
    100.0 * (sum / (3.0 * f64::from(count.max(1)))).sqrt()
}

impl Truth {
    /// Returns true if a pixel of this frame has the albedo of one of the next.
    fn has_same_albedo(&self, next: &Self, [from, to]: [usize; 2]) -> bool {
        (self.albedo[from] - next.albedo[to]).abs().max_element() < SAME_ALBEDO
    }

    /// Pixels of this frame with those of the next in which the same points are seen.
    fn pairs(&self, next: &Self, width: usize) -> Vec<[usize; 2]> {
        let height = self.points.len() / width;
        let pair = |pixel: usize| {
            let (point, depth) = (self.points[pixel], self.depths[pixel]);
            let ndc = next.world_to_ndc.project_point3(point);
            let at = [(ndc.x * 0.5 + 0.5) * width as f32, (0.5 - ndc.y * 0.5) * height as f32];
            let is_inside = at[0] >= 0.0 && at[1] >= 0.0 && at[0] < width as f32 && at[1] < height as f32;
            let other = (depth < FARTHEST && is_inside).then(|| at[1] as usize * width + at[0] as usize)?;
            (next.points[other].distance(point) < SAME_PLACE * depth).then_some([pixel, other])
        };
        (0..self.points.len()).filter_map(pair).collect()
    }
}
