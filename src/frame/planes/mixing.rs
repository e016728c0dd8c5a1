//! Mixing: how the planes of exposures become those of a frame.

use super::channels::{Channel, Source, data};

/// Rule by which a plane of several exposures becomes one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MixRule {
    /// Filtered values, and shares: the mean of all exposures.
    Mean,
    /// Counts: their sum.
    Sum,
    /// Distances: the least.
    Least,
    /// Values that cannot be mixed: those of the exposure in the middle.
    Middle,
    /// Shares of mattes: the mean of each matte's.
    Matte,
}

impl MixRule {
    /// The rule for a plane.
    pub fn of(channel: &Channel) -> Self {
        match channel.source {
            Source::Filtered(_) | Source::Data(data::STATUS..data::RAYS) => Self::Mean,
            Source::Data(data::RAYS..data::MATERIAL) => Self::Sum,
            Source::Data(data::Z) => Self::Least,
            Source::Data(_) => Self::Middle,
            Source::Matte(_) => Self::Matte,
        }
    }
}
