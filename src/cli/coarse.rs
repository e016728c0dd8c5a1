//! Coarse pictures: quick versions of frames. `preview` shows them while a camera is moved, and `render`
//! writes one before a first frame that takes long.

use std::path::PathBuf;
use std::time::Instant;

use clap::ValueEnum;

use super::args::Job;
use super::failure::one_line;
use super::frames::paths;
use super::frames::target::Target;
use super::say::terminal::{Terminal, duration};
use crate::frame::{self, Aside, Renderer};
use crate::layers::Layers;
use crate::memory;
use crate::output::{self, png};
use crate::report::file::Destination;
use crate::scene::Shot;
use crate::settings::{Filter, PixelRect, Settings};

/// Limits of coarse pictures for settings that improve pictures at the cost of time.
const MOST_PATHS: u32 = 2;
const MOST_RAYS: u32 = 1;
/// Rays that a thread casts in a second, as [`rays`] counts them. It counts too many rays for paths, because
/// many of them escape.
const RAYS_A_SECOND: u64 = 4_000_000;
/// Divisors of a frame's sides for the coarse picture that `render` shows first. The smallest that is cheap
/// enough is taken.
const DIVISORS: [u32; 5] = [2, 4, 8, 16, 32];
/// Maximum cost of a coarse picture: its frame's rays divided by this.
const PART: u64 = 20;
/// Maximum cost of a coarse picture: the rays of a second divided by this.
const PART_OF_SECOND: u64 = 4;

/// Condition under which `render` writes a coarse picture first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum CoarseArg {
    /// On a terminal, where pictures for screens are written and the first frame takes long
    #[default]
    Auto,
    /// Whenever frames are rendered
    Always,
    /// Never
    None,
}

/// Circumstances of a run that decide whether a coarse picture pays.
#[derive(Debug, Clone, Copy)]
pub struct CoarseRun {
    /// True if progress is shown to somebody.
    pub is_watched: bool,
    /// True if it writes PNG files.
    pub writes_png: bool,
    /// True if it continues an earlier run.
    pub goes_on: bool,
}

impl CoarseArg {
    /// Settings of the coarse picture of a frame of `shot` that is rendered with `settings` on so many
    /// threads. None if there is to be no coarse picture.
    pub fn plan(self, run: CoarseRun, shot: &Shot, settings: &Settings, threads: usize) -> Option<Settings> {
        let (of_frame, second) = (rays(shot, settings), RAYS_A_SECOND * threads as u64);
        let is_wanted = match self {
            Self::Auto => run.is_watched && run.writes_png && !run.goes_on && of_frame >= second,
            Self::Always => true,
            Self::None => false,
        };
        let is_quick = |small: &Settings| {
            let rays = rays(shot, small);
            rays <= of_frame / PART && rays <= second / PART_OF_SECOND
        };
        let sizes = || DIVISORS.iter().map(|divisor| smaller(settings, *divisor));
        is_wanted.then(|| sizes().find(is_quick).or_else(|| sizes().next_back())).flatten()
    }
}

/// Estimates the rays of a frame whose samples are all traced.
pub fn rays(shot: &Shot, settings: &Settings) -> u64 {
    let samples = settings.data_window().pixels() * u64::from(settings.samples).pow(2);
    shot.rays_of_sample(settings).times(samples).total()
}

/// Settings of a small version of the picture, sharp and with one sample a pixel.
pub fn smaller(settings: &Settings, divisor: u32) -> Settings {
    let part = |side: u32| side.div_ceil(divisor);
    let small = Settings {
        width: part(settings.width),
        height: part(settings.height),
        overscan: settings.overscan / divisor,
        crop: None,
        samples: 1,
        refinement: None,
        filter: Filter::Box,
        filter_radius: None,
        paths: settings.paths.min(MOST_PATHS),
        paths_per_frame: settings.paths_per_frame.min(MOST_PATHS),
        reflections: settings.reflections.min(MOST_RAYS),
        occlusion_rays: settings.occlusion_rays.min(MOST_RAYS),
        exposures: Some(1),
        shutter: None,
        stereo: None,
        layers: Layers::NONE,
        audit: false,
        ..settings.clone()
    };
    let crop = settings.crop.map(|crop| smaller_crop(&crop, divisor, &small.overscanned()));
    Settings { crop, ..small }
}

/// Pixels of `crop` in a picture whose sides are divided by `divisor`, and which has the pixels `all`.
fn smaller_crop(crop: &PixelRect, divisor: u32, all: &PixelRect) -> PixelRect {
    let divisor = divisor as i32;
    let span = |first: i32, count: u32, (least, all): (i32, u32)| {
        let last = least + all as i32 - 1;
        let end = (first + count as i32 - 1).div_euclid(divisor).clamp(least, last);
        let first = first.div_euclid(divisor).clamp(least, last);
        (first, (end - first + 1) as u32)
    };
    let (x, width) = span(crop.x, crop.width, (all.x, all.width));
    let (y, height) = span(crop.y, crop.height, (all.y, all.height));
    PixelRect { x, y, width, height }
}

/// Writes a coarse picture of the first requested frame of `job`, made with `settings`, beside the frames of
/// `target`. A failure is reported, and does not stop the run.
pub fn write<'s>(
    renderer: &mut Renderer<'s>,
    job: &'s Job,
    settings: &Settings,
    target: &Target,
    terminal: &Terminal,
) {
    let (start, path, frame) = (Instant::now(), target.coarse(), job.frames.first());
    match written(renderer, job, settings, (target, &path), frame) {
        Ok(()) => terminal.note(&format!(
            "a coarse picture of frame {frame}, made in {}: {}",
            duration(start.elapsed().as_secs_f64()),
            path.display()
        )),
        Err(why) => terminal.warn(&format!("no coarse picture: {}", one_line(&why))),
    }
}

fn written<'s>(
    renderer: &mut Renderer<'s>,
    job: &'s Job,
    settings: &Settings,
    (target, path): (&Target, &PathBuf),
    frame: i32,
) -> Result<(), String> {
    paths::check(job, Some(target), &[("--coarse", path)]).map_err(|error| error.to_string())?;
    let Destination::File(file) = Destination::new(path).map_err(|error| error.to_string())? else {
        return Err(format!("{} is not a regular file", path.display()));
    };
    let kind = job.backend.unwrap_or_default();
    let need = frame::need_of_aside(&job.shot, settings, kind, rayon::current_num_threads());
    need.check(&memory::left()).map_err(|error| error.to_string())?;
    // what a killed run left
    let name = path.file_name();
    output::remove_leftovers(target.folder(), |left| name.is_some_and(|name| name == left));
    let mut beside = Aside::new(&job.shot.scene, settings);
    let seen = renderer.render_aside(&mut beside, None, frame, false).map_err(|error| error.to_string())?;
    let film = &seen.film;
    let planes = png::colors(film).map_err(|error| error.to_string())?;
    png::write_colors(&file, [film.width, film.height], planes, job.look, None)
        .map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene;

    const WATCHED: CoarseRun = CoarseRun { is_watched: true, writes_png: true, goes_on: false };

    #[test]
    fn coarse_pictures_are_small_and_sharp() {
        let settings = Settings { width: 641, height: 3, samples: 4, paths: 0, ..Settings::default() };
        let small = smaller(&settings, 8);
        assert_eq!((small.width, small.height, small.samples, small.paths), (81, 1, 1, 0));
    }

    #[test]
    fn a_part_of_a_picture_is_the_same_part_of_the_small_one() {
        let rect = |x, y, width, height| PixelRect { x, y, width, height };
        let cropped = |crop| {
            let settings =
                Settings { width: 100, height: 50, overscan: 9, crop: Some(crop), ..Settings::default() };
            let small = smaller(&settings, 8);
            let window = small.data_window();
            assert!(small.overscanned().holds(&window), "{window:?}");
            window
        };
        assert_eq!(cropped(rect(16, 8, 32, 24)), rect(2, 1, 4, 3));
        // a pixel of overscan is left of nine
        assert_eq!(cropped(rect(-9, -9, 118, 68)), rect(-1, -1, 15, 9));
        assert_eq!(cropped(rect(99, 49, 1, 1)), rect(12, 6, 1, 1));
    }

    #[test]
    fn one_is_made_where_somebody_waits_for_long() {
        let shot = scene::load(Path::new("scenes/city/sky.toml"), false).expect("it is shipped");
        let long = &shot.settings;
        let short = &Settings { width: 64, height: 36, ..long.clone() };
        let plan = |arg: CoarseArg, run, settings| arg.plan(run, &shot, settings, 2);
        let coarse = plan(CoarseArg::Auto, WATCHED, long).expect("it takes long");
        assert!(rays(&shot, &coarse) * PART <= rays(&shot, long));
        assert!(coarse.width >= long.width / 8, "{coarse:?}");
        for run in [
            CoarseRun { is_watched: false, ..WATCHED },
            CoarseRun { writes_png: false, ..WATCHED },
            CoarseRun { goes_on: true, ..WATCHED },
        ] {
            assert_eq!(plan(CoarseArg::Auto, run, long), None, "{run:?}");
            assert!(plan(CoarseArg::Always, run, long).is_some(), "{run:?}");
        }
        assert_eq!(plan(CoarseArg::Auto, WATCHED, short), None);
        assert!(plan(CoarseArg::Always, WATCHED, short).is_some());
        assert_eq!(plan(CoarseArg::None, WATCHED, long), None);
    }
}
