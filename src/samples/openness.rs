//! Openness of samples: ambient occlusion of the directions around them.

use crate::changes::Until;

/// Number of a sample's rays that meet nothing, and its validity.
///
/// It is a number and not a share: sums of ones are exact in any order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Openness {
    /// Number of rays that meet nothing.
    pub open: u16,
    /// First frame in which the number may differ, unless the sample's own model moves before: the owner of
    /// the sample has to consider that.
    pub until: Until,
}

const _: () = assert!(size_of::<Openness>() == 4);

impl Openness {
    /// Openness that is not known.
    pub const UNKNOWN: Self = Self { open: 0, until: Until::UNKNOWN };

    /// Openness of a surface whose rays all meet something, for good.
    pub const CLOSED: Self = Self { open: 0, until: Until::FOREVER };
}
