//! What of a tile must be made again: one decision, taken before its samples are brought up to date (what *can* have
//! changed) and once more after it (what *has*).
//!
//! [`TileFacts::remake`] is a pure function of a few facts about the tile. How each fact is found out is the business of
//! [`tile_state`](super::tile_state); what must be asked about a single sample is the [plan](crate::frame::shot::plan)'s.

/// What a tile needs in a frame: more and more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Remake {
    /// The film shows the tile as it is, but for its age.
    Age,
    /// The film shows the tile's colours; what its samples are counted by is written again.
    Counts,
    /// The samples hold; what depends on the eye and all planes are made again.
    Picture,
    /// The samples may have changed: they are verified, completed and lit first.
    Samples,
}

/// How the samples of a tile differ from those of the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// Not at all: a frame older.
    None,
    /// Rays were cast, and met nothing that was not there before.
    Rays,
    /// In place or light; or it is not known.
    Samples,
}

/// What is known of a tile in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileFacts {
    /// Of its samples. Before they are brought up to date: whether they can have changed.
    pub samples: Change,
    /// Whether the film shows the frame before, and that frame was seen by the same camera.
    pub film_is_last: bool,
    /// Whether the frame before changed nothing here, so that its film says `good` of all cells, and no rays.
    pub was_quiet: bool,
    /// Whether rays go on from its mirrors and glass.
    pub goes_on: bool,
    /// Whether those rays may bring something else than in the frame before.
    pub trees_may_differ: bool,
    /// Whether a neighbour's pixels are made again, to which a wide filter adds this tile's colours.
    pub is_needed: bool,
}

impl TileFacts {
    /// What must be made again.
    pub fn remake(&self) -> Remake {
        let shows_samples = self.film_is_last && !(self.goes_on && self.trees_may_differ);
        // colours for a neighbour cost the rays of mirrors and glass again, and these are counted
        let casts_rays = self.goes_on && self.is_needed;
        match self.samples {
            Change::Samples => Remake::Samples,
            _ if !shows_samples || casts_rays => Remake::Picture,
            Change::None if self.was_quiet => Remake::Age,
            Change::None | Change::Rays => Remake::Counts,
        }
    }
}

/// Whether a tile's samples can have changed, and with them their light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleFacts {
    /// Whether the frame before was seen here, by the same camera.
    pub is_known: bool,
    /// Whether a light changed, in place or strength.
    pub any_light_changed: bool,
    /// Whether what moved may hide a sample or change its light, has left the tile, or has come into it.
    pub may_be_reached: bool,
    /// Whether light that the samples have gathered, or how open they are, may not hold any more.
    pub has_expired: bool,
}

impl SampleFacts {
    /// What can have changed.
    pub fn change(&self) -> Change {
        if self.is_known && !self.any_light_changed && !self.may_be_reached && !self.has_expired {
            Change::None
        } else {
            Change::Samples
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_hold_in_a_known_tile_out_of_reach_under_the_same_lights() {
        const TABLE: [([bool; 4], Change); 5] = [
            // is_known, any_light_changed, may_be_reached, has_expired
            ([true, false, false, false], Change::None),
            ([false, false, false, false], Change::Samples),
            ([true, true, false, false], Change::Samples),
            ([true, false, true, false], Change::Samples),
            ([true, false, false, true], Change::Samples),
        ];
        for ([is_known, any_light_changed, may_be_reached, has_expired], change) in TABLE {
            let facts = SampleFacts { is_known, any_light_changed, may_be_reached, has_expired };
            assert_eq!(facts.change(), change, "{facts:?}");
        }
    }

    #[test]
    fn what_is_made_again_of_a_tile() {
        use Change::{None, Rays, Samples};
        use Remake::{Age, Counts, Picture};
        const YES: bool = true;
        const NO: bool = false;
        const TABLE: [(Change, [bool; 5], Remake); 14] = [
            // samples, film_is_last, was_quiet, goes_on, trees_may_differ, is_needed
            (None, [YES, YES, NO, NO, NO], Age),
            (None, [YES, NO, NO, NO, NO], Counts),
            (Rays, [YES, YES, NO, NO, NO], Counts),
            (Rays, [YES, NO, NO, NO, NO], Counts),
            // somebody else had the film
            (None, [NO, YES, NO, NO, NO], Picture),
            (Rays, [NO, YES, NO, NO, NO], Picture),
            // no mirror: nothing is asked about trees
            (None, [YES, YES, NO, YES, NO], Age),
            // mirrors
            (None, [YES, YES, YES, NO, NO], Age),
            (None, [YES, YES, YES, YES, NO], Picture),
            (Rays, [YES, NO, YES, YES, NO], Picture),
            // a neighbour is made again
            (None, [YES, YES, NO, NO, YES], Age),
            (None, [YES, NO, NO, NO, YES], Counts),
            (None, [YES, YES, YES, NO, YES], Picture),
            (Rays, [YES, YES, YES, NO, YES], Picture),
        ];
        for (samples, [film_is_last, was_quiet, goes_on, trees_may_differ, is_needed], remake) in TABLE {
            let facts = TileFacts { samples, film_is_last, was_quiet, goes_on, trees_may_differ, is_needed };
            assert_eq!(facts.remake(), remake, "{facts:?}");
            assert_eq!(TileFacts { samples: Samples, ..facts }.remake(), Remake::Samples);
        }
    }
}
