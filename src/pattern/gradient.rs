//! Gradients: Blender's Gradient Texture node.

use std::f32::consts::TAU;

use super::finite8;
use crate::lanes::{F32x8, Vec3x8};

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
    pub fn value(&self, vector: Vec3x8) -> F32x8 {
        // A little less than 1, so that it is 0 all over a unit sphere whatever the rounding.
        let inward = || (F32x8::splat(0.999_999) - vector.length()).max(F32x8::ZERO);
        let value = match self {
            Self::Linear => vector.x,
            Self::Quadratic => vector.x.max(F32x8::ZERO) * vector.x.max(F32x8::ZERO),
            Self::Easing => eased(vector.x),
            Self::Diagonal => (vector.x + vector.y) * 0.5,
            Self::Spherical => inward(),
            Self::QuadraticSphere => inward() * inward(),
            Self::Radial => vector.y.each_with(vector.x, f32::atan2) / TAU + 0.5,
        };
        finite8(value).clamp(0.0, 1.0)
    }
}

/// Hermite's curve from 0 to 1 with level ends; clamped outside.
#[inline(always)]
pub(super) fn eased(share: F32x8) -> F32x8 {
    let share = share.clamp(0.0, 1.0);
    share * share * (F32x8::splat(3.0) - share * 2.0)
}
