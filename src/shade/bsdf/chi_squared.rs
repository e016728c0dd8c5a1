//! Are directions sampled as densely as the density says? Pearson's chi-squared test, for each lobe and for mixtures of all.

use std::f32::consts::TAU;

use glam::Vec3;

use super::Bsdfs;
use super::seen::{SeenBsdf, SurfaceAxes};
use super::seen_by::SeenBy;
use super::tests::{at, material};
use crate::scene::Material;
use crate::scene::look::Look;
use crate::scene::material::{Anisotropy, Coat, Fuzz};
use crate::shade::sampling::PathRandom;

/// Cells of the half sphere: by the cosine to the normal, and around it.
const CELLS: [usize; 2] = [10, 16];

/// Points in each cell by which the density is integrated, along either of its sides.
const POINTS: usize = 24;

/// Sampled directions.
const COUNT: u32 = 60_000;

/// Least number of directions that a cell is expected to have; cells with fewer count together.
const LEAST: f64 = 8.0;

/// Numbers of standard deviations by which chi-squared may be too large: once in 30,000 tests.
const MOST: f64 = 4.0;

fn cell_of(direction: Vec3) -> usize {
    let [up, around] = CELLS;
    let turn = direction.y.atan2(direction.x).rem_euclid(TAU) / TAU;
    let ring = ((direction.z * up as f32) as usize).min(up - 1);
    ring * around + ((turn * around as f32) as usize).min(around - 1)
}

/// Directions that are expected in each cell, and, at the end, in none: those that lead into the surface.
fn expected(seen: &SeenBsdf) -> Vec<f64> {
    let [up, around] = CELLS;
    let mut all = vec![0.0; up * around + 1];
    let steps = [up * POINTS, around * POINTS];
    let area = f64::from(TAU) / (steps[0] * steps[1]) as f64;
    for ring in 0..steps[0] {
        let z = (ring as f32 + 0.5) / steps[0] as f32;
        let across = (1.0 - z * z).sqrt();
        for turn in 0..steps[1] {
            let angle = TAU * (turn as f32 + 0.5) / steps[1] as f32;
            let direction = Vec3::new(across * angle.cos(), across * angle.sin(), z);
            all[cell_of(direction)] += f64::from(seen.density(direction)) * area * f64::from(COUNT);
        }
    }
    let above: f64 = all.iter().sum();
    if let Some(below) = all.last_mut() {
        *below = (f64::from(COUNT) - above).max(0.0);
    }
    all
}

/// Directions that are sampled in each cell, and in none.
fn found(seen: &SeenBsdf) -> Vec<f64> {
    let [up, around] = CELLS;
    let mut all = vec![0.0; up * around + 1];
    for index in 0..COUNT {
        // a sequence of its own for each, so that they are as uneven as chance has it
        let [along, above, ..] = PathRandom::new(index, 0).four(0);
        let cell = seen.reflect([along, above]).map_or(up * around, |ray| cell_of(ray.direction));
        all[cell] += 1.0;
    }
    all
}

/// How many standard deviations chi-squared of what is sampled is above its mean, where `seen` says how dense it is (Wilson and Hilferty's
/// approximation).
fn excess(seen: &SeenBsdf, sampled: &SeenBsdf) -> f64 {
    let (mut sum, mut cells, mut rare) = (0.0, 0.0, [0.0; 2]);
    let mut add = |expected: f64, found: f64| {
        sum += (found - expected).powi(2) / expected;
        cells += 1.0;
    };
    for (expected, found) in expected(seen).into_iter().zip(found(sampled)) {
        if expected < LEAST {
            rare = [rare[0] + expected, rare[1] + found];
        } else {
            add(expected, found);
        }
    }
    let [expected, found] = rare.map(|count| count.max(LEAST));
    add(expected, found);
    let freedom: f64 = cells - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    ((sum / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

fn rough(material: &Material, cos: f32) -> SeenBsdf {
    let bsdfs = Bsdfs::new(std::slice::from_ref(material));
    let axes = SurfaceAxes { normal: Vec3::Z, geometric_normal: Vec3::Z, tangent: Vec3::new(1.0, 2.0, 0.0) };
    let seen = bsdfs.seen(Look::plain(0), material.painted(), axes, -at(cos), SeenBy::Eye);
    seen.and_then(SeenBsdf::rough).expect("it has a rough lobe")
}

fn lobes() -> Vec<(&'static str, Material)> {
    let coat = |roughness| Coat { weight: 1.0, roughness, index: 1.5, tint: Vec3::ONE, darkening: 1.0 };
    let fuzz = |roughness| Fuzz { weight: 1.0, color: Vec3::ONE, roughness };
    let brushed = |amount| Some(Anisotropy { amount, turn: 0.3, around: None });
    let black = |roughness| {
        let mut black = material(roughness, 0.0, 0.0);
        black.metal_rough.iter_mut().for_each(|layer| layer.head_on = 0.0);
        black
    };
    vec![
        ("narrow metal", material(0.35, 1.0, 0.8)),
        ("wide metal", material(1.0, 1.0, 0.8)),
        ("plastic", material(0.6, 0.0, 0.3)),
        ("brushed metal", Material { anisotropy: brushed(0.8), ..material(0.6, 1.0, 0.8) }),
        ("satin", Material { anisotropy: brushed(0.4), fuzz: Some(fuzz(0.5)), ..material(0.8, 0.3, 0.8) }),
        ("a coat on a mirror", Material { coat: Some(coat(0.5)), ..material(0.0, 1.0, 0.8) }),
        ("a coat on metal", Material { coat: Some(coat(0.4)), ..material(0.7, 1.0, 0.8) }),
        ("fuzz", Material { fuzz: Some(fuzz(0.5)), ..black(1.0) }),
        ("flat fuzz", Material { fuzz: Some(fuzz(1.0)), ..black(1.0) }),
        ("all", Material { coat: Some(coat(0.4)), fuzz: Some(fuzz(0.4)), ..material(0.7, 0.5, 0.8) }),
    ]
}

#[test]
fn each_lobe_is_sampled_as_its_density_says() {
    for (name, material) in lobes() {
        for cos in [0.95, 0.5, 0.15] {
            let seen = rough(&material, cos);
            let excess = excess(&seen, &seen);
            assert!(excess < MOST, "{name}, cosine {cos}: {excess} standard deviations");
        }
    }
}

/// What is sampled in another way is found out: by a lobe that is a tenth wider, and by one that leans a degree more.
#[test]
fn the_test_finds_what_is_wrong() {
    let [seen, wider] = [0.35, 0.37].map(|roughness| rough(&material(roughness, 1.0, 0.8), 0.5));
    let leaning = rough(&material(0.35, 1.0, 0.8), 0.515);
    for sampled in [wider, leaning] {
        assert!(excess(&seen, &sampled) > 2.0 * MOST, "{}", excess(&seen, &sampled));
    }
}

/// Light goes both ways alike where a lobe says so: metal and plastic without the light that microfacets reflect several times, whose share is
/// that of the eye's direction.
#[test]
fn single_reflections_are_reciprocal() {
    for (roughness, metallic) in [(0.3, 1.0), (0.6, 0.0), (1.0, 0.5)] {
        let material = material(roughness, metallic, 0.7);
        let reflected = |eye: Vec3, light: Vec3| {
            let bsdfs = Bsdfs::new(std::slice::from_ref(&material));
            let seen = bsdfs
                .seen(
                    Look::plain(0),
                    material.painted(),
                    SurfaceAxes::of_normals([Vec3::Z; 2]),
                    -eye,
                    SeenBy::Eye,
                )
                .expect("it has a layer");
            seen.once_towards(light) / light.z
        };
        for (a, b) in [(0.9, 0.3), (0.5, 0.2), (0.7, 0.1)] {
            let (one, other) =
                (at(a), Vec3::new(0.4, -0.5, 0.0).normalize() * (1.0_f32 - b * b).sqrt() + Vec3::Z * b);
            let [there, back] = [reflected(one, other), reflected(other, one)];
            assert!(
                (there - back).abs().max_element() < 1e-4 * there.max_element(),
                "{roughness} {a} {b}: {there} {back}"
            );
        }
    }
}
