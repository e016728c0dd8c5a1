//! The command line of `afterimage preview`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use crate::cli::args::values::{ViewArg, exposure, settled_look, size, threads};
use crate::cli::bare_model::BareModelArgs;
use crate::settings::{Look, MOST_PATHS, MOST_SAMPLES};

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  afterimage preview walk.toml
      prints the address of a page on this machine; edit walk.toml and watch the page
  afterimage preview statue.obj --size 960x540 --samples 2
      a model on a turntable, in better quality

Keys in the page: left and right step, space plays, Home and End go to the first and the last frame. Drag in the
picture to orbit, with Shift to pan; the wheel zooms. Nothing is written. The page is served to this machine alone
(127.0.0.1), at an address that is another one in each run, until Ctrl-C.")]
pub struct PreviewArgs {
    /// A shot (TOML), or a model (OBJ, PLY, glTF, USD); without a camera of its own it is shown on a turntable
    #[arg(value_name = "SHOT.toml|MODEL")]
    pub shot: PathBuf,

    /// Port of the page's address; 0: any that is free
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,

    /// Size of the pictures in pixels [default: the shot's, made smaller to fit into 640x640]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,

    /// N, for N x N samples a pixel
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    pub samples: u32,

    /// Paths by which each sample gathers light, at most: no more than the shot's
    #[arg(long, value_name = "PATHS", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=i64::from(MOST_PATHS)))]
    pub paths: u32,

    /// Stops by which pictures are brighter, as 1 or -2.5 [default: the shot's, or 0]
    #[arg(long, value_name = "STOPS", value_parser = exposure, allow_hyphen_values = true)]
    pub exposure: Option<f32>,

    /// View transform of the pictures [default: the shot's, or standard]
    #[arg(long, value_enum)]
    pub view: Option<ViewArg>,

    /// A bare model's axis, camera and animation.
    #[command(flatten)]
    pub bare: BareModelArgs,

    /// Number of rendering threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<NonZeroUsize>,
}

impl PreviewArgs {
    /// Exposure and view transform of pictures; `of_shot` is that of the shot.
    pub fn look(&self, of_shot: Look) -> Look {
        settled_look((self.exposure, self.view), of_shot)
    }
}
