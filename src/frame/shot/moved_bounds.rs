//! Bounds of the models that moved, or that ever move: a cheap test before a ray is cast.
//!
//! Many rules of the [plan](super::plan) end in "test against what moved". Most segments pass far from all
//! that moved; a box around each of these models shows that without a ray (the paper tests bounding boxes
//! first, too).

use super::plan::Plan;
use crate::geometry::{Bounds, Segments, SweptBox};
use crate::lanes::{F32x8, Mask, Vec3x8};
use crate::pose::Pose;
use crate::samples::EMPTY;
use crate::scene::Scene;

/// Largest number of boxes; with more models than this, neighbours in the shot's order share one.
const MOST_BOXES: usize = 16;

/// Set of models, by the remainders of their numbers: models that share a remainder are taken for each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ModelSet(u64);

impl ModelSet {
    /// All models.
    pub const ALL: Self = Self(u64::MAX);

    /// Creates the set of these models, those of samples. The background and empty cells are not models.
    pub fn new(models: &[u32]) -> Self {
        let bit = |model: &u32| u64::from(*model < EMPTY) << (model % u64::BITS);
        Self(models.iter().fold(0, |bits, model| bits | bit(model)))
    }

    /// Returns true if a model may be in both sets. A `false` is certain.
    pub fn may_share(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// Boxes around models that move: those that moved since the frame before, at their new place, or all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MovedBounds {
    boxes: Vec<Bounds>,
    models: ModelSet,
}

impl MovedBounds {
    /// Bounds of the models that moved since the frame before. `bounds` has one object-space box a model.
    pub fn new(scene: &Scene, bounds: &[Bounds], pose: &Pose, plan: &Plan) -> Self {
        Self::around_models(scene, bounds, pose, |model| plan.moved[model])
    }

    /// Bounds of all models that move in some frame of the shot, at their places in this one.
    pub fn ever(scene: &Scene, bounds: &[Bounds], pose: &Pose) -> Self {
        Self::around_models(scene, bounds, pose, |model| !scene.models[model].track.is_constant())
    }

    fn around_models(scene: &Scene, bounds: &[Bounds], pose: &Pose, moves: impl Fn(usize) -> bool) -> Self {
        let models = || (0..scene.models.len()).filter(|model| moves(*model));
        let places = models().map(|model| {
            let transforms = pose.transforms(model);
            transforms.fold(Bounds::EMPTY, |all, transform| all.union(bounds[model].placed(transform)))
        });
        // a model that has disappeared is in nobody's way, but it counts among the models: its samples are
        // still there
        let boxes = places.filter(|bounds| !bounds.is_empty()).collect();
        let numbers: Vec<u32> = models().map(|model| model as u32).collect();
        Self { models: ModelSet::new(&numbers), ..Self::around(boxes) }
    }

    fn around(boxes: Vec<Bounds>) -> Self {
        let together = boxes.len().div_ceil(MOST_BOXES).max(1);
        let join = |some: &[Bounds]| some.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Self { boxes: boxes.chunks(together).map(join).collect(), models: ModelSet::default() }
    }

    /// Models that the boxes are around.
    pub fn models(&self) -> ModelSet {
        self.models
    }

    /// Bit mask of those of eight segments on which any of the models may be: at `origin + t * direction` for
    /// a t in `0..=far`. A bit that is not set is certain.
    #[inline]
    pub fn may_meet(&self, origin: Vec3x8, direction: Vec3x8, far: F32x8) -> u8 {
        let segments = Segments::new(origin, direction, far);
        self.boxes.iter().fold(Mask::NONE, |any, bounds| any | bounds.meets(&segments)).bits()
    }

    /// Returns true if any of the models may be on a segment of `sweep`. A `false` is certain.
    pub fn may_meet_sweep(&self, sweep: &SweptBox) -> bool {
        self.boxes.iter().any(|bounds| sweep.meets(bounds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn may_meet(moved: &MovedBounds, origin: Vec3, direction: Vec3, far: f32) -> bool {
        let bits = moved.may_meet(Vec3x8::splat(origin), Vec3x8::splat(direction), F32x8::splat(far));
        assert!(bits == 0 || bits == u8::MAX);
        bits != 0
    }

    #[test]
    fn many_movers_share_boxes_and_none_is_lost() {
        let boxes = (0..100).map(|i| Vec3::splat(i as f32)).map(|low| Bounds { low, high: low + 0.5 });
        let moved = MovedBounds::around(boxes.collect());
        assert!(moved.boxes.len() <= MOST_BOXES);
        for i in 0..100 {
            assert!(may_meet(&moved, Vec3::splat(i as f32 + 0.25), Vec3::X, 0.1), "{i}");
        }
    }
}
