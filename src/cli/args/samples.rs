//! `--samples` and `--threshold`, and how large pictures and their samples may be.

use crate::cli::failure::Failure;
use crate::settings::{Filter, LONGEST_SIDE, MOST_SAMPLES, PixelRect, Refinement, Settings};

/// Maximum number of samples of one frame: their numbers have 32 bits, and tiles at the rim are filled up.
const MOST_IN_A_FRAME: u64 = 4_000_000_000;

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
    let Settings { width, height, overscan, crop, .. } = settings;
    if !settings.fits() {
        return Err(Failure::Usage(format!(
            "{width}x{height} with an overscan of {overscan} pixels is more than {LONGEST_SIDE} pixels wide or high: take a \
             smaller --size or a smaller --overscan"
        )));
    }
    let around = settings.overscanned();
    let Some(crop) = crop.filter(|crop| !around.holds(crop)) else { return Ok(()) };
    let of_what = match overscan {
        0 => format!("the picture is {width}x{height}"),
        _ => format!("the picture is {width}x{height}, and with its overscan {around}"),
    };
    Err(Failure::Usage(format!(
        "--crop {crop}: {of_what}, and a crop must lie in it and have a pixel at least"
    )))
}

/// Refuses more samples than a renderer can number. `option` is the one that states the samples.
pub fn check_samples(settings: &Settings, option: &str) -> Result<(), Failure> {
    let PixelRect { width, height, .. } = settings.data_window();
    let samples = settings.levels().last().unwrap_or(settings.samples);
    let count = settings.data_window().pixels() * u64::from(samples).pow(2);
    if count > MOST_IN_A_FRAME {
        return Err(Failure::Usage(format!(
            "{width}x{height} with {samples}x{samples} samples a pixel is {count} samples a frame, and \
             {MOST_IN_A_FRAME} are the most: take a smaller --size or a smaller {option}"
        )));
    }
    Ok(())
}
