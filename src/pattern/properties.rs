//! What holds for the patterns whatever Blender gives: ranges, periods, and that all outputs are finite.

use std::f32::consts::TAU;

use glam::Vec3;

use super::brick::{Brick, BrickInputs};
use super::checker::{Checker, CheckerInputs};
use super::fractal::{FractalKind, Noise, NoiseInputs};
use super::gabor::{Gabor, GaborInputs};
use super::gradient::Gradient;
use super::magic::{Magic, MagicInputs};
use super::voronoi::{Voronoi, VoronoiFeature, VoronoiInputs, VoronoiMetric};
use super::wave::{Wave, WaveInputs, WaveProfile, WaveShape};
use super::white::WhiteNoise;
use super::{Dimensions, hash, perlin};

const DIMENSIONS: [Dimensions; 4] = [Dimensions::One, Dimensions::Two, Dimensions::Three, Dimensions::Four];
const FRACTALS: [FractalKind; 5] = [
    FractalKind::Fbm,
    FractalKind::Multifractal,
    FractalKind::HybridMultifractal,
    FractalKind::RidgedMultifractal,
    FractalKind::HeteroTerrain,
];
const FEATURES: [VoronoiFeature; 5] = [
    VoronoiFeature::F1,
    VoronoiFeature::F2,
    VoronoiFeature::SmoothF1,
    VoronoiFeature::DistanceToEdge,
    VoronoiFeature::NSphereRadius,
];
const METRICS: [VoronoiMetric; 4] =
    [VoronoiMetric::Euclidean, VoronoiMetric::Manhattan, VoronoiMetric::Chebychev, VoronoiMetric::Minkowski];
const SHAPES: [WaveShape; 8] = [
    WaveShape::BandsX,
    WaveShape::BandsY,
    WaveShape::BandsZ,
    WaveShape::BandsDiagonal,
    WaveShape::RingsX,
    WaveShape::RingsY,
    WaveShape::RingsZ,
    WaveShape::RingsSpherical,
];
const PROFILES: [WaveProfile; 3] = [WaveProfile::Sine, WaveProfile::Saw, WaveProfile::Triangle];
const GRADIENTS: [Gradient; 7] = [
    Gradient::Linear,
    Gradient::Quadratic,
    Gradient::Easing,
    Gradient::Diagonal,
    Gradient::Spherical,
    Gradient::QuadraticSphere,
    Gradient::Radial,
];

/// Random numbers, the same in each run.
struct Chance(u32);

impl Chance {
    /// 0 to 1.
    fn unit(&mut self) -> f32 {
        self.0 += 1;
        hash::unit([self.0 as f32])
    }

    /// From minus `reach` to `reach`.
    fn within(&mut self, reach: f32) -> f32 {
        (self.unit() * 2.0 - 1.0) * reach
    }

    fn vector(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.within(reach), self.within(reach), self.within(reach))
    }

    fn choice<T: Copy>(&mut self, all: &[T]) -> T {
        all[((self.unit() * all.len() as f32) as usize).min(all.len() - 1)]
    }

    /// A number that breaks careless arithmetic, or a plain one.
    fn nasty(&mut self) -> f32 {
        let plain = self.within(9.0);
        let huge = [1e30, -1e30, 1e20, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        let small = [0.0, -0.0, 1e-40, 1.0, -1.0, 0.5, 16.0, 3e9];
        match (self.unit() * 4.0) as u32 {
            0 => self.choice(&huge),
            1 => self.choice(&small),
            _ => plain,
        }
    }

    fn nasty_vector(&mut self) -> Vec3 {
        Vec3::new(self.nasty(), self.nasty(), self.nasty())
    }
}

fn nasty_noise(chance: &mut Chance) -> Vec3 {
    let inputs = NoiseInputs {
        scale: chance.nasty(),
        detail: chance.nasty(),
        roughness: chance.nasty(),
        lacunarity: chance.nasty(),
        offset: chance.nasty(),
        gain: chance.nasty(),
        distortion: chance.nasty(),
    };
    let (dimensions, kind) = (chance.choice(&DIMENSIONS), chance.choice(&FRACTALS));
    let noise = Noise { dimensions, kind, is_normalized: chance.unit() < 0.5 };
    let (vector, w) = (chance.nasty_vector(), chance.nasty());
    let color = noise.color(vector, w, &inputs);
    assert_eq!(color.x, noise.value(vector, w, &inputs), "{noise:?} {inputs:?}");
    color
}

fn nasty_voronoi(chance: &mut Chance) -> Vec3 {
    let inputs = VoronoiInputs {
        scale: chance.nasty(),
        detail: chance.nasty(),
        roughness: chance.nasty(),
        lacunarity: chance.nasty(),
        smoothness: chance.nasty(),
        exponent: chance.nasty(),
        randomness: chance.nasty(),
    };
    let voronoi = Voronoi {
        // Four dimensions take long, and have nothing of their own.
        dimensions: chance.choice(&DIMENSIONS[..3]),
        feature: chance.choice(&FEATURES),
        metric: chance.choice(&METRICS),
        is_normalized: chance.unit() < 0.5,
    };
    let found = voronoi.outputs(chance.nasty_vector(), chance.nasty(), &inputs);
    assert!(found.color.is_finite() && found.position.is_finite(), "{voronoi:?} {inputs:?} {found:?}");
    Vec3::new(found.distance, found.w, found.radius)
}

fn nasty_wave(chance: &mut Chance) -> Vec3 {
    let inputs = WaveInputs {
        scale: chance.nasty(),
        distortion: chance.nasty(),
        detail: chance.nasty(),
        detail_scale: chance.nasty(),
        detail_roughness: chance.nasty(),
        phase_offset: chance.nasty(),
    };
    let wave = Wave { shape: chance.choice(&SHAPES), profile: chance.choice(&PROFILES) };
    wave.color(chance.nasty_vector(), &inputs)
}

fn nasty_magic(chance: &mut Chance) -> Vec3 {
    let magic = Magic { depth: (chance.unit() * 14.0) as u32 };
    let inputs = MagicInputs { scale: chance.nasty(), distortion: chance.nasty() };
    let vector = chance.nasty_vector();
    magic.color(vector, &inputs).with_x(magic.value(vector, &inputs))
}

fn nasty_brick(chance: &mut Chance) -> Vec3 {
    let brick = Brick {
        offset: chance.nasty(),
        offset_frequency: chance.choice(&[0, 1, 2, 99, u32::MAX]),
        squash: chance.nasty(),
        squash_frequency: chance.choice(&[0, 1, 2, 99, u32::MAX]),
    };
    let inputs = BrickInputs {
        scale: chance.nasty(),
        mortar_size: chance.nasty(),
        mortar_smooth: chance.nasty(),
        bias: chance.nasty(),
        brick_width: chance.nasty(),
        row_height: chance.nasty(),
        ..BrickInputs::default()
    };
    let vector = chance.nasty_vector();
    let value = brick.value(vector, &inputs);
    assert!((0.0..=1.0).contains(&value), "{brick:?} {inputs:?} {value}");
    brick.color(vector, &inputs)
}

fn nasty_gabor(chance: &mut Chance) -> Vec3 {
    let inputs = GaborInputs {
        scale: chance.nasty(),
        frequency: chance.nasty(),
        anisotropy: chance.nasty(),
        orientation_2d: chance.nasty(),
        orientation_3d: chance.nasty_vector(),
    };
    let found = chance.choice(&[Gabor::Flat, Gabor::Solid]).outputs(chance.nasty_vector(), &inputs);
    Vec3::new(found.value, found.phase, found.intensity)
}

#[test]
fn outputs_are_finite_whatever_the_inputs() {
    let patterns = [nasty_noise, nasty_voronoi, nasty_wave, nasty_magic, nasty_brick, nasty_gabor]
        .into_iter()
        .enumerate();
    for (index, pattern) in patterns {
        let mut chance = Chance(index as u32 * 100_000);
        for _ in 0..1500 {
            let found = pattern(&mut chance);
            assert!(found.is_finite(), "pattern {index} at {}: {found}", chance.0);
        }
    }
    let mut chance = Chance(900_000);
    for _ in 0..1000 {
        let (vector, w) = (chance.nasty_vector(), chance.nasty());
        let checker = Checker.value(vector, &CheckerInputs { scale: chance.nasty(), ..Default::default() });
        let noise = WhiteNoise { dimensions: chance.choice(&DIMENSIONS) }.color(vector, w);
        let gradient = chance.choice(&GRADIENTS).value(vector);
        for value in [checker, gradient, noise.x, noise.y, noise.z] {
            assert!((0.0..=1.0).contains(&value), "{vector} {w}: {value}");
        }
    }
}

#[test]
fn perlin_noise_is_zero_on_the_lattice_and_within_one() {
    let mut chance = Chance(0);
    for _ in 0..2000 {
        let Vec3 { x, y, z } = chance.vector(100.0);
        let w = chance.within(100.0);
        let [a, b, c, d] = [x, y, z, w].map(f32::round);
        for value in [perlin::signed([a]), perlin::signed([a, b]), perlin::signed([a, b, c])] {
            assert_eq!(value, 0.0);
        }
        assert_eq!(perlin::signed([a, b, c, d]), 0.0);
        let all = [perlin::signed([x]), perlin::signed([x, y]), perlin::signed([x, y, z])];
        for value in all.into_iter().chain([perlin::signed([x, y, z, w])]) {
            assert!(value.abs() <= 1.05, "{value}");
        }
        assert_eq!(perlin::unsigned([x, y]), 0.5 * perlin::signed([x, y]) + 0.5);
    }
}

#[test]
fn perlin_noise_repeats_far_from_the_origin() {
    // Fractions that floats hold there, too.
    for place in [[0.25, 1.5, 2.0], [77.75, 3.25, 9.5]] {
        let far = place.map(|value| value + 100_000.0);
        assert_eq!(perlin::signed(place), perlin::signed(far));
        let mirrored = far.map(|value: f32| -value);
        assert_eq!(perlin::signed(place.map(|value| -value)), perlin::signed(mirrored));
    }
    // Still farther it is looked up between the lattice planes.
    assert!((0..9).any(|step| perlin::signed([3_000_000.0 + step as f32]) != 0.0));
}

#[test]
fn noise_that_is_normalized_is_within_0_to_1() {
    let mut chance = Chance(7);
    for dimensions in DIMENSIONS {
        let noise = Noise { dimensions, kind: FractalKind::Fbm, is_normalized: true };
        let plain = Noise { is_normalized: false, ..noise };
        for _ in 0..300 {
            let (vector, w) = (chance.vector(10.0), chance.within(10.0));
            let inputs = NoiseInputs { detail: chance.unit() * 5.0, ..Default::default() };
            assert!((-0.03..=1.03).contains(&noise.value(vector, w, &inputs)));
            let single = NoiseInputs { detail: 0.0, ..inputs };
            let remapped = plain.value(vector, w, &single) * 0.5 + 0.5;
            assert!((noise.value(vector, w, &single) - remapped).abs() < 1e-6);
        }
    }
}

fn voronoi(dimensions: Dimensions, feature: VoronoiFeature) -> Voronoi {
    Voronoi { dimensions, feature, metric: VoronoiMetric::Euclidean, is_normalized: false }
}

#[test]
fn features_of_voronoi_are_in_order() {
    let mut chance = Chance(11);
    let inputs = VoronoiInputs::default();
    for dimensions in DIMENSIONS {
        for _ in 0..100 {
            let (vector, w) = (chance.vector(3.0), chance.within(3.0));
            let value = |feature| voronoi(dimensions, feature).value(vector, w, &inputs);
            let first = value(VoronoiFeature::F1);
            assert!(first <= value(VoronoiFeature::F2));
            assert!(value(VoronoiFeature::SmoothF1) <= first + 1e-6);
            assert!(value(VoronoiFeature::DistanceToEdge) >= -1e-6);
            assert!(value(VoronoiFeature::NSphereRadius) > 0.0);
        }
    }
}

#[test]
fn position_of_voronoi_is_as_far_as_it_says() {
    let mut chance = Chance(13);
    let inputs = VoronoiInputs { scale: 3.0, ..Default::default() };
    for _ in 0..200 {
        let vector = chance.vector(3.0);
        let found = voronoi(Dimensions::Three, VoronoiFeature::F1).outputs(vector, 0.0, &inputs);
        assert!((found.position.distance(vector) * 3.0 - found.distance).abs() < 1e-4);
    }
}

#[test]
fn voronoi_without_randomness_is_a_lattice() {
    let inputs = VoronoiInputs { scale: 1.0, randomness: 0.0, ..Default::default() };
    let found =
        voronoi(Dimensions::Three, VoronoiFeature::F1).outputs(Vec3::new(0.25, -3.25, 7.125), 0.0, &inputs);
    assert_eq!(found.position, Vec3::new(0.0, -3.0, 7.0));
    let edge = voronoi(Dimensions::Two, VoronoiFeature::DistanceToEdge);
    assert!((edge.value(Vec3::new(0.25, 4.0, 0.0), 0.0, &inputs) - 0.25).abs() < 1e-6);
}

#[test]
fn checkers_wave_and_gradient_are_within_their_ranges() {
    let mut chance = Chance(17);
    let unscaled = CheckerInputs { scale: 1.0, ..Default::default() };
    for _ in 0..300 {
        let vector = chance.vector(20.0);
        let value = Checker.value(vector, &unscaled);
        assert_eq!(value, Checker.value(vector + 2.0, &unscaled));
        assert_ne!(value, Checker.value(vector + Vec3::X, &unscaled));
        let wave = Wave { shape: chance.choice(&SHAPES), profile: chance.choice(&PROFILES) };
        let inputs = WaveInputs { distortion: chance.within(4.0), ..Default::default() };
        assert!((0.0..=1.0).contains(&wave.value(vector, &inputs)));
    }
    assert_eq!(Gradient::Radial.value(Vec3::X), 0.5);
    assert_eq!(Gradient::Spherical.value(Vec3::ONE.normalize()), 0.0);
}

#[test]
fn waves_repeat_after_a_full_turn() {
    let mut chance = Chance(19);
    for _ in 0..200 {
        let vector = chance.vector(2.0);
        let wave = Wave { shape: chance.choice(&SHAPES), profile: WaveProfile::Sine };
        let inputs = WaveInputs { scale: 1.0, ..Default::default() };
        let later = WaveInputs { phase_offset: TAU, ..inputs };
        assert!((wave.value(vector, &inputs) - wave.value(vector, &later)).abs() < 1e-4);
    }
}

#[test]
fn magic_and_gabor_are_within_their_ranges() {
    let mut chance = Chance(23);
    for _ in 0..300 {
        let vector = chance.vector(4.0);
        let magic = Magic { depth: 1 + (chance.unit() * 10.0) as u32 };
        let color = magic.color(vector, &MagicInputs { scale: 1.0, ..Default::default() });
        assert!(color.min_element() >= -1e-6 && color.max_element() <= 1.0 + 1e-6, "{magic:?} {color}");
        let found = chance.choice(&[Gabor::Flat, Gabor::Solid]).outputs(vector, &GaborInputs::default());
        assert!((0.0..=1.0).contains(&found.phase));
        assert!((found.value * 2.0 - 1.0).abs() <= found.intensity + 1e-5);
    }
}
