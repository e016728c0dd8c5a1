//! Radiance and density of a direction.

use glam::Vec3;

/// Radiance from a direction, and the probability density of sampling that direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightFrom {
    /// Linear RGB, scene-referred.
    pub radiance: Vec3,
    /// Probability density in solid angle. Wherever it is 0, the radiance is 0 as well.
    pub pdf: f32,
}

impl LightFrom {
    /// No light, from a direction that is never sampled.
    pub const NONE: Self = Self { radiance: Vec3::ZERO, pdf: 0.0 };
}
