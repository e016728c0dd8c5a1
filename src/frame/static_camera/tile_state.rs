//! What is remembered of tiles while the camera does not move, and from it the facts by which [`remake`](super::remake)
//! decides: most tiles show what they showed in the frame before, and each is asked as a whole whether it still does.

use rayon::prelude::*;

use super::remake::{SampleFacts, TileFacts};
use crate::changes::Until;
use crate::frame::reuse::bins::Bins;
use crate::frame::secondary::ray_trees::TileTrees;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::moved_bounds::ModelSet;
use crate::frame::shot::plan::Term;
use crate::frame::shot::tile_bounds::TileBounds;
use crate::samples::{EMPTY, SampleStore, Status, Tile};

/// What is kept of a tile from frame to frame while the camera does not move. Nothing, by default.
#[derive(Debug)]
pub struct TileState {
    /// Whether the frame before was seen here: without it, nothing can be said of this one.
    pub is_known: bool,
    /// Whether its pixels were written in the frame at work, and not only counted.
    pub was_written: bool,
    /// Whether the frame before changed nothing here and cast no rays.
    pub was_quiet: bool,
    /// Whether rays went on from it when it was shown last.
    pub goes_on: bool,
    /// What they brought.
    pub trees: TileTrees,
    /// Whether they may bring something else.
    trees_may_differ: bool,
    /// Whether what moved may concern its samples.
    may_be_reached: bool,
    /// The first frame in which what its samples have gathered may not hold any more.
    pub until: Until,
    /// Where its samples were when they were lit last, if that was found out then. Some may have been taken away.
    pub bounds: Option<TileBounds>,
    /// Forgotten when it is not true any more.
    pub content: Option<Content>,
}

impl Default for TileState {
    fn default() -> Self {
        Self {
            is_known: false,
            was_written: false,
            was_quiet: false,
            goes_on: false,
            trees: TileTrees::default(),
            trees_may_differ: false,
            may_be_reached: false,
            until: Until::UNKNOWN,
            bounds: None,
            content: None,
        }
    }
}

impl TileState {
    /// Nothing is known any more but what the trees of those samples bring that stay.
    pub fn forget(&mut self) {
        *self = Self { trees: std::mem::take(&mut self.trees), ..Self::default() };
    }

    /// Whether the tile may have samples of a model that moved. A `false` is certain.
    pub fn may_have_moved(&self, frame: &FrameView) -> bool {
        self.content.as_ref().is_none_or(|content| content.may_have_moved(frame))
    }

    /// Whether the film may show other motion vectors of the tile than it should.
    fn vectors_may_differ(&self, frame: &FrameView) -> bool {
        let models = self.content.as_ref().map_or(ModelSet::ALL, |content| content.models);
        frame.motion_vectors.is_some_and(|vectors| vectors.may_differ(models))
    }

    /// What is known of the tile before its samples are brought up to date. `film_is_last`: the film shows the frame
    /// before. `is_needed`: see [`TileFacts::is_needed`].
    pub fn facts(&self, frame: &FrameView, film_is_last: bool, is_needed: bool) -> TileFacts {
        let samples = SampleFacts {
            is_known: self.is_known,
            any_light_changed: !frame.plan.keeps_all(Term::Specular, false),
            may_be_reached: self.may_be_reached,
            has_expired: frame.has_expired(self.until),
        };
        TileFacts {
            samples: samples.change(),
            film_is_last: film_is_last && self.is_known && !self.vectors_may_differ(frame),
            was_quiet: self.was_quiet,
            goes_on: self.goes_on,
            trees_may_differ: self.trees_may_differ,
            is_needed,
        }
    }
}

/// Finds out what concerns each tile, when the samples of models that moved have been taken out of `store` and put on
/// the lists of the tiles that they fall into. The camera must not have moved.
pub fn find_reached(store: &SampleStore, frame: &FrameView, bins: &Bins, states: &mut [TileState]) {
    let light_changed = !frame.plan.keeps_all(Term::Specular, false);
    states.par_iter_mut().zip(&store.tiles).enumerate().for_each(|(number, (state, tile))| {
        state.may_be_reached = frame.plan.any_moved && {
            let bounds = state.bounds.take();
            let content = state.content.get_or_insert_with(|| Content::of(frame, tile, bounds));
            !content.is_out_of_reach(frame, number) || bins.any(number)
        };
        let any_changed = light_changed || frame.plan.any_moved;
        state.trees_may_differ = any_changed && frame.has_expired(state.trees.until);
    });
}

/// What is known of a tile as long as its samples stay as they are, in place and in light.
#[derive(Debug)]
pub struct Content {
    pub bounds: TileBounds,
    models: ModelSet,
    /// Whether some cell has no sample, or some tag is in doubt whenever anything moves: see
    /// [`Tags::any_doubtful`](crate::samples::Tags).
    is_doubtful: bool,
}

impl Content {
    /// Of a tile as it stands, all samples of which are within `bounds`, if that is known.
    fn of(frame: &FrameView, tile: &Tile, bounds: Option<TileBounds>) -> Self {
        let any_doubtful = || frame.slots.iter().any(|slot| tile.tags.any_doubtful(*slot, &tile.model));
        Self {
            bounds: bounds.unwrap_or_else(|| TileBounds::samples(frame, tile)),
            models: ModelSet::of(&tile.model),
            is_doubtful: has_gaps(tile) || any_doubtful(),
        }
    }

    /// Whether any sample may be of a model that moved. A `false` is certain.
    fn may_have_moved(&self, frame: &FrameView) -> bool {
        self.models.may_share(frame.moved_bounds.models())
    }

    /// Whether nothing that moved may hide a sample or change its light; it is the content of tile number `number`.
    fn is_out_of_reach(&self, frame: &FrameView, number: usize) -> bool {
        let may_be_in_shadow = |light| self.bounds.may_be_in_shadow(frame.moved_bounds, light);
        !self.is_doubtful
            && !self.may_have_moved(frame)
            && !self.bounds.may_be_hidden(frame, number)
            && !frame.pose.lights.iter().any(may_be_in_shadow)
    }
}

/// Whether some cell has no sample: not whether one was missed in the frame before, and traced.
fn has_gaps(tile: &Tile) -> bool {
    let cells = tile.status.iter().zip(&tile.model);
    let is_gap = |status: Status| (status != Status::Outside) & (status != Status::Empty);
    cells.fold(false, |any, (status, model)| any | ((*model == EMPTY) & is_gap(*status)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::TagLayout;

    #[test]
    fn a_gap_is_a_cell_without_a_sample() {
        let mut tile = Tile::empty(&TagLayout::of(std::iter::empty()));
        (tile.model, tile.status) = ([0; _], [Status::Good; _]);
        tile.status[5] = Status::Missed;
        assert!(!has_gaps(&tile), "it was traced in the frame before");
        (tile.model[7], tile.status[7]) = (EMPTY, Status::Outside);
        assert!(!has_gaps(&tile), "beyond the picture");
        (tile.model[8], tile.status[8]) = (EMPTY, Status::Empty);
        assert!(!has_gaps(&tile), "nobody asks for it");
        tile.clear(9, Status::Missed);
        assert!(has_gaps(&tile));
    }
}
