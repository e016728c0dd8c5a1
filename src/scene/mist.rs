//! Mist: how much of what is far away a compositor may hide.

use schemars::JsonSchema;
use serde::Deserialize;

/// Distances of a shot's mist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mist {
    /// Distance from the eye at which it begins, units of the shot's files.
    pub start: f64,
    /// Way from there to where it hides all, units of the shot's files; above 0.
    pub depth: f64,
    /// How it grows on that way.
    pub falloff: MistFalloff,
}

/// How mist grows from where it begins to where it hides all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MistFalloff {
    /// By the square of the way: slowly at first.
    #[default]
    Quadratic,
    /// Evenly.
    Linear,
    /// By the root of the way: fast at first.
    Inverse,
}

impl Default for Mist {
    fn default() -> Self {
        Self { start: 5.0, depth: 25.0, falloff: MistFalloff::default() }
    }
}
