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
use crate::lanes::{F32x8, LANES, Vec3x8};

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

    /// Eight nasty numbers.
    fn nasties(&mut self) -> F32x8 {
        F32x8::new(std::array::from_fn(|_| self.nasty()))
    }

    fn nasty_vectors(&mut self) -> Vec3x8 {
        Vec3x8::from([self.nasties(), self.nasties(), self.nasties()])
    }
}

/// The vectors of all lanes.
fn each_lane(vectors: Vec3x8) -> [Vec3; LANES] {
    std::array::from_fn(|lane| vectors.lane(lane))
}

/// Noise at one place.
fn signed<const N: usize>(place: [f32; N]) -> f32 {
    perlin::signed(place.map(F32x8::splat), 1).lane(0)
}

fn alike(value: f32) -> F32x8 {
    F32x8::splat(value)
}

fn nasty_noise(chance: &mut Chance) -> [Vec3; LANES] {
    let inputs = NoiseInputs {
        scale: chance.nasties(),
        detail: chance.nasties(),
        roughness: chance.nasties(),
        lacunarity: chance.nasties(),
        offset: chance.nasties(),
        gain: chance.nasties(),
        distortion: chance.nasties(),
    };
    let (dimensions, kind) = (chance.choice(&DIMENSIONS), chance.choice(&FRACTALS));
    let noise = Noise { dimensions, kind, is_normalized: chance.unit() < 0.5 };
    let (vector, w) = (chance.nasty_vectors(), chance.nasties());
    let color = noise.color(vector, w, &inputs, LANES);
    assert_eq!(color.x, noise.value(vector, w, &inputs, LANES), "{noise:?} {inputs:?}");
    each_lane(color)
}

fn nasty_voronoi(chance: &mut Chance) -> [Vec3; LANES] {
    let inputs = VoronoiInputs {
        scale: chance.nasties(),
        detail: chance.nasties(),
        roughness: chance.nasties(),
        lacunarity: chance.nasties(),
        smoothness: chance.nasties(),
        exponent: chance.nasties(),
        randomness: chance.nasties(),
    };
    let voronoi = Voronoi {
        // Four dimensions take long, and have nothing of their own.
        dimensions: chance.choice(&DIMENSIONS[..3]),
        feature: chance.choice(&FEATURES),
        metric: chance.choice(&METRICS),
        is_normalized: chance.unit() < 0.5,
    };
    let found = voronoi.outputs(chance.nasty_vectors(), chance.nasties(), &inputs, LANES);
    let vectors = [found.color, found.position].map(each_lane);
    assert!(vectors.as_flattened().iter().all(|one| one.is_finite()), "{voronoi:?} {inputs:?} {found:?}");
    each_lane([found.distance, found.w, found.radius].into())
}

fn nasty_wave(chance: &mut Chance) -> [Vec3; LANES] {
    let inputs = WaveInputs {
        scale: chance.nasties(),
        distortion: chance.nasties(),
        detail: chance.nasties(),
        detail_scale: chance.nasties(),
        detail_roughness: chance.nasties(),
        phase_offset: chance.nasties(),
    };
    let wave = Wave { shape: chance.choice(&SHAPES), profile: chance.choice(&PROFILES) };
    each_lane(Vec3x8::all_of(wave.value(chance.nasty_vectors(), &inputs, LANES)))
}

fn nasty_magic(chance: &mut Chance) -> [Vec3; LANES] {
    let magic = Magic { depth: (chance.unit() * 14.0) as u32 };
    let inputs = MagicInputs { scale: chance.nasty(), distortion: chance.nasty() };
    let vector = chance.nasty_vector();
    [magic.color(vector, &inputs).with_x(magic.value(vector, &inputs)); LANES]
}

fn nasty_brick(chance: &mut Chance) -> [Vec3; LANES] {
    let brick = Brick {
        offset: chance.nasty(),
        offset_frequency: chance.choice(&[0, 1, 2, 99, u32::MAX]),
        squash: chance.nasty(),
        squash_frequency: chance.choice(&[0, 1, 2, 99, u32::MAX]),
    };
    let inputs = BrickInputs {
        scale: chance.nasties(),
        mortar_size: chance.nasties(),
        mortar_smooth: chance.nasties(),
        bias: chance.nasties(),
        brick_width: chance.nasties(),
        row_height: chance.nasties(),
        ..BrickInputs::default()
    };
    let vector = chance.nasty_vectors();
    for value in brick.value(vector, &inputs).values() {
        assert!((0.0..=1.0).contains(value), "{brick:?} {inputs:?} {value}");
    }
    each_lane(brick.color(vector, &inputs))
}

fn nasty_gabor(chance: &mut Chance) -> [Vec3; LANES] {
    let inputs = GaborInputs {
        scale: chance.nasty(),
        frequency: chance.nasty(),
        anisotropy: chance.nasty(),
        orientation_2d: chance.nasty(),
        orientation_3d: chance.nasty_vector(),
    };
    let found = chance.choice(&[Gabor::Flat, Gabor::Solid]).outputs(chance.nasty_vector(), &inputs);
    [Vec3::new(found.value, found.phase, found.intensity); LANES]
}

#[test]
fn outputs_are_finite_whatever_the_inputs() {
    let patterns = [nasty_noise, nasty_voronoi, nasty_wave, nasty_magic, nasty_brick, nasty_gabor]
        .into_iter()
        .enumerate();
    for (index, pattern) in patterns {
        let mut chance = Chance(index as u32 * 100_000);
        for _ in 0..400 {
            let found = pattern(&mut chance);
            assert!(found.iter().all(|one| one.is_finite()), "pattern {index} at {}: {found:?}", chance.0);
        }
    }
    let mut chance = Chance(900_000);
    for _ in 0..300 {
        let (vector, w) = (chance.nasty_vectors(), chance.nasties());
        let checker = Checker.value(vector, &CheckerInputs { scale: chance.nasties(), ..Default::default() });
        let noise = WhiteNoise { dimensions: chance.choice(&DIMENSIONS) }.color(vector, w);
        let gradient = chance.choice(&GRADIENTS).value(vector);
        for value in [checker, gradient, noise.x, noise.y, noise.z].map(|value| *value.values()).concat() {
            assert!((0.0..=1.0).contains(&value), "{vector:?} {w:?}: {value}");
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
        for value in [signed([a]), signed([a, b]), signed([a, b, c])] {
            assert_eq!(value, 0.0);
        }
        assert_eq!(signed([a, b, c, d]), 0.0);
        let all = [signed([x]), signed([x, y]), signed([x, y, z])];
        for value in all.into_iter().chain([signed([x, y, z, w])]) {
            assert!(value.abs() <= 1.05, "{value}");
        }
    }
}

#[test]
fn perlin_noise_repeats_far_from_the_origin() {
    // Fractions that floats hold there, too.
    for place in [[0.25, 1.5, 2.0], [77.75, 3.25, 9.5]] {
        let far = place.map(|value| value + 100_000.0);
        assert_eq!(signed(place), signed(far));
        let mirrored = far.map(|value: f32| -value);
        assert_eq!(signed(place.map(|value| -value)), signed(mirrored));
    }
    // Still farther it is looked up between the lattice planes.
    assert!((0..9).any(|step| signed([3_000_000.0 + step as f32]) != 0.0));
}

#[test]
fn noise_that_is_normalized_is_within_0_to_1() {
    let mut chance = Chance(7);
    for dimensions in DIMENSIONS {
        let noise = Noise { dimensions, kind: FractalKind::Fbm, is_normalized: true };
        let plain = Noise { is_normalized: false, ..noise };
        for _ in 0..300 {
            let (vector, w) = (Vec3x8::splat(chance.vector(10.0)), alike(chance.within(10.0)));
            let inputs = NoiseInputs { detail: alike(chance.unit() * 5.0), ..Default::default() };
            let value = |noise: Noise, inputs| noise.value(vector, w, inputs, 1).lane(0);
            assert!((-0.03..=1.03).contains(&value(noise, &inputs)));
            let single = NoiseInputs { detail: F32x8::ZERO, ..inputs };
            let remapped = value(plain, &single) * 0.5 + 0.5;
            assert!((value(noise, &single) - remapped).abs() < 1e-6);
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
            let (vector, w) = (Vec3x8::splat(chance.vector(3.0)), alike(chance.within(3.0)));
            let value = |feature| voronoi(dimensions, feature).value(vector, w, &inputs, 1).lane(0);
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
    let inputs = VoronoiInputs { scale: alike(3.0), ..Default::default() };
    for _ in 0..200 {
        let vector = chance.vector(3.0);
        let place = Vec3x8::splat(vector);
        let found = voronoi(Dimensions::Three, VoronoiFeature::F1).outputs(place, F32x8::ZERO, &inputs, 1);
        let distance = found.position.lane(0).distance(vector) * 3.0;
        assert!((distance - found.distance.lane(0)).abs() < 1e-4);
    }
}

#[test]
fn voronoi_without_randomness_is_a_lattice() {
    let inputs = VoronoiInputs { scale: F32x8::ONE, randomness: F32x8::ZERO, ..Default::default() };
    let place = |x, y, z| Vec3x8::splat(Vec3::new(x, y, z));
    let first = voronoi(Dimensions::Three, VoronoiFeature::F1);
    let found = first.outputs(place(0.25, -3.25, 7.125), F32x8::ZERO, &inputs, 1);
    assert_eq!(found.position.lane(0), Vec3::new(0.0, -3.0, 7.0));
    let edge = voronoi(Dimensions::Two, VoronoiFeature::DistanceToEdge);
    let distance = edge.value(place(0.25, 4.0, 0.0), F32x8::ZERO, &inputs, 1).lane(0);
    assert!((distance - 0.25).abs() < 1e-6);
}

#[test]
fn checkers_wave_and_gradient_are_within_their_ranges() {
    let mut chance = Chance(17);
    let unscaled = CheckerInputs { scale: F32x8::ONE, ..Default::default() };
    for _ in 0..300 {
        let vector = chance.vector(20.0);
        let checker = |vector: Vec3| Checker.value(Vec3x8::splat(vector), &unscaled).lane(0);
        assert_eq!(checker(vector), checker(vector + 2.0));
        assert_ne!(checker(vector), checker(vector + Vec3::X));
        let wave = Wave { shape: chance.choice(&SHAPES), profile: chance.choice(&PROFILES) };
        let inputs = WaveInputs { distortion: alike(chance.within(4.0)), ..Default::default() };
        assert!((0.0..=1.0).contains(&wave.value(Vec3x8::splat(vector), &inputs, 1).lane(0)));
    }
    let gradient = |gradient: Gradient, at: Vec3| gradient.value(Vec3x8::splat(at)).lane(0);
    assert_eq!(gradient(Gradient::Radial, Vec3::X), 0.5);
    assert_eq!(gradient(Gradient::Spherical, Vec3::ONE.normalize()), 0.0);
}

#[test]
fn waves_repeat_after_a_full_turn() {
    let mut chance = Chance(19);
    for _ in 0..200 {
        let vector = chance.vector(2.0);
        let wave = Wave { shape: chance.choice(&SHAPES), profile: WaveProfile::Sine };
        let inputs = WaveInputs { scale: F32x8::ONE, ..Default::default() };
        let later = WaveInputs { phase_offset: alike(TAU), ..inputs };
        let value = |inputs| wave.value(Vec3x8::splat(vector), inputs, 1).lane(0);
        assert!((value(&inputs) - value(&later)).abs() < 1e-4);
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
