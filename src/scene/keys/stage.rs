//! The table of what of a USD file is read in a shot file, as it is written: see [`shot_file`](super).

use schemars::JsonSchema;
use serde::Deserialize;

use super::toml_text::At;
use crate::scene::import::usd::Purpose;

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageTable {
    /// Variants in place of those that the file selects, as "/World/set:time=night": path of the prim, variant set and variant; the set
    /// may be left out where the prim has one
    pub variants: Option<Vec<At<String>>>,
    /// Purposes of prims that are shown beside `default` (["render"])
    #[schemars(extend("uniqueItems" = true))]
    pub purposes: Option<Vec<Purpose>>,
    /// Paths of prims that alone are read, with all that is below them
    #[schemars(length(min = 1))]
    pub mask: Option<At<Vec<At<String>>>>,
    /// Paths of prims at and below which no payload is loaded
    pub unloaded: Option<Vec<At<String>>>,
    /// Frames of which times are read, as "1001-1100" (all)
    pub time_samples: Option<At<String>>,
}
