//! Which rays can meet a model that moved, or one that ever moves: a cheap question before a ray is cast.
//!
//! Many rules of the [plan](super::plan) end in "test against what moved". Most segments pass far from all
//! that moved; a box around each mover tells so without a ray (the paper tests bounding boxes first, too).

use glam::Vec3;

use super::plan::Plan;
use super::stage::Stage;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::motion::{Pose, Transform};
use crate::samples::{BACKGROUND, CELLS, EMPTY, Tile};
use crate::scene::{Mesh, Scene};

/// Boxes at most; with more movers than this, neighbours in the shot's order share one.
const MOST_BOXES: usize = 16;

/// A box along the axes, world or object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    low: Vec3,
    high: Vec3,
}

impl Bounds {
    /// Around nothing.
    pub const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Around one point.
    pub fn at(point: Vec3) -> Self {
        Self { low: point, high: point }
    }

    /// Around a rectangle.
    pub fn of_rectangle(center: Vec3, across: Vec3, up: Vec3) -> Self {
        let reach = (across.abs() + up.abs()) * 0.5;
        Self { low: center - reach, high: center + reach }
    }

    /// Around all vertices of `mesh`, object space.
    pub fn of(mesh: &Mesh) -> Self {
        mesh.positions.as_slice().iter().fold(Self::EMPTY, |all, point| all.with(Vec3::from_array(*point)))
    }

    /// Around the samples of `tile`: the surfaces, world space, and the directions to the background.
    pub fn of_samples(stage: &Stage, tile: &Tile) -> [Self; 2] {
        let nothing = [Vec3x8::splat(Vec3::INFINITY), Vec3x8::splat(Vec3::NEG_INFINITY)];
        let (mut surfaces, mut sky) = (nothing, nothing);
        let widen = |[low, high]: &mut [Vec3x8; 2], wanted: Mask, offsets: Vec3x8| {
            *low = low.min(wanted.select3(offsets, *low));
            *high = high.max(wanted.select3(offsets, *high));
        };
        for first in (0..CELLS).step_by(LANES) {
            let models = &tile.model[first..first + LANES];
            let offsets = stage.offsets(tile, first);
            widen(&mut surfaces, Mask::less(models, EMPTY), offsets);
            let is_sky = Mask::equal(models, BACKGROUND);
            if is_sky.any() {
                widen(&mut sky, is_sky, offsets);
            }
        }
        let around = |[low, high]: [Vec3x8; 2], eye: Vec3| {
            (0..LANES).fold(Self::EMPTY, |all, lane| {
                all.union(Self { low: low.lane(lane) + eye, high: high.lane(lane) + eye })
            })
        };
        [around(surfaces, stage.view.camera.eye), around(sky, Vec3::ZERO)]
    }

    /// Around eight points.
    pub fn of_lanes(points: Vec3x8) -> Self {
        (0..LANES).fold(Self::EMPTY, |all, lane| all.with(points.lane(lane)))
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        !self.low.cmple(self.high).all()
    }

    /// Around this box and a point.
    pub fn with(self, point: Vec3) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }

    /// Around this box after `transform`, with room for what rounding does.
    fn placed(&self, transform: &Transform) -> Self {
        let corner = |i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            transform.point(Vec3::new(pick(0), pick(1), pick(2)))
        };
        let tight = (0..8).map(corner).fold(Self::EMPTY, Self::with);
        let room = 1e-4 * (tight.high - tight.low) + 1e-5 * tight.low.abs().max(tight.high.abs());
        Self { low: tight.low - room, high: tight.high + room }
    }

    /// Around both boxes.
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Where `origin + t * direction` is in the box for some t in `0..=far` (slabs; `inverse` is one over
    /// the direction, finite).
    #[inline(always)]
    fn meets(&self, origin: Vec3x8, inverse: Vec3x8, far: F32x8) -> Mask {
        let a = (Vec3x8::splat(self.low) - origin) * inverse;
        let b = (Vec3x8::splat(self.high) - origin) * inverse;
        let (near, away) = (a.min(b), a.max(b));
        let enter = near.x.max(near.y).max(near.z).max(F32x8::ZERO);
        let leave = away.x.min(away.y).min(away.z).min(far);
        enter.le(leave)
    }
}

/// Numbers of models, by their remainders: models that share one are taken for each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ModelSet(u64);

impl ModelSet {
    /// With those of some samples. Neither the background nor an empty cell is a model.
    pub fn of(models: &[u32]) -> Self {
        let bit = |model: &u32| u64::from(*model < EMPTY) << (model % u64::BITS);
        Self(models.iter().fold(0, |bits, model| bits | bit(model)))
    }

    /// Whether `model` may be in it. A `false` is certain.
    pub fn may_hold(self, model: u32) -> bool {
        self.may_share(Self::of(&[model]))
    }

    /// Whether a model may be in both. A `false` is certain.
    pub fn may_share(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

/// Boxes around models that move: those that moved since the frame before, at their new place, or all.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Movers {
    boxes: Vec<Bounds>,
    models: ModelSet,
}

impl Movers {
    /// Of the models that moved since the frame before. `bounds` has one object-space box a model.
    pub fn of(scene: &Scene, bounds: &[Bounds], pose: &Pose, plan: &Plan) -> Self {
        Self::around_models(scene, bounds, pose, |model| plan.moved[model])
    }

    /// Of all models that move in some frame of the shot, where they are in this one.
    pub fn ever(scene: &Scene, bounds: &[Bounds], pose: &Pose) -> Self {
        Self::around_models(scene, bounds, pose, |model| !scene.models[model].track.is_constant())
    }

    fn around_models(scene: &Scene, bounds: &[Bounds], pose: &Pose, moves: impl Fn(usize) -> bool) -> Self {
        let models = || (0..scene.models.len()).filter(|model| moves(*model));
        let boxes = models().map(|model| bounds[model].placed(&pose.models[model])).collect();
        let numbers: Vec<u32> = models().map(|model| model as u32).collect();
        Self { models: ModelSet::of(&numbers), ..Self::around(boxes) }
    }

    fn around(boxes: Vec<Bounds>) -> Self {
        let together = boxes.len().div_ceil(MOST_BOXES).max(1);
        let join = |some: &[Bounds]| some.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Self { boxes: boxes.chunks(together).map(join).collect(), models: ModelSet::default() }
    }

    /// Which models they are.
    pub fn models(&self) -> ModelSet {
        self.models
    }

    /// Of eight segments, those on which any of the models may be: at `origin + t * direction` for a t in
    /// `0..=far`. A bit that is not set is certain.
    #[inline]
    pub fn may_meet(&self, origin: Vec3x8, direction: Vec3x8, far: F32x8) -> u8 {
        // parallel to a slab: a huge slope says inside or outside as well as an infinite one, and 0 times
        // it is a number
        let steep = |along: F32x8| {
            let is_parallel = along.abs().lt(F32x8::splat(1e-30));
            is_parallel.select(F32x8::splat(1e30), F32x8::splat(1.0) / along)
        };
        let inverse = Vec3x8 { x: steep(direction.x), y: steep(direction.y), z: steep(direction.z) };
        self.boxes.iter().fold(Mask::NONE, |any, bounds| any | bounds.meets(origin, inverse, far)).bits()
    }
}

/// The boxes of points that grow from one box to another as t goes from 0 to `end`: each side of the box is a
/// linear function of t.
#[derive(Debug, Clone, Copy)]
pub struct Sweep {
    start: Bounds,
    /// What one step of t adds to `low` and `high`.
    slope: Bounds,
    end: f32,
}

impl Sweep {
    /// All segments from points in `sources` to points in `targets`.
    pub fn between(sources: &Bounds, targets: &Bounds) -> Self {
        let slope = Bounds { low: targets.low - sources.low, high: targets.high - sources.high };
        Self { start: *sources, slope, end: 1.0 }
    }

    /// All rays from points in `sources` along `direction`.
    pub fn along(sources: &Bounds, direction: Vec3) -> Self {
        Self { start: *sources, slope: Bounds { low: direction, high: direction }, end: f32::INFINITY }
    }

    /// All rays from `source` along directions in `directions`.
    pub fn fan(source: Vec3, directions: &Bounds) -> Self {
        Self::fans(&Bounds::at(source), directions)
    }

    /// All rays from points in `sources` along directions in `directions`.
    pub fn fans(sources: &Bounds, directions: &Bounds) -> Self {
        Self { start: *sources, slope: *directions, end: f32::INFINITY }
    }

    /// Whether the growing box meets `other` at some t: on each axis its low side must be below the other's
    /// high side, and its high side above the other's low side.
    fn meets(&self, other: &Bounds) -> bool {
        let mut span = (0.0_f32, self.end);
        for axis in 0..3 {
            let sides = [
                (self.start.low[axis] - other.high[axis], self.slope.low[axis]),
                (other.low[axis] - self.start.high[axis], -self.slope.high[axis]),
            ];
            // at + t * slope <= 0
            for (at, slope) in sides {
                if slope > 0.0 {
                    span.1 = span.1.min(-at / slope);
                } else if slope < 0.0 {
                    span.0 = span.0.max(-at / slope);
                } else if at > 0.0 {
                    return false;
                }
            }
        }
        span.0 <= span.1
    }
}

impl Movers {
    /// Whether any of the models may be on a way of `sweep`. A `false` is certain.
    pub fn may_meet_sweep(&self, sweep: &Sweep) -> bool {
        self.boxes.iter().any(|bounds| sweep.meets(bounds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn may_meet(movers: &Movers, origin: Vec3, direction: Vec3, far: f32) -> bool {
        let bits = movers.may_meet(Vec3x8::splat(origin), Vec3x8::splat(direction), F32x8::splat(far));
        assert!(bits == 0 || bits == u8::MAX);
        bits != 0
    }

    fn unit() -> Movers {
        Movers::around(vec![Bounds { low: Vec3::ZERO, high: Vec3::ONE }])
    }

    #[test]
    fn a_segment_through_the_box_may_meet_and_one_past_it_does_not() {
        let movers = unit();
        assert!(may_meet(&movers, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(!may_meet(&movers, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, 0.5), "it ends before the box");
        assert!(!may_meet(&movers, Vec3::new(-1.0, 1.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(
            !may_meet(&movers, Vec3::new(2.0, 0.5, 0.5), Vec3::X, f32::INFINITY),
            "it leaves from behind"
        );
        assert!(may_meet(&movers, Vec3::splat(0.5), Vec3::Y, 0.1), "it is inside");
        assert!(may_meet(&movers, Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 5.0), "it runs along an edge");
    }

    #[test]
    fn a_sweep_meets_what_one_of_its_segments_meets() {
        // boxes, sources and targets on a coarse grid; segments between many points of each
        let movers = Movers::around(vec![Bounds { low: Vec3::splat(2.0), high: Vec3::splat(3.0) }]);
        let steps = [0.0_f32, 0.35, 0.8, 1.0];
        let spots: Vec<(f32, f32)> = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y))).collect();
        let (mut met, mut missed) = (0, 0);
        for i in 0..1000 {
            let pick = |n: i32, of: i32| (i / n % of) as f32;
            let source = Vec3::new(pick(1, 10) - 2.0, pick(10, 10) - 2.5, pick(100, 10) - 1.5);
            let low = Vec3::new(pick(7, 9), pick(3, 8), pick(13, 7)) * 0.8;
            let targets = Bounds { low, high: low + Vec3::new(0.5, 0.2, 0.9) };
            let by_segment = spots.iter().any(|(x, y)| {
                steps.iter().any(|z| {
                    let target = low + Vec3::new(*x, *y, *z) * (targets.high - low);
                    may_meet(&movers, source, target - source, 1.0)
                })
            });
            let by_sweep = movers.may_meet_sweep(&Sweep::between(&Bounds::at(source), &targets));
            assert!(by_sweep || !by_segment, "{source} {targets:?}");
            met += i32::from(by_segment);
            missed += i32::from(!by_sweep);
        }
        assert!(met > 50 && missed > 50, "{met} {missed}");
        let sun = Vec3::new(0.1, 1.0, 0.2);
        let under = Bounds { low: Vec3::new(2.0, 0.0, 2.0), high: Vec3::new(2.5, 0.1, 2.5) };
        assert!(movers.may_meet_sweep(&Sweep::along(&under, sun)));
        assert!(!movers.may_meet_sweep(&Sweep::along(&under, -sun)));
        // from a box, and along an axis where nothing moves
        let sources = Bounds { low: Vec3::new(0.0, 0.0, 2.0), high: Vec3::new(2.5, 0.0, 3.0) };
        let up = Bounds { low: Vec3::new(0.0, 0.9, -0.1), high: Vec3::new(0.0, 1.0, 0.1) };
        assert!(movers.may_meet_sweep(&Sweep::fans(&sources, &up)));
        let beside = Bounds { high: Vec3::new(1.9, 0.0, 3.0), ..sources };
        assert!(!movers.may_meet_sweep(&Sweep::fans(&beside, &up)));
        let above = Bounds { low: Vec3::new(-1.0, 5.0, 2.0), high: Vec3::new(1.5, 5.0, 3.0) };
        assert!(movers.may_meet_sweep(&Sweep::between(&sources, &above)), "from its right rim");
        assert!(!movers.may_meet_sweep(&Sweep::between(&beside, &above)));
        let north = Bounds { low: Vec3::new(0.9, 0.9, 0.9), high: Vec3::ONE };
        assert!(movers.may_meet_sweep(&Sweep::fan(Vec3::ZERO, &north)));
        assert!(!movers.may_meet_sweep(&Sweep::fan(Vec3::new(4.0, 0.0, 0.0), &north)));
    }

    #[test]
    fn many_movers_share_boxes_and_none_is_lost() {
        let boxes = (0..100).map(|i| Vec3::splat(i as f32)).map(|low| Bounds { low, high: low + 0.5 });
        let movers = Movers::around(boxes.collect());
        assert!(movers.boxes.len() <= MOST_BOXES);
        for i in 0..100 {
            assert!(may_meet(&movers, Vec3::splat(i as f32 + 0.25), Vec3::X, 0.1), "{i}");
        }
    }
}
