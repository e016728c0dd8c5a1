//! Conversion of a frame's light to a screen's: exposure, then a view transform. EXR files are not affected.

use crate::settings::{Look, View};

/// Converts linear red, green and blue of a frame to light on a screen, as shares of its white, each 0 to 1.
/// NaN becomes 0.
pub fn on_screen(look: Look) -> impl Fn([f32; 3]) -> [f32; 3] {
    let scale = look.exposure.exp2();
    move |color| {
        let exposed = color.map(|light| if light.is_nan() { 0.0 } else { light * scale });
        match look.view {
            View::Standard => exposed.map(|light| light.clamp(0.0, 1.0)),
            View::Filmic => exposed.map(filmic),
            View::Agx => agx(exposed).map(light_of_srgb),
        }
    }
}

/// The inverse of sRGB's curve (IEC 61966-2-1): linear light of an encoded value from 0 to 1.
#[must_use]
pub fn light_of_srgb(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// John Hable's curve for Uncharted 2 ("Filmic Tonemapping Operators", 2010), with his constants: a toe, a straight part and a
/// shoulder, of each channel by itself. White is where a frame has [`FILMIC_WHITE`].
fn filmic(light: f32) -> f32 {
    /// He exposes by a stop before his curve.
    const EXPOSURE: f32 = 2.0;
    (hable(light.clamp(0.0, FILMIC_WHITE) * EXPOSURE) / hable(FILMIC_WHITE * EXPOSURE)).clamp(0.0, 1.0)
}

/// His linear white point, 11.2, before his exposure.
const FILMIC_WHITE: f32 = 5.6;

fn hable(x: f32) -> f32 {
    let [shoulder, linear, angle, toe, toe_above, toe_below] = [0.15, 0.50, 0.10, 0.20, 0.02, 0.30];
    let above = x * (shoulder * x + angle * linear) + toe * toe_above;
    let below = x * (shoulder * x + linear) + toe * toe_below;
    above / below - toe_above / toe_below
}

/// AgX by Troy Sobotka (<https://github.com/sobotka/AgX>), its base look, for displays with Rec. 709 primaries: as encoded for
/// them. Colours are moved towards grey, so that bright ones become white rather than another hue; brightness goes through a sigmoid
/// over 16.5 stops, on a logarithmic scale; and they are moved back, as in Benjamin Wrensch's "Minimal AgX Implementation" (2023),
/// whose matrices are [`towards_grey`] written out.
fn agx(color: [f32; 3]) -> [f32; 3] {
    /// Exposure range in stops from middle grey: beyond it there is only black, or white.
    const STOPS: [f32; 2] = [-10.0, 6.5];
    const MIDDLE_GREY: f32 = 0.18;
    /// Share of grey in each colour under the curve.
    const SHARE: f32 = 0.2;
    let finite = color.map(|light| light.clamp(0.0, f32::MAX));
    let curved = towards_grey(finite, SHARE).map(|light| {
        let stops = (light / MIDDLE_GREY).log2();
        agx_curve(((stops - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(0.0, 1.0))
    });
    towards_grey(curved, -SHARE / (1.0 - SHARE)).map(|value| value.clamp(0.0, 1.0))
}

/// Blends each channel with this share of the colour's grey. Because grey stays, a share of -s / (1 - s)
/// gives the inverse of that with s.
fn towards_grey(color: [f32; 3], share: f32) -> [f32; 3] {
    /// Red, green and blue of AgX's grey.
    const WEIGHTS: [f32; 3] = [0.212_005, 0.392_183, 0.395_812];
    let grey: f32 = color.iter().zip(WEIGHTS).map(|(light, weight)| light * weight).sum();
    color.map(|light| light + share * (grey - light))
}

/// AgX's sigmoid from 0 to 0 and from 1 to 1: through middle grey, where it is steepest, with a slope of 2, and bent by a power on
/// either side.
fn agx_curve(x: f32) -> f32 {
    /// Middle grey on the scale of stops, and on the screen's.
    const PIVOT: [f32; 2] = [10.0 / 16.5, 0.5];
    const SLOPE: f32 = 2.0;
    const TOE: f32 = 3.0;
    const SHOULDER: f32 = 3.25;
    // how far it is from the pivot to the end of the curve
    let (power, end) = if x < PIVOT[0] { (TOE, PIVOT[0]) } else { (SHOULDER, 1.0 - PIVOT[0]) };
    let distance = (x - PIVOT[0]).abs();
    // so that the curve ends half a screen away from the pivot
    let bend = ((SLOPE * end / PIVOT[1]).powf(power) - 1.0) / end.powf(power);
    let height = SLOPE * distance / (1.0 + bend * distance.powf(power)).powf(1.0 / power);
    PIVOT[1] + height.copysign(x - PIVOT[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::png::srgb_byte;

    const VIEWS: [View; 3] = [View::Standard, View::Filmic, View::Agx];

    fn bytes(view: View, exposure: f32, color: [f32; 3]) -> [u8; 3] {
        on_screen(Look { exposure, view })(color).map(srgb_byte)
    }

    #[test]
    fn without_a_look_bytes_are_those_of_the_curve_alone() {
        for light in (0..4000).map(|i| i as f32 * 3e-4).chain([-1.0, 7.0, f32::INFINITY, f32::NAN]) {
            assert_eq!(bytes(View::Standard, 0.0, [light; 3]), [srgb_byte(light); 3], "{light}");
        }
    }

    #[test]
    fn a_stop_is_twice_the_light() {
        for view in VIEWS {
            for light in [0.01, 0.18, 0.7] {
                let color = [light, 0.5 * light, 0.1];
                assert_eq!(
                    bytes(view, 2.0, color),
                    bytes(view, 0.0, color.map(|light| 4.0 * light)),
                    "{view:?}"
                );
            }
        }
        assert_eq!(bytes(View::Standard, -1.0, [1.0; 3]), [188; 3], "half of the light");
    }

    #[test]
    fn black_stays_black_and_what_is_no_number_is() {
        for view in VIEWS {
            for black in [0.0, -0.5, f32::NEG_INFINITY, f32::NAN] {
                assert_eq!(bytes(view, 3.0, [black; 3]), [0; 3], "{view:?} {black}");
            }
            assert_eq!(bytes(view, 0.0, [f32::INFINITY; 3]), [255; 3], "{view:?}");
        }
    }

    #[test]
    fn white_is_where_each_view_has_it() {
        // in stops above 1: at once; 11.2 after a stop of exposure; 6.5 stops above middle grey
        for (view, white) in [(View::Standard, 1.0), (View::Filmic, 5.6), (View::Agx, 0.18 * 6.5_f32.exp2())]
        {
            assert_eq!(bytes(view, 0.0, [white; 3]), [255; 3], "{view:?}");
            assert!(bytes(view, 0.0, [0.7 * white; 3])[0] < 255, "{view:?}");
        }
    }

    #[test]
    fn brighter_is_never_darker() {
        for view in VIEWS {
            let greys: Vec<u8> = (-120..80).map(|i| bytes(view, i as f32 * 0.1, [0.18; 3])[0]).collect();
            assert!(greys.windows(2).all(|pair| pair[0] <= pair[1]), "{view:?} {greys:?}");
            // most of the bytes are used
            assert!(greys.first() < Some(&4) && greys.last() == Some(&255), "{view:?}");
        }
    }

    #[test]
    fn the_filmic_curve_has_known_values() {
        // his formula with his constants put in
        let at = |x: f64| (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.02 / 0.3;
        for light in [0.01, 0.18, 1.0, 4.0] {
            let wanted = at(2.0 * light) / at(11.2);
            let found = f64::from(filmic(light as f32));
            assert!((found - wanted).abs() < 1e-5, "{light}: {found} {wanted}");
        }
        assert!((f64::from(filmic(1.0)) - 0.4929).abs() < 1e-3, "{}", filmic(1.0));
    }

    #[test]
    fn agx_has_middle_grey_in_the_middle_and_the_slope_of_its_source() {
        assert!((agx([0.18; 3])[0] - 0.5).abs() < 1e-3);
        let steep = (agx_curve(0.61) - agx_curve(0.60)) / 0.01;
        assert!((steep - 2.0).abs() < 0.01, "{steep}");
        // the polynomial that Wrensch fitted to the table of AgX, with a mean squared error of 3.7e-6
        let fitted = |x: f32| {
            let [a, b, c, d, e, f, g] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
            (((((a * x + b) * x + c) * x + d) * x + e) * x + f) * x + g
        };
        let apart = (0..=100).map(|i| (agx_curve(i as f32 / 100.0) - fitted(i as f32 / 100.0)).abs());
        assert!(apart.clone().all(|apart| apart < 0.02), "{:?}", apart.fold(0.0, f32::max));
    }

    /// As published: 0.84247906 0.0784336 0.07922375 for red, 0.04232824 0.87846864 0.07916613 for green.
    #[test]
    fn agx_moves_colours_towards_grey_as_its_matrices_do() {
        for (color, red, green) in [
            ([1.0, 0.0, 0.0], 0.842_479, 0.042_328),
            ([0.0, 1.0, 0.0], 0.078_434, 0.878_469),
            ([0.0, 0.0, 1.0], 0.079_224, 0.079_166),
        ] {
            let moved = towards_grey(color, 0.2);
            assert!((moved[0] - red).abs() < 2e-4 && (moved[1] - green).abs() < 2e-4, "{moved:?}");
            let back = towards_grey(moved, -0.25);
            assert!(back.iter().zip(color).all(|(back, color)| (back - color).abs() < 1e-6), "{back:?}");
        }
    }

    #[test]
    fn in_agx_a_bright_colour_becomes_white() {
        let at = |exposure| bytes(View::Agx, exposure, [1.0, 0.1, 0.02]);
        let [low, high] = [0.0, 8.0].map(at);
        assert!(low[0] - low[2] > 100 && high[2] > 230, "{low:?} {high:?}");
    }
}
