//! Shadow tags: what a sample remembers of its last shadow ray to each light.

/// Who stood between a sample and a light when it was last asked.
///
/// Tags save rays and never decide a picture: a frame with all tags dropped is the same to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Tag {
    /// Not asked yet.
    #[default]
    Unknown,
    /// Nobody: the light reaches the sample.
    Lit,
    /// The surface itself: it faces away, or the light's cone does not hold it.
    Averted,
    /// A model that never moves.
    ByStill,
    /// A model that moves in some frame of the shot.
    ByMovable,
}

impl Tag {
    /// In the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Unknown, Self::Lit, Self::Averted, Self::ByStill, Self::ByMovable];

    /// Whether the light reaches the sample.
    pub fn is_lit(self) -> bool {
        self == Tag::Lit
    }

    /// Whether light that was summed under this tag is wrong under `now`.
    pub fn changes_light_to(self, now: Tag) -> bool {
        self == Tag::Unknown || self.is_lit() != now.is_lit()
    }
}
