//! The sun as a disk that shines from infinitely far away.

use std::f64::consts::TAU;

use glam::Vec3;

use super::light_from::LightFrom;
use crate::geometry::angle;

/// A round source of light, infinitely far away, of the same radiance all over. World space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Direction to its centre, unit length.
    pub to_sun: Vec3,
    /// Cosine of the angle from its centre to its rim.
    pub cos_angle: f32,
    /// Radiance, linear RGB.
    pub radiance: Vec3,
}

impl Sun {
    /// Creates a disk of `diameter` degrees around `to_sun` (any length but zero) with the irradiance
    /// `irradiance` on a surface that faces it.
    pub fn of_irradiance(to_sun: Vec3, diameter: f64, irradiance: Vec3) -> Self {
        let cos_angle = (diameter / 2.0).to_radians().cos() as f32;
        let dark = Self { to_sun: to_sun.normalize(), cos_angle, radiance: Vec3::ZERO };
        // by the rounded cosine, so that the irradiance is exactly the requested one
        Self { radiance: irradiance / dark.solid_angle(), ..dark }
    }

    /// Solid angle of the disk, steradians.
    pub fn solid_angle(&self) -> f32 {
        (TAU * self.one_minus_cos()) as f32
    }

    /// Samples a direction (unit length), evenly spread over the disk. `random`: two numbers from 0 to 1.
    pub fn sample(&self, random: [f32; 2]) -> Vec3 {
        // as `1 - cos`, and `1 - cos² = (1 - cos)(2 - (1 - cos))`: the cosine itself is too close to 1 for floats
        let off = self.one_minus_cos() * f64::from(random[0]);
        let radius = (off * (2.0 - off)).sqrt() as f32;
        let [sin, cos] = angle::turned(random[1]);
        let (across, up) = self.to_sun.any_orthonormal_pair();
        let aside = (across * cos + up * sin) * radius;
        (self.to_sun * (1.0 - off) as f32 + aside).normalize()
    }

    /// Radiance from `direction` (unit length), and the density with which [`Self::sample`] returns that
    /// direction.
    pub fn light(&self, direction: Vec3) -> LightFrom {
        if self.shows(direction) {
            LightFrom { radiance: self.radiance, pdf: 1.0 / self.solid_angle() }
        } else {
            LightFrom::NONE
        }
    }

    fn one_minus_cos(&self) -> f64 {
        1.0 - f64::from(self.cos_angle)
    }

    /// Returns true if `direction` points at the disk. Compares the distance of unit vectors, whose square is
    /// `2 (1 - cos)`: it is small where the cosine, as a float, has few digits left.
    fn shows(&self, direction: Vec3) -> bool {
        f64::from(direction.distance_squared(self.to_sun)) <= 2.0 * self.one_minus_cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun() -> Sun {
        Sun::of_irradiance(Vec3::new(3.0, 4.0, -2.0), 0.53, Vec3::new(3.0, 2.0, 1.0))
    }

    #[test]
    fn samples_lie_in_the_disk_and_fill_it() {
        let sun = sun();
        let [mut inner, mut outside, n] = [0, 0, 128];
        for at in 0..n * n {
            let random = [at % n, at / n].map(|i| (i as f32 + 0.5) / n as f32);
            let direction = sun.sample(random);
            assert!((direction.length() - 1.0).abs() < 1e-6);
            let inside = LightFrom { radiance: sun.radiance, pdf: 1.0 / sun.solid_angle() };
            outside += i32::from(sun.light(direction) != inside);
            // half of the solid angle
            let half = sun.one_minus_cos();
            inner += i32::from(f64::from(direction.distance_squared(sun.to_sun)) < half);
        }
        assert_eq!(outside, 0);
        assert!((inner - n * n / 2).abs() <= n, "{inner}");
    }

    #[test]
    fn it_is_half_a_degree_wide_and_gives_the_irradiance_asked_for() {
        let sun = sun();
        let (across, _) = sun.to_sun.any_orthonormal_pair();
        let at =
            |degrees: f32| sun.light((sun.to_sun + across * degrees.to_radians().tan()).normalize()).radiance;
        assert_eq!((at(0.26), at(0.27)), (sun.radiance, Vec3::ZERO));
        assert_eq!(sun.light(-sun.to_sun), LightFrom::NONE);
        let irradiance = sun.radiance * sun.solid_angle();
        assert!((irradiance - Vec3::new(3.0, 2.0, 1.0)).abs().max_element() < 1e-5, "{irradiance}");
    }
}
