//! Light as it arrives at surfaces.

use glam::Vec3;

use crate::lanes::{F32x8, Mask, Vec3x8};

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
