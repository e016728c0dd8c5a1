//! Settings that decide a picture beside the scene: size, samples, filter, depth, mode.

pub mod limits;
mod output;
mod pixel_rect;
mod samples;
mod wanted;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use self::output::{Backdrop, Compression, DenoiseQuality, FileFormat, Look, View};
pub use self::pixel_rect::PixelRect;
pub use self::samples::{Filter, MOST_SAMPLES, Refinement, RefinementError};
pub use self::wanted::{Free, Wanted};
pub use crate::exposure::Shutter;
use crate::layers::Layers;
pub use crate::stereo::Stereo;

/// Longest side of a picture, pixels: sample numbers stay within 32 bits at usual counts.
pub const LONGEST_SIDE: u32 = 65_535;

/// Most pixels around a picture, on each side.
pub const MOST_OVERSCAN: u32 = 16_384;

/// Most paths by which a sample may gather light: as many as the sequence of their random numbers keeps apart
/// well, and as a tile can hold.
pub const MOST_PATHS: u32 = 1024;

/// Default number of paths of a sample, where there is light to gather.
pub const DEFAULT_PATHS: u32 = 16;

/// Most rays by which a rough surface may reflect: those of a tile are held at once.
pub const MOST_REFLECTIONS: u32 = 64;

/// Most rays of ambient occlusion of a sample.
pub const MOST_OCCLUSION_RAYS: u32 = 256;

/// Most memory that stored ray trees may take, MiB: a tebibyte.
pub const MOST_TREE_MEMORY: u32 = 1 << 20;

/// Default of the memory that stored ray trees may take, MiB: room for those of 9.5 million samples.
pub const DEFAULT_TREE_MEMORY: u32 = 256;

/// Source of a frame's samples.
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

/// Choice of the kept sample that a cell shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Reuse {
    /// The nearest to the cell's centre, wherever it lies; all others are kept, too, up to a cap.
    #[default]
    Target,
    /// The sample in the cell that is nearest to the eye, as in the paper; the others are dropped. For
    /// comparison.
    Paper,
}

/// Place of the base frame in a segment: segments lie between cuts, and are as long as
/// [`Settings::base_every`] says at most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BasePlace {
    /// The first one: all others are inferred forwards in time.
    #[default]
    First,
    /// The one in the middle: those before it are inferred backwards in time.
    Middle,
}

/// Caustics: the light that comes by way of clear glass and of mirrors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Caustics {
    /// Clear glass casts no shadow: lights shine through it as if it were not there.
    #[default]
    None,
    /// Glass casts a shadow as everything does. What comes through it is found by the paths that gather
    /// light, alone.
    Paths,
}

/// Budget of frames for more paths of samples that have fewer than they may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Budget {
    /// No budget: a sample gets all of its paths at once.
    #[default]
    None,
    /// As many paths as in a frame that is traced in full, those that are new or have expired included.
    Full,
    /// Number of rays a frame, those of new and expired paths included; these paths are traced in any case.
    Rays(u64),
}

impl Budget {
    /// As the command line and shot files state it.
    ///
    /// # Errors
    /// Text that is neither.
    pub fn parse(text: &str) -> Result<Self, BudgetError> {
        match text.parse() {
            _ if text == "full" => Ok(Self::Full),
            Ok(rays) => Ok(Self::Rays(rays)),
            Err(_) => Err(BudgetError),
        }
    }
}

/// Text that is no [`Budget`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BudgetError;

impl std::fmt::Display for BudgetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("must be `full`, or a number of rays a frame")
    }
}

impl std::error::Error for BudgetError {}

/// Effort in building the structures that rays are traced through, where the tracer has a choice. Pictures
/// are the same but for rounding at edges.
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
    /// Number of coherent rays for each triangle below which a careful build does not pay. It takes a quarter of
    /// a microsecond a triangle longer, and makes such a ray 1 to 28 nanoseconds faster (docs/performance.md, "Time
    /// to the first frame").
    const RAYS_A_TRIANGLE: u64 = 40;

    /// Number of coherent rays for which a scattered one counts: it becomes 33 to 220 nanoseconds faster.
    const GAIN_OF_SCATTERED: u64 = 8;

    /// Chooses the build that pays for so many rays through so many triangles.
    pub fn that_pays(rays: RayEstimate, triangles: u64) -> Self {
        let of_scattered = rays.scattered.saturating_mul(Self::GAIN_OF_SCATTERED);
        let gain = rays.coherent.saturating_add(of_scattered);
        if gain < triangles.saturating_mul(Self::RAYS_A_TRIANGLE) { Self::Quick } else { Self::Best }
    }
}

/// Estimate of how many rays are cast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RayEstimate {
    /// From the camera, and from what it sees to lights: rays of neighbours take the same way.
    pub coherent: u64,
    /// Along light paths, and from surfaces to what is around them: each takes a way of its own.
    pub scattered: u64,
}

impl RayEstimate {
    /// Number of all rays.
    pub fn total(self) -> u64 {
        self.coherent.saturating_add(self.scattered)
    }

    /// Rays of so many samples, if these are the rays of one.
    pub fn times(self, samples: u64) -> Self {
        let Self { coherent, scattered } = self;
        Self { coherent: coherent.saturating_mul(samples), scattered: scattered.saturating_mul(samples) }
    }
}

/// Settings of a whole run.
///
/// Other crates change what they want of the [default](Self::default): `Settings { samples: 3, ..Settings::default() }`.
/// `#[non_exhaustive]` would forbid that, and is left out: any version may add fields.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Settings {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Number of pixels around the picture, on each side, that are rendered as well.
    pub overscan: u32,
    /// Part of the picture and its overscan that is rendered; `None` for all.
    pub crop: Option<PixelRect>,
    /// Number N, for N x N samples a pixel; the fewest, if there is a refinement.
    pub samples: u32,
    /// Adaptive samples, if pixels may have more.
    pub refinement: Option<Refinement>,
    /// Filter from samples to pixels.
    pub filter: Filter,
    /// Radius of the filter, in pixels; the filter's usual radius if `None`. Filters [of one pixel](Filter::is_of_one_pixel) have no
    /// other.
    pub filter_radius: Option<f32>,
    /// Largest number of bounces, at mirrors and glass, of a ray from the eye.
    pub depth: u32,
    /// Largest number of rays by which each sample of a rough surface reflects the scene; 0: it does not.
    pub reflections: u32,
    /// Number of paths by which each sample gathers light from all around; 0: none.
    pub paths: u32,
    /// Number of these paths that a sample gets at once; the others follow as far as the budget goes.
    pub paths_per_frame: u32,
    /// Largest number of places at which a path is scattered in media after the first one that the eye sees.
    pub volume_bounces: u32,
    /// Places along each ray from the eye at which media scatter light.
    pub volume_samples: u32,
    /// Budget of frames for more paths.
    pub budget: Budget,
    /// Largest number of surfaces that such a path may meet.
    pub bounces: u32,
    /// Treatment of light by way of clear glass.
    pub caustics: Caustics,
    /// Upper limit of the indirect light of a ray beyond the first surface, or of a path; `None` for no
    /// limit. Radiance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clamp: Option<f32>,
    /// Light group whose contribution alone is rendered, of lights, of what emits, and of the world; `None`: all of them. Random choices are those
    /// of the whole picture, which is the sum of those of all groups.
    pub only_lights: Option<String>,
    /// Number of rays of ambient occlusion of each sample, where a layer or the ambient light needs it.
    pub occlusion_rays: u32,
    /// Length of these rays, in the units of the shot's files.
    pub occlusion_radius: f64,
    /// Memory for the ray trees of mirrors and glass that are kept before a camera at rest, MiB.
    pub tree_memory: u32,
    /// Stereo, if there are two eyes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stereo: Option<Stereo>,
    /// Shutter, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shutter: Option<Shutter>,
    /// Largest number of exposures that divide the samples of a pixel among them, if there is a shutter or a lens; `None` for as many as suit
    /// [the scene](crate::frame::exposures).
    pub exposures: Option<u32>,
    /// Source of the frames' samples.
    pub mode: Mode,
    /// Rule by which kept samples serve the cells of an inferred frame.
    pub reuse: Reuse,
    /// Distance of base frames, in frames, counted from the shot's first; 0: the first alone is one.
    pub base_every: u32,
    /// Place of the base frame among these frames.
    pub base_place: BasePlace,
    /// Layers that are made and written beside `R G B A`.
    pub layers: Layers,
    /// Treatment of the background.
    pub background: Backdrop,
    /// True to trace every sample again and count those that differ.
    pub audit: bool,
    /// Effort in building the tracer's structures.
    pub build: Build,
    /// The error from which counts follow, if one is wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted: Option<Wanted>,
}

impl Default for Settings {
    /// Settings of a shot that says nothing.
    fn default() -> Self {
        Self {
            width: 1280,
            height: 720,
            overscan: 0,
            crop: None,
            samples: 2,
            refinement: None,
            filter: Filter::default(),
            filter_radius: None,
            depth: 4,
            reflections: 4,
            paths: 0,
            paths_per_frame: DEFAULT_PATHS,
            volume_bounces: 4,
            volume_samples: 1,
            budget: Budget::None,
            bounces: 2,
            caustics: Caustics::default(),
            clamp: None,
            only_lights: None,
            occlusion_rays: 16,
            occlusion_radius: 1.0,
            tree_memory: DEFAULT_TREE_MEMORY,
            stereo: None,
            shutter: None,
            exposures: None,
            mode: Mode::default(),
            reuse: Reuse::default(),
            base_every: 48,
            base_place: BasePlace::default(),
            layers: Layers::USUAL,
            background: Backdrop::default(),
            audit: false,
            build: Build::default(),
            wanted: None,
        }
    }
}

impl Settings {
    /// Number of pixels beyond its own that a sample shows in.
    pub fn filter_reach(&self) -> u32 {
        if self.filter == Filter::Box { 0 } else { self.filter_radius().ceil() as u32 }
    }

    /// Radius of the filter, in pixels.
    pub fn filter_radius(&self) -> f32 {
        self.filter_radius.unwrap_or(self.filter.usual_radius())
    }

    /// Number of paths that a new sample gets at once.
    pub fn first_paths(&self) -> u32 {
        if self.budget == Budget::None {
            self.paths
        } else {
            self.paths_per_frame.clamp(1, self.paths.max(1))
        }
    }

    /// Picture with its overscan.
    pub fn overscanned(&self) -> PixelRect {
        let around = self.overscan as i32;
        PixelRect {
            x: -around,
            y: -around,
            width: self.width + 2 * self.overscan,
            height: self.height + 2 * self.overscan,
        }
    }

    /// Returns true if the picture with its overscan has no side that is too long.
    pub fn fits(&self) -> bool {
        let longest = self.width.max(self.height);
        u64::from(longest) + 2 * u64::from(self.overscan) <= u64::from(LONGEST_SIDE)
    }

    /// Pixels that are rendered; files call it data window.
    pub fn data_window(&self) -> PixelRect {
        self.crop.unwrap_or_else(|| self.overscanned())
    }

    /// Samples along a pixel's edge of each level, from the fewest on.
    pub fn levels(&self) -> impl Iterator<Item = u32> + use<> {
        let most = self.refinement.map_or(self.samples, |refinement| refinement.most);
        std::iter::successors(Some(self.samples), |samples| samples.checked_mul(2))
            .take_while(move |samples| *samples <= most)
    }

    /// Largest number of samples of a pixel, those of all levels together.
    pub fn samples_a_pixel(&self) -> u64 {
        self.levels().map(|samples| u64::from(samples).pow(2)).sum()
    }

    /// Largest number of samples of one frame of the whole picture, without overscan: values derived from
    /// this do not depend on which part of it is rendered.
    pub fn samples_a_frame(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height) * self.samples_a_pixel()
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
    fn each_level_is_twice_as_fine_as_the_one_before() {
        let with = |samples, most| {
            let refinement = Some(Refinement { most, threshold: 0.1 });
            Settings { samples, refinement, ..Settings::default() }
        };
        assert_eq!(with(1, 4).levels().collect::<Vec<_>>(), [1, 2, 4]);
        assert_eq!(with(3, 6).samples_a_pixel(), 9 + 36);
        assert_eq!(Settings { samples: 5, ..Settings::default() }.levels().collect::<Vec<_>>(), [5]);
    }

    #[test]
    fn a_crop_lies_in_the_picture_with_its_overscan() {
        let settings = Settings { width: 40, height: 20, overscan: 8, ..Settings::default() };
        let rect = |x, y, width, height| PixelRect { x, y, width, height };
        let around = settings.overscanned();
        assert_eq!(around, rect(-8, -8, 56, 36));
        assert!(around.holds(&rect(-8, -8, 56, 36)) && around.holds(&rect(47, 27, 1, 1)));
        for outside in [
            rect(-9, 0, 5, 5),
            rect(0, 0, 49, 1),
            rect(0, 27, 1, 2),
            rect(0, 0, 0, 5),
            rect(i32::MAX, 0, u32::MAX, 1),
        ] {
            assert!(!around.holds(&outside), "{outside}");
        }
    }

    #[test]
    fn a_careful_build_is_for_many_rays() {
        let sample = RayEstimate { coherent: 2, scattered: 0 };
        let build =
            |sample: RayEstimate, samples, triangles| Build::that_pays(sample.times(samples), triangles);
        let frame = 1280 * 720;
        assert_eq!(build(sample, frame, 10_000_000), Build::Quick, "a frame of a big model");
        assert_eq!(build(sample, 24 * 4 * frame, 1_000_000), Build::Best, "an animation");
        // a kitchen: 0.2 s a core are saved by a quick build, and 0.7 s lost in each frame
        let with_paths = RayEstimate { scattered: 15, ..sample };
        assert_eq!(
            build(with_paths, 9 * 320 * 180, 1_009_572),
            Build::Best,
            "one small frame with light paths"
        );
        assert_eq!(build(RayEstimate::default(), 1, u64::MAX), Build::Quick);
        assert_eq!(build(RayEstimate { coherent: 1, scattered: u64::MAX }, 2, u64::MAX), Build::Best);
    }
}
