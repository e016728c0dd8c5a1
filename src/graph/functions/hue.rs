//! Conversions of colours to hue, saturation and value or lightness, and back.

use super::rest_of;
use crate::lanes::{F32x8, Vec3x8};

/// Hue (0 to 1), saturation, and value of a colour. Greys have hue and saturation 0, and black has.
pub fn rgb_to_hsv(color: Vec3x8) -> Vec3x8 {
    let value = color.max_element();
    let range = value - color.min_element();
    let saturation = value.is_zero().select(F32x8::ZERO, range / value);
    let hue = saturation.is_zero().select(F32x8::ZERO, hue(color, value, range));
    Vec3x8::from([hue, saturation, value]).finite_or_zero()
}

/// The colour of hue (0 to 1), saturation, and value. Hues outside of 0 to 1 are as in the last sixth, red to magenta.
pub fn hsv_to_rgb(hsv: Vec3x8) -> Vec3x8 {
    let Vec3x8 { x: hue, y: saturation, z: value } = hsv;
    let turned = hue.equals(F32x8::ONE).select(F32x8::ZERO, hue * 6.0);
    let sixth = turned.floor();
    let within = turned - sixth;
    let least = value * rest_of(saturation);
    let falling = value * rest_of(saturation * within);
    let rising = value * rest_of(saturation * rest_of(within));
    let sixths = [
        [value, rising, least],
        [falling, value, least],
        [least, value, rising],
        [least, falling, value],
        [rising, least, value],
    ];
    let last = Vec3x8::from([value, least, falling]);
    let color = sixths.into_iter().enumerate().fold(last, |color, (number, of_sixth)| {
        sixth.equals(F32x8::splat(number as f32)).select3(of_sixth.into(), color)
    });
    saturation.is_zero().select3(Vec3x8::all_of(value), color).finite_or_zero()
}

/// Hue (0 to 1), saturation, and lightness (at most 1) of a colour. Greys have hue and saturation 0.
pub fn rgb_to_hsl(color: Vec3x8) -> Vec3x8 {
    let (most, least) = (color.max_element(), color.min_element());
    let lightness = ((most + least) / 2.0).min(F32x8::ONE);
    let range = most - least;
    let is_light = lightness.gt(F32x8::splat(0.5));
    let saturation = range / is_light.select(F32x8::splat(2.0) - most - least, most + least);
    let is_gray = most.equals(least);
    let of_color = |value: F32x8| is_gray.select(F32x8::ZERO, value);
    Vec3x8::from([of_color(hue(color, most, range)), of_color(saturation), lightness]).finite_or_zero()
}

/// The colour of hue (0 to 1), saturation, and lightness. Hues outside of 0 to 1 are as that of the nearer end, red.
pub fn hsl_to_rgb(hsl: Vec3x8) -> Vec3x8 {
    let Vec3x8 { x: hue, y: saturation, z: lightness } = hsl;
    let turned = (hue * 6.0).finite_or_zero();
    let away = |from: f32| (turned - from).abs();
    let pure = [away(3.0) - 1.0, F32x8::splat(2.0) - away(2.0), F32x8::splat(2.0) - away(4.0)];
    let chroma = rest_of((lightness * 2.0 - 1.0).abs()) * saturation;
    Vec3x8::from(pure.map(|channel| (channel.clamp(0.0, 1.0) - 0.5) * chroma + lightness)).finite_or_zero()
}

/// The hue of a colour that is no grey, 0 to 1, from its largest channel and the distance to its smallest one.
fn hue(color: Vec3x8, most: F32x8, range: F32x8) -> F32x8 {
    let Vec3x8 { x: red, y: green, z: blue } = color;
    let of_green = (blue - red) / range + 2.0;
    let of_blue = (red - green) / range + 4.0;
    let others = green.equals(most).select(of_green, of_blue);
    let sixths = red.equals(most).select((green - blue) / range, others);
    let turned = sixths / 6.0;
    sixths.lt(F32x8::ZERO).select(turned + 1.0, turned)
}
