//! Reflection of light from all around by rough metal, computed in another way than the renderer's: textbook
//! formulas in double floats, summed over even steps of microfacets' slopes instead of sampled normals.
//! docs/quality.md has figures from here.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::layer::{Albedos, albedo, reflected_once};
use super::tests::{at, material, seen};

/// Number of steps of slopes; half as many around, by symmetry. Twice as many change albedos by less than
/// 1e-3.
const STEPS: u32 = 256;

const ROUGHNESSES: [f32; 11] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Cosines to the eye, between the steps of [`Albedos`] and at them. Below the last one its lines leave the
/// curves of smooth surfaces.
const COSINES: [f32; 9] = [1.0, 0.9, 0.7, 0.5, 0.3, 0.2, 0.1, 0.05, 1.0 / 32.0];

/// Largest error of the light that is reflected once, as a share of all light.
const ALBEDO_BOUND: f64 = 3e-3;

/// Largest error of the light that a white metal reflects in a white furnace, as a share of all light.
const FURNACE_BOUND: f64 = 5e-3;

fn alpha_of(roughness: f32) -> f32 {
    material(roughness, 1.0, 1.0).metal_rough.expect("it has a layer").alpha()
}

/// Model of how microfacets hide each other.
#[derive(Clone, Copy)]
enum Masking {
    /// Masking from eye and light is correlated by height, as here.
    Correlated,
    /// Masking from eye and light is independent (Mitsuba 3's `roughconductor`).
    Separable,
}

/// Integral over all microfacet normals of `value` (of the direction to the light and of the normal), by the
/// solid angle of the light. The eye is in the plane y = 0, so that half of the normals stand for all.
fn integral(alpha: f64, to_eye: DVec3, value: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let around = STEPS / 2;
    let mut sum = 0.0;
    for i in 0..STEPS {
        // the slope in units of alpha is s / (1 - s)
        let s = (f64::from(i) + 0.5) / f64::from(STEPS);
        let tan = alpha * s / (1.0 - s);
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        // sin dtheta, and the factor 4 times the cosine to the eye from a normal's solid angle to that of its
        // reflection
        let measure = 4.0 * cos.powi(3) * tan * alpha / (1.0 - s).powi(2);
        for j in 0..around {
            let turn = PI * (f64::from(j) + 0.5) / f64::from(around);
            let normal = DVec3::new(tan * turn.cos(), tan * turn.sin(), 1.0) * cos;
            let toward = normal.dot(to_eye);
            let to_light = normal * (2.0 * toward) - to_eye;
            if toward > 0.0 && to_light.z > 0.0 {
                sum += value(to_light, normal) * measure * toward;
            }
        }
    }
    sum * 2.0 * PI / f64::from(STEPS * around)
}

/// Light from all around that white microfacets reflect once: GGX, Smith, no Fresnel term (Walter et al.
/// 2007, equations 20, 33 and 34); and the part of it that is the share of white in Schlick's formula.
fn once(alpha: f64, cos: f64, masking: Masking) -> [f64; 2] {
    let square = alpha * alpha;
    let lambda = |cos: f64| 0.5 * ((1.0 + square * (1.0 / (cos * cos) - 1.0)).sqrt() - 1.0);
    let to_eye = DVec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let brdf_times_cosine = |to_light: DVec3, normal: DVec3| {
        let tan_square = 1.0 / (normal.z * normal.z) - 1.0;
        let distribution = 1.0 / (PI * square * normal.z.powi(4) * (1.0 + tan_square / square).powi(2));
        let seen = match masking {
            Masking::Correlated => 1.0 / (1.0 + lambda(cos) + lambda(to_light.z)),
            Masking::Separable => 1.0 / ((1.0 + lambda(cos)) * (1.0 + lambda(to_light.z))),
        };
        distribution * seen / (4.0 * cos)
    };
    let white = |to_light, normal: DVec3| {
        brdf_times_cosine(to_light, normal) * (1.0 - normal.dot(to_eye)).max(0.0).powi(5)
    };
    [integral(alpha, to_eye, brdf_times_cosine), integral(alpha, to_eye, white)]
}

/// Mean over a ball that is seen from afar.
fn mean_of_ball(value: impl Fn(f64) -> f64) -> f64 {
    const RINGS: u32 = 16;
    let ring = |ring: u32| {
        let cos = (f64::from(ring) + 0.5) / f64::from(RINGS);
        2.0 * cos * value(cos) / f64::from(RINGS)
    };
    (0..RINGS).map(ring).sum()
}

#[test]
fn what_is_reflected_once_is_what_the_integral_says() {
    for roughness in ROUGHNESSES {
        let alpha = alpha_of(roughness);
        let albedos = Albedos::new(alpha);
        for cos in COSINES {
            let wanted = once(alpha.into(), cos.into(), Masking::Correlated);
            for (got, wanted) in albedos.at(cos).into_iter().zip(wanted) {
                let off = f64::from(got) - wanted;
                assert!(off.abs() < ALBEDO_BOUND, "roughness {roughness}, cosine {cos}: {got}, {wanted}");
            }
        }
    }
}

/// Checks that, with the light that is reflected several times, nothing is lost and nothing is added.
#[test]
fn a_white_metal_of_any_roughness_reflects_all_light() {
    for roughness in ROUGHNESSES {
        let metal = material(roughness, 1.0, 1.0);
        for cos in COSINES {
            let seen = seen(&metal, cos);
            let reflected = |to_light: DVec3, _| f64::from(seen.towards(to_light.as_vec3()).0.x);
            let all = integral(alpha_of(roughness).into(), at(cos).as_dvec3(), reflected);
            assert!((all - 1.0).abs() < FURNACE_BOUND, "roughness {roughness}, cosine {cos}: {all}");
        }
    }
}

/// Checks the light that is added to a ball in a furnace, compared with a renderer that reflects it once: the
/// light that a metal reflects several times, in proportion to its reflectance, and next to nothing by the
/// kind of masking.
#[test]
fn rough_metal_is_brighter_by_what_it_reflects_several_times() {
    for (roughness, several_times, by_masking) in [(0.3, 0.0241, 0.0004), (0.5, 0.1334, 0.0033)] {
        let alpha = f64::from(alpha_of(roughness));
        let of = |masking| mean_of_ball(|cos| once(alpha, cos, masking)[0]);
        let [correlated, separable] = [Masking::Correlated, Masking::Separable].map(of);
        let masking = correlated / separable - 1.0;
        assert!((masking - by_masking).abs() < 3e-4, "roughness {roughness}: {masking}");
        let albedos = Albedos::new(alpha as f32);
        for base in [1.0, 0.5] {
            let mean = |of: fn(Vec3, [f32; 2]) -> Vec3, albedos: &dyn Fn(f64) -> [f32; 2]| {
                mean_of_ball(|cos| f64::from(of(Vec3::splat(base), albedos(cos)).x))
            };
            let in_all = mean(albedo, &|cos| albedos.at(cos as f32));
            let once =
                mean(reflected_once, &|cos| once(alpha, cos, Masking::Correlated).map(|share| share as f32));
            let added = in_all / once - 1.0;
            let wanted = several_times * f64::from(base);
            assert!((added - wanted).abs() < 2e-3, "roughness {roughness}, {base}: {added}, not {wanted}");
        }
    }
}
