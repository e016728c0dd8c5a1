//! The table of curves in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::At;
use crate::scene::import::curves::Basis;

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CurvesTable {
    /// File of the curves: text (.curves), or an array of points (.npy: points x 3, or x 4 with radii)
    pub file: At<String>,
    /// With an array: the number of points of each curve (.npy), or one number for all curves
    pub counts: Option<At<Counts>>,
    /// With an array: texture coordinates of each curve (.npy: curves x 2)
    pub uvs: Option<At<String>>,
    /// Basis of the curves, where the file says nothing of it (linear)
    pub basis: Option<At<Basis>>,
    /// Radius of points that state none; of the first points, if there is `tip`
    #[schemars(range(min = 0, max = 1e9))]
    pub radius: Option<At<f64>>,
    /// Radius of the last points (that of the first)
    #[schemars(range(min = 0, max = 1e9))]
    pub tip: Option<At<f64>>,
    /// Greatest distance between a curve and the straight pieces that are drawn of it, in the units of the file (what no picture shows)
    #[schemars(range(min = 1e-9, max = 1e9))]
    pub tolerance: Option<At<f64>>,
    /// Name of a `[[material]]` (matt grey)
    pub material: Option<At<String>>,
}

/// Numbers of points of curves.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum Counts {
    /// Points of each curve
    Same(u32),
    /// File of the counts
    File(String),
}
