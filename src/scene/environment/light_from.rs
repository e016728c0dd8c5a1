//! What a look in a direction finds.

use glam::Vec3;

/// Light from a direction, and how likely that direction is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightFrom {
    /// Linear RGB, scene-referred.
    pub radiance: Vec3,
    /// Probability density in solid angle. Where it is 0, the radiance is, too.
    pub pdf: f32,
}

impl LightFrom {
    /// None, from where no light is looked for.
    pub const NONE: Self = Self { radiance: Vec3::ZERO, pdf: 0.0 };
}
