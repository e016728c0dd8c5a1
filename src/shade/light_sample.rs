//! Light as it arrives.

use glam::Vec3;

use crate::lanes::{F32x8, Mask, Vec3x8};

/// Light as it arrives at eight points.
#[derive(Debug, Clone, Copy)]
pub struct LightSample {
    /// From the points to the light, any length: the light is at `t = far` along it.
    pub to_light: Vec3x8,
    /// Unit length.
    pub direction: Vec3x8,
    /// End of the shadow rays in lengths of `to_light`.
    pub far: f32,
    /// On a surface that faces the light; linear RGB. Zero outside the cone of a spot.
    pub irradiance: Vec3x8,
    /// The points to which the light sends anything, by its shape alone, whatever its colour and power: not outside the cone of a
    /// spot, or behind a panel.
    pub reaches: Mask,
}

/// All of `strength` from these places, falling with the square of the distance.
#[inline(always)]
pub fn from_place(strength: Vec3, places: Vec3x8, points: Vec3x8) -> LightSample {
    let to_light = places - points;
    // a sample in the light itself gets a lot, not infinity
    let squared = to_light.dot(to_light).max(F32x8::splat(f32::MIN_POSITIVE.sqrt()));
    LightSample {
        to_light,
        direction: to_light * (F32x8::splat(1.0) / squared.sqrt()),
        far: 1.0,
        irradiance: Vec3x8::splat(strength) / squared,
        reaches: Mask::ALL,
    }
}
