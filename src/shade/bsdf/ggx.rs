//! Reflection of rough surfaces: a microfacet model with the GGX distribution.
//!
//! - Distribution: Trowbridge and Reitz 1975; Walter et al., "Microfacet Models for Refraction through Rough
//!   Surfaces", 2007, who call it GGX.
//! - Masking and shadowing: height-correlated Smith; Heitz, "Understanding the Masking-Shadowing Function in
//!   Microfacet-Based BRDFs", 2014, equations 72 and 99.
//! - Reflectance of each microfacet: [`Fresnel`].
//! - Sampling of visible normals: Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps",
//!   2023.
//!
//! Directions have unit length and point away from the surface. In functions of one direction at a time they
//! are in the space of the surface: its normal is Z.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::geometry::angle;
use crate::lanes::{F32x8, Vec3x8};
use crate::shade::bsdf::fresnel::Fresnel;

/// Density of microfacet normals about `half`, for each unit of area and of solid angle.
#[inline]
fn distribution(alpha: f32, half: Vec3) -> f32 {
    let square = alpha * alpha;
    // by the sine and not by the cosine alone, which is too inexact for narrow lobes
    let spread = square * half.z * half.z + half.x * half.x + half.y * half.y;
    square * FRAC_1_PI / (spread * spread)
}

/// Smith's function of the area that is hidden from a direction with this cosine.
#[inline]
fn lambda(alpha: f32, cos: f32) -> f32 {
    0.5 * (stretch(alpha, cos) / cos - 1.0)
}

/// Cosine, stretched by the roughness.
#[inline]
fn stretch(alpha: f32, cos: f32) -> f32 {
    let square = alpha * alpha;
    (square + (1.0 - square) * cos * cos).sqrt()
}

/// Reflectance from `to_light` to `to_eye` (BRDF, 1/sr) times the cosine to the light.
#[inline]
pub fn reflected(alpha: f32, fresnel: &Fresnel<f32>, to_eye: Vec3, to_light: Vec3) -> Vec3 {
    if to_eye.z <= 0.0 || to_light.z <= 0.0 {
        return Vec3::ZERO;
    }
    let half = (to_eye + to_light).normalize();
    let shape = distribution(alpha, half) * to_light.z
        / (2.0 * (stretch(alpha, to_eye.z) * to_light.z + stretch(alpha, to_light.z) * to_eye.z));
    Vec3::from(fresnel.at(half.dot(to_eye))) * shape
}

/// Density with which [`sample`] chooses `to_light`, in solid angle.
#[inline]
pub fn density(alpha: f32, to_eye: Vec3, to_light: Vec3) -> f32 {
    if to_eye.z <= 0.0 || to_light.z <= 0.0 {
        return 0.0;
    }
    let half = (to_eye + to_light).normalize();
    // visible normals, D G1 (o . h) / cos, by the solid angle of their reflections, 1 / (4 o . h)
    distribution(alpha, half) / (2.0 * (to_eye.z + stretch(alpha, to_eye.z)))
}

/// Samples a direction in which a microfacet that is seen from `to_eye` reflects, by two numbers from 0 to
/// below 1. It may lead below the surface, where other microfacets are in the way.
#[inline]
pub fn sample(alpha: f32, to_eye: Vec3, numbers: [f32; 2]) -> Vec3 {
    let normal = visible_normal(alpha, to_eye, numbers);
    normal * (2.0 * normal.dot(to_eye)) - to_eye
}

/// Samples the normal of a microfacet that is seen from `to_eye`, by two numbers from 0 to below 1.
#[inline]
pub fn visible_normal(alpha: f32, to_eye: Vec3, [around, along]: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(alpha * to_eye.x, alpha * to_eye.y, to_eye.z).normalize();
    let [sin, cos] = angle::turned(around);
    // evenly over the cap of the sphere that reflects the direction upwards
    let z = (1.0 - along) * (1.0 + stretched.z) - stretched.z;
    let across = (1.0 - z * z).max(0.0).sqrt();
    let half = Vec3::new(across * cos, across * sin, z) + stretched;
    Vec3::new(alpha * half.x, alpha * half.y, half.z.max(0.0)).normalize_or(Vec3::Z)
}

/// Share of the light that a microfacet, seen at the cosine `of_eye`, reflects at the cosine `of_light`, and that no other one takes.
#[inline]
pub fn unmasked(alpha: f32, of_eye: f32, of_light: f32) -> f32 {
    let (of_eye, of_light) = (lambda(alpha, of_eye), lambda(alpha, of_light));
    (1.0 + of_eye) / (1.0 + of_eye + of_light)
}

/// Weight of the light from a sampled direction: [`reflected`] over [`density`].
#[inline]
pub fn sample_weight(alpha: f32, fresnel: &Fresnel<f32>, to_eye: Vec3, to_light: Vec3) -> Vec3 {
    if to_light.z <= 0.0 {
        return Vec3::ZERO;
    }
    let half = (to_eye + to_light).normalize();
    Vec3::from(fresnel.at(half.dot(to_eye))) * unmasked(alpha, to_eye.z, to_light.z)
}

/// [`reflected`] for eight surfaces, in world space.
#[inline(always)]
pub fn reflected_lanes(
    alpha: F32x8,
    fresnel: &Fresnel<F32x8>,
    normal: Vec3x8,
    to_eye: Vec3x8,
    to_light: Vec3x8,
) -> Vec3x8 {
    let (of_eye, of_light) = (normal.dot(to_eye), normal.dot(to_light));
    let half = (to_eye + to_light).normalize();
    let (up, aside) = (normal.dot(half), normal.cross(half));
    let square = alpha * alpha;
    let spread = square * up * up + aside.dot(aside);
    let rest_of_square = F32x8::ONE - square;
    let stretch = |cos: F32x8| (square + rest_of_square * cos * cos).sqrt();
    let below = F32x8::splat(2.0) * (stretch(of_eye) * of_light + stretch(of_light) * of_eye);
    let shape = square * F32x8::splat(FRAC_1_PI) * of_light / (spread * spread * below);
    let color = Vec3x8::from(fresnel.at(half.dot(to_eye)));
    let is_above = of_eye.gt(F32x8::ZERO) & of_light.gt(F32x8::ZERO);
    is_above.select3(color * shape, Vec3x8::ZERO)
}

/// [`density`] for eight surfaces, in world space.
#[inline(always)]
pub fn density_lanes(alpha: F32x8, normal: Vec3x8, to_eye: Vec3x8, to_light: Vec3x8) -> F32x8 {
    let (of_eye, of_light) = (normal.dot(to_eye), normal.dot(to_light));
    let half = (to_eye + to_light).normalize();
    let (up, aside) = (normal.dot(half), normal.cross(half));
    let square = alpha * alpha;
    let spread = square * up * up + aside.dot(aside);
    let stretched = (square + (F32x8::ONE - square) * of_eye * of_eye).sqrt();
    let below = spread * spread * F32x8::splat(2.0) * (of_eye + stretched);
    let is_above = of_eye.gt(F32x8::ZERO) & of_light.gt(F32x8::ZERO);
    is_above.select(square * F32x8::splat(FRAC_1_PI) / below, F32x8::ZERO)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::tests::at_turn;
    use super::*;
    use crate::scene::material::LEAST_ALPHA;
    use crate::shade::sampling::PathRandom;

    /// Metal in part, so that both formulas count.
    const MIXTURE: Fresnel<f32> = Fresnel { metal: [0.9, 0.5, 0.04], edge: 0.8, metallic: 0.7, index: 1.5 };

    const ALPHAS: [f32; 6] = [LEAST_ALPHA, 0.01, 0.09, 0.25, 0.6, 1.0];

    /// Cosines to the eye.
    const COSINES: [f32; 5] = [1.0, 0.9, 0.5, 0.2, 0.05];

    /// Integral of `value` over all directions, by microfacet normals: slopes in units of alpha, so that
    /// narrow lobes get as many steps as wide ones.
    fn integral(alpha: f32, to_eye: Vec3, value: impl Fn(Vec3) -> f64) -> f64 {
        const STEPS: usize = 600;
        let mut sum = 0.0;
        for i in 0..STEPS {
            for j in 0..STEPS {
                // radius of the slope: tan = alpha r, with r over 0..infinity by r = s / (1 - s)
                let s = (i as f64 + 0.5) / STEPS as f64;
                let (r, turn) = (s / (1.0 - s), 2.0 * PI * (j as f64 + 0.5) / STEPS as f64);
                let tan = f64::from(alpha) * r;
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let sin = tan * cos;
                let half = glam::DVec3::new(sin * turn.cos(), sin * turn.sin(), cos);
                let eye = to_eye.as_dvec3();
                let toward = half.dot(eye);
                if toward <= 0.0 {
                    continue;
                }
                let to_light = half * (2.0 * toward) - eye;
                // solid angle of the normal: sin dtheta dphi = cos^3 tan dtan dphi; and that of its
                // reflection
                let of_normal = cos.powi(3) * tan * f64::from(alpha) / (1.0 - s).powi(2);
                sum += value(to_light.as_vec3()) * of_normal * 4.0 * toward;
            }
        }
        sum * 2.0 * PI / (STEPS * STEPS) as f64
    }

    #[test]
    fn the_density_of_what_is_sampled_is_one_in_all() {
        for alpha in ALPHAS {
            for cos in COSINES {
                let eye = at_turn(cos, 0.3);
                let above = integral(alpha, eye, |light| f64::from(density(alpha, eye, light)));
                let below = (0..16384).filter(|index| {
                    let [a, b, ..] = PathRandom::new(3, *index).four(0);
                    sample(alpha, eye, [a, b]).z <= 0.0
                });
                let sum = above + below.count() as f64 / 16384.0;
                assert!((sum - 1.0).abs() < 0.01, "alpha {alpha}, cosine {cos}: {sum}");
            }
        }
    }

    /// Checks that means of several functions over sampled directions are their integrals by the density.
    #[test]
    fn samples_are_as_dense_as_the_density_says() {
        const COUNT: u32 = 16384;
        for alpha in ALPHAS {
            for cos in COSINES {
                let eye = at_turn(cos, 0.3);
                let tests: [fn(Vec3) -> f64; 4] = [
                    |light| f64::from(light.x),
                    |light| f64::from(light.y * light.y),
                    |light| f64::from(light.z),
                    |light| f64::from(u8::from(light.z > 0.7)),
                ];
                for (number, test) in tests.into_iter().enumerate() {
                    let value = |light: Vec3| if light.z > 0.0 { test(light) } else { 0.0 };
                    let wanted =
                        integral(alpha, eye, |light| value(light) * f64::from(density(alpha, eye, light)));
                    let sum: f64 = (0..COUNT)
                        .map(|index| {
                            let [a, b, ..] = PathRandom::new(11, index).four(0);
                            value(sample(alpha, eye, [a, b]))
                        })
                        .sum();
                    let got = sum / f64::from(COUNT);
                    assert!(
                        (got - wanted).abs() < 0.012,
                        "{number}: alpha {alpha}, cosine {cos}: {got}, {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn light_goes_either_way() {
        let fresnel = MIXTURE;
        for alpha in ALPHAS {
            for (a, b) in [(0.9, 0.2), (0.5, 0.6), (0.05, 0.8)] {
                let (eye, light) = (at_turn(a, 0.4), at_turn(b, 2.9));
                // without the cosines
                let there = reflected(alpha, &fresnel, eye, light) / light.z;
                let back = reflected(alpha, &fresnel, light, eye) / eye.z;
                assert!(
                    (there - back).abs().max_element() <= 1e-4 * there.max_element(),
                    "{alpha}: {there}, {back}"
                );
            }
        }
    }

    #[test]
    fn weights_are_the_reflectance_over_the_density() {
        let fresnel = MIXTURE;
        for alpha in ALPHAS {
            for (number, cos) in (0..).zip(COSINES) {
                let eye = at_turn(cos, 1.0);
                for index in 0..64 {
                    let [a, b, ..] = PathRandom::new(number, index).four(0);
                    let light = sample(alpha, eye, [a, b]);
                    assert!((light.length() - 1.0).abs() < 1e-4);
                    let weight = sample_weight(alpha, &fresnel, eye, light);
                    let product = weight * density(alpha, eye, light);
                    let wanted = reflected(alpha, &fresnel, eye, light);
                    let slack = 2e-3 * wanted.max_element() + 1e-6;
                    assert!(
                        (product - wanted).abs().max_element() <= slack,
                        "{alpha} {cos}: {product}, {wanted}"
                    );
                }
            }
        }
    }

    /// Checks that, under an even sky, no surface reflects more than it gets, and a smooth one reflects
    /// nearly all.
    #[test]
    fn no_light_is_made() {
        for alpha in ALPHAS {
            for cos in COSINES {
                let eye = at_turn(cos, 0.0);
                let white = Fresnel::of_metal(Vec3::ONE);
                let of_white =
                    integral(alpha, eye, |light| f64::from(reflected(alpha, &white, eye, light).x));
                assert!(of_white < 1.002, "{alpha} {cos}: {of_white}");
                assert!(alpha > 0.01 || cos < 0.1 || of_white > 0.99, "{alpha} {cos}: {of_white}");
                let glass = Fresnel { metallic: 0.0, ..MIXTURE };
                let of_glass =
                    integral(alpha, eye, |light| f64::from(reflected(alpha, &glass, eye, light).x));
                assert!(of_glass > 0.0 && of_glass < of_white);
            }
        }
    }

    #[test]
    fn eight_at_once_are_as_one_by_one() {
        let fresnel = MIXTURE;
        for alpha in ALPHAS {
            for (a, b, turn) in [(0.9, 0.2, 0.1), (0.5, 0.5, 3.1), (0.05, 0.8, 2.0), (0.4, -0.1, 1.0)] {
                let (eye, light) = (at_turn(a, 0.0), at_turn(b, turn));
                let wanted = reflected(alpha, &fresnel, eye, light);
                // again with X for Z
                let turned = |v: Vec3| Vec3x8::splat(Vec3::new(v.z, v.x, v.y));
                let all = Fresnel {
                    metal: fresnel.metal.map(F32x8::splat),
                    edge: F32x8::splat(fresnel.edge),
                    metallic: F32x8::splat(fresnel.metallic),
                    index: F32x8::splat(fresnel.index),
                };
                let got =
                    reflected_lanes(F32x8::splat(alpha), &all, turned(Vec3::Z), turned(eye), turned(light));
                let dense = density_lanes(F32x8::splat(alpha), turned(Vec3::Z), turned(eye), turned(light));
                let wanted_density = density(alpha, eye, light);
                assert!((dense.lane(1) - wanted_density).abs() <= 1e-3 * wanted_density, "{alpha} {a} {b}");
                let slack = 1e-3 * wanted.max_element();
                assert!(
                    (got.lane(5) - wanted).abs().max_element() <= slack,
                    "{alpha} {a} {b}: {got:?}, {wanted}"
                );
            }
        }
    }

    #[test]
    fn the_extremes_are_numbers() {
        for alpha in [LEAST_ALPHA, 1.0] {
            for eye in [Vec3::Z, at_turn(1e-6, 0.0)] {
                for random in [[0.0, 0.0], [0.999_999_9, 0.999_999_9], [0.5, 0.0]] {
                    let light = sample(alpha, eye, random);
                    let weight = sample_weight(alpha, &MIXTURE, eye, light);
                    assert!(
                        light.is_finite() && weight.is_finite() && weight.max_element() <= 1.0001,
                        "{light} {weight}"
                    );
                    assert!(reflected(alpha, &MIXTURE, eye, light).is_finite());
                    assert!(density(alpha, eye, light).is_finite());
                }
            }
        }
    }
}
