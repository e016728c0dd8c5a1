//! The table of a volume in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::At;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct VdbTable {
    /// OpenVDB file (.vdb), relative to the shot file; with one `#` for each digit of a number all files of that name, each of which is there
    /// in the frame of its number alone
    pub file: At<String>,
    /// Names of the grids that are read (all of numbers)
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub grids: Option<At<Vec<String>>>,
    /// Name of a `[[material]]`: what it says of `volume_scatter`, `volume_absorb` and `volume_emit` is where the grid `density`, or else the first
    /// one, has 1; a graph of it is evaluated of all grids
    pub material: At<String>,
    /// With a number in `file`: frame of the first file (its number)
    pub first: Option<At<f64>>,
}
