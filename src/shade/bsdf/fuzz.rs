//! Fuzz above all else that a surface has: fibres, dust, the down of a peach. As OpenPBR has it (Academy Software Foundation, "OpenPBR
//! Surface specification", version 1.1, "fuzz").
//!
//! - It *reflects* by a linearly transformed cosine: a matt surface's light, squeezed towards grazing angles, as light leaves a layer of
//!   fibres in which it has been scattered several times (Zeltner, Burley and Chiang, "Practical Multiple-Scattering Sheen Using Linearly
//!   Transformed Cosines", 2022). The fits to their tables are those of the MaterialX library (`mx_microfacet_sheen.glsl`).
//! - What is *below* gets the rest: one less the share that it reflects in the direction of the ray, of the channel of which that is most
//!   (albedo scaling, as Cycles and glTF have it; MaterialX takes a white fuzz's).

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use super::albedos::LEAST_COSINE;
use crate::lanes::Real;
use crate::scene::material::Fuzz;
use crate::shade::sampling::cosine_direction;

/// Least roughness for which the fits hold.
const LEAST_ROUGHNESS: f32 = 0.01;

/// Fuzz as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenFuzz {
    /// Where to it reflects.
    pub lobe: FuzzLobe<f32>,
    /// Share of light from all around that it reflects.
    pub albedo: Vec3,
    /// Share of the light of what is below that comes through.
    pub lets_through: f32,
}

/// The transform of a lobe: from directions to light to those of a cosine lobe, in the space in which the eye is above X.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FuzzLobe<T> {
    /// Factor across the normal.
    pub scale: T,
    /// Way along X for each unit along the normal.
    pub shear: T,
}

impl SeenFuzz {
    /// None at all.
    pub const NONE: Self =
        Self { lobe: FuzzLobe { scale: 1.0, shear: 0.0 }, albedo: Vec3::ZERO, lets_through: 1.0 };

    /// The fuzz as a ray sees it at this cosine.
    pub fn new(fuzz: &Fuzz, cos: f32) -> Self {
        let (cos, rough) = (cos.clamp(LEAST_COSINE, 1.0), fuzz.roughness.clamp(LEAST_ROUGHNESS, 1.0));
        let albedo = fuzz.color * (fuzz.weight * reflected(cos, rough));
        let scale = (2.581_26 * cos + 0.813_703 * rough) * rough
            / (1.0 + 0.310_327 * cos * cos + 2.609_94 * cos * rough);
        let shear = (1.0 - cos).sqrt() * (rough - 1.0) * rough.powi(3)
            / (0.000_025_405_3 + 1.712_28 * cos - 1.715_06 * cos * rough + 1.341_74 * rough * rough);
        Self { lobe: FuzzLobe { scale, shear }, albedo, lets_through: 1.0 - albedo.max_element() }
    }

    /// The same of a surface of which this share is there: what is below it has its share already.
    pub fn in_part(self, solid: f32) -> Self {
        Self { albedo: self.albedo * solid, ..self }
    }
}

/// Share of light from all around that white fuzz reflects.
fn reflected(cos: f32, rough: f32) -> f32 {
    let width = rough * (0.020_660_7 + 1.584_91 * rough) / (0.037_942_4 + rough * (1.322_27 + rough));
    let middle = rough * (-0.193_854 + rough * (-1.148_85 + rough * (1.793_2 - 0.959_43 * rough * rough)))
        / (0.046_391 + rough);
    let even = rough * (0.000_654_023 + (-0.020_781_8 + 0.119_681 * rough) * rough)
        / (1.262_64 + rough * (rough - 1.920_21));
    let off = (cos - middle) / width;
    let peak = (-0.5 * off * off).exp() / (width * TAU.sqrt());
    (peak + even).clamp(0.0, 1.0)
}

impl<T: Real> FuzzLobe<T> {
    /// Density of the lobe, in solid angle: its integral is 1. `of_eye` and `of_light`: cosines to the normal, above 0; `between` that of
    /// the angle between both.
    #[inline(always)]
    pub fn density(&self, of_eye: T, of_light: T, between: T) -> T {
        let Self { scale, shear } = *self;
        let (none, one) = (T::of(0.0), T::of(1.0));
        let across = (one - of_light * of_light).max(none);
        let sin_of_eye = (one - of_eye * of_eye).max(T::of(LEAST_SINE * LEAST_SINE)).sqrt();
        let along = (between - of_eye * of_light) / sin_of_eye;
        let beside = (across - along * along).max(none);
        let moved = scale * along + shear * of_light;
        let squeezed = scale / (moved * moved + scale * scale * beside + of_light * of_light);
        of_light * T::of(FRAC_1_PI) * squeezed * squeezed
    }
}

/// Least sine of the angle to the eye: straight above, the lobe is the same all around.
const LEAST_SINE: f32 = 1e-3;

impl FuzzLobe<f32> {
    /// Samples a direction by two numbers from 0 to below 1, in the space of the surface, of which Z is the normal.
    pub fn sample(&self, to_eye: Vec3, random: [f32; 2]) -> Vec3 {
        let Vec3 { x, y, z } = cosine_direction(random, [Vec3::X, Vec3::Y, Vec3::Z]);
        let (along, beside) = ((x - z * self.shear) / self.scale, y / self.scale);
        let toward = Vec3::new(to_eye.x, to_eye.y, 0.0).try_normalize().unwrap_or(Vec3::X);
        let aside = Vec3::new(-toward.y, toward.x, 0.0);
        (toward * along + aside * beside + Vec3::Z * z).normalize_or(Vec3::Z)
    }

    /// [`density`](Self::density) of directions in the space of the surface.
    pub fn density_of(&self, to_eye: Vec3, to_light: Vec3) -> f32 {
        if to_eye.z <= 0.0 || to_light.z <= 0.0 {
            return 0.0;
        }
        self.density(to_eye.z, to_light.z, to_eye.dot(to_light))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::at_turn;
    use super::*;
    use crate::shade::sampling::PathRandom;

    const CLOTH: Fuzz = Fuzz { weight: 1.0, color: Vec3::new(1.0, 0.5, 0.25), roughness: 0.5 };

    /// All that the lobe reflects goes somewhere above the surface.
    #[test]
    fn the_density_of_the_lobe_is_one_in_all() {
        const STEPS: u32 = 400;
        for roughness in [0.1, 0.3, 0.5, 1.0] {
            for cos in [1.0, 0.7, 0.3, 0.05] {
                let (eye, seen) = (at_turn(cos, 0.7), SeenFuzz::new(&Fuzz { roughness, ..CLOTH }, cos));
                let mut sum = 0.0;
                for ring in 0..STEPS {
                    for turn in 0..STEPS {
                        // squared, so that grazing angles get more of the steps
                        let up = ((ring as f32 + 0.5) / STEPS as f32).powi(2);
                        let area = 2.0 * up.sqrt() * TAU / (STEPS * STEPS) as f32;
                        let light = at_turn(up, TAU * (turn as f32 + 0.5) / STEPS as f32);
                        sum += f64::from(seen.lobe.density_of(eye, light) * area);
                    }
                }
                assert!((sum - 1.0).abs() < 0.02, "{roughness} {cos}: {sum}");
            }
        }
    }

    /// Fuzz glows at grazing angles, and takes from what is below what it reflects.
    #[test]
    fn fuzz_is_brightest_on_edge() {
        let [above, aside, on_edge] = [1.0, 0.4, 0.05].map(|cos| SeenFuzz::new(&CLOTH, cos));
        assert!(
            above.albedo.x < aside.albedo.x && aside.albedo.x < on_edge.albedo.x,
            "{above:?} {on_edge:?}"
        );
        assert_eq!(aside.albedo.y, 0.5 * aside.albedo.x);
        assert!((aside.lets_through + aside.albedo.x - 1.0).abs() < 1e-6);
        assert_eq!(SeenFuzz::new(&Fuzz { weight: 0.0, ..CLOTH }, 0.2).lets_through, 1.0);
    }

    #[test]
    fn samples_are_as_dense_as_the_density_says() {
        const COUNT: u32 = 1 << 14;
        for (roughness, cos) in [(0.2, 0.3), (0.5, 0.8), (1.0, 0.1)] {
            let (eye, seen) = (at_turn(cos, 2.0), SeenFuzz::new(&Fuzz { roughness, ..CLOTH }, cos));
            // the mean of one over the density is the area in which there are samples: a half sphere
            let mut area = 0.0;
            for index in 0..COUNT {
                let [a, b, ..] = PathRandom::new(5, index).four(0);
                let light = seen.lobe.sample(eye, [a, b]);
                let density = seen.lobe.density_of(eye, light);
                assert!(light.z > 0.0 && density > 0.0, "{light}");
                if light.z > 0.05 {
                    area += 1.0 / f64::from(density) / f64::from(COUNT);
                }
            }
            let wanted = std::f64::consts::TAU * 0.95;
            assert!((area / wanted - 1.0).abs() < 0.03, "{roughness} {cos}: {area} of {wanted}");
        }
    }
}
