//! What decides a picture beside the scene: size, samples, filter, depth, mode.

use crate::layers::Layers;
use serde::{Deserialize, Serialize};

/// Longest side of a picture, pixels: sample numbers stay within 32 bits at usual counts.
pub const LONGEST_SIDE: u32 = 65_535;

/// Most samples along a pixel's edge.
pub const MOST_SAMPLES: u32 = 16;

/// How a frame gets its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Reprojects where that is foreseen to pay, and traces the rest.
    #[default]
    Auto,
    /// Reprojects every frame that has one before it.
    Reproject,
    /// Traces every frame from nothing: the baseline.
    Full,
}

/// How samples become pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// The mean of a pixel's own samples.
    #[default]
    Box,
    /// Mitchell and Netravali's cubic, B = C = 1/3, two pixels in each direction.
    Mitchell,
}

/// What the structures that rays are traced through are worth, where the tracer has a choice. Pictures are the
/// same but for rounding at edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Build {
    /// Built with care, for fast rays: right for an animation.
    #[default]
    Best,
    /// Built fast, for frames that are up to a twentieth slower: right for a look at a big model.
    Quick,
}

/// Settings of a whole run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// N, for N x N samples a pixel.
    pub samples: u32,
    /// Samples to pixels.
    pub filter: Filter,
    /// Bounces that a ray from the eye may take at mirrors and glass.
    pub depth: u32,
    /// Reuse or not.
    pub mode: Mode,
    /// A base frame every so many frames, counted from the shot's first; 0: the first alone.
    pub base_every: u32,
    /// What is made and written beside `R G B A`.
    pub layers: Layers,
    /// Trace every sample again and count what differs.
    pub audit: bool,
    /// How the tracer is built.
    pub build: Build,
}
