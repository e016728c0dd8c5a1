//! A volume that planes enclose.

use glam::Vec3;

use crate::animation::Transform;
use crate::geometry::tree::{Planes, WIDTH};
use crate::lanes::F32x8;

/// Number of planes of a volume: four sides, one behind the eyes, and one behind what is seen.
pub(super) const SIDES: usize = 6;

/// Share of a coordinate by which rounding may move a point against a plane. A dozen roundings.
const ROUNDING: f32 = 2e-6;

/// A plane; the volume is on the side on which `normal` times a point is at most `limit`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub normal: Vec3,
    pub limit: f32,
}

impl Side {
    /// A plane with everything on its inner side.
    pub const NONE: Self = Self { normal: Vec3::ZERO, limit: f32::INFINITY };

    /// Creates a plane from its `limit` for points seen from `middle`; with room for rounding of coordinates up to `largest`.
    pub fn about(middle: Vec3, normal: Vec3, limit: f32, largest: f32) -> Self {
        let room = ROUNDING * largest * normal.abs().element_sum();
        Self { normal, limit: limit + normal.dot(middle) + room }
    }

    /// Returns true if the point lies on the outer side.
    #[inline(always)]
    pub fn excludes(&self, point: Vec3) -> bool {
        self.normal.dot(point) > self.limit
    }

    /// This plane of world space in the object space of a model.
    fn in_object(&self, transform: &Transform) -> Self {
        let map = &transform.to_world;
        let normal = map.matrix3.transpose() * glam::Vec3A::from(self.normal);
        Self { normal: normal.into(), limit: self.limit - self.normal.dot(map.translation.into()) }
    }
}

/// A convex volume, all of which is on the inner sides of its planes. Points that are not beyond any one of the planes count as inside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Volume {
    pub sides: [Side; SIDES],
}

impl Volume {
    /// This volume of world space in the object space of a model.
    pub fn in_object(&self, transform: &Transform) -> Self {
        if transform.is_identity {
            return *self;
        }
        Self { sides: self.sides.each_ref().map(|side| side.in_object(transform)) }
    }

    /// Returns true if nothing of a triangle is inside. It is if all corners are beyond one of the planes, and is not if one of them is
    /// inside. Of a triangle that is much larger than the volume neither shows: it is cut.
    pub fn misses(&self, corners: &[Vec3; 3]) -> bool {
        let mut are_inside = [true; 3];
        for side in &self.sides {
            let are_beyond = corners.map(|corner| side.excludes(corner));
            if are_beyond == [true; 3] {
                return true;
            }
            are_inside.iter_mut().zip(are_beyond).for_each(|(is_inside, is_beyond)| *is_inside &= !is_beyond);
        }
        !are_inside.contains(&true) && cut(corners, &self.sides).1 == 0
    }

    /// Returns true if nothing of a segment is inside.
    pub fn misses_segment(&self, ends: &[Vec3; 2]) -> bool {
        // the part that is inside, as shares of the way
        let (mut from, mut to) = (0.0_f32, 1.0_f32);
        for side in &self.sides {
            let [first, last] = ends.map(|end| side.normal.dot(end) - side.limit);
            match (first > 0.0, last > 0.0) {
                (true, true) => return true,
                (true, false) => from = from.max(first / (first - last)),
                (false, true) => to = to.min(first / (first - last)),
                (false, false) => (),
            }
        }
        from > to
    }

    /// Prepares the volume for [`BoxTest::met`].
    pub fn box_test(&self) -> BoxTest {
        BoxTest(self.sides.each_ref().map(|side| {
            let normal = side.normal.to_array();
            // the corner of a box that is furthest inside
            let corner = [0, 1, 2].map(|axis| if normal[axis] > 0.0 { axis } else { axis + 3 });
            (corner, normal.map(F32x8::splat), F32x8::splat(side.limit))
        }))
    }
}

/// Corners of a triangle that planes have cut, at most.
const MOST_CORNERS: usize = 3 + SIDES;

/// Cuts off what of a triangle is beyond any of `sides`, one after the other (I. Sutherland and G. Hodgman, "Reentrant Polygon
/// Clipping", 1974). Returns the corners of what is left, and their number.
pub(super) fn cut(triangle: &[Vec3; 3], sides: &[Side]) -> ([Vec3; MOST_CORNERS], usize) {
    let (mut corners, mut count) = ([Vec3::ZERO; MOST_CORNERS], 3);
    corners[..3].copy_from_slice(triangle);
    for side in sides {
        let beyond = |corner: Vec3| side.normal.dot(corner) - side.limit;
        let (before, number) = (corners, count);
        count = 0;
        for (at, from) in before[..number].iter().enumerate() {
            let to = before[(at + 1) % number];
            let ends = [beyond(*from), beyond(to)];
            if ends[0] <= 0.0 {
                corners[count] = *from;
                count += 1;
            }
            if (ends[0] <= 0.0) != (ends[1] <= 0.0) {
                corners[count] = *from + (to - *from) * (ends[0] / (ends[0] - ends[1]));
                count += 1;
            }
        }
    }
    (corners, count)
}

/// The planes of a volume, ready to be asked for eight boxes at once: for each the indices of the coordinates of the corner that is
/// furthest inside, its normal and its limit.
pub(super) struct BoxTest([([usize; 3], [F32x8; 3], F32x8); SIDES]);

impl BoxTest {
    /// Bit mask of those of eight boxes that are not beyond any one plane.
    #[inline(always)]
    pub fn met(&self, boxes: &Planes) -> u32 {
        let mut met = u32::MAX >> (u32::BITS - WIDTH as u32);
        for (corner, normal, limit) in &self.0 {
            let [x, y, z] = corner.map(|coordinate| F32x8::new(boxes[coordinate]));
            let inside = (x * normal[0] + y * normal[1] + z * normal[2]).le(*limit);
            met &= u32::from(inside.bits());
        }
        met
    }
}
