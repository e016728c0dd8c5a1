//! Denoising of the frames of a run, if it is asked for.

use std::time::Instant;

use super::args::Job;
use super::failure::{Failure, one_line};
use super::frames::writing::Seen;
use crate::denoise::{self, DenoiseError, Denoiser};
use crate::memory::Need;
use crate::settings::Settings;

/// A denoiser, or none.
#[derive(Default)]
pub struct Denoising(Option<Denoiser>);

impl Denoising {
    /// Loads the library if `job` asks for it.
    pub fn new(job: &Job) -> Result<Self, DenoiseError> {
        let threads = rayon::current_num_threads();
        let filters_guides = denoise::has_rough_guides(&job.shot.scene, &job.settings);
        let new = |quality| Denoiser::new(threads, quality).map(|new| new.filtering_guides(filters_guides));
        job.denoise.map(new).transpose().map(Self)
    }

    /// Settings of `job`, with the layers that guide the denoiser.
    pub fn settings(&self, job: &Job) -> Settings {
        if self.0.is_some() { denoise::with_guides(&job.settings) } else { job.settings.clone() }
    }

    /// Adds the denoiser's memory to that which a run `needs`.
    pub fn need(&self, needs: Need, settings: &Settings) -> Need {
        if self.0.is_some() { needs.and(Need::new(denoise::need(settings))) } else { needs }
    }

    /// Gives a frame its denoised picture. Returns the seconds that this took.
    pub fn clean(&mut self, seen: &mut Seen) -> Result<f64, Failure> {
        let Some(denoiser) = &mut self.0 else { return Ok(0.0) };
        let start = Instant::now();
        let denoised = denoiser.denoise(&seen.finished.film).map_err(|error| {
            Failure::Failed(one_line(&format!("frame {}: {error}", seen.finished.stats.frame)))
        })?;
        seen.denoised = Some(denoised);
        Ok(start.elapsed().as_secs_f64())
    }

    /// Denoises a frame that is to be written, and adds the seconds to its statistics.
    pub fn clean_timed(&mut self, seen: &mut Seen) -> Result<(), Failure> {
        let seconds = self.clean(seen)?;
        seen.finished.stats.seconds.denoise += seconds;
        seen.finished.stats.seconds.total += seconds;
        Ok(())
    }
}
