//! How much light comes from where.

use glam::Vec3;

use crate::motion::{LightPose, pose::LightShape};

/// Light as it arrives at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrival {
    /// From the point to the light, any length: the light is at `t = far` along it.
    pub to_light: Vec3,
    /// Unit length.
    pub direction: Vec3,
    /// End of the shadow ray in lengths of `to_light`.
    pub far: f32,
    /// On a surface that faces the light; linear RGB. Zero outside the cone of a spot.
    pub irradiance: Vec3,
}

/// What `light` sends to `point` when nothing is in its way.
///
/// Point lights fall with the square of the distance; a spot fades from its inner to its outer cone by
/// the smoothstep of the cosine.
#[inline]
pub fn arrival(light: &LightPose, point: Vec3) -> Arrival {
    match light.shape {
        LightShape::Directional { to_light } => {
            Arrival { to_light, direction: to_light, far: f32::INFINITY, irradiance: light.strength }
        }
        LightShape::Point { position } => from_position(light.strength, position, point),
        LightShape::Spot { position, axis, cos_outer, cos_inner } => {
            let mut arrival = from_position(light.strength, position, point);
            let cos = -arrival.direction.dot(axis);
            arrival.irradiance *= fade(cos, cos_outer, cos_inner);
            arrival
        }
    }
}

fn from_position(intensity: Vec3, position: Vec3, point: Vec3) -> Arrival {
    let to_light = position - point;
    // a sample in the light itself gets a lot, not infinity
    let squared = to_light.length_squared().max(f32::MIN_POSITIVE.sqrt());
    Arrival {
        to_light,
        direction: to_light * squared.sqrt().recip(),
        far: 1.0,
        irradiance: intensity / squared,
    }
}

/// 0 at `outer` and beyond, 1 from `inner` on.
fn fade(cos: f32, outer: f32, inner: f32) -> f32 {
    if cos <= outer {
        return 0.0;
    }
    if cos >= inner {
        return 1.0;
    }
    let t = (cos - outer) / (inner - outer);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_light_falls_with_the_square() {
        let shape = LightShape::Point { position: Vec3::new(0.0, 2.0, 0.0) };
        let light = LightPose { shape, strength: Vec3::splat(8.0) };
        let arrival = arrival(&light, Vec3::ZERO);
        assert_eq!(arrival.irradiance, Vec3::splat(2.0));
        assert_eq!(arrival.to_light * arrival.far, Vec3::new(0.0, 2.0, 0.0));
        assert!((arrival.direction - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_spot_is_full_inside_and_dark_outside() {
        let shape = LightShape::Spot { position: Vec3::Y, axis: Vec3::NEG_Y, cos_outer: 0.5, cos_inner: 0.9 };
        let light = LightPose { shape, strength: Vec3::ONE };
        assert_eq!(arrival(&light, Vec3::ZERO).irradiance, Vec3::ONE);
        assert_eq!(arrival(&light, Vec3::new(3.0, 0.0, 0.0)).irradiance, Vec3::ZERO);
        assert_eq!(fade(0.7, 0.5, 0.9), 0.5);
    }
}
