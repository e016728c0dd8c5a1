//! `--samples` and `--threshold`, and how large pictures and their samples may be.

use crate::cli::failure::Failure;
use crate::settings::{Filter, MOST_SAMPLES, Refinement, Settings, limits};

/// Samples along a pixel's edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SamplesArg {
    /// Samples along an edge of every pixel.
    pub fewest: u32,
    /// Samples along an edge of pixels that differ from their neighbours, if these get more.
    pub most: Option<u32>,
}

/// Reads `N`, or `MIN-MAX`.
pub fn samples(text: &str) -> Result<SamplesArg, String> {
    let count = |text: &str| {
        let count = text.parse().ok().filter(|count| (1..=MOST_SAMPLES).contains(count));
        count.ok_or_else(|| format!("{text} is not in 1..={MOST_SAMPLES}"))
    };
    Ok(match text.split_once('-') {
        Some((fewest, most)) => SamplesArg { fewest: count(fewest)?, most: Some(count(most)?) },
        None => SamplesArg { fewest: count(text)?, most: None },
    })
}

/// Reads a contrast.
pub fn threshold(text: &str) -> Result<f32, String> {
    let threshold = text.parse().ok().filter(|threshold| *threshold > 0.0 && *threshold < 1.0);
    threshold.ok_or_else(|| String::from("must be above 0 and below 1"))
}

/// Settles N, for N x N samples a pixel, and the refinement: from `samples` and `threshold` as typed, or from
/// `settings`.
pub fn settled(
    samples: Option<SamplesArg>,
    threshold: Option<f32>,
    settings: &Settings,
    filter: Filter,
) -> Result<(u32, Option<Refinement>), Failure> {
    let of_shot =
        SamplesArg { fewest: settings.samples, most: settings.refinement.map(|refinement| refinement.most) };
    let SamplesArg { fewest, most } = samples.unwrap_or(of_shot);
    let Some(most) = most else {
        return match threshold {
            Some(_) => Err(Failure::Usage(format!(
                "--threshold means nothing for {fewest}x{fewest} samples in every pixel: add --samples MIN-MAX"
            ))),
            None => Ok((fewest, None)),
        };
    };
    let of_shot = settings.refinement.map(|refinement| refinement.threshold);
    let threshold = threshold.or(of_shot).unwrap_or(Refinement::THRESHOLD);
    let refinement = Refinement { most, threshold }.checked(fewest, filter);
    let refinement = refinement.map_err(|message| {
        Failure::Usage(format!("{fewest} to {most} samples along a pixel's edge: {message}"))
    })?;
    Ok((fewest, Some(refinement)))
}

/// Refuses pictures that are too large, and crops that lie outside of them.
pub fn check_window(settings: &Settings) -> Result<(), Failure> {
    limits::check_window(settings, &option).map_err(Failure::Usage)
}

/// Refuses more samples than a renderer can number. `stated_by` is the option that states the samples.
pub fn check_samples(settings: &Settings, stated_by: &str) -> Result<(), Failure> {
    limits::check_samples(settings, &option, stated_by).map_err(Failure::Usage)
}

fn option(key: &str) -> String {
    format!("--{key}")
}
