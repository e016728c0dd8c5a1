//! `samples` of a shot file, as it is written: see [`shot_file`](super).

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;

use crate::settings::MOST_SAMPLES;

/// A number, or the bounds of adaptive samples.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "it must be a whole number, or a table like { min = 1, max = 4 }, with a threshold if you like"
)]
pub(crate) enum SamplesValue {
    Fixed(i64),
    Adaptive(AdaptiveTable),
}

/// Samples along a pixel's edge where there is little to see, and where there is much.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AdaptiveTable {
    /// N, for N x N samples in every pixel
    #[schemars(range(min = 1, max = MOST_SAMPLES))]
    pub min: i64,
    /// Samples along an edge of a pixel that differs from its neighbours: `min` doubled once or more
    #[schemars(range(min = 2, max = MOST_SAMPLES))]
    pub max: i64,
    /// Contrast of colours from which on pixels differ, above 0 and below 1 (0.1)
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub threshold: Option<f64>,
}

impl JsonSchema for SamplesValue {
    fn schema_name() -> Cow<'static, str> {
        "Samples".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let adaptive = generator.subschema_for::<AdaptiveTable>();
        json_schema!({"anyOf": [{"type": "integer", "minimum": 1, "maximum": MOST_SAMPLES}, adaptive]})
    }
}
