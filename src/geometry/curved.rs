//! What every geometry answers whose primitives are not flat triangles: quadrics, curves, and whatever else is met and evaluated one primitive at a
//! time.
//!
//! Both tracers call [`Curved::meet_four`], so that both get the same floats, and know nothing else of a geometry but the boxes of its
//! primitives. *Weights*: a point on a primitive is two numbers, as it is on a triangle; each geometry says what they mean.

use std::fmt::Debug;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::Bounds;

/// Number of rays that are intersected at once.
pub const FOUR: usize = 4;

/// Primitives in object space, numbered from 0 on. A number beyond the last is that of the last: a wrong one shows, and is no fault.
pub trait Curved: Debug + Send + Sync {
    /// Name of what it is: `sphere`, say.
    fn name(&self) -> &'static str;

    /// Name of all of its kind, in the plural: `quadrics`, say.
    fn kind(&self) -> &'static str;

    /// Number of its primitives; at least one.
    fn count(&self) -> u32;

    /// Box around a primitive, object space.
    fn bounds(&self, primitive: u32) -> Bounds;

    /// Number of boxes that trees have for a primitive: what is long and thin has several, which follow each other along it.
    fn boxes(&self) -> u32 {
        1
    }

    /// Box around a part of a primitive, one of as many as there are [`boxes`](Self::boxes); object space.
    fn bounds_of_part(&self, primitive: u32, _part: u32) -> Bounds {
        self.bounds(primitive)
    }

    /// First intersections of four rays with a primitive: a bit mask of the rays that have one, and the intersections; those of other lanes
    /// mean nothing. A ray's result is that of [`meet`](Self::meet), whatever rays are beside it.
    fn meet_four(&self, primitive: u32, rays: &[Ray; FOUR]) -> (u8, [Meeting; FOUR]);

    /// First intersection of `ray` with a primitive.
    #[inline]
    fn meet(&self, primitive: u32, ray: &Ray) -> Option<Meeting> {
        let (met, [meeting, ..]) = self.meet_four(primitive, &[*ray; FOUR]);
        (met & 1 != 0).then_some(meeting)
    }

    /// Intersection of the line from `origin` along `direction` (object space) with a primitive, the one nearest to `about`: in double
    /// floats, and on the primitive even if the line passes by it.
    fn meet_line(&self, primitive: u32, origin: DVec3, direction: DVec3, about: Vec3) -> Vec3;

    /// Point of a primitive, object space, at these weights.
    fn point(&self, primitive: u32, weights: [f32; 2]) -> Vec3;

    /// Weights of a point on a primitive, object space; of a point beside it those of one near it.
    fn weights(&self, primitive: u32, point: Vec3) -> [f32; 2];

    /// Bound of the distance of a point from a primitive, object space: close to it where the point is nearly on the primitive.
    fn distance(&self, primitive: u32, point: Vec3) -> f64;

    /// Normal of a primitive, outwards, of unit length, object space.
    fn normal(&self, primitive: u32, weights: [f32; 2]) -> Vec3;

    /// Texture coordinates of a primitive.
    fn uv(&self, primitive: u32, weights: [f32; 2]) -> Vec2;

    /// The geometry after `map`, which has an inverse.
    fn mapped(&self, map: DAffine3) -> Arc<dyn Curved>;

    /// Bytes of memory that it takes.
    fn bytes(&self) -> u64;

    /// Vertices between which a place lies, by the lists that a mesh has by vertex, and the share of the way from the first to the second;
    /// `None` if it has no vertices.
    fn vertices(&self, _primitive: u32, _weights: [f32; 2]) -> Option<([u32; 2], f32)> {
        None
    }

    /// Direction along a fibre at a place, object space, of unit length; zero if it is none.
    fn tangent(&self, _primitive: u32, _weights: [f32; 2]) -> Vec3 {
        Vec3::ZERO
    }

    /// Point close to a place of a fibre, within it, object space: rays from there leave the fibre without meeting it. `None` if it is none.
    fn inside(&self, _primitive: u32, _weights: [f32; 2]) -> Option<Vec3> {
        None
    }

    /// Greatest radius of its fibres, object space; 0 if it has none.
    fn most_radius(&self) -> f32 {
        0.0
    }

    /// Calls `found` with all primitives that a point is nearer to than `reach`, and maybe others; object space.
    fn near(&self, _point: Vec3, _reach: f32, found: &mut dyn FnMut(u32)) {
        (0..self.count()).for_each(found);
    }

    /// Returns true if it has no size: the box around a shot leaves it out.
    fn is_endless(&self) -> bool {
        false
    }
}

/// Intersection of a ray with a primitive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// Ray parameter, in lengths of the ray's direction.
    pub t: f32,
    /// Point on the primitive.
    pub weights: [f32; 2],
}

/// A ray in object space: `origin + t * direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Origin; finite.
    pub origin: Vec3,
    /// Direction, of any length but zero.
    pub direction: Vec3,
    /// Lower end of t, which is excluded.
    pub near: f32,
    /// Upper end of t.
    pub far: f32,
    /// True if the ray ends at t = 1 in a point of the primitive that it is tested against, which does not count.
    pub ends_here: bool,
}
