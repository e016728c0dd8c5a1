//! Which segments can meet a model that moved: a cheap question before a ray is cast.
//!
//! Many rules of the [plan](super::plan) end in "test against what moved". Most segments pass far from all
//! that moved; a box around each mover tells so without a ray (the paper tests bounding boxes first, too).

use glam::Vec3;

use super::plan::Plan;
use crate::motion::{Pose, Transform};
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
    const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Around all vertices of `mesh`, object space.
    pub fn of(mesh: &Mesh) -> Self {
        mesh.positions.as_slice().iter().fold(Self::EMPTY, |all, point| all.with(Vec3::from_array(*point)))
    }

    fn with(self, point: Vec3) -> Self {
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

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Whether `origin + t * direction` is in the box for some t in `0..=far` (slabs; `inverse` is one over
    /// the direction, finite).
    #[inline]
    fn meets(&self, origin: Vec3, inverse: Vec3, far: f32) -> bool {
        let (a, b) = ((self.low - origin) * inverse, (self.high - origin) * inverse);
        let enter = a.min(b).max_element().max(0.0);
        let leave = a.max(b).min_element().min(far);
        enter <= leave
    }
}

/// Boxes around the models that moved since the frame before, at their new place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Movers {
    boxes: Vec<Bounds>,
}

impl Movers {
    /// `bounds` has one object-space box a model.
    pub fn of(scene: &Scene, bounds: &[Bounds], pose: &Pose, plan: &Plan) -> Self {
        let moved = (0..scene.models.len()).filter(|model| plan.moved[*model]);
        Self::around(moved.map(|model| bounds[model].placed(&pose.models[model])).collect())
    }

    fn around(boxes: Vec<Bounds>) -> Self {
        let together = boxes.len().div_ceil(MOST_BOXES).max(1);
        let join = |some: &[Bounds]| some.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Self { boxes: boxes.chunks(together).map(join).collect() }
    }

    /// Whether anything that moved may be at `origin + t * direction` for a t in `0..=far`. A `false` is
    /// certain.
    #[inline]
    pub fn may_meet(&self, origin: Vec3, direction: Vec3, far: f32) -> bool {
        // parallel to a slab: a huge slope says inside or outside as well as an infinite one, and 0 times
        // it is a number
        let steep = |along: f32| if along.abs() < 1e-30 { 1e30 } else { along.recip() };
        let inverse = Vec3::new(steep(direction.x), steep(direction.y), steep(direction.z));
        self.boxes.iter().any(|bounds| bounds.meets(origin, inverse, far))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Movers {
        Movers { boxes: vec![Bounds { low: Vec3::ZERO, high: Vec3::ONE }] }
    }

    #[test]
    fn a_segment_through_the_box_may_meet_and_one_past_it_does_not() {
        let movers = unit();
        assert!(movers.may_meet(Vec3::new(-1.0, 0.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(!movers.may_meet(Vec3::new(-1.0, 0.5, 0.5), Vec3::X, 0.5), "it ends before the box");
        assert!(!movers.may_meet(Vec3::new(-1.0, 1.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(!movers.may_meet(Vec3::new(2.0, 0.5, 0.5), Vec3::X, f32::INFINITY), "it leaves from behind");
        assert!(movers.may_meet(Vec3::splat(0.5), Vec3::Y, 0.1), "it is inside");
        assert!(movers.may_meet(Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 5.0), "it runs along an edge");
    }

    #[test]
    fn many_movers_share_boxes_and_none_is_lost() {
        let boxes = (0..100).map(|i| Vec3::splat(i as f32)).map(|low| Bounds { low, high: low + 0.5 });
        let movers = Movers::around(boxes.collect());
        assert!(movers.boxes.len() <= MOST_BOXES);
        for i in 0..100 {
            assert!(movers.may_meet(Vec3::splat(i as f32 + 0.25), Vec3::X, 0.1), "{i}");
        }
    }
}
