//! Tiles at rest: before a camera that stands, most tiles show what they showed, and are asked as a whole
//! whether they still do.

use super::contest::Falls;
use super::movers::{Bounds, ModelSet, Sweep};
use super::plan::LightChange;
use super::stage::Stage;
use crate::motion::pose::LightShape;
use crate::samples::Tile;

/// What is remembered of a tile from frame to frame while the camera stands.
#[derive(Debug, Default)]
pub struct Memo {
    /// Whether rays went on from it when it was shown last: what they meet is made anew in every frame.
    pub goes_on: bool,
    /// If nothing in it changed in the frame before, and no ray was cast for it.
    pub rest: Option<Rest>,
}

impl Memo {
    /// Whether tile number `number` is certain to be what it was in the frame before: the camera must stand.
    pub fn is_at_rest(&self, stage: &Stage, number: usize, falls: &Falls) -> bool {
        self.rest.as_ref().is_some_and(|rest| rest.holds(stage)) && !falls.any(number)
    }

    /// Whether the tile may have samples of a model that moved. A `false` is certain.
    pub fn may_have_moved(&self, stage: &Stage) -> bool {
        self.rest.as_ref().is_none_or(|rest| rest.may_have_moved(stage))
    }
}

/// What is known of a tile whose samples stay as they are, in place and in light. It holds until one of them
/// changes.
#[derive(Debug)]
pub struct Rest {
    around: Around,
    models: ModelSet,
    /// Whether some tag is in doubt whenever anything moves: see [`Tags::any_doubtful`](crate::samples::Tags).
    is_doubtful: bool,
}

impl Rest {
    /// Of a tile as it stands.
    pub fn of(stage: &Stage, tile: &Tile) -> Self {
        Self {
            around: Around::samples(stage, tile),
            models: ModelSet::of(&tile.model),
            is_doubtful: stage.slots.iter().any(|slot| tile.tags.any_doubtful(*slot, &tile.model)),
        }
    }

    /// Whether any sample may be of a model that moved. A `false` is certain.
    fn may_have_moved(&self, stage: &Stage) -> bool {
        self.models.may_share(stage.movers.models())
    }

    /// Whether no sample goes, is hidden or is lit otherwise, as far as can be told without a ray.
    fn holds(&self, stage: &Stage) -> bool {
        let lights = &stage.plan.lights;
        let is_out_of_reach = || {
            let may_be_in_shadow = |light| self.around.may_be_in_shadow(stage, light);
            !self.is_doubtful
                && !self.may_have_moved(stage)
                && !self.around.may_be_hidden(stage)
                && !(0..lights.len()).any(may_be_in_shadow)
        };
        lights.iter().all(|light| *light == LightChange::None) && (!stage.plan.any_moved || is_out_of_reach())
    }
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
        let [surfaces, sky] = [false, true].map(|background| Bounds::of_samples(stage, tile, background));
        Self { surfaces, sky }
    }

    /// The surfaces of `tile` alone.
    pub fn surfaces(stage: &Stage, tile: &Tile) -> Self {
        Self { surfaces: Bounds::of_samples(stage, tile, false), sky: Bounds::EMPTY }
    }

    /// Whether anything that moved may be between the eye and any sample. A `false` is certain.
    pub fn may_be_hidden(&self, stage: &Stage) -> bool {
        let Self { surfaces, sky } = self;
        let eye = stage.view.camera.eye;
        let hides = |bounds: &Bounds, sweep: Sweep| !bounds.is_empty() && stage.movers.may_meet_sweep(&sweep);
        hides(surfaces, Sweep::between(&Bounds::at(eye), surfaces)) || hides(sky, Sweep::fan(eye, sky))
    }

    /// Whether anything that moved may be between a light and any surface. A `false` is certain.
    pub fn may_be_in_shadow(&self, stage: &Stage, light: usize) -> bool {
        let surfaces = &self.surfaces;
        let ways = match stage.pose.lights[light].shape {
            LightShape::Directional { to_light } => Sweep::along(surfaces, to_light),
            LightShape::Point { position } | LightShape::Spot { position, .. } => {
                Sweep::between(&Bounds::at(position), surfaces)
            }
            LightShape::Rectangle { center, across, up, .. } => {
                Sweep::between(&Bounds::of_rectangle(center, across, up), surfaces)
            }
        };
        !surfaces.is_empty() && stage.movers.may_meet_sweep(&ways)
    }
}
