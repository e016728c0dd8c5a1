//! The table of a deforming model's shapes in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::At;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{"required": ["obj"]}, {"required": ["cache"]}, {"required": ["curves"]}]))]
pub(crate) struct ShapesTable {
    /// A file name with one `#` for each digit of a number, relative to the shot file: all OBJ files of that name, of which positions
    /// (`v`) alone are read
    pub obj: Option<At<String>>,
    /// Point cache (MDD or PC2), relative to the shot file, instead of OBJ files: a shape for each of its samples
    pub cache: Option<At<String>>,
    /// Beside `curves`: a file name with `#` for digits, of arrays (.npy) or texts (.curves) of the same curves with other points
    pub curves: Option<At<String>>,
    /// Frame at which the model has the first shape; may be fractional (the first file's number; of a cache what it says, or 1)
    pub first: Option<At<f64>>,
    /// Frames from a number to the next one, or from sample to sample (1; of a cache what it says)
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub every: Option<At<f64>>,
    /// True if the first shape comes again after the last one, and so on
    #[serde(default)]
    pub repeat: bool,
}
