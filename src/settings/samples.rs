//! The samples of a pixel: how many there may be, and what makes a pixel of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Most samples along a pixel's edge.
pub const MOST_SAMPLES: u32 = 16;

/// Filter that makes pixels of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// The mean of a pixel's own samples.
    #[default]
    Box,
    /// The area that each sample stands for, as far as it lies in the pixel.
    Area,
    /// Falls evenly to the radius.
    Tent,
    /// A normal distribution with a standard deviation of a third of the radius.
    Gaussian,
    /// Mitchell and Netravali's cubic, B = C = 1/3.
    Mitchell,
    /// Blackman's and Harris' window of four terms.
    BlackmanHarris,
    /// The windowed sinc.
    Lanczos,
}

impl Filter {
    /// Filters that reach across pixels: all but the box.
    pub const WIDE: [Self; 6] =
        [Self::Area, Self::Tent, Self::Gaussian, Self::Mitchell, Self::BlackmanHarris, Self::Lanczos];
    /// Least radius, in pixels.
    pub const LEAST_RADIUS: f32 = 0.5;
    /// Largest radius, in pixels.
    pub const LARGEST_RADIUS: f32 = 4.0;

    /// Returns true if a sample in the centre of its cell counts in its own pixel alone. Such a filter has no other
    /// radius.
    pub fn is_of_one_pixel(self) -> bool {
        matches!(self, Self::Box | Self::Area)
    }

    /// Default radius, in pixels: of the area, how far a sample reaches at most.
    pub fn usual_radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Area | Self::Mitchell => 2.0,
            Self::Lanczos => 3.0,
        }
    }
}

/// Adaptive samples: pixels that differ from their neighbours get more.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Refinement {
    /// Number N, for N x N samples in such a pixel at most: the fewest, doubled once or more.
    pub most: u32,
    /// Contrast of colours from which on pixels differ: see [`contrast`](crate::frame::tiles::contrast).
    pub threshold: f32,
}

impl Refinement {
    /// Default threshold.
    pub const THRESHOLD: f32 = 0.1;

    /// Checks that pixels can be refined so from `fewest` samples on, and mixed by this filter.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub fn checked(self, fewest: u32, filter: Filter) -> Result<Self, RefinementError> {
        let Self { most, threshold } = self;
        let is_doubled = most > fewest && most % fewest == 0 && (most / fewest).is_power_of_two();
        if !is_doubled || most > MOST_SAMPLES {
            return Err(RefinementError::Bounds);
        }
        if !(threshold > 0.0 && threshold < 1.0) {
            return Err(RefinementError::Threshold(threshold));
        }
        if filter != Filter::Box {
            return Err(RefinementError::Filter);
        }
        Ok(self)
    }
}

/// A [`Refinement`] that cannot be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RefinementError {
    /// The most samples are not the fewest, doubled once or more.
    Bounds,
    /// The threshold is no contrast.
    Threshold(f32),
    /// The filter cannot mix pixels of few samples and of many.
    Filter,
}

impl std::fmt::Display for RefinementError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Bounds => {
                f.write_str("the most must be the fewest doubled once or more, like 1 and 4, and 16 at most")
            }
            Self::Threshold(stated) => {
                write!(f, "the threshold {stated} must be a contrast above 0 and below 1")
            }
            Self::Filter => f.write_str("only the filter `box` can mix pixels of few samples and of many"),
        }
    }
}

impl std::error::Error for RefinementError {}
