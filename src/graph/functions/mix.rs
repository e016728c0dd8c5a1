//! Blender's Mix node: blend types of colours, and mixtures of numbers and vectors.
//!
//! The node's options to clamp are the caller's: a factor to 0 to 1 before, a colour to 0 to 1 after.
use super::hue::{hsv_to_rgb, rgb_to_hsv};
use super::{each2, each3, finite, finite_vector, named};
use glam::Vec3;

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
    pub fn apply(self, factor: f32, a: Vec3, b: Vec3) -> Vec3 {
        finite_vector(match self {
            Self::Hue | Self::Saturation | Self::Color | Self::Value => self.of_hsv(factor, a, b),
            _ => each2(a, b, |a, b| self.of_channel(factor, a, b)),
        })
    }

    fn of_channel(self, t: f32, a: f32, b: f32) -> f32 {
        let rest = 1.0 - t;
        match self {
            Self::Mix => rest * a + t * b,
            Self::Darken => towards(a, a.min(b), t),
            Self::Multiply => a * (rest + t * b),
            Self::Burn => burn(a, rest + t * b),
            Self::Lighten => towards(a, a.max(b), t),
            Self::Screen => 1.0 - (rest + t * (1.0 - b)) * (1.0 - a),
            Self::Dodge => dodge(a, 1.0 - t * b),
            Self::Add => a + t * b,
            Self::Overlay if a < 0.5 => a * (rest + 2.0 * t * b),
            Self::Overlay => 1.0 - (rest + 2.0 * t * (1.0 - b)) * (1.0 - a),
            Self::SoftLight => rest * a + t * ((1.0 - a) * b * a + a * (1.0 - (1.0 - b) * (1.0 - a))),
            Self::LinearLight => a + t * (2.0 * b - 1.0),
            Self::Difference => towards(a, (a - b).abs(), t),
            Self::Exclusion => towards(a, a + b - 2.0 * a * b, t).max(0.0),
            Self::Subtract => a - t * b,
            Self::Divide if b == 0.0 => a,
            Self::Divide => rest * a + t * a / b,
            Self::Hue | Self::Saturation | Self::Color | Self::Value => 0.0,
        }
    }

    fn of_hsv(self, t: f32, a: Vec3, b: Vec3) -> Vec3 {
        let (from, to) = (rgb_to_hsv(a), rgb_to_hsv(b));
        match self {
            Self::Saturation if from.y == 0.0 => a,
            Self::Saturation => hsv_to_rgb(Vec3::new(from.x, float(t, from.y, to.y), from.z)),
            Self::Value => hsv_to_rgb(Vec3::new(from.x, from.y, float(t, from.z, to.z))),
            // What has no hue has none to give.
            _ if to.y == 0.0 => a,
            Self::Hue => a + (hsv_to_rgb(Vec3::new(to.x, from.y, from.z)) - a) * t,
            _ => a + (hsv_to_rgb(Vec3::new(to.x, to.y, from.z)) - a) * t,
        }
    }
}

/// A mixture of two numbers: `a` at a factor of 0, `b` at 1, and beyond them outside of 0 to 1.
pub fn float(factor: f32, a: f32, b: f32) -> f32 {
    finite((1.0 - factor) * a + factor * b)
}

/// A mixture of two vectors with one factor, as Blender's option "uniform" has it.
pub fn vector(factor: f32, a: Vec3, b: Vec3) -> Vec3 {
    each2(a, b, |a, b| float(factor, a, b))
}

/// A mixture of two vectors with a factor for each component, as Blender's option "non-uniform" has it.
pub fn vector_non_uniform(factor: Vec3, a: Vec3, b: Vec3) -> Vec3 {
    each3(factor, a, b, float)
}

fn towards(a: f32, b: f32, factor: f32) -> f32 {
    a + factor * (b - a)
}

fn burn(a: f32, by: f32) -> f32 {
    if by <= 0.0 { 0.0 } else { (1.0 - (1.0 - a) / by).clamp(0.0, 1.0) }
}

fn dodge(a: f32, by: f32) -> f32 {
    match a {
        0.0 => 0.0,
        _ if by <= 0.0 => 1.0,
        _ => (a / by).min(1.0),
    }
}
