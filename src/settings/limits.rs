//! Limits of whole pictures, which no setting breaks alone.

use super::{LONGEST_SIDE, PixelRect, Settings};

/// Maximum number of samples of one frame: their numbers have 32 bits, and tiles at the rim are filled up.
const MOST_IN_A_FRAME: u64 = 4_000_000_000;

/// Refuses pictures that are too large, and crops that lie outside of them. `word`: the user's word for a setting, as `--size`.
///
/// # Errors
/// The reason, and the remedy.
pub fn check_window(settings: &Settings, word: &dyn Fn(&str) -> String) -> Result<(), String> {
    let Settings { width, height, overscan, crop, .. } = settings;
    if !settings.fits() {
        return Err(format!(
            "{width}x{height} with an overscan of {overscan} pixels is more than {LONGEST_SIDE} pixels wide or high: take a \
             smaller {} or a smaller {}",
            word("size"),
            word("overscan")
        ));
    }
    let around = settings.overscanned();
    let Some(crop) = crop.filter(|crop| !around.holds(crop)) else { return Ok(()) };
    let of_what = match overscan {
        0 => format!("the picture is {width}x{height}"),
        _ => format!("the picture is {width}x{height}, and with its overscan {around}"),
    };
    Err(format!("{} {crop}: {of_what}, and a crop must lie in it and have a pixel at least", word("crop")))
}

/// Refuses more samples than a renderer can number. `word`: as in [`check_window`]; `stated_by`: the user's word for what states the
/// samples.
///
/// # Errors
/// The reason, and the remedy.
pub fn check_samples(
    settings: &Settings,
    word: &dyn Fn(&str) -> String,
    stated_by: &str,
) -> Result<(), String> {
    let PixelRect { width, height, .. } = settings.data_window();
    let samples = settings.levels().last().unwrap_or(settings.samples);
    let count = settings.data_window().pixels() * u64::from(samples).pow(2);
    if count > MOST_IN_A_FRAME {
        return Err(format!(
            "{width}x{height} with {samples}x{samples} samples a pixel is {count} samples a frame, and \
             {MOST_IN_A_FRAME} are the most: take a smaller {} or a smaller {stated_by}",
            word("size")
        ));
    }
    Ok(())
}
