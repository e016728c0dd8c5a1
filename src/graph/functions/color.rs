//! Blender's nodes of colours: conversions to hue and back, and what adjusts colours. Colours are linear, and of any size.
pub use super::hue::{hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv};
use super::{fraction, mix, named, rest_of};
use crate::lanes::{F32x8, Vec3x8};

named! {
    /// A mode of Blender's Separate Color and Combine Color nodes.
    Model {
        /// Red, green, blue.
        Rgb = "rgb",
        /// Hue, saturation, value.
        Hsv = "hsv",
        /// Hue, saturation, lightness.
        Hsl = "hsl",
    }
}

impl Model {
    /// The channels of a linear colour, as Separate Color gives them. Hues are 0 to 1.
    pub fn separate(self, color: Vec3x8) -> Vec3x8 {
        match self {
            Self::Rgb => color,
            Self::Hsv => rgb_to_hsv(color),
            Self::Hsl => rgb_to_hsl(color),
        }
    }

    /// The linear colour of channels, as Combine Color gives it.
    pub fn combine(self, channels: Vec3x8) -> Vec3x8 {
        match self {
            Self::Rgb => channels,
            Self::Hsv => hsv_to_rgb(channels),
            Self::Hsl => hsl_to_rgb(channels),
        }
    }
}

/// What Blender's Hue/Saturation/Value node changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Adjustment {
    /// A turn of the hue: 0.5 leaves it, 0 and 1 turn it to its opposite.
    pub hue: F32x8,
    /// What the saturation is multiplied by; the product is clamped to 0 to 1.
    pub saturation: F32x8,
    /// What the value is multiplied by.
    pub value: F32x8,
    /// How much of the result is mixed with the colour itself: 0 to 1.
    pub factor: F32x8,
}

impl Adjustment {
    /// The colour that Blender's Hue/Saturation/Value node makes: no channel is negative.
    pub fn apply(&self, color: Vec3x8) -> Vec3x8 {
        let hsv = rgb_to_hsv(color);
        let hue = fraction(hsv.x + self.hue + 0.5);
        let saturation = (hsv.y * self.saturation).finite_or_zero().clamp(0.0, 1.0);
        let adjusted = hsv_to_rgb([hue, saturation, hsv.z * self.value].into());
        mix::vector(self.factor, color, adjusted).max(Vec3x8::ZERO)
    }
}

/// Blender's Brightness/Contrast node: no channel of the result is negative.
pub fn brightness_contrast(color: Vec3x8, brightness: F32x8, contrast: F32x8) -> Vec3x8 {
    let (gain, offset) = (contrast + 1.0, brightness - contrast * 0.5);
    color.each(|channel| (gain * channel + offset).max(F32x8::ZERO).finite_or_zero())
}

/// Blender's Gamma node: channels to the power of gamma, where they are positive. White, where gamma is 0.
pub fn gamma(color: Vec3x8, gamma: F32x8) -> Vec3x8 {
    let of_channel = |channel: f32, gamma: f32| match gamma {
        0.0 => 1.0,
        _ if channel > 0.0 => channel.powf(gamma),
        _ => channel,
    };
    color.each(|channel| channel.each_with(gamma, of_channel).finite_or_zero())
}

/// Blender's Invert Color node: `1 - color`, mixed with the colour itself by a factor.
pub fn invert(factor: F32x8, color: Vec3x8) -> Vec3x8 {
    mix::vector(factor, color, color.each(rest_of))
}

/// The luminance of a linear colour with the primaries of Rec. 709: Blender's RGB to BW node, and what a colour is as a number.
pub fn luma(color: Vec3x8) -> F32x8 {
    (color.x * 0.212_639 + color.y * 0.715_168_7 + color.z * 0.072_192_3).finite_or_zero()
}
