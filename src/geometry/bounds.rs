//! Axis-aligned boxes, and their intersection with segments.

use glam::Vec3;

use crate::animation::Transform;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};

/// Axis-aligned box, world or object space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub low: Vec3,
    /// Greatest coordinates.
    pub high: Vec3,
}

impl Bounds {
    /// Empty box.
    pub const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    /// Box of one point.
    pub fn at(point: Vec3) -> Self {
        Self { low: point, high: point }
    }

    /// Box around eight points.
    pub fn of_lanes(points: Vec3x8) -> Self {
        (0..LANES).fold(Self::EMPTY, |all, lane| all.with(points.lane(lane)))
    }

    /// Returns true if the box is empty.
    pub fn is_empty(&self) -> bool {
        !self.low.cmple(self.high).all()
    }

    /// Box around this box and a point.
    pub fn with(self, point: Vec3) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }

    /// The corners of the box.
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            Vec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Box around this box after `transform`, with room for rounding; empty if the model is not there. There
    /// is as much room on all sides: a thin model has none of its own, and lies in the face of its box.
    pub fn placed(&self, transform: &Transform) -> Self {
        if !transform.is_visible {
            return Self::EMPTY;
        }
        let tight =
            self.corners().map(|corner| transform.point(corner)).into_iter().fold(Self::EMPTY, Self::with);
        let room = 1e-4 * (tight.high - tight.low).max_element()
            + 1e-5 * tight.low.abs().max(tight.high.abs()).max_element();
        Self { low: tight.low - room, high: tight.high + room }
    }

    /// Box around both boxes.
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Mask of those of eight segments that meet the box (slabs). A bit that is not set is certain.
    #[inline(always)]
    pub fn meets(&self, segments: &Segments) -> Mask {
        let Segments { origin, inverse, far } = *segments;
        let a = (Vec3x8::splat(self.low) - origin) * inverse;
        let b = (Vec3x8::splat(self.high) - origin) * inverse;
        let (near, away) = (a.min(b), a.max(b));
        let enter = near.x.max(near.y).max(near.z).max(F32x8::ZERO);
        let leave = away.x.min(away.y).min(away.z).min(far);
        enter.le(leave)
    }
}

/// Eight axis-aligned boxes.
#[derive(Debug, Clone, Copy)]
pub struct Bounds8 {
    low: Vec3x8,
    high: Vec3x8,
}

impl Bounds8 {
    /// Eight boxes that contain the origin alone.
    pub const ORIGIN: Self = Self { low: Vec3x8::ZERO, high: Vec3x8::ZERO };

    /// Sets box number `lane` to `bounds`.
    pub fn set_lane(&mut self, lane: usize, bounds: &Bounds) {
        self.low.set_lane(lane, bounds.low);
        self.high.set_lane(lane, bounds.high);
    }

    /// Mask of those of eight segments that meet the box of their own number (slabs). A bit that is not set
    /// is certain, however far from the boxes the segments begin.
    #[inline(always)]
    pub fn meets(&self, segments: &Segments) -> Mask {
        // three roundings of each distance, by 2^-24 each, at either end
        const ROUNDING: f32 = 1.0 + 6e-7;
        let Segments { origin, inverse, far } = *segments;
        let a = (self.low - origin) * inverse;
        let b = (self.high - origin) * inverse;
        let (near, away) = (a.min(b), a.max(b));
        let enter = near.x.max(near.y).max(near.z).max(F32x8::ZERO);
        let leave = away.x.min(away.y).min(away.z) * F32x8::splat(ROUNDING);
        enter.le(leave.min(far))
    }
}

/// Eight segments: `origin + t * direction` for t in `0..=far`.
#[derive(Debug, Clone, Copy)]
pub struct Segments {
    origin: Vec3x8,
    /// Reciprocals of the directions, finite.
    inverse: Vec3x8,
    far: F32x8,
}

impl Segments {
    /// Creates segments from `origin` along `direction` (of any length) up to `far` times its length.
    #[inline]
    pub fn new(origin: Vec3x8, direction: Vec3x8, far: F32x8) -> Self {
        // parallel to a slab: a huge slope tells inside from outside as well as an infinite one, and 0 times
        // it is a number
        let steep = |along: F32x8| {
            let is_parallel = along.abs().lt(F32x8::splat(1e-30));
            is_parallel.select(F32x8::splat(1e30), F32x8::splat(1.0) / along)
        };
        let inverse = Vec3x8 { x: steep(direction.x), y: steep(direction.y), z: steep(direction.z) };
        Self { origin, inverse, far }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Tests one segment, in each lane.
    pub fn meets(bounds: &Bounds, origin: Vec3, direction: Vec3, far: f32) -> bool {
        let segments = Segments::new(Vec3x8::splat(origin), Vec3x8::splat(direction), F32x8::splat(far));
        let bits = bounds.meets(&segments).bits();
        assert!(bits == 0 || bits == u8::MAX);
        bits != 0
    }

    #[test]
    fn a_segment_through_the_box_may_meet_and_one_past_it_does_not() {
        let unit = Bounds { low: Vec3::ZERO, high: Vec3::ONE };
        assert!(meets(&unit, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(!meets(&unit, Vec3::new(-1.0, 0.5, 0.5), Vec3::X, 0.5), "it ends before the box");
        assert!(!meets(&unit, Vec3::new(-1.0, 1.5, 0.5), Vec3::X, f32::INFINITY));
        assert!(!meets(&unit, Vec3::new(2.0, 0.5, 0.5), Vec3::X, f32::INFINITY), "it leaves from behind");
        assert!(meets(&unit, Vec3::splat(0.5), Vec3::Y, 0.1), "it is inside");
        assert!(meets(&unit, Vec3::new(0.0, -1.0, 0.0), Vec3::Y, 5.0), "it runs along an edge");
    }

    #[test]
    fn what_is_thin_has_room_on_all_sides() {
        // at z = 0 no share of its coordinates makes any
        let quad = Bounds { low: Vec3::new(-1.0, -1.0, 0.0), high: Vec3::new(1.0, 1.0, 0.0) };
        let placed = quad.placed(&Transform::IDENTITY);
        assert!(
            meets(&placed, Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z, 5.0 * (1.0 - f32::EPSILON)),
            "{placed:?}"
        );
        assert!(!meets(&placed, Vec3::new(0.3, 0.2, 5.0), Vec3::NEG_Z, 4.99), "{placed:?}");
    }

    #[test]
    fn eight_boxes_are_met_as_each_by_itself() {
        let boxes: [Bounds; LANES] = std::array::from_fn(|i| {
            let low = Vec3::new(i as f32, 0.0, (i % 3) as f32);
            Bounds { low, high: low + Vec3::new(0.5, 1.0, 0.75) }
        });
        let mut eight = Bounds8::ORIGIN;
        boxes.iter().enumerate().for_each(|(lane, bounds)| eight.set_lane(lane, bounds));
        let mut met = 0;
        for step in 0..200 {
            let (x, z) = ((step % 20) as f32 * 0.41 - 0.3, (step / 20) as f32 * 0.37 - 0.4);
            for (origin, direction, far) in [
                (Vec3::new(x, -1.0, z), Vec3::new(0.1, 1.0, 0.2), 1.5),
                (Vec3::splat(x), Vec3::X, f32::INFINITY),
            ] {
                let segments =
                    Segments::new(Vec3x8::splat(origin), Vec3x8::splat(direction), F32x8::splat(far));
                let bits = eight.meets(&segments).bits();
                for (lane, bounds) in boxes.iter().enumerate() {
                    assert_eq!(
                        bits >> lane & 1 == 1,
                        meets(bounds, origin, direction, far),
                        "{origin} {lane}"
                    );
                }
                met += bits.count_ones();
            }
        }
        assert!(met > 50, "{met}");
    }
}
