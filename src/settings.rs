//! What decides a picture beside the scene: size, samples, filter, depth, mode.

use crate::layers::Layers;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Longest side of a picture, pixels: sample numbers stay within 32 bits at usual counts.
pub const LONGEST_SIDE: u32 = 65_535;

/// Most samples along a pixel's edge.
pub const MOST_SAMPLES: u32 = 16;

/// Most paths by which a sample may gather light: as many as the sequence of their random numbers keeps apart well, and a
/// tile can hold.
pub const MOST_PATHS: u32 = 1024;

/// Paths of a sample where there is light to gather and nothing is said.
pub const DEFAULT_PATHS: u32 = 16;

/// Most rays by which a rough surface may reflect: those of a tile are held at once.
pub const MOST_REFLECTIONS: u32 = 64;

/// Most rays by which a sample finds out how open it is.
pub const MOST_OCCLUSION_RAYS: u32 = 256;

/// How a frame gets its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
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

/// Which of the samples that are kept a cell shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Reuse {
    /// The nearest to the cell's centre, wherever it lies; all others are kept, too, up to a cap.
    #[default]
    Target,
    /// Of those in the cell the nearest to the eye, as in the paper; the others are dropped. For comparison.
    Paper,
}

/// How samples become pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// The mean of a pixel's own samples.
    #[default]
    Box,
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
    /// In pixels.
    pub const LEAST_RADIUS: f32 = 0.5;
    /// In pixels.
    pub const LARGEST_RADIUS: f32 = 4.0;

    /// Where nothing is said: how far it reaches, in pixels.
    pub fn usual_radius(self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
            Self::Lanczos => 3.0,
        }
    }
}

/// What frames spend on more paths for samples that have fewer than they may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// Nothing: a sample gets all of its paths at once.
    #[default]
    None,
    /// With what new and expired paths cost, as many paths as a frame that is traced in full.
    Full,
    /// With what new and expired paths cost, so many rays a frame; what must be traced is traced in any case.
    Rays(u64),
}

impl Budget {
    /// As the command line and shot files state it.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text.parse() {
            _ if text == "full" => Ok(Self::Full),
            Ok(rays) => Ok(Self::Rays(rays)),
            Err(_) => Err(String::from("must be `full`, or a number of rays a frame")),
        }
    }
}

/// How the file of a frame is made. The values in it do not depend on that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileFormat {
    /// A part for each layer, where files have one part otherwise.
    pub multipart: bool,
    /// Of all parts.
    pub compression: Compression,
}

/// What becomes of the background where the camera sees it directly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Backdrop {
    /// It is a part of the picture, and hides what the picture is put over.
    #[default]
    Visible,
    /// Nothing of it is in the picture.
    Transparent,
}

/// How files are made smaller. Nothing is lost in any way: methods that lose something spoil normals and counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Compression {
    /// Not at all.
    None,
    /// Deflate, line by line: read fastest by programs that ask for single lines.
    #[default]
    Zips,
    /// Deflate, 16 lines at once.
    Zip,
    /// Wavelets, 32 lines at once.
    Piz,
}

/// What denoising a picture is worth: time, or quality.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DenoiseQuality {
    /// For final frames.
    #[default]
    High,
    /// Less than half the time.
    Balanced,
    /// A fifth of the time: for previews.
    Fast,
}

/// What the structures that rays are traced through are worth, where the tracer has a choice. Pictures are the
/// same but for rounding at edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Build {
    /// Built with care, for fast rays: right for an animation.
    #[default]
    Best,
    /// Built fast, for rays that are a little slower: right for a short shot of a big model.
    Quick,
}

impl Build {
    /// Rays for each triangle below which a careful build does not pay. With ten million triangles it takes a
    /// quarter of a microsecond a triangle longer, and makes a ray 1 to 5 nanoseconds faster (docs/performance.md,
    /// "Time to the first frame"): it pays from 50 rays a triangle on at best. Through smaller models rays gain
    /// less, but those are built in no time.
    const RAYS_A_TRIANGLE: u64 = 40;

    /// What pays for so many rays through so many triangles.
    pub fn that_pays(rays: u64, triangles: u64) -> Self {
        if rays < triangles.saturating_mul(Self::RAYS_A_TRIANGLE) { Self::Quick } else { Self::Best }
    }
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
    /// How far it reaches, in pixels; the filter's usual radius if nobody says. The box has no other.
    pub filter_radius: Option<f32>,
    /// Bounces that a ray from the eye may take at mirrors and glass.
    pub depth: u32,
    /// Rays by which each sample of a rough surface reflects the scene, at most; 0: it does not.
    pub reflections: u32,
    /// Paths by which each sample gathers light from all around; 0: none.
    pub paths: u32,
    /// Paths of them that a sample gets at once; the others as far as the budget goes.
    pub paths_per_frame: u32,
    /// What frames spend on more paths.
    pub budget: Budget,
    /// Surfaces that such a path may meet.
    pub bounces: u32,
    /// Rays by which each sample finds out how open it is, where a layer or the ambient light asks for it.
    pub occlusion_rays: u32,
    /// How far these reach, in the units of the shot's files.
    pub occlusion_radius: f64,
    /// Reuse or not.
    pub mode: Mode,
    /// Which kept samples serve the cells of an inferred frame.
    pub reuse: Reuse,
    /// A base frame every so many frames, counted from the shot's first; 0: the first alone.
    pub base_every: u32,
    /// What is made and written beside `R G B A`.
    pub layers: Layers,
    /// What becomes of the background.
    pub background: Backdrop,
    /// Trace every sample again and count what differs.
    pub audit: bool,
    /// How the tracer is built.
    pub build: Build,
}

impl Default for Settings {
    /// As a shot has them that says nothing.
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            samples: 2,
            filter: Filter::default(),
            filter_radius: None,
            depth: 4,
            reflections: 4,
            paths: 0,
            paths_per_frame: DEFAULT_PATHS,
            budget: Budget::None,
            bounces: 2,
            occlusion_rays: 16,
            occlusion_radius: 1.0,
            mode: Mode::default(),
            reuse: Reuse::default(),
            base_every: 48,
            layers: Layers::USUAL,
            background: Backdrop::default(),
            audit: false,
            build: Build::default(),
        }
    }
}

impl Settings {
    /// How far the filter reaches, in pixels.
    pub fn filter_radius(&self) -> f32 {
        self.filter_radius.unwrap_or(self.filter.usual_radius())
    }

    /// Paths that a new sample gets at once.
    pub fn first_paths(&self) -> u32 {
        if self.budget == Budget::None {
            self.paths
        } else {
            self.paths_per_frame.clamp(1, self.paths.max(1))
        }
    }

    /// Samples of one frame.
    pub fn samples_a_frame(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * u64::from(self.samples).pow(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn new_samples_get_all_paths_unless_there_is_a_budget() {
        let with = |paths, budget| Settings { paths, budget, ..Settings::default() }.first_paths();
        assert_eq!(with(64, Budget::None), 64);
        assert_eq!(with(64, Budget::Full), DEFAULT_PATHS);
        assert_eq!(with(4, Budget::Rays(9)), 4);
    }

    #[test]
    fn a_careful_build_is_for_many_rays() {
        let frame = 2 * 1280 * 720;
        assert_eq!(Build::that_pays(frame, 10_000_000), Build::Quick, "a frame of a big model");
        assert_eq!(Build::that_pays(24 * 4 * frame, 1_000_000), Build::Best, "an animation");
        assert_eq!(Build::that_pays(0, u64::MAX), Build::Quick);
    }
}
