//! Settings of what is made of a finished frame: its file, and its conversion for screens.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Format of the file of a frame. The values in it do not depend on that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileFormat {
    /// True for a part for each layer; otherwise files have one part.
    pub multipart: bool,
    /// Compression of all parts.
    pub compression: Compression,
}

/// Conversion of the light of a frame for screens: previews, contact sheets, movies, reports. EXR files hold
/// the light itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Look {
    /// Exposure in stops: each doubles the light.
    pub exposure: f32,
    /// View transform: the conversion of light to the values of a screen.
    pub view: View,
}

impl Look {
    /// Largest number of stops, up or down.
    pub const MOST_EXPOSURE: f32 = 20.0;
}

/// View transform: the conversion of light to the values of a screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum View {
    /// As it is: sRGB, and what is brighter than 1 is cut off.
    #[default]
    Standard,
    /// A film-like curve of each channel, with a toe and a soft shoulder: white is 5.6.
    Filmic,
    /// AgX: 16.5 stops, middle grey in the middle; what is very bright becomes white, whatever its hue.
    Agx,
}

/// Treatment of the background where the camera sees it directly.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Backdrop {
    /// It is a part of the picture, and hides what the picture is put over.
    #[default]
    Visible,
    /// Nothing of it is in the picture.
    Transparent,
}

/// Compression of files. Nothing is lost in any way: methods that lose something spoil normals and counts.
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

/// Choice between time and quality when a picture is denoised.
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
