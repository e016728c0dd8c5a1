//! Blender's nodes of colours: conversions to hue and back, and what adjusts colours. Colours are linear, and of any size.
use super::math::fraction;
use super::{each, finite, finite_vector, mix, named};
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

/// Hue (0 to 1), saturation, and value of a colour. Greys have hue and saturation 0, and black has.
pub fn rgb_to_hsv(color: Vec3) -> Vec3 {
    let value = color.max_element();
    let range = value - color.min_element();
    let saturation = if value == 0.0 { 0.0 } else { range / value };
    let hue = if saturation == 0.0 { 0.0 } else { hue(color, value, range) };
    finite_vector(Vec3::new(hue, saturation, value))
}

/// The colour of hue (0 to 1), saturation, and value. Hues outside of 0 to 1 are as in the last sixth, red to magenta.
pub fn hsv_to_rgb(hsv: Vec3) -> Vec3 {
    let Vec3 { x: hue, y: saturation, z: value } = hsv;
    if saturation == 0.0 {
        return Vec3::splat(finite(value));
    }
    let turned = if hue == 1.0 { 0.0 } else { hue * 6.0 };
    let sixth = turned.floor();
    let within = turned - sixth;
    let least = value * (1.0 - saturation);
    let falling = value * (1.0 - saturation * within);
    let rising = value * (1.0 - saturation * (1.0 - within));
    finite_vector(match sixth {
        0.0 => Vec3::new(value, rising, least),
        1.0 => Vec3::new(falling, value, least),
        2.0 => Vec3::new(least, value, rising),
        3.0 => Vec3::new(least, falling, value),
        4.0 => Vec3::new(rising, least, value),
        _ => Vec3::new(value, least, falling),
    })
}

/// Hue (0 to 1), saturation, and lightness (at most 1) of a colour. Greys have hue and saturation 0.
pub fn rgb_to_hsl(color: Vec3) -> Vec3 {
    let (most, least) = (color.max_element(), color.min_element());
    let lightness = ((most + least) / 2.0).min(1.0);
    if most == least {
        return finite_vector(Vec3::new(0.0, 0.0, lightness));
    }
    let range = most - least;
    let saturation = range / if lightness > 0.5 { 2.0 - most - least } else { most + least };
    finite_vector(Vec3::new(hue(color, most, range), saturation, lightness))
}

/// The colour of hue (0 to 1), saturation, and lightness. Hues outside of 0 to 1 are as that of the nearer end, red.
pub fn hsl_to_rgb(hsl: Vec3) -> Vec3 {
    let Vec3 { x: hue, y: saturation, z: lightness } = hsl;
    let turned = finite(hue * 6.0);
    let pure = Vec3::new((turned - 3.0).abs() - 1.0, 2.0 - (turned - 2.0).abs(), 2.0 - (turned - 4.0).abs());
    let chroma = (1.0 - (2.0 * lightness - 1.0).abs()) * saturation;
    finite_vector((pure.clamp(Vec3::ZERO, Vec3::ONE) - 0.5) * chroma + lightness)
}

/// The hue of a colour that is no grey, 0 to 1, from its largest channel and the distance to its smallest one.
fn hue(color: Vec3, most: f32, range: f32) -> f32 {
    let sixths = if color.x == most {
        (color.y - color.z) / range
    } else if color.y == most {
        2.0 + (color.z - color.x) / range
    } else {
        4.0 + (color.x - color.y) / range
    };
    if sixths < 0.0 { sixths / 6.0 + 1.0 } else { sixths / 6.0 }
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
