//! Colours of lights that state a temperature (UsdLux, `colorTemperature`).

use glam::{DMat3, DVec3};

/// Temperature at which light is white, Kelvin.
pub const WHITE: f64 = 6500.0;

/// Temperatures for which the curve below was fitted, Kelvin.
const FITTED: [f64; 2] = [1667.0, 25_000.0];

/// From CIE XYZ to linear Rec. 709 (IEC 61966-2-1), column by column.
const TO_RGB: DMat3 = DMat3::from_cols_array(&[
    3.2406, -0.9689, 0.0557, //
    -1.5372, 1.8758, -0.2040, //
    -0.4986, 0.0415, 1.0570,
]);

/// Shares of red, green and blue in luminance (Rec. 709).
const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);

/// Colour of a black body at this temperature in Kelvin: linear Rec. 709, of luminance 1, and white at [`WHITE`].
pub fn color(kelvin: f64) -> DVec3 {
    let color = black_body(kelvin.clamp(FITTED[0], FITTED[1])) / black_body(WHITE);
    color / LUMINANCE.dot(color)
}

/// Colour of a black body, of luminance 1, beside the white of Rec. 709.
///
/// A fit to Planck's curve in CIE xy (Kim and others, US patent 7024034, 2006).
fn black_body(kelvin: f64) -> DVec3 {
    let cubic = |[a, b, c, d]: [f64; 4], x: f64| ((a * x + b) * x + c) * x + d;
    let x = if kelvin <= 4000.0 {
        cubic([-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910], 1000.0 / kelvin)
    } else {
        cubic([-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390], 1000.0 / kelvin)
    };
    let y = if kelvin <= 2222.0 {
        cubic([-1.106_381_4, -1.348_110_2, 2.185_558_32, -0.202_196_83], x)
    } else if kelvin <= 4000.0 {
        cubic([-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67], x)
    } else {
        cubic([3.081_758, -5.873_386_7, 3.751_129_97, -0.370_014_83], x)
    };
    (TO_RGB * DVec3::new(x / y, 1.0, (1.0 - x - y) / y)).max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warm_light_is_red_and_cold_light_is_blue() {
        assert!(color(WHITE).abs_diff_eq(DVec3::ONE, 1e-12));
        let mut last = f64::INFINITY;
        for kelvin in [500.0, 1800.0, 2222.1, 3000.0, 3999.0, 4001.0, 5500.0, 9000.0, 20_000.0, 1e9] {
            let color = color(kelvin);
            let warmth = color.x / color.z.max(1e-3);
            assert!(warmth < last && (LUMINANCE.dot(color) - 1.0).abs() < 1e-12, "{kelvin}: {color}");
            last = warmth;
        }
        // a bulb of 3000 K beside daylight (CIE 1931: x 0.4369, y 0.4041)
        let bulb = black_body(3000.0);
        let known = TO_RGB * DVec3::new(0.4369 / 0.4041, 1.0, 0.1590 / 0.4041);
        assert!(bulb.abs_diff_eq(known, 5e-3), "{bulb} {known}");
    }
}
