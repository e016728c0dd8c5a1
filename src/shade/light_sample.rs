//! Light as it arrives at surfaces.

use glam::Vec3;

use crate::lanes::{F32x8, Mask, Vec3x8};
use crate::pose::{Cone, Spread};

/// Light as it arrives at eight points.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// Vectors from the points to the light, any length: the light is at `t = far` along them.
    pub to_light: Vec3x8,
    /// Directions to the light, unit length.
    pub direction: Vec3x8,
    /// End of the shadow rays, in lengths of `to_light`.
    pub far: f32,
    /// Irradiance of a surface that faces the light; linear RGB. Zero outside the cone of a spot.
    pub irradiance: Vec3x8,
    /// Mask of the points that the light reaches by its shape alone, whatever its colour and power: not
    /// outside the cone of a spot, or behind a panel.
    pub reaches: Mask,
}

impl LightSample {
    /// Ways to the light from points by `lift` away from those for which this was computed.
    #[inline(always)]
    pub fn all_from_lifted(&self, lift: Vec3) -> Vec3x8 {
        self.from_points_beside(Vec3x8::splat(lift))
    }

    /// Ways to the light from points beside those for which this was computed: a light at infinity is in the same direction.
    #[inline(always)]
    pub fn from_points_beside(&self, offsets: Vec3x8) -> Vec3x8 {
        if self.far.is_finite() { self.to_light - offsets } else { self.to_light }
    }

    /// This one in the lanes of `mask`, and `other` in the rest: both of one light, which is near or at infinity.
    pub fn where_set(&self, mask: Mask, other: &Self) -> Self {
        Self {
            to_light: mask.select3(self.to_light, other.to_light),
            direction: mask.select3(self.direction, other.direction),
            far: self.far,
            irradiance: mask.select3(self.irradiance, other.irradiance),
            reaches: self.reaches & mask | other.reaches & !mask,
        }
    }

    /// [`all_from_lifted`](Self::all_from_lifted) of one lane.
    pub fn from_lifted(&self, lane: usize, lift: Vec3) -> Vec3 {
        self.all_from_lifted(lift).lane(lane)
    }
}

/// Light of `strength` from these places, falling with the square of the distance.
#[inline(always)]
pub fn from_place(strength: Vec3, places: Vec3x8, points: Vec3x8) -> LightSample {
    let to_light = places - points;
    // a sample in the light itself gets much light, but not infinity
    let squared = to_light.dot(to_light).max(F32x8::splat(f32::MIN_POSITIVE.sqrt()));
    LightSample {
        to_light,
        direction: to_light * (F32x8::splat(1.0) / squared.sqrt()),
        far: 1.0,
        irradiance: Vec3x8::splat(strength) / squared,
        reaches: Mask::ALL,
    }
}

/// What of the light shines within a cone.
#[inline(always)]
pub fn within(cone: &Cone, light_sample: LightSample) -> LightSample {
    let share = share_of(cone, light_sample.direction);
    LightSample {
        irradiance: light_sample.irradiance * share,
        reaches: light_sample.reaches & share.gt(F32x8::ZERO),
        ..light_sample
    }
}

/// Share of the full light that a cone lets through to where these directions, unit length, lead to the light.
#[inline(always)]
pub fn share_of(cone: &Cone, to_light: Vec3x8) -> F32x8 {
    fade(-to_light.dot(Vec3x8::splat(cone.axis)), [cone.cos_outer, cone.cos_inner], cone.curve)
}

/// Share of the light along its axis that a panel sends to where these directions, unit length, lead to it: 1 less the tangent of
/// the angle between them over that of half of the spread.
#[inline(always)]
pub fn share_of_spread(spread: &Spread, to_light: Vec3x8) -> F32x8 {
    let cos = -to_light.dot(Vec3x8::splat(spread.axis));
    let sine = (F32x8::ONE - cos * cos).max(F32x8::ZERO).sqrt();
    let share = F32x8::ONE - F32x8::splat(spread.fall) * sine / cos;
    cos.gt(F32x8::ZERO).select(share.max(F32x8::ZERO), F32x8::ZERO)
}

/// Share by a cosine: 0 at `outer` and beyond, 1 from `inner` on, and t²(a - bt) between them.
#[inline(always)]
fn fade(cos: F32x8, [outer, inner]: [f32; 2], [a, b]: [f32; 2]) -> F32x8 {
    let (outer, inner, one) = (F32x8::splat(outer), F32x8::splat(inner), F32x8::splat(1.0));
    let t = (cos - outer) / (inner - outer);
    let between = t * t * (F32x8::splat(a) - t * F32x8::splat(b));
    cos.le(outer).select(F32x8::ZERO, cos.lt(inner).select(between, one))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SpotFall;

    #[test]
    fn panels_dim_by_the_tangent() {
        // half of the spread is 45 degrees
        let spread = Spread { axis: Vec3::NEG_Y, fall: 1.0 };
        let at = |tangent: f32| {
            let to_light = Vec3::new(tangent, 1.0, 0.0).normalize();
            share_of_spread(&spread, Vec3x8::splat(to_light)).lane(0)
        };
        assert_eq!(at(0.0), 1.0);
        assert!((at(0.25) - 0.75).abs() < 1e-6 && (at(-0.5) - 0.5).abs() < 1e-6);
        assert_eq!((at(1.5), share_of_spread(&spread, Vec3x8::splat(Vec3::NEG_Y)).lane(0)), (0.0, 0.0));
    }

    #[test]
    fn spots_fade_by_the_smoothstep() {
        let [smooth, square] = [SpotFall::Smooth, SpotFall::Square].map(SpotFall::curve);
        assert_eq!(fade(F32x8::splat(0.7), [0.5, 0.9], smooth).lane(0), 0.5);
        assert_eq!(fade(F32x8::splat(0.7), [0.5, 0.9], square).lane(0), 0.25);
        assert_eq!(fade(F32x8::splat(0.7), [0.7, 0.7], smooth).lane(0), 0.0, "a cone without a soft rim");
    }
}
