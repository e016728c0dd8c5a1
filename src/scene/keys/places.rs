//! The table of the places of a model's copies in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::At;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlacesTable {
    /// Array as numpy.save writes it, relative to the shot file: matrices as `matrix` has them, of copies x 3 x 4 numbers, or of copies x keys
    /// x 3 x 4. Where a matrix is zero, the copy is not there
    pub file: At<String>,
    /// Text file, relative to the shot file, with the name of each copy in a line of its own (the model's name, and a number)
    pub names: Option<At<String>>,
    /// Array as numpy.save writes it, relative to the shot file, with a number from 0 to 1 for each copy: see `random` of the model
    pub randoms: Option<At<String>>,
    /// Frame of the first key; may be fractional (1)
    pub first: Option<At<f64>>,
    /// Frames from a key to the next one (1)
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub every: Option<At<f64>>,
}
