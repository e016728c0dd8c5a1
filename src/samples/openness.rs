//! How open samples are: what ambient occlusion leaves of the directions around them.

use crate::changes::Until;

/// How many of a sample's rays get away, and how long that holds.
///
/// A number and not a share: sums of ones are exact in any order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Openness {
    /// Rays that nothing is in the way of.
    pub open: u16,
    /// The first frame in which it may be another number, unless the sample's own model moves before: who keeps it sees to
    /// that.
    pub until: Until,
}

const _: () = assert!(size_of::<Openness>() == 4);

impl Openness {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { open: 0, until: Until::UNKNOWN };

    /// No ray gets away, for good.
    pub const CLOSED: Self = Self { open: 0, until: Until::FOREVER };
}
