//! How far rays and paths go: surfaces that turn them count against the shot's limit, veils hardly at all.

/// Veils, surfaces that let rays pass straight through, that one way leads through beside the surfaces that
/// turn it. Without a limit a ray may go on for ever between two that coincide.
pub const MOST_VEILS: u8 = 32;

/// Place of a surface among those that a ray from the eye, or a path, meets one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Surfaces before it that turned the way.
    turns: u8,
    /// Surfaces before it that let it pass straight through.
    veils: u8,
    /// Surfaces at which the way may still arrive, this one included and those not counted that it passes
    /// straight through.
    left: u8,
}

impl Step {
    /// Place of the first of at most `count` surfaces.
    pub fn first(count: u32) -> Self {
        Self { turns: 0, veils: 0, left: u8::try_from(count).unwrap_or(u8::MAX) }
    }

    /// Place of the next surface; `is_straight`: the way passes straight through this one.
    pub fn next(self, is_straight: bool) -> Self {
        if is_straight && self.veils < MOST_VEILS {
            Self { veils: self.veils + 1, ..self }
        } else {
            Self { turns: self.turns + 1, left: self.left.saturating_sub(1), ..self }
        }
    }

    /// Returns true if the way ends before that surface. Paths only collect its emission.
    pub fn is_beyond(self) -> bool {
        self.left == 0
    }

    /// Returns true if no surface comes after it, but for those behind it if it is a veil.
    pub fn is_last(self) -> bool {
        self.left <= 1
    }

    /// Set of random numbers for choosing a light source and a point on it.
    pub fn asking(self) -> u32 {
        self.sets() + 1
    }

    /// Set of random numbers for going on.
    pub fn going_on(self) -> u32 {
        self.sets() + 2
    }

    /// Two sets for each surface, and for those behind veils far from all others.
    fn sets(self) -> u32 {
        2 * u32::from(self.turns) + (u32::from(self.veils) << 16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn veils_use_up_no_bounces_until_they_are_too_many() {
        let mut step = Step::first(2);
        for _ in 0..MOST_VEILS {
            step = step.next(true);
            assert!(!step.is_last());
        }
        let last = step.next(true);
        assert!(last.is_last() && !last.is_beyond() && last.next(true).is_beyond());
        assert!(Step::first(2).next(false).next(false).is_beyond());
    }

    #[test]
    fn each_surface_has_random_numbers_of_its_own() {
        let ways = [[false, false], [false, true], [true, false], [true, true]];
        let mut sets: Vec<u32> = ways
            .iter()
            .flat_map(|way| {
                way.iter().scan(Step::first(9), |step, straight| {
                    *step = step.next(*straight);
                    Some(*step)
                })
            })
            .chain([Step::first(9)])
            .flat_map(|step| [step.asking(), step.going_on()])
            .collect();
        sets.sort_unstable();
        sets.dedup();
        // the places that differ: none, one and two surfaces before that turned it, or let it pass
        assert_eq!(sets.len(), 2 * 6);
    }
}
