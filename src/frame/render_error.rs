//! Reasons for which a render ends early.

use std::fmt;

use crate::trace::TraceError;

/// Why there is no picture.
#[derive(Debug)]
pub enum RenderError {
    /// The tracer failed.
    Trace(TraceError),
    /// Texels could not be read, for this reason.
    Textures(String),
    /// The setting `only_lights` names no group of lights, for this reason.
    LightGroup(String),
    /// Nobody wanted it any more.
    Stopped,
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trace(error) => error.fmt(f),
            Self::Textures(why) => f.write_str(why),
            Self::LightGroup(why) => write!(f, "`only_lights` {why}"),
            Self::Stopped => f.write_str("stopped before it was done"),
        }
    }
}

impl std::error::Error for RenderError {}

impl From<TraceError> for RenderError {
    fn from(error: TraceError) -> Self {
        Self::Trace(error)
    }
}
