//! What the command line says of a bare model, which is shown on a turntable.

use std::path::Path;

use clap::ValueEnum;

use super::failure::Failure;
use crate::scene::turntable::{self, Up};

/// Axes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// Y, as in most OBJ files
    Y,
    /// Z, as some CAD and modelling programs write
    Z,
}

impl From<UpArg> for Up {
    fn from(axis: UpArg) -> Self {
        match axis {
            UpArg::Y => Self::Y,
            UpArg::Z => Self::Z,
        }
    }
}

/// Whether a file is a bare model, by its ending.
pub fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj"))
}

/// How a model is shown if `path` is one.
pub fn turntable_options(
    path: &Path,
    up: Option<UpArg>,
    size: Option<(u32, u32)>,
) -> Result<turntable::Options, Failure> {
    if up.is_some() && !is_model(path) {
        return Err(Failure::Usage(String::from(
            "--up is for bare models: in a shot file, write `rotate` into the [[model]]",
        )));
    }
    let default = turntable::Options::default();
    let size = size.map_or(default.size, |(width, height)| [width, height]);
    Ok(turntable::Options { up: up.map(Up::from), size })
}
