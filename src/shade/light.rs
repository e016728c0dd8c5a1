//! How much light comes from where.

use glam::Vec3;

use crate::lanes::{Lanes, Lanes3};
use crate::motion::{LightPose, pose::LightShape};

/// Light as it arrives at eight points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// From the points to the light, any length: the light is at `t = far` along it.
    pub to_light: Lanes3,
    /// Unit length.
    pub direction: Lanes3,
    /// End of the shadow rays in lengths of `to_light`.
    pub far: f32,
    /// On a surface that faces the light; linear RGB. Zero outside the cone of a spot.
    pub irradiance: Lanes3,
}

/// What `light` sends to `points` when nothing is in its way.
///
/// Point lights fall with the square of the distance; a spot fades from its inner to its outer cone by
/// the smoothstep of the cosine.
#[inline(always)]
pub fn arrival(light: &LightPose, points: Lanes3) -> Arrival {
    match light.shape {
        LightShape::Directional { to_light } => {
            let to_light = Lanes3::splat(to_light);
            let irradiance = Lanes3::splat(light.strength);
            Arrival { to_light, direction: to_light, far: f32::INFINITY, irradiance }
        }
        LightShape::Point { position } => from_position(light.strength, position, points),
        LightShape::Spot { position, axis, cos_outer, cos_inner } => {
            let mut arrival = from_position(light.strength, position, points);
            let cos = -arrival.direction.dot(Lanes3::splat(axis));
            arrival.irradiance = arrival.irradiance * fade(cos, cos_outer, cos_inner);
            arrival
        }
    }
}

#[inline(always)]
fn from_position(intensity: Vec3, position: Vec3, points: Lanes3) -> Arrival {
    let to_light = Lanes3::splat(position) - points;
    // a sample in the light itself gets a lot, not infinity
    let squared = to_light.dot(to_light).max(Lanes::splat(f32::MIN_POSITIVE.sqrt()));
    Arrival {
        to_light,
        direction: to_light * (Lanes::splat(1.0) / squared.sqrt()),
        far: 1.0,
        irradiance: Lanes3::splat(intensity) / squared,
    }
}

/// 0 at `outer` and beyond, 1 from `inner` on.
#[inline(always)]
fn fade(cos: Lanes, outer: f32, inner: f32) -> Lanes {
    let (outer, inner, one) = (Lanes::splat(outer), Lanes::splat(inner), Lanes::splat(1.0));
    let t = (cos - outer) / (inner - outer);
    let between = t * t * (Lanes::splat(3.0) - (t + t));
    cos.le(outer).select(Lanes::ZERO, cos.lt(inner).select(between, one))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_light_falls_with_the_square() {
        let shape = LightShape::Point { position: Vec3::new(0.0, 2.0, 0.0) };
        let light = LightPose { shape, strength: Vec3::splat(8.0) };
        let arrival = arrival(&light, Lanes3::ZERO);
        assert_eq!(arrival.irradiance.lane(0), Vec3::splat(2.0));
        assert_eq!(arrival.to_light.lane(1) * arrival.far, Vec3::new(0.0, 2.0, 0.0));
        assert!((arrival.direction.lane(2) - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_spot_is_full_inside_and_dark_outside() {
        let shape = LightShape::Spot { position: Vec3::Y, axis: Vec3::NEG_Y, cos_outer: 0.5, cos_inner: 0.9 };
        let light = LightPose { shape, strength: Vec3::ONE };
        let at = |point: Vec3| arrival(&light, Lanes3::splat(point)).irradiance.lane(0);
        assert_eq!(at(Vec3::ZERO), Vec3::ONE);
        assert_eq!(at(Vec3::new(3.0, 0.0, 0.0)), Vec3::ZERO);
        assert_eq!(fade(Lanes::splat(0.7), 0.5, 0.9).0[0], 0.5);
        assert_eq!(fade(Lanes::splat(0.7), 0.7, 0.7).0[0], 0.0, "a cone without a soft rim");
    }
}
