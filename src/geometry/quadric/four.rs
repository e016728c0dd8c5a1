//! Intersections of four rays at a time with a piece. Tracers ask by packets, and a ray that is traced by
//! itself fills all four lanes: a lane's result does not depend on the lanes beside it.

use std::array::from_fn;

use glam::{DAffine3, DVec3};
use wide::{CmpEq, CmpGe, CmpGt, CmpLe, CmpLt, f64x4};

use super::piece::{Kind, Piece, RIM};
use crate::geometry::curved::{FOUR, Meeting, Ray};

/// Four points or directions.
#[derive(Clone, Copy)]
struct Vec3x4 {
    x: f64x4,
    y: f64x4,
    z: f64x4,
}

impl Vec3x4 {
    /// Sets all four to the same vector.
    #[inline]
    fn splat(vector: DVec3) -> Self {
        Self { x: vector.x.into(), y: vector.y.into(), z: vector.z.into() }
    }

    #[inline(always)]
    fn new(three: impl Fn(usize, usize) -> f32) -> Self {
        let axis = |axis: usize| f64x4::new(from_fn(|lane| f64::from(three(lane, axis))));
        Self { x: axis(0), y: axis(1), z: axis(2) }
    }

    #[inline(always)]
    fn dot(self, other: Self) -> f64x4 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    fn map(self, of_axis: impl Fn(f64x4) -> f64x4) -> Self {
        Self { x: of_axis(self.x), y: of_axis(self.y), z: of_axis(self.z) }
    }

    /// Points at `t` along `direction`.
    #[inline(always)]
    fn along(self, direction: Self, t: f64x4) -> Self {
        Self { x: self.x + direction.x * t, y: self.y + direction.y * t, z: self.z + direction.z * t }
    }

    /// Transforms by a map's linear part.
    #[inline(always)]
    fn turned(self, map: &DAffine3) -> Self {
        let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(Self::splat);
        let row = |x: f64x4, y: f64x4, z: f64x4| x * self.x + y * self.y + z * self.z;
        Self { x: row(x.x, y.x, z.x), y: row(x.y, y.y, z.y), z: row(x.z, y.z, z.z) }
    }

    /// Transforms by a map.
    #[inline(always)]
    fn placed(self, map: &DAffine3) -> Self {
        let (turned, by) = (self.turned(map), Self::splat(map.translation));
        Self { x: turned.x + by.x, y: turned.y + by.y, z: turned.z + by.z }
    }
}

#[inline(always)]
fn lanes(mask: f64x4) -> u8 {
    mask.move_mask() as u8 & 15
}

#[inline(always)]
fn opposite(value: f64x4) -> f64x4 {
    value ^ f64x4::splat(-0.0)
}

#[inline(always)]
fn nowhere() -> f64x4 {
    f64x4::splat(f64::NAN)
}

/// Rounds to single floats.
#[inline(always)]
fn singles(values: f64x4) -> [f32; FOUR] {
    values.to_array().map(|value| value as f32)
}

#[inline(always)]
fn doubles(values: [f32; FOUR]) -> f64x4 {
    f64x4::new(values.map(f64::from))
}

/// First intersections of four rays in object space with `piece`, of a quadric to whose own space `inverse`
/// leads: a bit mask of the rays that have one, and the intersections; those of other lanes mean nothing.
#[inline(always)]
pub fn meet(piece: &Piece, inverse: &DAffine3, rays: &[Ray; FOUR]) -> (u8, [Meeting; FOUR]) {
    const NONE: [Meeting; FOUR] = [Meeting { t: 0.0, weights: [0.0; 2] }; FOUR];
    let origin = Vec3x4::new(|lane, axis| rays[lane].origin[axis]).placed(inverse);
    let direction = Vec3x4::new(|lane, axis| rays[lane].direction[axis]).turned(inverse);
    let Some([mut one, mut other]) = places(piece, origin, direction) else { return (0, NONE) };
    if rays.iter().any(|ray| ray.ends_here) {
        let ends =
            f64x4::new(from_fn(|lane| f64::from_bits(if rays[lane].ends_here { u64::MAX } else { 0 })));
        let from_end = |t: f64x4| {
            let away = (t - f64x4::ONE).abs();
            away.is_nan().blend(f64x4::splat(f64::INFINITY), away)
        };
        let is_other = from_end(other).cmp_lt(from_end(one));
        other = (ends & is_other).blend(nowhere(), other);
        one = (ends & !is_other).blend(nowhere(), one);
    }
    let (near, far) = (doubles(rays.map(|ray| ray.near)), doubles(rays.map(|ray| ray.far)));
    let in_reach = |t: f64x4| {
        let rounded = doubles(singles(t));
        rounded.cmp_gt(near) & rounded.cmp_le(far)
    };
    let (one_counts, other_counts) = (in_reach(one), in_reach(other));
    let met = lanes(one_counts | other_counts);
    if met == 0 {
        return (0, NONE);
    }
    let is_other = other_counts & (!one_counts | other.cmp_lt(one));
    let first = is_other.blend(other, one);
    let [u, v] = weights(piece, origin.along(direction, first)).map(singles);
    let t = singles(first);
    (met, from_fn(|lane| Meeting { t: t[lane], weights: [u[lane], v[lane]] }))
}

/// Parameters t at which a line meets the piece: up to two, the others NaN.
pub fn places_of(piece: &Piece, origin: DVec3, direction: DVec3) -> [f64; 2] {
    let places = places(piece, Vec3x4::splat(origin), Vec3x4::splat(direction));
    places.map_or([f64::NAN; 2], |places| places.map(|t| t.to_array()[0]))
}

/// Weights of `point` on the piece.
pub fn weights_of(piece: &Piece, point: DVec3) -> [f64; 2] {
    weights(piece, Vec3x4::splat(point)).map(|weight| weight.to_array()[0])
}

/// Parameters t at which four lines meet the piece: up to two each, the others NaN. `None` if no line does.
#[inline(always)]
fn places(piece: &Piece, origin: Vec3x4, direction: Vec3x4) -> Option<[f64x4; 2]> {
    let [low, high] = piece.range;
    if let Kind::Disk { .. } = piece.kind {
        let t = (f64x4::splat(low) - origin.y) / direction.y;
        let (x, z) = (origin.x + t * direction.x, origin.z + t * direction.z);
        let is_on = (x * x + z * z).cmp_le(f64x4::splat(piece.profile[2] * (1.0 + RIM)));
        return Some([is_on.blend(t, nowhere()), nowhere()]);
    }
    let roots = roots(piece, origin, direction)?;
    if piece.kind == Kind::Ball {
        return Some(roots);
    }
    Some(roots.map(|t| {
        let y = origin.y + t * direction.y;
        let is_on = f64x4::splat(low - RIM).cmp_le(y) & y.cmp_le(f64x4::splat(high + RIM));
        is_on.blend(t, nowhere())
    }))
}

/// Parameters t at which four lines meet the whole quadric that the piece is a part of. `None` if all pass by
/// it.
///
/// Computed from the line's point nearest to the centre, so that a distance costs no digits of the
/// discriminant (E. Haines, J. Günther, T. Akenine-Möller, "Precision Improvements for Ray/Sphere
/// Intersection", Ray Tracing Gems, chapter 7), and by the sum that cancels nothing.
#[inline(always)]
fn roots(piece: &Piece, origin: Vec3x4, direction: Vec3x4) -> Option<[f64x4; 2]> {
    let Vec3x4 { x, y, z } = direction;
    let start = opposite(origin.dot(direction)) / direction.dot(direction);
    let near = origin.along(direction, start);
    let [a, b, _] = piece.profile;
    let a = f64x4::splat(a);
    let square = x * x + z * z - a * y * y;
    let half = near.x * x + near.z * z - (a * near.y + f64x4::splat(0.5 * b)) * y;
    let rest = beyond(piece, near);
    // NaN, or below zero, where the line passes by
    let discriminant = half * half - square * rest;
    if lanes(discriminant.cmp_ge(f64x4::ZERO)) == 0 {
        return None;
    }
    let sum = opposite(half + discriminant.sqrt().copysign(half));
    let [mut one, mut other] = [start + sum / square, start + rest / sum];
    let touches = sum.cmp_eq(f64x4::ZERO) & discriminant.cmp_eq(f64x4::ZERO);
    one = touches.blend(start, one);
    other = touches.blend(nowhere(), other);
    // a ray that begins on the surface does not meet it there, whatever rounding gives
    let begins = beyond(piece, origin).cmp_eq(f64x4::ZERO);
    let is_other = other.abs().cmp_lt(one.abs());
    other = (begins & is_other).blend(f64x4::ZERO, other);
    one = (begins & !is_other).blend(f64x4::ZERO, one);
    Some([one, other])
}

/// Implicit function: zero on the quadric, above zero outside.
#[inline(always)]
fn beyond(piece: &Piece, point: Vec3x4) -> f64x4 {
    let [a, b, c] = piece.profile.map(f64x4::splat);
    point.x * point.x + point.z * point.z - ((a * point.y + b) * point.y + c)
}

/// Weights of four points on the piece.
#[inline(always)]
fn weights(piece: &Piece, point: Vec3x4) -> [f64x4; 2] {
    match piece.kind {
        Kind::Ball => {
            let sum = point.x.abs() + point.y.abs() + point.z.abs();
            let Vec3x4 { x, y, z } = point.map(|part| part / sum);
            let is_above = y.cmp_ge(f64x4::ZERO);
            let [far_x, far_z] = [(z, x), (x, z)].map(|(by, like)| (f64x4::ONE - by.abs()).copysign(like));
            [is_above.blend(x, far_x), is_above.blend(z, far_z)]
        }
        Kind::Belt => {
            let [low, high] = piece.range.map(f64x4::splat);
            [point.y.max(low).min(high), diamond(point.x, point.z)]
        }
        Kind::Sheet { .. } | Kind::Disk { .. } => [point.x, point.z],
    }
}

/// Direction of (x, z) as a number from -2 to 2: its position along a square that stands on its corner.
#[inline(always)]
fn diamond(x: f64x4, z: f64x4) -> f64x4 {
    let sum = x.abs() + z.abs();
    let angle = (f64x4::ONE - x / sum).copysign(z);
    sum.cmp_eq(f64x4::ZERO).blend(f64x4::ZERO, angle)
}
