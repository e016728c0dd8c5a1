//! Gradients: Blender's Gradient Texture node.

use std::f32::consts::TAU;

use glam::Vec3;

use super::finite;

/// Options of the Gradient Texture node. It has no inputs but the vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Gradient {
    /// X.
    Linear,
    /// The square of X, 0 where X is negative.
    Quadratic,
    /// X with smooth ends.
    Easing,
    /// The mean of X and Y.
    Diagonal,
    /// 1 at the origin, 0 on the unit sphere and outside.
    Spherical,
    /// The square of [`Self::Spherical`].
    QuadraticSphere,
    /// The angle about Z as a share of a full turn; half at the axis X, growing towards Y.
    Radial,
}

impl Gradient {
    /// The output Factor, 0 to 1. The output Color is the same number three times.
    pub fn value(&self, vector: Vec3) -> f32 {
        // A little less than 1, so that it is 0 all over a unit sphere whatever the rounding.
        let inward = || (0.999_999 - vector.length()).max(0.0);
        let value = match self {
            Self::Linear => vector.x,
            Self::Quadratic => vector.x.max(0.0) * vector.x.max(0.0),
            Self::Easing => eased(vector.x),
            Self::Diagonal => (vector.x + vector.y) * 0.5,
            Self::Spherical => inward(),
            Self::QuadraticSphere => inward() * inward(),
            Self::Radial => vector.y.atan2(vector.x) / TAU + 0.5,
        };
        finite(value).clamp(0.0, 1.0)
    }

    /// The output Color, 0 to 1: [`Self::value`] three times.
    pub fn color(&self, vector: Vec3) -> Vec3 {
        Vec3::splat(self.value(vector))
    }
}

/// Hermite's curve from 0 to 1 with level ends; clamped outside.
pub(super) fn eased(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
