//! Mixing: how the planes of exposures become those of a frame.

use super::channels::{Channel, PlaneSource, data, sums};

/// Rule by which a plane of several exposures becomes one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MixRule {
    /// Filtered values, and shares: the mean of all exposures.
    Mean,
    /// The variance of the mean of all exposures.
    Variance,
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
    pub fn new(channel: &Channel) -> Self {
        match channel.source {
            PlaneSource::Filtered(&[sums::VARIANCE]) => Self::Variance,
            PlaneSource::Filtered(_) | PlaneSource::Data(data::STATUS..data::RAYS) => Self::Mean,
            PlaneSource::Data(data::RAYS..data::MATERIAL) => Self::Sum,
            PlaneSource::Data(data::Z) => Self::Least,
            PlaneSource::Data(_) => Self::Middle,
            PlaneSource::Matte(_) => Self::Matte,
        }
    }
}
