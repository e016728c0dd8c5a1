//! Conversions of colours to hue, saturation and value or lightness, and back.

use super::{finite, finite_vector};
use glam::Vec3;

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
