//! Errors of pictures that cannot serve as an environment.

use std::fmt;

/// Reason why a picture cannot serve as an environment.
#[derive(Debug, Clone, PartialEq)]
pub enum PictureError {
    /// No texel at all, or not three values for each.
    #[allow(missing_docs, reason = "the names say it")]
    Size { width: u32, height: u32, values: usize },
    /// A value is negative, NaN or infinite.
    Value {
        /// Column and row of the value, from 0, from the top left.
        pixel: [u32; 2],
        /// Channel of the value: `R`, `G` or `B`.
        channel: char,
        /// The value.
        value: f32,
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size { width, height, values } => {
                write!(f, "has {values} values for {width}x{height} pixels: three for each are needed")
            }
            Self::Value { pixel: [x, y], channel, value } => {
                let place = format!("in channel {channel} of pixel ({x}, {y})");
                match value.is_finite() {
                    true => write!(f, "has the negative value {value} {place}: set negative values to 0"),
                    false => write!(f, "has the value {value} {place}: replace it by a finite one"),
                }
            }
        }
    }
}

impl std::error::Error for PictureError {}
