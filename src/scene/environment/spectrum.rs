//! Spectrum of the sun, its attenuation by the air, and the resulting colour.
//!
//! Formulas and the spectrum are those of appendix 1 of Preetham, Shirley and Smits (1999), which follow
//! Iqbal's "An Introduction to Solar Radiation" (1983).

use glam::{DMat3, DVec3, Vec3};

/// CIE 1931 tristimulus values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Xyz(DVec3);

impl Xyz {
    /// Creates a colour of the chromaticity x, y and the luminance Y.
    pub fn of_chromaticity(x: f64, y: f64, luminance: f64) -> Self {
        Self(DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance)
    }

    pub fn scaled(self, factor: f64) -> Self {
        Self(self.0 * factor)
    }

    /// Converts to linear RGB with Rec. 709 primaries and a white of D65. Colours beyond these primaries
    /// become the nearest that have no negative part.
    pub fn to_rgb(self) -> Vec3 {
        const RGB_OF_XYZ: DMat3 = DMat3::from_cols_array_2d(&[
            [3.240_454_2, -0.969_266_0, 0.055_643_4],
            [-1.537_138_5, 1.876_010_8, -0.204_025_9],
            [-0.498_531_4, 0.041_556_0, 1.057_225_2],
        ]);
        (RGB_OF_XYZ * self.0).max(DVec3::ZERO).as_vec3()
    }
}

/// Colour of the sun at `zenith_angle` degrees (at most 90) from the zenith, after its light crossed air of
/// that turbidity. Y is the luminance of the disk in cd/m².
pub(super) fn sunlight(zenith_angle: f64, turbidity: f64) -> Xyz {
    /// Lumens a watt at the wavelength to which the eye is most sensitive.
    const LUMENS: f64 = 683.0;
    /// Factor from W cm⁻² µm⁻¹ sr⁻¹ to W m⁻² nm⁻¹ sr⁻¹.
    const SQUARE_METRES: f64 = 10.0;
    let air = Air::new(zenith_angle, turbidity);
    let mut sum = DVec3::ZERO;
    for (step, [radiance, ozone, vapour]) in (0..).zip(SUN) {
        let wavelength = FIRST + STEP * f64::from(step);
        sum += observer(wavelength) * (radiance * air.transmittance(wavelength, ozone, vapour));
    }
    Xyz(sum * (LUMENS * SQUARE_METRES * STEP))
}

/// Air along the path of the light.
struct Air {
    /// Relative air mass: 1 towards the zenith.
    mass: f64,
    /// Ångström's turbidity coefficient, of aerosols.
    beta: f64,
}

impl Air {
    fn new(zenith_angle: f64, turbidity: f64) -> Self {
        let slant = 0.15 * (93.885 - zenith_angle).powf(-1.253);
        Self { mass: 1.0 / (zenith_angle.to_radians().cos() + slant), beta: 0.046_08 * turbidity - 0.045_86 }
    }

    /// Share of light of `wavelength` (nm) that arrives, where ozone and water vapour absorb as given. (Mixed gases
    /// absorb only light that is not seen.)
    fn transmittance(&self, wavelength: f64, ozone: f64, vapour: f64) -> f64 {
        /// Exponent of Ångström's law.
        const ALPHA: f64 = 1.3;
        /// Thickness of the ozone layer, cm.
        const OZONE: f64 = 0.35;
        /// Precipitable water, cm.
        const WATER: f64 = 2.0;
        let (micrometres, mass) = (wavelength / 1000.0, self.mass);
        let molecules = 0.008_735 * micrometres.powf(-4.08) * mass;
        let aerosols = self.beta * micrometres.powf(-ALPHA) * mass;
        let water = vapour * WATER * mass;
        let absorbed = 0.2385 * water / (1.0 + 20.07 * water).powf(0.45);
        (-(molecules + aerosols + ozone * OZONE * mass + absorbed)).exp()
    }
}

/// The CIE 1931 observer at `wavelength` (nm), by the fit of C. Wyman, P.-P. Sloan and P. Shirley, "Simple Analytic
/// Approximations to the CIE XYZ Color Matching Functions" (JCGT 2013).
fn observer(wavelength: f64) -> DVec3 {
    let lobe = |height: f64, center: f64, below: f64, above: f64| {
        let width = if wavelength < center { below } else { above };
        height * (-0.5 * ((wavelength - center) / width).powi(2)).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

/// First wavelength of [`SUN`] and the distance to the next one, nm.
const FIRST: f64 = 380.0;
const STEP: f64 = 10.0;

/// Spectrum by wavelength: radiance of the sun outside of the air (W cm⁻² µm⁻¹ sr⁻¹), absorption of ozone
/// (cm⁻¹) and of water vapour (cm⁻¹).
const SUN: [[f64; 3]; 38] = [
    [1655.9, 0.0, 0.0],
    [1623.4, 0.0, 0.0],
    [2112.8, 0.0, 0.0],
    [2588.8, 0.0, 0.0],
    [2582.9, 0.0, 0.0],
    [2423.2, 0.0, 0.0],
    [2676.1, 0.0, 0.0],
    [2965.8, 0.003, 0.0],
    [3054.5, 0.006, 0.0],
    [3005.8, 0.009, 0.0],
    [3066.4, 0.014, 0.0],
    [2883.0, 0.021, 0.0],
    [2871.2, 0.030, 0.0],
    [2782.5, 0.040, 0.0],
    [2710.1, 0.048, 0.0],
    [2723.4, 0.063, 0.0],
    [2636.1, 0.075, 0.0],
    [2550.4, 0.085, 0.0],
    [2506.0, 0.103, 0.0],
    [2531.2, 0.120, 0.0],
    [2535.6, 0.120, 0.0],
    [2513.4, 0.115, 0.0],
    [2463.2, 0.125, 0.0],
    [2417.3, 0.120, 0.0],
    [2368.4, 0.105, 0.0],
    [2321.2, 0.090, 0.0],
    [2282.8, 0.079, 0.0],
    [2235.0, 0.067, 0.0],
    [2197.0, 0.057, 0.0],
    [2152.7, 0.048, 0.0],
    [2109.8, 0.036, 0.0],
    [2072.8, 0.028, 0.016],
    [2024.0, 0.023, 0.024],
    [1987.1, 0.018, 0.0125],
    [1942.7, 0.014, 1.0],
    [1907.2, 0.011, 0.87],
    [1862.9, 0.010, 0.061],
    [1825.9, 0.009, 0.001],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_observer_has_its_known_integrals_and_white_is_white() {
        let sum: DVec3 = (360..=830).map(|wavelength| observer(f64::from(wavelength))).sum();
        // of the tables: 106.9 each
        assert!((sum - 106.9).abs().max_element() < 1.0, "{sum}");
        let white = Xyz::of_chromaticity(0.3127, 0.3290, 1.0).to_rgb();
        assert!(white.abs_diff_eq(Vec3::ONE, 1e-3), "{white}");
        assert_eq!(Xyz::of_chromaticity(0.08, 0.83, 1.0).to_rgb().x, 0.0, "greener than the primaries");
    }

    #[test]
    fn the_air_takes_more_of_low_and_of_blue_light() {
        let of = |zenith_angle, turbidity| sunlight(zenith_angle, turbidity).0;
        let (noon, low) = (of(0.0, 2.0), of(88.0, 2.0));
        assert!(low.y < 0.3 * noon.y && low.z / low.y < 0.5 * noon.z / noon.y, "{noon} {low}");
        assert!(of(0.0, 8.0).y < 0.8 * noon.y);
        let air = Air::new(0.0, 2.0);
        assert!((air.mass - 1.0).abs() < 1e-3);
        assert!((Air::new(90.0, 2.0).mass - 36.5).abs() < 1.0, "{}", Air::new(90.0, 2.0).mass);
        assert!(air.transmittance(450.0, 0.0, 0.0) < air.transmittance(650.0, 0.0, 0.0));
    }

    #[test]
    fn the_sun_outside_of_the_air_gives_about_127_kilolux() {
        let empty = Air { mass: 0.0, beta: 0.0 };
        assert_eq!(empty.transmittance(500.0, 1.0, 1.0), 1.0);
        let sum: f64 =
            (0..).zip(SUN).map(|(step, [sun, ..])| sun * observer(FIRST + STEP * f64::from(step)).y).sum();
        let disk = std::f64::consts::TAU * (1.0 - 0.265_f64.to_radians().cos());
        let kilolux = sum * 683.0 * 10.0 * STEP * disk / 1000.0;
        assert!((115.0..140.0).contains(&kilolux), "{kilolux}");
    }
}
