//! Tiles at rest: before a camera that stands, most tiles show what they showed, and are asked as a whole
//! whether they still do.

use rayon::prelude::*;

use super::beyond::Beyond;
use super::bins::Bins;
use super::movers::{ModelSet, Movers, bounds_of_samples};
use super::plan::LightChange;
use super::stage::Stage;
use crate::geometry::{Bounds, SweptBox as Sweep};
use crate::pose::{LightPose, LightShape};
use crate::samples::{EMPTY, SampleStore, Status, Tile};

/// What is remembered of a tile from frame to frame while the camera stands. Nothing is, by default.
#[derive(Debug, Default)]
pub struct Memo {
    /// Whether the frame before was seen here: without it, nothing can be said of this one.
    pub is_known: bool,
    /// Whether the tile is certain to be what it was in the frame before.
    pub is_at_rest: bool,
    /// Whether it changed in nothing in the frame before, and cast no rays: that frame's film shows it as it is at rest.
    pub is_settled: bool,
    /// Whether rays went on from it when it was shown last.
    pub goes_on: bool,
    /// Where they went, if that was noted.
    pub beyond: Option<Beyond>,
    /// Whether they are certain to bring what they brought.
    pub beyond_rests: bool,
    /// Where its samples were when they were lit last, if that was found out then. Some may have been taken away.
    pub around: Option<Around>,
    /// Forgotten when it is not true any more.
    pub rest: Option<Rest>,
}

impl Memo {
    /// Whether the tile may have samples of a model that moved. A `false` is certain.
    pub fn may_have_moved(&self, stage: &Stage) -> bool {
        self.rest.as_ref().is_none_or(|rest| rest.may_have_moved(stage))
    }

    /// Whether the film, if it is that of the frame before, shows what the samples show, as long as these do not
    /// change.
    pub fn shows_samples(&self) -> bool {
        self.is_known && (!self.goes_on || self.beyond_rests)
    }

    /// Whether the film, if it is that of the frame before, shows the tile's colours as they are.
    pub fn stands(&self) -> bool {
        self.is_at_rest && self.shows_samples()
    }
}

/// Finds the tiles at rest, when the samples of models that moved have been taken out of `store` and put on the lists
/// of the tiles that they fall into. The camera must stand.
pub fn find(store: &SampleStore, stage: &Stage, bins: &Bins, memos: &mut [Memo]) {
    let lights_rest = stage.plan.lights.iter().all(|light| *light == LightChange::None);
    memos.par_iter_mut().zip(&store.tiles).enumerate().for_each(|(number, (memo, tile))| {
        let is_out_of_reach = !stage.plan.any_moved || {
            let around = memo.around.take();
            let rest = memo.rest.get_or_insert_with(|| Rest::of(stage, tile, around));
            rest.is_out_of_reach(stage) && !bins.any(number)
        };
        memo.is_at_rest = memo.is_known && lights_rest && is_out_of_reach;
        let is_beyond_reach = |beyond: &Beyond| beyond.is_out_of_reach(stage);
        memo.beyond_rests =
            lights_rest && (!stage.plan.any_moved || memo.beyond.as_ref().is_some_and(is_beyond_reach));
    });
}

/// What is known of a tile as long as its samples stay as they are, in place and in light.
#[derive(Debug)]
pub struct Rest {
    pub around: Around,
    models: ModelSet,
    /// Whether some cell has no sample, or some tag is in doubt whenever anything moves: see
    /// [`Tags::any_doubtful`](crate::samples::Tags).
    is_doubtful: bool,
}

impl Rest {
    /// Of a tile as it stands, all samples of which are within `around`, if that is known.
    fn of(stage: &Stage, tile: &Tile, around: Option<Around>) -> Self {
        let any_doubtful = || stage.slots.iter().any(|slot| tile.tags.any_doubtful(*slot, &tile.model));
        Self {
            around: around.unwrap_or_else(|| Around::samples(stage, tile)),
            models: ModelSet::of(&tile.model),
            is_doubtful: has_gaps(tile) || any_doubtful(),
        }
    }

    /// Whether any sample may be of a model that moved. A `false` is certain.
    fn may_have_moved(&self, stage: &Stage) -> bool {
        self.models.may_share(stage.movers.models())
    }

    /// Whether nothing that moved may hide a sample or change its light.
    fn is_out_of_reach(&self, stage: &Stage) -> bool {
        let may_be_in_shadow = |light| self.around.may_be_in_shadow(stage.movers, light);
        !self.is_doubtful
            && !self.may_have_moved(stage)
            && !self.around.may_be_hidden(stage)
            && !stage.pose.lights.iter().any(may_be_in_shadow)
    }
}

/// Whether some cell has no sample: not whether one was missed in the frame before, and traced.
fn has_gaps(tile: &Tile) -> bool {
    let cells = tile.status.iter().zip(&tile.model);
    cells.fold(false, |any, (status, model)| any | ((*model == EMPTY) & (*status != Status::Outside)))
}

/// Where the samples of a tile are.
#[derive(Debug, Clone, PartialEq)]
pub struct Around {
    /// Surfaces, world space.
    surfaces: Bounds,
    /// Directions to the background.
    sky: Bounds,
}

impl Around {
    /// Those of `tile`.
    pub fn samples(stage: &Stage, tile: &Tile) -> Self {
        let [surfaces, sky] = bounds_of_samples(stage, tile);
        Self { surfaces, sky }
    }

    /// Surfaces alone, world space.
    pub fn surfaces(surfaces: Bounds) -> Self {
        Self { surfaces, sky: Bounds::EMPTY }
    }

    /// Whether anything that moved may be between the eye and any sample. A `false` is certain.
    pub fn may_be_hidden(&self, stage: &Stage) -> bool {
        let Self { surfaces, sky } = self;
        let eye = stage.view.camera.eye;
        let hides = |bounds: &Bounds, sweep: Sweep| !bounds.is_empty() && stage.movers.may_meet_sweep(&sweep);
        hides(surfaces, Sweep::between(&Bounds::at(eye), surfaces)) || hides(sky, Sweep::fan(eye, sky))
    }

    /// Whether any of `movers` may be between a light and any surface. A `false` is certain.
    pub fn may_be_in_shadow(&self, movers: &Movers, light: &LightPose) -> bool {
        let surfaces = &self.surfaces;
        let ways = match light.shape {
            LightShape::Directional { to_light } => Sweep::along(surfaces, to_light),
            LightShape::Point { position } | LightShape::Spot { position, .. } => {
                Sweep::between(&Bounds::at(position), surfaces)
            }
            LightShape::Rectangle { center, across, up, .. } => {
                Sweep::between(&Bounds::of_rectangle(center, across, up), surfaces)
            }
        };
        !surfaces.is_empty() && movers.may_meet_sweep(&ways)
    }
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
        tile.clear(9, Status::Missed);
        assert!(has_gaps(&tile));
    }
}
