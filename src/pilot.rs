//! Chooses samples, paths, reflected paths and shadow rays by one number: the error that frames may have.
//!
//! Small pictures of the shot tell what noise each of the four brings, and how many rays it takes, in frames that are traced in full and in
//! inferred ones. From these follow the counts that reach the error with the fewest rays a frame. All of it follows from the shot alone: every
//! machine that renders a part of it chooses the same.
//!
//! The model, with n samples a pixel, of which each has p paths, r reflected paths and l shadow rays to a light with a size:
//!
//! ```text
//! variance of a pixel = A / n^e + (B / p + C / r + D / l) / n      A: edges and textures
//! ```
//!
//! e is 1.5 for samples that are spread evenly, and less for those that were kept.
//!
//! In the small picture pixels are wider, and as much more of them lie on edges: A falls with the width of a pixel.

use serde::Serialize;

use crate::film::Film;
use crate::frame::{self, Built, RenderError, Renderer};
use crate::layers::Layers;
use crate::memory;
use crate::scene::{Material, Scene, Shot};
use crate::settings::{Budget, Filter, MOST_PATHS, MOST_REFLECTIONS, MOST_SAMPLES, Mode, Settings, Wanted};
use crate::stats::FrameStats;
use crate::trace::BackendKind;

/// Pixels of a small picture, at most: so that all of them take about as long as a frame of a small shot.
const MOST_PIXELS: u64 = 1600;

/// Samples along a pixel's edge of the pictures that are compared, and of that with which they are.
const COMPARED: u32 = 2;
const REFERENCE: u32 = 4;

/// Number of rays by which the pictures have more than one of something.
const MORE: u32 = 4;

/// Exponent by which noise of edges and textures falls with the number of samples: of even ones (Mitchell, "Consequences of Stratified
/// Sampling in Graphics", 1996), and as measured of those that were kept.
const EVEN: f64 = 1.5;
const KEPT: f64 = 1.25;

/// Frames that follow each other, of which the last one is looked at: kept samples come to rest.
const CHAIN: usize = 3;

/// Frames from which on a shot is looked at twice.
const LONG: usize = 48;

/// Rays for which the work on a sample counts that is none of rays: where it is traced, and where it may be kept. (Ten frames of cubes that turn took as
/// long either way when inferred ones had 3.7 rays a sample and full ones 4.5; of a flock, with 5.6 and 5.1, a quarter longer.)
const RAYS_OF_TRACED: f64 = 1.0;
const RAYS_OF_KEPT: f64 = 2.0;

/// Share of the pixels that differ most which tell nothing: a small picture has one spark or another.
const SPARKS: f64 = 0.002;

/// Multiple of the mean of a picture from which on brightness tells nothing: a lamp in the dark, or its image in a floor, is white however it is
/// off, and would have all of the dark traced until the lamp's edges are as even as the rest.
const BRIGHT: f64 = 10.0;

/// What makes noise, and what more rays of it are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    Paths,
    Reflections,
    ShadowRays,
}

impl Source {
    const ALL: [Self; 3] = [Self::Paths, Self::Reflections, Self::ShadowRays];

    /// Counts that are tried.
    fn counts(self) -> &'static [u32] {
        match self {
            Self::Paths => &[1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128],
            Self::Reflections => &[1, 2, 4, 8, 16, 32, 64],
            Self::ShadowRays => &[1, 4, 16],
        }
    }
}

const _: () = assert!(MOST_PATHS >= 128 && MOST_REFLECTIONS >= 64);

/// Counts of a frame's samples, and of what each of them casts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// N, for N x N samples a pixel.
    pub samples: u32,
    /// Paths of each sample by which it gathers light; 0: none.
    pub paths: u32,
    /// Paths of each sample by which a rough surface reflects; 0: none.
    pub reflections: u32,
    /// Shadow rays of each sample to each light that has a size; `None`: as many as each light says.
    pub shadow_rays: Option<u32>,
}

/// What was chosen for a shot, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The error that was wanted, relative to the mean of the picture.
    pub wanted: f32,
    /// The counts.
    pub counts: Counts,
    /// Error that a frame will have: root of the mean square, relative to the mean.
    pub expected: f64,
    /// Shares of this error's square: of edges and textures, of paths, of reflected paths, and of shadow rays.
    pub shares: [f64; 4],
    /// Rays of a frame, in the mean over base frames and inferred ones.
    pub rays: u64,
    /// False if reuse would save nothing: in `auto` mode all frames are traced in full then.
    pub reuses: bool,
}

/// What small pictures have shown.
#[derive(Debug, Clone, PartialEq)]
struct Measured {
    /// Variance of one sample by edges and textures, in a pixel of the shot's size, over the square of the mean.
    edges: f64,
    /// Exponent by which it falls with the number of samples.
    even: f64,
    /// Variance of one sample by one path of each source.
    noise: [f64; 3],
    /// Costs of base frames, and of inferred ones.
    costs: [Cost; 2],
    /// Frames from one base frame to the next.
    length: f64,
}

/// What a sample costs, in rays.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Cost {
    /// Without any of the sources.
    fixed: f64,
    /// One of each.
    rays: [f64; 3],
}

impl Cost {
    fn of(&self, counts: [u32; 3]) -> f64 {
        self.fixed + (0..3).map(|at| self.rays[at] * f64::from(counts[at])).sum::<f64>()
    }
}

impl Measured {
    /// What a sample costs in the mean of all frames.
    fn cost(&self, counts: [u32; 3]) -> f64 {
        let [base, inferred] = self.costs.map(|cost| cost.of(counts));
        (base + inferred * (self.length - 1.0)) / self.length
    }

    /// Returns true if reuse saves anything.
    fn reuse_pays(&self, counts: [u32; 3]) -> bool {
        let [base, inferred] = self.costs.map(|cost| cost.of(counts));
        // of one frame nothing is reused in any case
        self.length <= 1.0 || inferred < base
    }
}

/// Chooses counts for `shot` with these settings, of which those that are not free stay. `None` if the settings want no error, or if there is no
/// memory for a small picture.
///
/// # Errors
/// If a small picture cannot be rendered.
pub fn choose(kind: BackendKind, shot: &Shot, settings: &Settings) -> Result<Option<Choice>, RenderError> {
    let Some(wanted) = settings.wanted else { return Ok(None) };
    let small = small(settings, divisor(settings), REFERENCE);
    let need = frame::need(shot, &small, kind, CHAIN, rayon::current_num_threads());
    if need.check(&memory::left()).is_err() {
        // the shot itself has no room either, and who renders it says what would help
        return Ok(None);
    }
    let sources = sources(&shot.scene, settings, &wanted);
    let measured = measure(kind, shot, settings, &sources)?;
    Ok(Some(best(&measured, &wanted, settings, &sources)))
}

impl Choice {
    /// Returns true if the wanted error is expected.
    pub fn is_reached(&self) -> bool {
        // as far as singles tell
        self.expected <= f64::from(self.wanted) * 1.000_001
    }

    /// Has a shot's scene and settings be of these counts.
    pub fn apply(&self, scene: &mut Scene, settings: &mut Settings) {
        let Counts { samples, paths, reflections, shadow_rays } = self.counts;
        (settings.samples, settings.reflections) = (samples, reflections);
        if settings.wanted.is_some_and(|wanted| wanted.free.samples) {
            settings.refinement = None;
        }
        if settings.mode == Mode::Auto && !self.reuses {
            settings.mode = Mode::Full;
        }
        if settings.paths != paths {
            (settings.paths, settings.paths_per_frame) = (paths, paths);
        }
        set_shadow_rays(scene, shadow_rays);
    }
}

/// As `4x4 samples, 8 paths, 2 reflected paths, 4 shadow rays`.
impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { samples, paths, reflections, shadow_rays } = *self;
        write!(f, "{samples}x{samples} samples")?;
        let more =
            [(Some(paths), "path"), (Some(reflections), "reflected path"), (shadow_rays, "shadow ray")];
        for (count, name) in
            more.into_iter().filter_map(|(count, name)| Some((count.filter(|count| *count > 0)?, name)))
        {
            write!(f, ", {count} {name}{}", if count == 1 { "" } else { "s" })?;
        }
        Ok(())
    }
}

/// As `an error of 3 %: 4x4 samples, 8 paths; 2.9 % is expected, of its square edges and textures make 40 %, paths 60 %`.
impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { wanted, counts, expected, shares, .. } = self;
        let percent = |share: f64| (share * 1000.0).round() / 10.0;
        write!(f, "an error of {} %: {counts}; ", percent(f64::from(*wanted)))?;
        if !self.is_reached() {
            f.write_str("more is out of reach, ")?;
        }
        write!(f, "{} % is expected", percent(*expected))?;
        let names = ["edges and textures", "paths", "reflected paths", "shadow rays"];
        let told = names.iter().zip(shares).filter(|(_, share)| **share >= 0.005);
        for (number, (name, share)) in told.enumerate() {
            let before = if number == 0 { ", of its square" } else { "," };
            let makes = if number == 0 { " make" } else { "" };
            write!(f, "{before} {name}{makes} {} %", (share * 100.0).round())?;
        }
        if !self.reuses {
            f.write_str("; reuse saves nothing")?;
        }
        Ok(())
    }
}

/// Sources that the shot has and whose counts are free.
fn sources(scene: &Scene, settings: &Settings, wanted: &Wanted) -> Vec<Source> {
    let is_there = |source: &Source| match source {
        Source::Paths => wanted.free.paths && settings.paths > 0,
        Source::Reflections => {
            let is_rough = scene.materials.iter().any(Material::is_rough);
            wanted.free.reflections && settings.reflections > 0 && is_rough
        }
        Source::ShadowRays => {
            wanted.free.shadow_rays && scene.lights.iter().any(|light| light.kind.is_area())
        }
    };
    Source::ALL.into_iter().filter(is_there).collect()
}

fn set_shadow_rays(scene: &mut Scene, count: Option<u32>) {
    let Some(count) = count else { return };
    scene.lights.iter_mut().filter(|light| light.kind.is_area()).for_each(|light| light.samples = count);
}

/// Renders the small pictures.
fn measure(
    kind: BackendKind,
    shot: &Shot,
    settings: &Settings,
    sources: &[Source],
) -> Result<Measured, RenderError> {
    let divisor = divisor(settings);
    let frames = pilot_frames(shot);
    let mut pictures = Pictures { kind, frames: &frames, built: None };
    let with_more = |source: Option<Source>, samples: u32| {
        let count = |of: Source| if source == Some(of) { MORE } else { 1 };
        let mut small = small(settings, divisor, samples);
        let mut scene = shot.scene.clone();
        for of in sources {
            match of {
                Source::Paths => (small.paths, small.paths_per_frame) = (count(*of), count(*of)),
                Source::Reflections => small.reflections = count(*of),
                Source::ShadowRays => set_shadow_rays(&mut scene, Some(count(*of))),
            }
        }
        (scene, small)
    };
    let (scene, reference) = with_more(None, REFERENCE);
    let reference = pictures.render(&scene, &Settings { mode: Mode::Full, ..reference }, true)?;
    let mut of = |source: Option<Source>| {
        let (scene, small) = with_more(source, COMPARED);
        pictures.render(&scene, &small, false)
    };
    let first = of(None)?;
    let base_every = if settings.base_every == 0 { u32::MAX } else { settings.base_every };
    let length = shot.frames.list().len().min(base_every as usize).max(1) as f64;
    let rays_of = |made: &[Made]| -> [f64; 2] {
        let sum = |of: fn(&Made) -> f64| made.iter().map(of).sum::<f64>() / made.len() as f64;
        [sum(|made| made.base), sum(|made| made.inferred)]
    };
    let rays_of_first = rays_of(&first);
    let [n, reference_n] = [COMPARED, REFERENCE].map(|samples| f64::from(samples.pow(2)));
    let of_first = difference(&first, &reference);
    let (mut noise, mut rays) = ([0.0; 3], [[0.0; 3]; 2]);
    for source in sources {
        let more = of(Some(*source))?;
        let gained = of_first - difference(&more, &reference);
        let count = f64::from(MORE);
        noise[*source as usize] = (gained * n / (1.0 - 1.0 / count)).max(0.0);
        for ((rays, more), first) in rays.iter_mut().zip(rays_of(&more)).zip(rays_of_first) {
            rays[*source as usize] = ((more - first) / (count - 1.0)).max(0.0);
        }
    }
    let of_noise = noise.iter().sum::<f64>() * (1.0 / n + 1.0 / reference_n);
    let even = if settings.mode == Mode::Full || length <= 1.0 { EVEN } else { KEPT };
    let edges = (of_first - of_noise).max(0.0) / (n.powf(-even) + reference_n.powf(-EVEN));
    let work = [RAYS_OF_TRACED, RAYS_OF_KEPT];
    let cost = |kind: usize| {
        let fixed = (rays_of_first[kind] - rays[kind].iter().sum::<f64>()).max(0.0) + work[kind];
        Cost { fixed, rays: rays[kind] }
    };
    Ok(Measured { edges: edges / f64::from(divisor), even, noise, costs: [cost(0), cost(1)], length })
}

/// Frames of the shot of which small pictures are made: chains without a cut, which begin after a third of them and after two thirds, or
/// in the middle of a short one.
fn pilot_frames(shot: &Shot) -> Vec<Vec<i32>> {
    let all = shot.frames.list();
    let begins = if all.len() < LONG { vec![all.len() / 2] } else { vec![all.len() / 3, all.len() * 2 / 3] };
    let chain = |begin: usize| {
        let later = all[begin..].iter().skip(1).take(CHAIN - 1);
        let whole = later.take_while(|frame| !shot.scene.camera.cuts.contains(frame));
        std::iter::once(&all[begin]).chain(whole).copied().collect()
    };
    begins.into_iter().map(chain).collect()
}

/// Divisor of the sides of small pictures.
fn divisor(settings: &Settings) -> u32 {
    let times_too_large = settings.data_window().pixels() as f64 / MOST_PIXELS as f64;
    times_too_large.sqrt().ceil().max(1.0) as u32
}

/// Settings of a small picture of one eye.
fn small(settings: &Settings, divisor: u32, samples: u32) -> Settings {
    Settings {
        width: settings.width.div_ceil(divisor),
        height: settings.height.div_ceil(divisor),
        overscan: 0,
        crop: None,
        samples,
        refinement: None,
        filter: Filter::Box,
        filter_radius: None,
        budget: Budget::None,
        // each sample has its own moment all the same, and models are placed once
        exposures: Some(1),
        stereo: None,
        only_lights: None,
        mode: if settings.mode == Mode::Full { Mode::Full } else { Mode::Reproject },
        layers: Layers::NONE,
        audit: false,
        wanted: None,
        ..settings.clone()
    }
}

/// The last picture of a chain, and the rays of a sample in its base frame, and in the picture.
struct Made {
    film: std::sync::Arc<Film>,
    base: f64,
    inferred: f64,
}

/// Renders small pictures through the same acceleration structures.
struct Pictures<'a> {
    kind: BackendKind,
    frames: &'a [Vec<i32>],
    built: Option<Built>,
}

impl Pictures<'_> {
    fn render(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        is_reference: bool,
    ) -> Result<Vec<Made>, RenderError> {
        let mut renderer = match self.built.take() {
            Some(built) => Renderer::through(built, scene, settings),
            None => Renderer::with(self.kind, scene, settings)?,
        };
        // noise of its own, or the two would differ by less than they do from the truth
        renderer.set_salt(u32::from(is_reference));
        let samples = settings.data_window().pixels() as f64 * f64::from(settings.samples.pow(2));
        let rays = |stats: &FrameStats| stats.rays.total() as f64 / samples;
        let mut all = Vec::new();
        for chain in self.frames {
            let reuses = !is_reference && settings.mode != Mode::Full;
            // what is not made of samples of frames before is looked at by itself
            let chain = if reuses { &chain[..] } else { &chain[chain.len() - 1..] };
            let mut made = renderer.render(chain[0], false)?;
            let base = rays(&made.stats);
            for frame in &chain[1..] {
                made = renderer.render(*frame, true)?;
            }
            all.push(Made { inferred: rays(&made.stats), film: made.film, base });
        }
        self.built = Some(renderer.into_built());
        Ok(all)
    }
}

/// Mean of [`difference_of`] of pictures and their references.
fn difference(pictures: &[Made], references: &[Made]) -> f64 {
    let pairs = pictures.iter().zip(references);
    pairs.map(|(a, b)| difference_of(&colors(&a.film), &colors(&b.film))).sum::<f64>() / pictures.len() as f64
}

/// Mean of the squares of what the pixels of a picture differ from a reference by, over that of the reference's mean: without the pixels that
/// differ most, and with what is far brighter than the mean as bright as [`BRIGHT`] says.
fn difference_of(picture: &[[f64; 3]], reference: &[[f64; 3]]) -> f64 {
    let mean = reference.iter().flatten().sum::<f64>() / (3 * reference.len()) as f64;
    let off = |(a, b): (&f64, &f64)| (a.min(BRIGHT * mean) - b.min(BRIGHT * mean)).powi(2);
    let square = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(off).sum::<f64>() / 3.0;
    let mut squares: Vec<f64> = picture.iter().zip(reference).map(square).collect();
    squares.sort_unstable_by(f64::total_cmp);
    let kept = squares.len() - (squares.len() as f64 * SPARKS).ceil() as usize;
    let kept = &squares[..kept.max(1)];
    if mean > 0.0 { kept.iter().sum::<f64>() / kept.len() as f64 / mean.powi(2) } else { 0.0 }
}

/// Colours of all pixels.
fn colors(film: &Film) -> Vec<[f64; 3]> {
    let planes = ["R", "G", "B"].map(|name| film.values(name).unwrap_or_default());
    (0..planes[0].len()).map(|at| planes.each_ref().map(|plane| f64::from(plane[at]))).collect()
}

/// The counts that reach the wanted error with the fewest rays, or that come closest to it.
fn best(measured: &Measured, wanted: &Wanted, settings: &Settings, sources: &[Source]) -> Choice {
    let has_exposures = settings.shutter.is_some() || settings.exposures.is_some();
    // an even number can be divided among few exposures
    let step = if has_exposures { 2 } else { 1 };
    let samples: Vec<u32> = match wanted.free.samples {
        true => (2..=MOST_SAMPLES).step_by(step).collect(),
        false => vec![settings.samples],
    };
    let choices = |source: Source| if sources.contains(&source) { source.counts() } else { &[1][..] };
    let [paths, reflections, shadow_rays] = Source::ALL.map(choices);
    let combined = samples.iter().flat_map(|samples| {
        paths.iter().flat_map(move |p| {
            reflections.iter().flat_map(move |r| shadow_rays.iter().map(move |l| (*samples, [*p, *r, *l])))
        })
    });
    let of = |(samples, counts): (u32, [u32; 3])| {
        let n = f64::from(samples.pow(2));
        let noise = [0, 1, 2].map(|at| measured.noise[at] / (n * f64::from(counts[at])));
        let shares = [measured.edges / n.powf(measured.even), noise[0], noise[1], noise[2]];
        (shares, n * measured.cost(counts))
    };
    let square = f64::from(wanted.error).powi(2);
    let rank = |(shares, rays): ([f64; 4], f64)| {
        let variance: f64 = shares.iter().sum();
        // those that reach it by their rays, and others by how far they are from it
        if variance <= square { (0, rays) } else { (1, variance) }
    };
    let chosen = combined.min_by(|a, b| {
        let ([(kind, one), (other_kind, other)], counts) = ([rank(of(*a)), rank(of(*b))], a.cmp(b));
        kind.cmp(&other_kind).then(one.total_cmp(&other)).then(counts)
    });
    let (samples, counts) = chosen.unwrap_or((settings.samples, [1; 3]));
    let (shares, rays) = of((samples, counts));
    let variance: f64 = shares.iter().sum();
    let count_of = |source: Source, stated: u32| {
        if sources.contains(&source) { counts[source as usize] } else { stated }
    };
    Choice {
        wanted: wanted.error,
        counts: Counts {
            samples,
            paths: count_of(Source::Paths, settings.paths),
            reflections: count_of(Source::Reflections, settings.reflections),
            shadow_rays: sources.contains(&Source::ShadowRays).then_some(counts[Source::ShadowRays as usize]),
        },
        expected: variance.sqrt(),
        shares: shares.map(|share| if variance > 0.0 { share / variance } else { 0.0 }),
        rays: (rays * settings.data_window().pixels() as f64) as u64,
        reuses: measured.reuse_pays(counts),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Free;

    fn chosen(error: f32, free: Free, measured: &Measured) -> Choice {
        let settings = Settings { samples: 3, paths: 5, reflections: 6, ..Settings::default() };
        let wanted = Wanted { error, free };
        let sources: Vec<Source> = Source::ALL
            .into_iter()
            .filter(|source| [free.paths, free.reflections, free.shadow_rays][*source as usize])
            .collect();
        best(measured, &wanted, &settings, &sources)
    }

    const COST: Cost = Cost { fixed: 3.0, rays: [0.5, 1.0, 1.0] };
    const NOISY: Measured = Measured {
        edges: 0.5,
        even: EVEN,
        noise: [4.0, 0.5, 0.2],
        costs: [Cost { fixed: 4.0, ..COST }, COST],
        length: 20.0,
    };

    #[test]
    fn how_bright_a_lamp_in_the_dark_is_tells_nothing() {
        // a tenth of a noisy picture is a lamp, of which a pixel at its edge shows more or less
        let picture = |lamp: f64, edge: f64, off: f64| -> Vec<[f64; 3]> {
            let of = |at: u32| match at % 100 {
                0 => lamp * edge,
                1 => lamp,
                _ => 1.0 + if at.is_multiple_of(2) { off } else { -off },
            };
            (0..1000).map(|at| [of(at); 3]).collect()
        };
        let at = |lamp: f64| difference_of(&picture(lamp, 0.9, 0.1), &picture(lamp, 0.7, 0.0)).sqrt();
        let mean = |lamp: f64| 0.98 + 0.017 * lamp;
        // as the mean has it, where nothing is far brighter than that
        assert!((at(2.0) * mean(2.0) - f64::sqrt(0.099 * 0.099 + 0.04 * 0.04)).abs() < 2e-3, "{}", at(2.0));
        assert!((at(1e4) * mean(1e4) - 0.099).abs() < 2e-3, "{}", at(1e4));
    }

    #[test]
    fn what_is_chosen_reaches_the_error_and_costs_more_the_less_of_it_is_wanted() {
        let mut before = 0;
        for error in [0.5, 0.2, 0.1, 0.05, 0.03] {
            let choice = chosen(error, Free::ALL, &NOISY);
            assert!(choice.expected <= f64::from(error), "{choice:?}");
            assert!((choice.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            assert!(choice.rays >= before, "{choice:?}");
            before = choice.rays;
        }
    }

    #[test]
    fn rays_go_where_the_noise_is_and_where_they_are_cheap() {
        let choice = chosen(0.05, Free::ALL, &NOISY);
        assert!(choice.counts.paths > choice.counts.reflections, "{choice:?}");
        let cost = Cost { rays: [30.0, 1.0, 1.0], ..COST };
        let dear = Measured { costs: [cost; 2], ..NOISY };
        assert!(chosen(0.05, Free::ALL, &dear).counts.paths < choice.counts.paths);
        let edges = Measured { noise: [0.0; 3], ..NOISY };
        let counts = chosen(0.05, Free::ALL, &edges).counts;
        assert_eq!((counts.paths, counts.reflections, counts.shadow_rays), (1, 1, Some(1)));
    }

    #[test]
    fn what_is_not_cheaper_when_it_is_reused_is_traced() {
        let dear = Cost { fixed: 5.0, ..COST };
        for (costs, reuses) in [([dear, COST], true), ([COST, dear], false), ([COST, COST], false)] {
            assert_eq!(chosen(0.05, Free::ALL, &Measured { costs, ..NOISY }).reuses, reuses);
        }
        assert!(chosen(0.05, Free::ALL, &Measured { costs: [COST; 2], length: 1.0, ..NOISY }).reuses);
    }

    #[test]
    fn counts_that_are_stated_stay() {
        let free = Free { samples: false, reflections: false, shadow_rays: false, ..Free::ALL };
        let counts = chosen(0.05, free, &NOISY).counts;
        assert_eq!((counts.samples, counts.reflections, counts.shadow_rays), (3, 6, None));
        assert!(counts.paths > 1);
    }

    #[test]
    fn an_error_that_is_out_of_reach_gets_all_there_is() {
        let counts = chosen(1e-4, Free::ALL, &NOISY).counts;
        assert_eq!((counts.samples, counts.paths, counts.reflections), (16, 128, 64));
    }
}
