//! Frame up to which a result holds, in two bytes.

/// Expiry of a result: the frame from which on it does not hold any more.
///
/// Frames are counted from the second one before the shot's first frame of motion, which
/// [`Motion`](super::Motion) knows: ask [`Motion::has_expired`](super::Motion::has_expired). The earlier of
/// two is `a.min(b)`.
///
/// The first 65,533 frames of motion (45 minutes at 24 frames a second) are told apart exactly. A result that
/// would expire later expires in the last of these, so it is never too late. From that frame on a result
/// holds either forever or not at all: one that is given there expires in the frame in which it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Until(u16);

impl Until {
    /// Unknown: expired in every frame.
    pub const UNKNOWN: Self = Self(0);

    /// Valid in the frame in which the result was found, and not known to be valid in any other.
    pub const EXPIRED: Self = Self(1);

    /// Valid in all frames of the shot.
    pub const FOREVER: Self = Self(u16::MAX);

    /// Last frame that can be named.
    pub(super) const LAST: u16 = u16::MAX - 1;

    /// Expiry in this frame of motion.
    pub(super) fn frame(frame: u16) -> Self {
        Self(frame.clamp(Self::EXPIRED.0, Self::LAST))
    }

    /// Postpones the expiry by a frame. Returns true if there was one. For tests of the audit.
    pub fn delay(&mut self) -> bool {
        let ends = *self != Self::FOREVER && *self != Self::UNKNOWN;
        if ends {
            self.0 = self.0.saturating_add(1);
        }
        ends
    }

    /// Converts to bits, to be stored.
    pub fn to_bits(self) -> u16 {
        self.0
    }

    /// Inverse of [`Until::to_bits`].
    pub fn from_bits(bits: u16) -> Self {
        Self(bits)
    }
}
