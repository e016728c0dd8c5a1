//! Leads a renderer through a schedule: keeps samples of base frames, returns to them, and loads stores of
//! earlier runs.

use std::fmt;
use std::time::Instant;

use super::{Origin, Step};
use crate::frame::{Finished, RenderError, Renderer, Snapshot};
use crate::stereo::Eye;

/// A frame that was not finished, and why.
#[derive(Debug)]
pub struct StepError {
    /// Number of the frame.
    pub frame: i32,
    /// Reason of the failure.
    pub error: RenderError,
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "frame {}: {}", self.frame, self.error)
    }
}

impl std::error::Error for StepError {}

/// Position of a renderer in its schedule.
#[derive(Debug, Default)]
pub struct Walk {
    /// Samples of the last base frame, if they are needed again.
    kept: Option<Snapshot>,
}

impl Walk {
    /// Renders the frame of `step` for `eye`. Steps must come in the schedule's order; the left eye comes
    /// first. `load` gives the renderer the samples that an earlier run has saved.
    ///
    /// # Errors
    /// Those of `load`, and a [`StepError`].
    pub fn render<E: From<StepError>>(
        &mut self,
        renderer: &mut Renderer<'_>,
        eye: Eye,
        step: Step,
        load: impl FnOnce(&mut Renderer<'_>) -> Result<(), E>,
    ) -> Result<Finished, E> {
        let start = Instant::now();
        match step.origin {
            // samples were restored or loaded for the left eye already
            _ if eye == Eye::Right => {}
            Origin::Nothing | Origin::Before => {}
            // in either case nothing that later frames left in the film counts: what is rendered between does not matter
            Origin::Base => match self.kept.take() {
                Some(kept) => renderer.restore(kept),
                None => renderer.forget_film(),
            },
            Origin::Saved => load(renderer)?,
        }
        let preparing = start.elapsed().as_secs_f64();
        let mut finished = renderer
            .render_eye(eye, step.frame, step.reuses())
            .map_err(|error| StepError { frame: step.frame, error })?;
        let start = Instant::now();
        if step.keep && renderer.eyes().last() == Some(&eye) {
            self.kept = renderer.snapshot();
        }
        let seconds = preparing + start.elapsed().as_secs_f64();
        finished.stats.seconds.reproject += seconds;
        finished.stats.seconds.total += seconds;
        Ok(finished)
    }
}
