//! Values of options: named choices, and numbers in the forms in which they are typed.

use std::num::NonZeroUsize;

use clap::ValueEnum;

use crate::scene::Shot;
use crate::settings::{
    Backdrop, BasePlace, Build, Caustics, Compression, Filter, LONGEST_SIDE, Look, PixelRect, Reuse,
    Settings, View,
};
use crate::trace::BackendKind;

/// Filters by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FilterArg {
    /// The mean of a pixel's own samples
    Box,
    /// The area that each sample stands for, as far as it lies in the pixel: the least noise in animations
    Area,
    /// Falls evenly
    Tent,
    /// A normal distribution
    Gaussian,
    /// Mitchell and Netravali's cubic
    Mitchell,
    /// Blackman's and Harris' window
    BlackmanHarris,
    /// The windowed sinc: sharpest, and rings
    Lanczos,
}

impl From<FilterArg> for Filter {
    fn from(filter: FilterArg) -> Self {
        match filter {
            FilterArg::Box => Self::Box,
            FilterArg::Area => Self::Area,
            FilterArg::Tent => Self::Tent,
            FilterArg::Gaussian => Self::Gaussian,
            FilterArg::Mitchell => Self::Mitchell,
            FilterArg::BlackmanHarris => Self::BlackmanHarris,
            FilterArg::Lanczos => Self::Lanczos,
        }
    }
}

/// Ways of light by way of clear glass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CausticsArg {
    /// Lights shine through it as if it were not there
    None,
    /// It casts shadows; paths find what comes through
    Paths,
}

impl From<CausticsArg> for Caustics {
    fn from(caustics: CausticsArg) -> Self {
        match caustics {
            CausticsArg::None => Self::None,
            CausticsArg::Paths => Self::Paths,
        }
    }
}

/// A limit to the indirect radiance of single rays, or none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClampArg(pub Option<f32>);

/// Reads a radiance above 0, or `none`.
pub fn clamp(text: &str) -> Result<ClampArg, String> {
    if text == "none" {
        return Ok(ClampArg(None));
    }
    let limit = text.trim().parse().ok().filter(|limit: &f32| limit.is_finite() && *limit > 0.0);
    let wanted = "a radiance above 0 is wanted, such as 10, or `none`";
    limit.map(|limit| ClampArg(Some(limit))).ok_or_else(|| String::from(wanted))
}

/// Places of base frames by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BasePlaceArg {
    /// The first of them
    First,
    /// The one in the middle
    Middle,
}

impl From<BasePlaceArg> for BasePlace {
    fn from(place: BasePlaceArg) -> Self {
        match place {
            BasePlaceArg::First => Self::First,
            BasePlaceArg::Middle => Self::Middle,
        }
    }
}

/// Backgrounds by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BackdropArg {
    /// It is a part of the picture; A is 1
    Visible,
    /// R G B are without it; A is 0
    Transparent,
}

impl From<BackdropArg> for Backdrop {
    fn from(background: BackdropArg) -> Self {
        match background {
            BackdropArg::Visible => Self::Visible,
            BackdropArg::Transparent => Self::Transparent,
        }
    }
}

/// View transforms by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ViewArg {
    /// sRGB as it is; what is brighter than 1 is cut off
    Standard,
    /// John Hable's curve, with a toe and a soft shoulder; white is 5.6
    Filmic,
    /// Troy Sobotka's AgX: 16.5 stops; what is very bright becomes white, whatever its hue
    Agx,
}

impl From<ViewArg> for View {
    fn from(view: ViewArg) -> Self {
        match view {
            ViewArg::Standard => Self::Standard,
            ViewArg::Filmic => Self::Filmic,
            ViewArg::Agx => Self::Agx,
        }
    }
}

/// Reads an exposure in stops.
pub fn exposure(text: &str) -> Result<f32, String> {
    let most = Look::MOST_EXPOSURE;
    let stops = text.trim().parse().ok().filter(|stops: &f32| stops.abs() <= most);
    stops.ok_or_else(|| format!("must be from -{most} to {most} stops"))
}

/// Exposure and view transform of pictures for screens: as typed, if given, or else the shot's.
pub fn settled_look((exposure, view): (Option<f32>, Option<ViewArg>), of_shot: Look) -> Look {
    Look { exposure: exposure.unwrap_or(of_shot.exposure), view: view.map_or(of_shot.view, View::from) }
}

/// Methods by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum CompressionArg {
    /// No compression: large files
    None,
    /// Deflate, line by line
    Zips,
    /// Deflate, 16 lines at once: a little smaller
    Zip,
    /// Wavelets, 32 lines at once: for grainy pictures
    Piz,
}

impl From<CompressionArg> for Compression {
    fn from(method: CompressionArg) -> Self {
        match method {
            CompressionArg::None => Self::None,
            CompressionArg::Zips => Self::Zips,
            CompressionArg::Zip => Self::Zip,
            CompressionArg::Piz => Self::Piz,
        }
    }
}

/// Rules by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ReuseArg {
    /// The nearest to the cell's centre; the others are kept, up to a cap
    Target,
    /// The nearest to the eye of those in the cell, as in the paper; the others are dropped
    Paper,
}

impl From<ReuseArg> for Reuse {
    fn from(rule: ReuseArg) -> Self {
        match rule {
            ReuseArg::Target => Self::Target,
            ReuseArg::Paper => Self::Paper,
        }
    }
}

/// Ways to build by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum BuildArg {
    /// Whichever renders the whole shot faster, regardless of the requested frames
    #[default]
    Auto,
    /// High quality, for fast rays
    Best,
    /// Fast, for a short shot of a big model
    Quick,
}

impl BuildArg {
    /// Build quality for `shot`.
    pub fn for_shot(self, shot: &Shot, settings: &Settings) -> Build {
        match self {
            Self::Auto => shot.build_that_pays(settings),
            Self::Best => Build::Best,
            Self::Quick => Build::Quick,
        }
    }
}

/// Tracers by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Intel's Embree
    Embree,
    /// Written in Rust, for comparison
    Rust,
}

impl From<Backend> for BackendKind {
    fn from(backend: Backend) -> Self {
        match backend {
            Backend::Embree => Self::Embree,
            Backend::Rust => Self::Rust,
        }
    }
}

/// Reads the radius of a filter, in pixels.
pub fn filter_radius(text: &str) -> Result<f32, String> {
    let range = Filter::LEAST_RADIUS..=Filter::LARGEST_RADIUS;
    let radius = text.trim().parse().ok().filter(|radius| range.contains(radius));
    radius.ok_or_else(|| format!("must be from {} to {} pixels", range.start(), range.end()))
}

/// Reads `1280x720`.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| {
        let side = |text: &str| text.trim().parse().ok().filter(|side| (1..=LONGEST_SIDE).contains(side));
        Some((side(width)?, side(height)?))
    });
    sides.ok_or_else(|| format!("write it as 1280x720, each side from 1 to {LONGEST_SIDE}"))
}

/// Reads `320x180+640+400`.
pub fn crop(text: &str) -> Result<PixelRect, String> {
    PixelRect::parse(text.trim()).ok_or_else(|| {
        String::from(
            "write it as 320x180+640+400: width, height, and the first column and row, counted from 0",
        )
    })
}

/// Reads a length in the units of the models.
pub fn radius(text: &str) -> Result<f64, String> {
    let radius = text.trim().parse().ok().filter(|radius: &f64| radius.is_finite() && *radius > 0.0);
    radius.ok_or_else(|| String::from("a length above 0 is wanted, in the units of the models"))
}

/// Reads a number of threads.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let count = text.parse::<NonZeroUsize>().ok().filter(|count| count.get() <= 4096);
    count.ok_or_else(|| String::from("a whole number from 1 to 4096 is wanted"))
}
