//! The frame up to which an answer holds, in two bytes.

/// How long an answer holds: it does not any more from some frame on.
///
/// Frames are counted from the second one before the shot's first frame of motion, which [`Motion`](super::Motion) knows: ask
/// [`Motion::has_expired`](super::Motion::has_expired). The earlier of two is `a.min(b)`.
///
/// The first 65,533 frames of motion (45 minutes at 24 frames a second) are told apart exactly. What would
/// expire later expires in the last of these, so it is never too late. From that frame on an answer
/// holds either forever or not at all: one that is given there expires in the frame in which it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Until(u16);

impl Until {
    /// Nothing is known: it has expired in every frame.
    pub const UNKNOWN: Self = Self(0);

    /// It held in the frame in which it was found, and is known to hold in no other.
    pub const EXPIRED: Self = Self(1);

    /// It holds in all frames of the shot.
    pub const FOREVER: Self = Self(u16::MAX);

    /// The last frame that can be named.
    pub(super) const LAST: u16 = u16::MAX - 1;

    /// From this frame of motion on it does not hold.
    pub(super) fn frame(frame: u16) -> Self {
        Self(frame.clamp(Self::EXPIRED.0, Self::LAST))
    }

    /// Has what does not hold forever hold a frame longer: whether it did not. For tests of the audit.
    pub fn delay(&mut self) -> bool {
        let ends = *self != Self::FOREVER && *self != Self::UNKNOWN;
        if ends {
            self.0 = self.0.saturating_add(1);
        }
        ends
    }

    /// To be stored.
    pub fn to_bits(self) -> u16 {
        self.0
    }

    /// What [`Until::to_bits`] gave.
    pub fn from_bits(bits: u16) -> Self {
        Self(bits)
    }
}
