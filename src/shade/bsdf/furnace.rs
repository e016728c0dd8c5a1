//! Reflection of light from all around by rough surfaces, computed in another way than the renderer's: textbook
//! formulas in double floats, summed over even steps of microfacets' slopes instead of sampled normals.
//! docs/quality.md has figures from here.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::albedos::{Albedos, Layer, Shares};
use super::tests::{at, material, seen};
use crate::scene::Material;
use crate::scene::material::{MetalRough, head_on};
use crate::shade::bsdf::fresnel::Fresnel;

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

/// Light from all around that microfacets reflect once, each the share that `reflectance` gives for its cosine: GGX, Smith
/// (Walter et al. 2007, equations 20, 33 and 34).
fn once(alpha: f64, cos: f64, masking: Masking, reflectance: impl Fn(f64) -> f64) -> f64 {
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
    integral(alpha, to_eye, |to_light, normal| {
        brdf_times_cosine(to_light, normal) * reflectance(normal.dot(to_eye).min(1.0))
    })
}

fn white(_: f64) -> f64 {
    1.0
}

/// Share of white in Schlick's formula.
fn grazing(cos: f64) -> f64 {
    (1.0 - cos).powi(5)
}

/// Fresnel's equations by the angles on both sides.
fn dielectric(index: f64) -> impl Fn(f64) -> f64 {
    move |cos| {
        let outside = cos.min(1.0 - 1e-9).acos();
        let inside = (outside.sin() / index).asin();
        let across = (outside - inside).sin() / (outside + inside).sin();
        let along = (outside - inside).tan() / (outside + inside).tan();
        0.5 * (across * across + along * along)
    }
}

/// Shares that a surface of this width reflects at a cosine; the part that is no metal bends light by `index`.
fn shares(alpha: f32, index: f64, cos: f32) -> Shares<f32> {
    Shares::new(Albedos::new(Layer { alpha, index: index as f32, is_glass: false }).at(cos))
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
        for (cos, index) in COSINES.into_iter().zip([1.2, 1.5, 2.2].into_iter().cycle()) {
            let shares = shares(alpha, index, cos);
            let wanted = |reflectance: &dyn Fn(f64) -> f64| {
                once(alpha.into(), cos.into(), Masking::Correlated, reflectance)
            };
            for (got, wanted) in [
                (shares.white, wanted(&white)),
                (shares.grazing, wanted(&grazing)),
                (shares.clear_once, wanted(&dielectric(index))),
            ] {
                let off = f64::from(got) - wanted;
                assert!(off.abs() < ALBEDO_BOUND, "roughness {roughness}, cosine {cos}: {got}, {wanted}");
            }
        }
    }
}

/// Plastic whose base is black, of this index of refraction.
fn plastic(roughness: f32, index: f64) -> Material {
    let plain = material(roughness, 0.0, 0.0);
    let layer = plain.metal_rough.map(|layer| MetalRough { head_on: head_on(index) as f32, ..layer });
    Material { metal_rough: layer, ..plain }
}

/// Checks the layer of plastic as rays see it, by its reflectance towards each light: at all angles as bright as Fresnel's
/// equations have it, and a little more by what is reflected several times.
#[test]
fn plastic_reflects_what_fresnels_equations_say() {
    /// Most that is reflected several times, of all light.
    const SEVERAL_TIMES: f64 = 0.035;
    for roughness in [0.05, 0.3, 0.5, 0.8, 1.0] {
        for (index, cos) in [1.33, 1.5, 2.2].into_iter().flat_map(|index| COSINES.map(|cos| (index, cos))) {
            let alpha = f64::from(alpha_of(roughness));
            let wanted = once(alpha, cos.into(), Masking::Correlated, dielectric(index));
            let seen = seen(&plastic(roughness, index), cos);
            let reflected = |to_light: DVec3, _| f64::from(seen.towards(to_light.as_vec3()).0.x);
            let got = integral(alpha, at(cos).as_dvec3(), reflected);
            let name = format!("roughness {roughness}, index {index}, cosine {cos}: {got}, {wanted}");
            assert!(got > wanted - ALBEDO_BOUND && got < wanted + SEVERAL_TIMES, "{name}");
            assert!((got - f64::from(seen.albedo.x)).abs() < ALBEDO_BOUND, "{name}, {}", seen.albedo);
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

/// Checks the light that is added to a ball in a furnace, compared with a renderer that reflects it once: the light that a
/// metal reflects several times, less of it where it reflects less, and next to nothing by the kind of masking.
#[test]
fn rough_metal_is_brighter_by_what_it_reflects_several_times() {
    for (roughness, several_times, by_masking) in
        [(0.3, [0.0241, 0.0187], 0.0004), (0.5, [0.1334, 0.0816], 0.0033)]
    {
        let alpha = alpha_of(roughness);
        let of = |masking| mean_of_ball(|cos| once(alpha.into(), cos, masking, white));
        let [correlated, separable] = [Masking::Correlated, Masking::Separable].map(of);
        let masking = correlated / separable - 1.0;
        assert!((masking - by_masking).abs() < 3e-4, "roughness {roughness}: {masking}");
        let albedos = Albedos::new(Layer { alpha, index: 1.5, is_glass: false });
        for (base, wanted) in [1.0, 0.5].into_iter().zip(several_times) {
            let metal = Fresnel::of_metal(Vec3::splat(base));
            let in_all = |cos: f64| f64::from(Shares::new(albedos.at(cos as f32)).in_all(&metal)[0]);
            let reflectance = |cos: f64| f64::from(metal.at(cos as f32)[0]);
            let once = |cos| once(alpha.into(), cos, Masking::Correlated, reflectance);
            let added = mean_of_ball(in_all) / mean_of_ball(once) - 1.0;
            assert!((added - wanted).abs() < 2e-3, "roughness {roughness}, {base}: {added}, not {wanted}");
        }
    }
}
