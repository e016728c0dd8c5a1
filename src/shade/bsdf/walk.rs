//! Random walks of light over microfacets: what rough surfaces reflect in all, without the approximations of
//! [`albedos`](super::albedos). Docs/quality.md has figures from here.
//!
//! After Heitz, Hanika, d'Eon and Dachsbacher, "Multiple-Scattering Microfacet BSDFs with the Smith Model", 2016: the
//! surface is a medium. A ray that goes on from a height meets the next microfacet by the Smith function of its
//! direction, and which one that is depends on the direction alone (visible normals of GGX).

use std::f64::consts::TAU;

use glam::DVec3;

use super::albedos::{Albedos, Layer, Shares};
use super::tests::material;
use crate::shade::bsdf::fresnel::Fresnel;

/// Numbers from 0 to 1 without an end: PCG (O'Neill 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (f64::from(mixed.rotate_right((self.0 >> 59) as u32)) + 0.5) / 4_294_967_296.0
    }
}

/// Normal of a microfacet that is met from the direction `from`, be it above or below the horizon.
fn met(alpha: f64, from: DVec3, random: &mut Random) -> DVec3 {
    let stretched = DVec3::new(alpha * from.x, alpha * from.y, from.z).normalize();
    // the half-ball of normals, seen from there: evenly over its outline
    let turn = TAU * random.next();
    let z = 1.0 - random.next() * (1.0 + stretched.z);
    let across = (1.0 - z * z).max(0.0).sqrt();
    let half = DVec3::new(across * turn.cos(), across * turn.sin(), z) + stretched;
    DVec3::new(alpha * half.x, alpha * half.y, half.z.max(1e-12)).normalize()
}

/// Share of the surface below the height at which a ray along `way` meets the next microfacet, if it leaves from above
/// the share `below`; `None` if it gets away.
fn next_height(alpha: f64, way: DVec3, below: f64, random: &mut Random) -> Option<f64> {
    let chance = random.next();
    if way.z.abs() < 1e-4 {
        return Some(below);
    }
    let square = alpha * alpha * (1.0 / (way.z * way.z) - 1.0);
    let lambda = 0.5 * (way.z.signum() * (1.0 + square).sqrt() - 1.0);
    let gets_away = if way.z > 0.0 { below.powf(lambda) } else { 0.0 };
    if chance > 1.0 - gets_away {
        return None;
    }
    Some((below / (1.0 - chance).powf(1.0 / lambda)).min(1.0))
}

/// Light from all around that is reflected to an eye at this cosine, where each microfacet reflects as much as each of
/// `kinds` says.
fn walked<const KINDS: usize>(alpha: f64, cos: f64, kinds: &[Fresnel<f32>; KINDS]) -> [f64; KINDS] {
    const WALKS: u32 = 30_000;
    /// A walk that does not end is lost: so do one in a million.
    const MOST_STEPS: u32 = 100;
    let mut random = Random(WALKS.into());
    let mut sums = [0.0; KINDS];
    for _ in 0..WALKS {
        // light goes either way: from the eye to where it comes from
        let mut way = DVec3::new(-(1.0 - cos * cos).sqrt(), 0.0, -cos);
        let (mut below, mut weights, mut steps) = (1.0, [1.0; KINDS], 0);
        while let Some(height) = next_height(alpha, way, below, &mut random) {
            let normal = met(alpha, -way, &mut random);
            let toward = -normal.dot(way);
            let reflected = kinds.map(|fresnel| f64::from(fresnel.at(toward as f32)[0]));
            weights.iter_mut().zip(reflected).for_each(|(weight, reflected)| *weight *= reflected);
            (below, way, steps) = (height, (way + normal * (2.0 * toward)).normalize(), steps + 1);
            if steps == MOST_STEPS {
                weights = [0.0; KINDS];
                break;
            }
        }
        sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight);
    }
    sums.map(|sum| sum / f64::from(WALKS))
}

/// Checks metals of several reflectances, and a dielectric, seen from all sides. Prints by how much each is off
/// (`cargo nextest run --lib --no-capture walks`).
#[test]
fn rough_surfaces_are_as_bright_as_random_walks_over_microfacets_say() {
    /// Largest error as a share of all light; noise of the walks included.
    const BOUND: f64 = 0.012;
    /// Largest error of a metal as a share of what it reflects.
    const METAL_BOUND: f64 = 0.035;
    let metals = [0.2, 0.4, 0.6, 0.8, 1.0].map(|head_on| Fresnel::of_metal(glam::Vec3::splat(head_on)));
    let clear = Fresnel { metallic: 0.0, index: 1.5, ..metals[0] };
    let [a, b, c, d, e] = metals;
    let kinds = [a, b, c, d, e, clear];
    for roughness in [0.3, 0.5, 0.7, 0.85, 1.0] {
        let alpha = material(roughness, 1.0, 1.0).metal_rough.expect("it has a layer").alpha();
        let albedos = Albedos::new(Layer { alpha, index: clear.index, is_glass: false });
        let mut worst = [0.0_f64; 6];
        for cos in [0.1, 0.3, 0.5, 0.75, 1.0] {
            let wanted = walked(alpha.into(), cos, &kinds);
            for (number, (fresnel, wanted)) in kinds.iter().zip(wanted).enumerate() {
                let got = f64::from(Shares::new(albedos.at(cos as f32)).in_all(fresnel)[0]);
                let name = format!("roughness {roughness}, cosine {cos}, {fresnel:?}: {got}, {wanted}");
                assert!((got - wanted).abs() < BOUND, "{name}");
                let off = got / wanted - 1.0;
                assert!(fresnel.metallic == 0.0 || off.abs() < METAL_BOUND, "{name}");
                if off.abs() > worst[number].abs() {
                    worst[number] = off;
                }
            }
        }
        println!("roughness {roughness}: {:.1?} %", worst.map(|off| 100.0 * off));
    }
}
