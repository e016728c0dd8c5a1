//! Blender's nodes of colours: conversions to hue and back, and what adjusts colours. Colours are linear, and of any size.
pub use super::hue::{hsl_to_rgb, hsv_to_rgb, rgb_to_hsl, rgb_to_hsv};
use super::math::fraction;
use super::{each, finite, mix, named};
use glam::Vec3;

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
    pub fn separate(self, color: Vec3) -> Vec3 {
        match self {
            Self::Rgb => color,
            Self::Hsv => rgb_to_hsv(color),
            Self::Hsl => rgb_to_hsl(color),
        }
    }

    /// The linear colour of channels, as Combine Color gives it.
    pub fn combine(self, channels: Vec3) -> Vec3 {
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
    pub hue: f32,
    /// What the saturation is multiplied by; the product is clamped to 0 to 1.
    pub saturation: f32,
    /// What the value is multiplied by.
    pub value: f32,
    /// How much of the result is mixed with the colour itself: 0 to 1.
    pub factor: f32,
}

impl Adjustment {
    /// The colour that Blender's Hue/Saturation/Value node makes: no channel is negative.
    pub fn apply(&self, color: Vec3) -> Vec3 {
        let hsv = rgb_to_hsv(color);
        let hue = fraction(hsv.x + self.hue + 0.5);
        let saturation = finite(hsv.y * self.saturation).clamp(0.0, 1.0);
        let adjusted = hsv_to_rgb(Vec3::new(hue, saturation, hsv.z * self.value));
        mix::vector(self.factor, color, adjusted).max(Vec3::ZERO)
    }
}

/// Blender's Brightness/Contrast node: no channel of the result is negative.
pub fn brightness_contrast(color: Vec3, brightness: f32, contrast: f32) -> Vec3 {
    let (gain, offset) = (1.0 + contrast, brightness - contrast * 0.5);
    each(color, |channel| finite((gain * channel + offset).max(0.0)))
}

/// Blender's Gamma node: channels to the power of gamma, where they are positive. White, where gamma is 0.
pub fn gamma(color: Vec3, gamma: f32) -> Vec3 {
    if gamma == 0.0 {
        return Vec3::ONE;
    }
    each(color, |channel| finite(if channel > 0.0 { channel.powf(gamma) } else { channel }))
}

/// Blender's Invert Color node: `1 - color`, mixed with the colour itself by a factor.
pub fn invert(factor: f32, color: Vec3) -> Vec3 {
    mix::vector(factor, color, 1.0 - color)
}

/// The luminance of a linear colour with the primaries of Rec. 709: Blender's RGB to BW node, and what a colour is as a number.
pub fn luma(color: Vec3) -> f32 {
    finite(color.dot(Vec3::new(0.212_639, 0.715_168_7, 0.072_192_3)))
}
