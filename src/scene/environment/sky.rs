//! The clear sky and the sun, after A. J. Preetham, P. Shirley and B. Smits, "A Practical Analytic Model for Daylight"
//! (SIGGRAPH 1999).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec3, Vec3};

use super::spectrum::{Xyz, sunlight};
use super::sun::Sun;

/// Radiance and irradiance, in the units of pictures, that stand for 1 kcd/m² and for 1 klx. The paper's
/// clear sky has some 3 to 15 kcd/m² around noon.
pub(super) const UNITS_A_KILO: f64 = 0.1;

/// Angular diameter of the sun's disk, degrees.
const SUN_DIAMETER: f64 = 0.53;

/// Columns and rows of the sky's grid. A row ends at the horizon.
const SIZE: [u32; 2] = [512, 256];

/// Loss of brightness for each degree of the sun below the horizon, as a power of 10: outdoors it is about
/// 700 lx when the sun sets, and 3.4 lx at -6 degrees, the end of civil twilight. The paper ends at the
/// horizon.
const TWILIGHT: f64 = 0.385;

/// Parameters of a clear sky.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sky {
    /// Elevation of the sun above the horizon, degrees; within [`Sky::ELEVATIONS`].
    pub elevation: f64,
    /// Azimuth of the sun, degrees: 0 is -Z, 90 is +X.
    pub azimuth: f64,
    /// Haziness of the air: 2 is very clear, 3 clear, 6 hazy; within [`Sky::TURBIDITIES`].
    pub turbidity: f64,
    /// Albedo of the ground below the horizon, linear RGB from 0 to 1.
    pub ground: Vec3,
}

impl Default for Sky {
    fn default() -> Self {
        Self { elevation: 45.0, azimuth: 135.0, turbidity: 3.0, ground: Vec3::splat(0.2) }
    }
}

impl Sky {
    /// Lowest and highest elevation, in degrees.
    pub const ELEVATIONS: [f64; 2] = [-6.0, 90.0];
    /// Minimum and maximum turbidity. The fits of the paper turn negative soon below 2.
    pub const TURBIDITIES: [f64; 2] = [2.0, 10.0];

    /// Direction to the sun, unit length.
    pub fn to_sun(&self) -> DVec3 {
        direction(self.elevation, self.azimuth)
    }

    /// Disk of the sun; none if its centre is not above the horizon.
    pub fn sun(&self) -> Option<Sun> {
        let irradiance = (self.elevation > 0.0).then(|| self.sun_irradiance())?;
        Some(Sun::of_irradiance(self.to_sun().as_vec3(), SUN_DIAMETER, irradiance))
    }

    /// Computes the radiance of a grid that covers the sphere: width, height, and linear RGB row by row.
    /// Without the disk of the sun. Below the horizon it is the ground, lit by the sky and the sun.
    pub fn picture(&self) -> (u32, u32, Vec<f32>) {
        let [width, height] = SIZE;
        let model = Model::new(self);
        let mut sky = Vec::with_capacity((width * height) as usize);
        let mut irradiance = DVec3::ZERO;
        for row in 0..height / 2 {
            let [top, middle, bottom] =
                [0.0, 0.5, 1.0].map(|at| PI * (f64::from(row) + at) / f64::from(height));
            // what the row's cosines to the normal sum up to, over its solid angle
            let facing = (bottom.sin().powi(2) - top.sin().powi(2)) / 2.0 * TAU / f64::from(width);
            for column in 0..width {
                let azimuth = 360.0 * ((f64::from(column) + 0.5) / f64::from(width) - 0.5);
                let radiance = model.radiance(direction(90.0 - middle.to_degrees(), azimuth));
                irradiance += radiance.as_dvec3() * facing;
                sky.push(radiance);
            }
        }
        if self.elevation > 0.0 {
            irradiance += self.sun_irradiance().as_dvec3() * self.to_sun().y;
        }
        let ground = self.ground * (irradiance / PI).as_vec3();
        sky.resize((width * height) as usize, ground);
        (width, height, sky.iter().flat_map(Vec3::to_array).collect())
    }

    /// Irradiance by the sun on a surface that faces it.
    fn sun_irradiance(&self) -> Vec3 {
        let half = (SUN_DIAMETER / 2.0).to_radians();
        let solid_angle = TAU * (1.0 - half.cos());
        let lux = sunlight(90.0 - self.elevation, self.turbidity).scaled(solid_angle);
        lux.scaled(UNITS_A_KILO / 1000.0).to_rgb()
    }
}

/// Direction of unit length at these angles.
fn direction(elevation: f64, azimuth: f64) -> DVec3 {
    let ((up, out), (sin, cos)) = (elevation.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    DVec3::new(out * sin, up, -out * cos)
}

/// Perez' function of five coefficients (of the paper's section 3.1): relative radiance at the angle `theta` to
/// the zenith, given its cosine, and `gamma` to the sun.
#[derive(Clone, Copy)]
struct Perez([f64; 5]);

impl Perez {
    /// Computes coefficients as linear functions of the turbidity: factor and constant.
    fn new(turbidity: f64, coefficients: [[f64; 2]; 5]) -> Self {
        Self(coefficients.map(|[factor, constant]| factor * turbidity + constant))
    }

    fn at(&self, cos_theta: f64, gamma: f64) -> f64 {
        let Self([a, b, c, d, e]) = *self;
        (1.0 + a * (b / cos_theta).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
    }
}

/// Luminance and chromaticity all over the sky, for one position of the sun.
struct Model {
    to_sun: DVec3,
    /// Parts for Y in kcd/m², x and y: the function, and the value at the zenith over that of the function.
    parts: [(Perez, f64); 3],
}

impl Model {
    fn new(sky: &Sky) -> Self {
        let turbidity = sky.turbidity;
        // the sky of a sun below the horizon is that of sunset, darkened
        let elevation = sky.elevation.max(0.0);
        let dimmed = 10_f64.powf(TWILIGHT * sky.elevation.min(0.0));
        let theta = (90.0 - elevation).to_radians();
        let zenith = [
            luminance(turbidity, theta) * dimmed,
            chromaticity(&ZENITH_X, turbidity, theta),
            chromaticity(&ZENITH_Y, turbidity, theta),
        ];
        let parts = std::array::from_fn(|part| {
            let perez = Perez::new(turbidity, PEREZ[part]);
            (perez, zenith[part] / perez.at(1.0, theta))
        });
        Self { to_sun: direction(elevation, sky.azimuth), parts }
    }

    /// Linear RGB from `direction` (unit length, above the horizon).
    fn radiance(&self, direction: DVec3) -> Vec3 {
        let gamma = direction.dot(self.to_sun).clamp(-1.0, 1.0).acos();
        // just above the horizon: at it the quotient is infinite
        let cos_theta = direction.y.max(1e-3);
        let [luminance, x, y] = self.parts.map(|(perez, zenith)| zenith * perez.at(cos_theta, gamma));
        Xyz::of_chromaticity(x, y, luminance.max(0.0)).scaled(UNITS_A_KILO).to_rgb()
    }
}

/// Luminance at the zenith, kcd/m², for the sun at `theta` to it. (The paper's appendix 2, as all numbers
/// below.)
fn luminance(turbidity: f64, theta: f64) -> f64 {
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * theta.min(FRAC_PI_2));
    (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192
}

/// Chromaticity at the zenith, for the sun at `theta` to it. `fit`: rows for T², T and 1, columns for theta³,
/// theta², theta and 1.
fn chromaticity(fit: &[[f64; 4]; 3], turbidity: f64, theta: f64) -> f64 {
    let polynomial = |row: &[f64; 4]| row.iter().fold(0.0, |sum, factor| sum * theta + factor);
    fit.iter().fold(0.0, |sum, row| sum * turbidity + polynomial(row))
}

const ZENITH_X: [[f64; 4]; 3] = [
    [0.00166, -0.00375, 0.00209, 0.0],
    [-0.02903, 0.06377, -0.03202, 0.00394],
    [0.11693, -0.21196, 0.06052, 0.25886],
];

const ZENITH_Y: [[f64; 4]; 3] = [
    [0.00275, -0.00610, 0.00317, 0.0],
    [-0.04214, 0.08970, -0.04153, 0.00516],
    [0.15346, -0.26756, 0.06670, 0.26688],
];

/// Coefficients A to E for Y, x and y, each a factor of the turbidity and a constant.
const PEREZ: [[[f64; 2]; 5]; 3] = [
    [[0.1787, -1.4630], [-0.3554, 0.4275], [-0.0227, 5.3251], [0.1206, -2.5771], [-0.0670, 0.3703]],
    [[-0.0193, -0.2592], [-0.0665, 0.0008], [-0.0004, 0.2125], [-0.0641, -0.8989], [-0.0033, 0.0452]],
    [[-0.0167, -0.2608], [-0.0950, 0.0092], [-0.0079, 0.2102], [-0.0441, -1.6537], [-0.0109, 0.0529]],
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    fn sky(elevation: f64, turbidity: f64) -> Sky {
        Sky { elevation, turbidity, ..Sky::default() }
    }

    fn luminance_of(rgb: Vec3) -> f32 {
        rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
    }

    #[test]
    fn it_is_positive_and_finite_wherever_the_sun_is() {
        for elevation in [-6.0, -5.0, -0.1, 0.0, 0.1, 1.0, 10.0, 45.0, 80.0, 90.0] {
            for turbidity in [2.0, 2.5, 4.0, 7.0, 10.0] {
                let sky = sky(elevation, turbidity);
                let (width, height, texels) = sky.picture();
                assert_eq!(texels.len(), (3 * width * height) as usize);
                assert!(texels.iter().all(|value| value.is_finite() && *value >= 0.0));
                let bright = texels.chunks(3).all(|rgb| luminance_of(Vec3::from_slice(rgb)) > 1e-6);
                assert!(bright, "{elevation} {turbidity}");
                match sky.sun() {
                    None => assert!(elevation <= 0.0),
                    Some(sun) => {
                        let radiance = sun.radiance;
                        assert!(elevation > 0.0 && radiance.is_finite() && radiance.min_element() >= 0.0);
                        assert!(radiance.max_element() > 0.0, "{elevation} {turbidity}: {radiance}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_zenith_has_what_the_paper_gives_it() {
        // worked out by hand for a turbidity of 3 and the sun at 30 degrees to the zenith
        let theta = 30_f64.to_radians();
        assert!((luminance(3.0, theta) - 10.41).abs() < 0.02, "{}", luminance(3.0, theta));
        let [x, y] = [&ZENITH_X, &ZENITH_Y].map(|fit| chromaticity(fit, 3.0, theta));
        assert!((x - 0.2534).abs() < 5e-4 && (y - 0.2598).abs() < 5e-4, "{x} {y}");
        let model = Model::new(&sky(60.0, 3.0));
        let zenith = model.radiance(DVec3::Y);
        let expected = luminance(3.0, theta) * UNITS_A_KILO;
        assert!((f64::from(luminance_of(zenith)) - expected).abs() < 0.01 * expected, "{zenith}");
    }

    #[test]
    fn a_clear_sky_is_blue_and_of_order_one_around_noon() {
        let model = Model::new(&sky(60.0, 3.0));
        let away = model.radiance(direction(40.0, 315.0));
        assert!((0.1..2.0).contains(&luminance_of(away)), "{away}");
        assert!(away.z > 1.5 * away.x, "{away}");
        let beside = model.radiance(direction(55.0, 135.0));
        assert!(luminance_of(beside) > 2.0 * luminance_of(away), "brighter beside the sun: {beside} {away}");
        let horizon = model.radiance(direction(1.0, 315.0));
        assert!(horizon.z / horizon.x < away.z / away.x, "paler at the horizon: {horizon}");
    }

    #[test]
    fn evening_is_darker_and_redder() {
        let sky_at = |elevation| luminance_of(Model::new(&sky(elevation, 3.0)).radiance(DVec3::Y));
        let levels = [60.0, 20.0, 5.0, 0.0, -2.0, -5.0].map(sky_at);
        assert!(levels.is_sorted_by(|a, b| a > b), "{levels:?}");
        let continuous = (sky_at(1e-6) - sky_at(-1e-6)).abs();
        assert!(continuous < 1e-4 * sky_at(0.0), "no step at the horizon");
        let [noon, evening] = [60.0, 3.0].map(|elevation| sky(elevation, 3.0).sun().unwrap().radiance);
        assert!(evening.x / evening.z > 3.0 * noon.x / noon.z, "{noon} {evening}");
        assert!(luminance_of(evening) < 0.3 * luminance_of(noon), "{noon} {evening}");
    }

    #[test]
    fn the_sun_stands_where_it_should_and_outshines_the_sky() {
        let at = |elevation, azimuth| Sky { elevation, azimuth, ..Sky::default() }.to_sun().as_vec3();
        for (to_sun, expected) in
            [(at(0.0, 0.0), Vec3::NEG_Z), (at(0.0, 90.0), Vec3::X), (at(90.0, 33.0), Vec3::Y)]
        {
            assert!(to_sun.abs_diff_eq(expected, 1e-6), "{to_sun} {expected}");
        }
        let sun = sky(90.0, 2.0).sun().unwrap();
        // outdoors it is some 100 klx
        let lit = f64::from(luminance_of(sun.radiance * sun.solid_angle())) / UNITS_A_KILO;
        assert!((90.0..125.0).contains(&lit), "{lit} klx");
    }

    #[test]
    fn the_ground_reflects_what_falls_on_it() {
        let ground = Vec3::new(0.5, 0.25, 0.0);
        let lit = Sky { ground, ..sky(50.0, 3.0) };
        let (width, height, texels) = lit.picture();
        let texel = |row: u32| Vec3::from_slice(&texels[(3 * row * width) as usize..]);
        assert_eq!((texel(height / 2), texel(height / 2).z), (texel(height - 1), 0.0));
        let sun = lit.sun().unwrap();
        let of_sun = sun.radiance * sun.solid_angle() * sun.to_sun.y;
        // the sky adds its part
        let irradiance = texel(height - 1).x / ground.x * std::f32::consts::PI;
        assert!(irradiance > 1.05 * of_sun.x && irradiance < 2.0 * of_sun.x, "{irradiance} {of_sun}");
    }
}
