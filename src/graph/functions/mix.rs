//! Blender's Mix node: blend types of colours, and mixtures of numbers and vectors.
//!
//! The node's options to clamp are the caller's: a factor to 0 to 1 before, a colour to 0 to 1 after.
use super::hue::{hsv_to_rgb, rgb_to_hsv};
use super::{named, rest_of};
use crate::lanes::{F32x8, Vec3x8};

named! {
    /// A blend type of Blender's Mix node of colours. At a factor of 0 the result is `a`; what follows is for a factor of 1.
    Blend {
        /// `b`.
        Mix = "mix",
        /// The smaller one of each channel.
        Darken = "darken",
        /// `a * b`.
        Multiply = "multiply",
        /// `1 - (1 - a) / b`, clamped to 0 to 1; 0 where `b` is not positive.
        Burn = "burn",
        /// The larger one of each channel.
        Lighten = "lighten",
        /// `1 - (1 - a) * (1 - b)`.
        Screen = "screen",
        /// `a / (1 - b)`, at most 1; 1 where `b` is 1 or more, and 0 where `a` is 0.
        Dodge = "dodge",
        /// `a + b`.
        Add = "add",
        /// Twice the product where `a` is below a half, otherwise as `screen` of the upper half.
        Overlay = "overlay",
        /// `(1 - a) * a * b + a * screen(a, b)`.
        SoftLight = "soft_light",
        /// `a + 2 * b - 1`.
        LinearLight = "linear_light",
        /// The distance between `a` and `b`.
        Difference = "difference",
        /// `a + b - 2 * a * b`, at least 0.
        Exclusion = "exclusion",
        /// `a - b`.
        Subtract = "subtract",
        /// `a / b`; `a` where `b` is 0.
        Divide = "divide",
        /// `a` with the hue of `b`; `a` where `b` is grey.
        Hue = "hue",
        /// `a` with the saturation of `b`; `a` where it is grey.
        Saturation = "saturation",
        /// `a` with the hue and the saturation of `b`; `a` where `b` is grey.
        Color = "color",
        /// `a` with the value of `b`.
        Value = "value",
    }
}

impl Blend {
    /// Blends linear colours. The factor is any number; Blender clamps it to 0 to 1 unless told not to.
    pub fn apply(self, factor: F32x8, a: Vec3x8, b: Vec3x8) -> Vec3x8 {
        match self {
            Self::Hue | Self::Saturation | Self::Color | Self::Value => self.of_hsv(factor, a, b),
            _ => a.each_with(b, |a, b| self.of_channel(factor, a, b)),
        }
        .finite_or_zero()
    }

    fn of_channel(self, t: F32x8, a: F32x8, b: F32x8) -> F32x8 {
        let rest = rest_of(t);
        match self {
            Self::Mix => rest * a + t * b,
            Self::Darken => towards(a, a.min(b), t),
            Self::Multiply => a * (rest + t * b),
            Self::Burn => burn(a, rest + t * b),
            Self::Lighten => towards(a, a.max(b), t),
            Self::Screen => rest_of((rest + t * rest_of(b)) * rest_of(a)),
            Self::Dodge => dodge(a, rest_of(t * b)),
            Self::Add => a + t * b,
            Self::Overlay => {
                let bright = rest_of((rest + t * 2.0 * rest_of(b)) * rest_of(a));
                a.lt(F32x8::splat(0.5)).select(a * (rest + t * 2.0 * b), bright)
            }
            Self::SoftLight => rest * a + t * (rest_of(a) * b * a + a * rest_of(rest_of(b) * rest_of(a))),
            Self::LinearLight => a + t * (b * 2.0 - 1.0),
            Self::Difference => towards(a, (a - b).abs(), t),
            Self::Exclusion => towards(a, a + b - a * 2.0 * b, t).max(F32x8::ZERO),
            Self::Subtract => a - t * b,
            Self::Divide => b.is_zero().select(a, rest * a + t * a / b),
            Self::Hue | Self::Saturation | Self::Color | Self::Value => F32x8::ZERO,
        }
    }

    fn of_hsv(self, t: F32x8, a: Vec3x8, b: Vec3x8) -> Vec3x8 {
        let (from, to) = (rgb_to_hsv(a), rgb_to_hsv(b));
        let towards = |to: [F32x8; 3]| a + (hsv_to_rgb(to.into()) - a) * t;
        // What has no hue has none to give.
        let unless_gray = |made: Vec3x8| to.y.is_zero().select3(a, made);
        match self {
            Self::Saturation => {
                let made = hsv_to_rgb([from.x, float(t, from.y, to.y), from.z].into());
                from.y.is_zero().select3(a, made)
            }
            Self::Value => hsv_to_rgb([from.x, from.y, float(t, from.z, to.z)].into()),
            Self::Hue => unless_gray(towards([to.x, from.y, from.z])),
            _ => unless_gray(towards([to.x, to.y, from.z])),
        }
    }
}

/// A mixture of two numbers: `a` at a factor of 0, `b` at 1, and beyond them outside of 0 to 1.
#[inline(always)]
pub fn float(factor: F32x8, a: F32x8, b: F32x8) -> F32x8 {
    (rest_of(factor) * a + factor * b).finite_or_zero()
}

/// A mixture of two vectors with one factor, as Blender's option "uniform" has it.
pub fn vector(factor: F32x8, a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    a.each_with(b, |a, b| float(factor, a, b))
}

/// A mixture of two vectors with a factor for each component, as Blender's option "non-uniform" has it.
pub fn vector_non_uniform(factor: Vec3x8, a: Vec3x8, b: Vec3x8) -> Vec3x8 {
    Vec3x8::from([float(factor.x, a.x, b.x), float(factor.y, a.y, b.y), float(factor.z, a.z, b.z)])
}

fn towards(a: F32x8, b: F32x8, factor: F32x8) -> F32x8 {
    a + factor * (b - a)
}

fn burn(a: F32x8, by: F32x8) -> F32x8 {
    by.le(F32x8::ZERO).select(F32x8::ZERO, rest_of(rest_of(a) / by).clamp(0.0, 1.0))
}

fn dodge(a: F32x8, by: F32x8) -> F32x8 {
    let bright = by.le(F32x8::ZERO).select(F32x8::ONE, (a / by).min(F32x8::ONE));
    a.is_zero().select(F32x8::ZERO, bright)
}
