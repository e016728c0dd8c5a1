//! Extent to which a tile must be made again: one decision, taken before its samples are updated (what *can*
//! have changed) and once more after it (what *has*).
//!
//! [`TileFacts::remake`] is a pure function of a few facts about the tile. The facts are established in
//! [`tile_state`](super::tile_state); the tests of a single sample are the
//! [plan](crate::frame::shot::plan)'s.

/// Work that a tile needs in a frame, in rising order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DirtyLevel {
    /// Ages alone: the film shows the tile as it is.
    Age,
    /// Counts: the film shows the tile's colours; the planes that count samples and rays are written again.
    Counts,
    /// Picture: the samples hold; light that depends on the eye and all planes are made again.
    Picture,
    /// Samples: they may have changed, and are verified, completed and lit first.
    Samples,
}

/// Change of a tile's samples since the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// None: they are a frame older.
    None,
    /// Rays were cast, with the same results as before.
    Rays,
    /// Samples may have changed in place or light.
    Samples,
}

/// Facts about a tile in a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileFacts {
    /// Change of its samples. Before they are updated: the change that can have happened.
    pub samples: Change,
    /// True if the film shows the frame before, and that frame was seen by the same camera.
    pub film_is_last: bool,
    /// True if the frame before changed nothing here, so that its film shows `good` in all cells, and no
    /// rays.
    pub was_quiet: bool,
    /// True if rays go on from its mirrors and glass.
    pub goes_on: bool,
    /// True if the light of these rays may differ from the frame before.
    pub trees_may_differ: bool,
    /// True if a neighbour's pixels are made again, to which a wide filter adds this tile's colours.
    pub is_needed: bool,
}

impl TileFacts {
    /// Decides the work that the tile needs.
    pub fn remake(&self) -> DirtyLevel {
        let shows_samples = self.film_is_last && !(self.goes_on && self.trees_may_differ);
        // making colours for a neighbour casts the rays of mirrors and glass again, and these are counted
        let casts_rays = self.goes_on && self.is_needed;
        match self.samples {
            Change::Samples => DirtyLevel::Samples,
            _ if !shows_samples || casts_rays => DirtyLevel::Picture,
            // colours for a neighbour may take rays beside the borders, and these are counted as well
            Change::None if self.was_quiet && !self.is_needed => DirtyLevel::Age,
            Change::None | Change::Rays => DirtyLevel::Counts,
        }
    }
}

/// Facts by which a tile's samples, or their light, can have changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleFacts {
    /// True if the frame before was seen here, by the same camera.
    pub is_known: bool,
    /// True if a light changed, in place or strength.
    pub any_light_changed: bool,
    /// True if a model that moved may hide a sample or change its light, has left the tile, or has come into
    /// it.
    pub may_be_reached: bool,
    /// True if gathered light or openness of the samples may be invalid.
    pub has_expired: bool,
}

impl SampleFacts {
    /// Change that can have happened.
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
        use DirtyLevel::{Age, Counts, Picture};
        const YES: bool = true;
        const NO: bool = false;
        const TABLE: [(Change, [bool; 5], DirtyLevel); 14] = [
            // samples, film_is_last, was_quiet, goes_on, trees_may_differ, is_needed
            (None, [YES, YES, NO, NO, NO], Age),
            (None, [YES, NO, NO, NO, NO], Counts),
            (Rays, [YES, YES, NO, NO, NO], Counts),
            (Rays, [YES, NO, NO, NO, NO], Counts),
            // the film shows another frame
            (None, [NO, YES, NO, NO, NO], Picture),
            (Rays, [NO, YES, NO, NO, NO], Picture),
            // no mirror: trees do not matter
            (None, [YES, YES, NO, YES, NO], Age),
            // mirrors
            (None, [YES, YES, YES, NO, NO], Age),
            (None, [YES, YES, YES, YES, NO], Picture),
            (Rays, [YES, NO, YES, YES, NO], Picture),
            // a neighbour is made again
            (None, [YES, YES, NO, NO, YES], Counts),
            (None, [YES, NO, NO, NO, YES], Counts),
            (None, [YES, YES, YES, NO, YES], Picture),
            (Rays, [YES, YES, YES, NO, YES], Picture),
        ];
        for (samples, [film_is_last, was_quiet, goes_on, trees_may_differ, is_needed], remake) in TABLE {
            let facts = TileFacts { samples, film_is_last, was_quiet, goes_on, trees_may_differ, is_needed };
            assert_eq!(facts.remake(), remake, "{facts:?}");
            assert_eq!(TileFacts { samples: Samples, ..facts }.remake(), DirtyLevel::Samples);
        }
    }
}
