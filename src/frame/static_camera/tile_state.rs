//! State of tiles that is kept while the camera does not move, and the facts from it by which
//! [`remake`](super::remake) decides: most tiles look as in the frame before, and each is tested as a whole
//! for that.

use rayon::prelude::*;

use super::remake::{SampleFacts, TileFacts};
use super::sight;
use crate::changes::Until;
use crate::frame::grid::cells::CellSet;
use crate::frame::reuse::bins::Bins;
use crate::frame::secondary::ray_trees::TileTrees;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::moved_bounds::ModelSet;
use crate::frame::shot::plan::Term;
use crate::frame::shot::tile_bounds::TileBounds;
use crate::samples::{EMPTY, MirroredOfTile, SampleStore, Status, Tile};
use crate::settings::Reuse;

/// State of a tile that is kept from frame to frame while the camera does not move. Unknown by default.
#[derive(Debug)]
pub struct TileState {
    /// True if the frame before was seen here: without it, nothing is known about this one.
    pub is_known: bool,
    /// True if its pixels were written in the current frame, and not only counts.
    pub was_written: bool,
    /// True if the frame before changed nothing here and cast no rays.
    pub was_quiet: bool,
    /// True if rays went on from the tile when it was shown last.
    pub goes_on: bool,
    /// True if what it contributed to pixels when it was shown last depends on what the tiles beside it show.
    pub asks_beside: bool,
    /// Ray trees of the tile.
    pub trees: TileTrees,
    /// True if their light may differ.
    trees_may_differ: bool,
    /// True if its flat mirrors showed kept samples when it was shown last, and not what their own rays meet.
    pub shows_mirrored: bool,
    /// What flat mirrors have shown in the current frame, until the frame is done.
    pub mirrored: MirroredOfTile,
    /// True if a model that moved may concern its samples.
    may_be_reached: bool,
    /// First frame in which gathered light or openness of its samples may be invalid.
    pub until: Until,
    /// Bounds of its samples when they were lit last, if they were computed. Some samples may have been
    /// removed since.
    pub bounds: Option<TileBounds>,
    /// Summary of its samples; reset when it is not true any more.
    pub content: Option<Content>,
    /// Bounds of what its targets see of the models at rest, once they are known.
    pub behind: Option<TileBounds>,
    /// Cells for which a primary ray was cast to find these: not counted yet.
    pub asked: CellSet,
}

impl Default for TileState {
    fn default() -> Self {
        Self {
            is_known: false,
            was_written: false,
            was_quiet: false,
            goes_on: false,
            asks_beside: false,
            trees: TileTrees::default(),
            trees_may_differ: false,
            shows_mirrored: false,
            mirrored: MirroredOfTile::default(),
            may_be_reached: false,
            until: Until::UNKNOWN,
            bounds: None,
            content: None,
            behind: None,
            asked: CellSet::default(),
        }
    }
}

impl TileState {
    /// Resets all state, except the trees: those of samples that stay are still valid.
    pub fn forget(&mut self) {
        *self = Self { trees: std::mem::take(&mut self.trees), ..Self::default() };
    }

    /// Returns true if the tile may have samples of a model that moved. A `false` is certain.
    pub fn may_have_moved(&self, frame: &FrameView) -> bool {
        self.content.as_ref().is_none_or(|content| content.may_have_moved(frame))
    }

    /// Returns true if the film may show other motion vectors of the tile than it should.
    fn vectors_may_differ(&self, frame: &FrameView) -> bool {
        let models = self.content.as_ref().map_or(ModelSet::ALL, |content| content.models);
        frame.motion_vectors.is_some_and(|vectors| vectors.may_differ(models))
    }

    /// Facts about the tile before its samples are updated. `film_is_last`: the film shows the frame before.
    /// `is_needed`: see [`TileFacts::is_needed`].
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

/// Determines, for each tile, if models that moved concern it, when their samples have been taken out of
/// `store` and put into the bins of the tiles that they fall into. The camera must not have moved.
pub fn find_reached(store: &SampleStore, frame: &FrameView, bins: &Bins, states: &mut [TileState]) {
    let light_changed = !frame.plan.keeps_all(Term::Specular, false);
    states.par_iter_mut().zip(&store.tiles).enumerate().for_each(|(number, (state, tile))| {
        state.may_be_reached = frame.plan.any_moved && {
            let behind = match state.behind.take() {
                Some(behind) => behind,
                None if frame.settings.reuse == Reuse::Target => {
                    let (behind, asked) = sight::behind(frame, number, tile);
                    state.asked = asked;
                    behind
                }
                None => TileBounds::NONE,
            };
            let bounds = state.bounds.take();
            let content = state.content.get_or_insert_with(|| Content::of(frame, tile, bounds, &behind));
            state.behind = Some(behind);
            // rays that were cast are shown, too
            !content.is_out_of_reach(frame, number) || bins.any(number) || !state.asked.is_empty()
        };
        let any_changed = light_changed || frame.plan.any_moved;
        let may_differ = any_changed && frame.has_expired(state.trees.until);
        state.trees_may_differ = may_differ || state.shows_mirrored;
    });
}

/// Summary of a tile, valid as long as its samples stay the same, in place and in light.
#[derive(Debug)]
pub struct Content {
    pub bounds: TileBounds,
    /// Bounds of the samples and of what the targets see of the models at rest.
    pub sight: TileBounds,
    models: ModelSet,
    /// True if some cell has no sample, or some tag is in doubt whenever anything moves: see
    /// [`Tags::any_doubtful`](crate::samples::Tags).
    is_doubtful: bool,
}

impl Content {
    /// Summarizes a tile as it is. `bounds` are around all its samples, if they are known; `behind` are around what its targets see
    /// of the models at rest.
    fn of(frame: &FrameView, tile: &Tile, bounds: Option<TileBounds>, behind: &TileBounds) -> Self {
        let any_doubtful = || frame.slots.iter().any(|slot| tile.tags.any_doubtful(*slot, &tile.model));
        let bounds = bounds.unwrap_or_else(|| TileBounds::samples(frame, tile));
        Self {
            sight: bounds.union(behind),
            bounds,
            models: ModelSet::new(&tile.model),
            is_doubtful: has_gaps(tile) || any_doubtful(),
        }
    }

    /// Returns true if any sample may be of a model that moved. A `false` is certain.
    fn may_have_moved(&self, frame: &FrameView) -> bool {
        self.models.may_share(frame.moved_bounds.models())
    }

    /// Returns true if nothing that moved can hide a sample or change its light; the content is that of tile
    /// number `number`.
    fn is_out_of_reach(&self, frame: &FrameView, number: usize) -> bool {
        let may_be_in_shadow = |light| self.bounds.may_be_in_shadow(frame.moved_bounds, frame.pose, light);
        !self.is_doubtful
            && !self.may_have_moved(frame)
            && !self.sight.may_be_hidden(frame, number)
            && !(0..frame.pose.lights.len()).any(may_be_in_shadow)
    }
}

/// Returns true if some cell has no sample now. Cells that were missed in the frame before, and traced, have
/// one.
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
        let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
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
