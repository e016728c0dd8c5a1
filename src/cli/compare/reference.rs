//! `compare --reference N`: the error of both ways against frames of more samples.

use std::sync::Arc;

use crate::cli::args::Job;
use crate::cli::args::samples::check_samples;
use crate::cli::failure::Failure;
use crate::film::Film;
use crate::frame::{Finished, Renderer, Watcher};
use crate::layers::Layers;
use crate::report::error::{BothErrors, PictureError};
use crate::report::reference::{ErrorTotals, Reference};
use crate::settings::{MOST_SAMPLES, Mode, Settings};
use crate::stereo::Eye;
use crate::trace::BackendKind;

/// Titles of the columns that the table has with a reference.
pub const TITLES: &str = "  error   full ratio";

/// Refuses a reference that has no more samples than the pictures it is compared with: it would tell nothing.
pub fn check(settings: &Settings, samples: u32) -> Result<(), Failure> {
    let own = settings.levels().last().unwrap_or(settings.samples);
    if samples <= own {
        return Err(Failure::Usage(format!(
            "--reference {samples} is no more than the {own}x{own} samples a pixel that are compared with it: take a \
             greater one (at most {MOST_SAMPLES}), or fewer --samples"
        )));
    }
    check_samples(&Settings { samples, refinement: None, ..settings.clone() }, "--reference")
}

/// Settings of the reference.
pub fn settings(job: &Job, samples: u32) -> Settings {
    let settings = job.settings.clone();
    Settings { samples, refinement: None, mode: Mode::Full, audit: false, layers: Layers::NONE, ..settings }
}

/// Renders the reference frames. They are made one after the other, so that memory holds the samples of one.
pub struct Judge<'s> {
    renderer: Renderer<'s>,
}

impl<'s> Judge<'s> {
    /// Creates a judge with its own scene in the tracer.
    pub fn new(kind: BackendKind, job: &'s Job, samples: u32) -> Result<Self, Failure> {
        let settings = settings(job, samples);
        Ok(Self { renderer: Renderer::with(kind, &job.shot.scene, &settings).map_err(Failure::of)? })
    }

    /// Reports finished tiles to `watcher`.
    pub fn watch(&mut self, watcher: Option<Watcher>) {
        self.renderer.watch(watcher);
    }

    /// Number of tiles in each frame.
    pub fn tiles_a_frame(&self) -> usize {
        self.renderer.tiles_a_frame()
    }

    /// Renders the reference of a frame as seen by `eye`. Returns the errors of `both` pictures against it,
    /// reprojected first, and the reference.
    pub fn errors(&mut self, eye: Eye, both: [&Finished; 2]) -> Result<(BothErrors, Arc<Film>), Failure> {
        let frame = both[0].stats.frame;
        let reference = self.renderer.render_eye(eye, frame, false);
        let reference =
            reference.map_err(|error| Failure::Failed(format!("frame {frame}, reference: {error}")))?.film;
        let [reprojected, full] = both.map(|finished| PictureError::between(&finished.film, &reference));
        Ok((BothErrors { reprojected, full }, reference))
    }
}

/// Formats the values below [`TITLES`].
pub fn columns(error: &BothErrors) -> String {
    let (ours, full) = (error.reprojected.display, error.full.display);
    let ratio = if full > 0.0 { format!("{:.2}", ours / full) } else { String::from("-") };
    format!(" {ours:>6.4} {full:>6.4} {ratio:>5}")
}

/// Lines about the error. Equal numbers of samples do not tell whether they make equal pictures.
pub fn lines(reference: Option<&Reference>) -> Vec<String> {
    let Some(Reference { samples, all, inferred }) = reference else {
        return vec![String::from(
            "error    not measured: samples of inferred frames lie elsewhere in their cells; --reference N tells what \
             that costs in error",
        )];
    };
    let line = |name: &str, totals: &ErrorTotals| {
        let or_dash =
            |value: Option<f64>| value.map_or_else(|| String::from("-"), |value| format!("{value:.2}"));
        format!(
            "error    {:.5} reprojected, {:.5} full: {} times; reprojected at equal error: {} times as fast ({name}: {})",
            totals.errors.reprojected.display,
            totals.errors.full.display,
            or_dash(totals.ratio),
            or_dash(totals.speed_up_at_equal_error),
            totals.frames,
        )
    };
    vec![
        line("all frames", all),
        line("inferred", inferred),
        format!(
            "{:<9}RMSE of linear R, G, B, clamped to 0 to 1, against {samples}x{samples} samples a pixel; time for an error \
             as error^2 x seconds",
            ""
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_has_more_samples_than_what_is_compared() {
        let settings = crate::report::comparison::tests::comparison(vec![]).settings.picture;
        let settings = Settings { samples: 2, ..settings };
        for (samples, is_good) in [(1, false), (2, false), (3, true), (16, true)] {
            assert_eq!(check(&settings, samples).is_ok(), is_good, "{samples}");
        }
        let huge = Settings { width: 65535, height: 5000, ..settings };
        let error = check(&huge, 16).expect_err("too many for memory");
        assert!(error.to_string().contains("--reference"), "{error}");
    }

    #[test]
    fn the_summary_tells_errors_or_how_to_measure_them() {
        let unknown = lines(None);
        assert!(unknown.len() == 1 && unknown[0].contains("--reference N"), "{unknown:?}");
        let totals = ErrorTotals {
            frames: 3,
            ratio: Some(1.25),
            speed_up_at_equal_error: Some(0.8),
            ..ErrorTotals::default()
        };
        let lines = lines(Some(&Reference { samples: 8, all: ErrorTotals::default(), inferred: totals }));
        assert!(lines[1].contains("1.25 times; reprojected at equal error: 0.80 times as fast"), "{lines:?}");
        assert!(lines[0].contains("full: - times"), "nothing to divide by: {lines:?}");
        assert!(lines[2].contains("8x8"), "{lines:?}");
    }
}
