//! Command-line options of a bare USD file: what of it is read.

use std::collections::BTreeSet;

use clap::Args;

use crate::scene::frames::Frames;
use crate::scene::usd::{Purpose, StageChoice, VariantChoice, prim_path};

/// Arguments as typed.
#[derive(Debug, Clone, Default, Args)]
pub struct UsdArgs {
    /// For a bare USD file: a variant in place of the one that it selects, as /World/set:time=night; without the set's name where the
    /// prim has one set alone. May be given several times
    #[arg(long, value_name = "/PRIM:SET=NAME", value_parser = VariantChoice::parse)]
    pub variant: Vec<VariantChoice>,

    /// For a bare USD file: purposes that are shown beside `default`: render, proxy, guide [default: those of its render settings, or
    /// render]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = purpose)]
    pub purposes: Vec<Purpose>,

    /// For a bare USD file: read only these prims, with all below them, as /World/set,/World/lights
    #[arg(long, value_name = "/PRIM,...", value_delimiter = ',', value_parser = prim_path)]
    pub mask: Vec<String>,

    /// For a bare USD file: load no payload at and below these prims; `/`: none at all
    #[arg(long, value_name = "/PRIM,...", value_delimiter = ',', value_parser = prim_path)]
    pub unloaded: Vec<String>,

    /// For a bare USD file: load no payload whose bounds (extentsHint) its camera does not see at any frame. They cast no shadows then
    #[arg(long)]
    pub only_seen: bool,

    /// For a bare USD file: its frames, of which alone times are read, as 1001-1100 [default: all]
    #[arg(long, value_name = "RANGE", allow_hyphen_values = true, value_parser = Frames::parse)]
    pub time_samples: Option<Frames>,

    /// For a bare USD file: the RenderSettings, or the RenderPass, as /Render/final [default: those that it names, or its first]
    #[arg(long, value_name = "/PRIM", value_parser = prim_path)]
    pub render_settings: Option<String>,
}

impl UsdArgs {
    /// The option that was typed first in the help's order, if any was.
    pub fn first(&self) -> Option<&'static str> {
        let Self { variant, purposes, mask, unloaded, only_seen, time_samples, render_settings } = self;
        [
            ("--variant", !variant.is_empty()),
            ("--purposes", !purposes.is_empty()),
            ("--mask", !mask.is_empty()),
            ("--unloaded", !unloaded.is_empty()),
            ("--only-seen", *only_seen),
            ("--time-samples", time_samples.is_some()),
            ("--render-settings", render_settings.is_some()),
        ]
        .into_iter()
        .find_map(|(name, is_there)| is_there.then_some(name))
    }

    /// What of a file is read.
    pub fn choice(&self) -> StageChoice {
        let purposes: BTreeSet<Purpose> = self.purposes.iter().copied().collect();
        StageChoice {
            variants: self.variant.clone(),
            purposes: (!purposes.is_empty()).then_some(purposes),
            mask: self.mask.clone(),
            unloaded: self.unloaded.clone(),
            frames: self.time_samples.as_ref().map(Frames::ends),
        }
    }
}

fn purpose(name: &str) -> Result<Purpose, String> {
    Purpose::named(name)
        .ok_or_else(|| String::from("must be render, proxy or guide; default is always shown"))
}
