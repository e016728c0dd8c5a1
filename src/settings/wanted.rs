//! The error that is wanted of frames, and what follows from it.

use serde::Serialize;

/// The error that frames may have, from which [counts](crate::pilot::Counts) follow.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Wanted {
    /// Root of the mean square of a frame's noise, before any denoiser, relative to the mean of the frame: above 0 and below 1.
    pub error: f32,
    /// Counts that follow from it; the others are as they are stated.
    pub free: Free,
}

/// True for each of the counts that are to be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Free {
    /// Samples of a pixel.
    pub samples: bool,
    /// Paths of a sample.
    pub paths: bool,
    /// Reflected paths of a sample.
    pub reflections: bool,
    /// Shadow rays of a sample to lights that have a size.
    pub shadow_rays: bool,
}

impl Free {
    /// All of them.
    pub const ALL: Self = Self { samples: true, paths: true, reflections: true, shadow_rays: true };
}

impl Wanted {
    /// Reads an error, like `0.03` or `3%`.
    ///
    /// # Errors
    /// Text that is none.
    pub fn parse(text: &str) -> Result<f32, String> {
        let text = text.trim();
        let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |percent| (percent.trim_end(), 0.01));
        let error = number.parse().ok().map(|number: f32| number * unit);
        error.filter(|error| Self::RANGE.contains(error)).ok_or_else(|| String::from(Self::RULE))
    }

    /// Errors that can be asked for.
    pub const RANGE: std::ops::RangeInclusive<f32> = 0.001..=0.9;

    /// The same in words.
    pub const RULE: &str = "must be a share of the picture's mean from 0.001 to 0.9, such as 0.03 or 3%";
}
