//! Fractals of Perlin noise: Blender's Noise Texture node.
//!
//! The kinds are those of Musgrave in Ebert et al., "Texturing and Modeling: A Procedural Approach" (2003),
//! chapter 16, where the amplitude of an octave is a power of Roughness and its frequency one of Lacunarity.

use std::array;

use glam::Vec3;

use super::{Dimensions, finite, finite_vector, hash, mix, perlin, place_of, scaled, sum_of};

/// The most octaves after the first.
const MOST_DETAIL: f32 = 15.0;

/// How octaves of noise come together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FractalKind {
    /// Fractional Brownian motion: a sum.
    Fbm,
    /// A product: the rougher, the higher.
    Multifractal,
    /// A sum in which an octave counts as much as those before it are high: smooth valleys, rough peaks.
    HybridMultifractal,
    /// The same with sharp ridges where noise passes through zero.
    RidgedMultifractal,
    /// A sum in which an octave is multiplied by the height so far: like eroded land.
    HeteroTerrain,
}

/// Options of the Noise Texture node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Noise {
    /// Axes on which it depends.
    pub dimensions: Dimensions,
    /// How octaves come together.
    pub kind: FractalKind,
    /// Whether a sum ([`FractalKind::Fbm`]) is brought to 0 to 1; it is about -1 to 1 and more else.
    pub is_normalized: bool,
}

/// Inputs of the Noise Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NoiseInputs {
    /// Multiplies the place.
    pub scale: f32,
    /// Octaves after the first, 0 to 15 (clamped). A fraction adds a share of the next.
    pub detail: f32,
    /// Amplitude of an octave as a share of that of the one before; at least 0 (clamped).
    pub roughness: f32,
    /// Frequency of an octave as a multiple of that of the one before.
    pub lacunarity: f32,
    /// Added to the noise of an octave; of the last three kinds.
    pub offset: f32,
    /// How fast an octave counts less where those before it are low; of the hybrid and the ridged kind.
    pub gain: f32,
    /// How far the place is moved by another noise.
    pub distortion: f32,
}

impl Default for NoiseInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: 5.0,
            detail: 2.0,
            roughness: 0.5,
            lacunarity: 2.0,
            offset: 0.0,
            gain: 1.0,
            distortion: 0.0,
        }
    }
}

impl Noise {
    /// The output Factor.
    pub fn value(&self, vector: Vec3, w: f32, inputs: &NoiseInputs) -> f32 {
        match self.dimensions {
            Dimensions::One => self.value_at(moved::<1>(vector, w, inputs), inputs),
            Dimensions::Two => self.value_at(moved::<2>(vector, w, inputs), inputs),
            Dimensions::Three => self.value_at(moved::<3>(vector, w, inputs), inputs),
            Dimensions::Four => self.value_at(moved::<4>(vector, w, inputs), inputs),
        }
    }

    /// The output Color. Its first part is [`Self::value`], so who needs both asks for this alone.
    pub fn color(&self, vector: Vec3, w: f32, inputs: &NoiseInputs) -> Vec3 {
        match self.dimensions {
            Dimensions::One => self.color_at(moved::<1>(vector, w, inputs), inputs),
            Dimensions::Two => self.color_at(moved::<2>(vector, w, inputs), inputs),
            Dimensions::Three => self.color_at(moved::<3>(vector, w, inputs), inputs),
            Dimensions::Four => self.color_at(moved::<4>(vector, w, inputs), inputs),
        }
    }

    fn color_at<const N: usize>(&self, place: [f32; N], inputs: &NoiseInputs) -> Vec3 {
        let elsewhere = |seed: usize| self.value_at(sum_of(place, seed_offset(seed)), inputs);
        // The seeds below N are those of the distortion.
        finite_vector(Vec3::new(self.value_at(place, inputs), elsewhere(N), elsewhere(N + 1)))
    }

    fn value_at<const N: usize>(&self, place: [f32; N], inputs: &NoiseInputs) -> f32 {
        let octaves = Octaves {
            detail: inputs.detail.clamp(0.0, MOST_DETAIL),
            roughness: inputs.roughness.max(0.0),
            lacunarity: inputs.lacunarity,
        };
        let (offset, gain) = (inputs.offset, inputs.gain);
        finite(match self.kind {
            FractalKind::Fbm => octaves.fbm(place, self.is_normalized),
            FractalKind::Multifractal => octaves.multifractal(place),
            FractalKind::HybridMultifractal => octaves.hybrid_multifractal(place, offset, gain),
            FractalKind::RidgedMultifractal => octaves.ridged_multifractal(place, offset, gain),
            FractalKind::HeteroTerrain => octaves.hetero_terrain(place, offset),
        })
    }
}

/// The place times the scale, moved by the distortion.
fn moved<const N: usize>(vector: Vec3, w: f32, inputs: &NoiseInputs) -> [f32; N] {
    let place: [f32; N] = scaled(place_of(vector, w), inputs.scale);
    if inputs.distortion == 0.0 {
        return place;
    }
    let noise = |axis| perlin::signed(sum_of(place, seed_offset(axis)));
    array::from_fn(|axis| place[axis] + noise(axis) * inputs.distortion)
}

/// How far away the noise of a seed is looked up, 100 to 200 on each axis: noise itself has no seed.
fn seed_offset<const N: usize>(seed: usize) -> [f32; N] {
    let seed = seed as f32;
    array::from_fn(|axis| {
        let share = if N == 1 { hash::unit([seed]) } else { hash::unit([seed, axis as f32]) };
        100.0 + share * 100.0
    })
}

/// What all kinds of fractals share.
pub(super) struct Octaves {
    /// See [`NoiseInputs::detail`]; the caller clamps it.
    pub detail: f32,
    /// See [`NoiseInputs::roughness`].
    pub roughness: f32,
    /// See [`NoiseInputs::lacunarity`].
    pub lacunarity: f32,
}

impl Octaves {
    /// The number of octaves that count fully, and the share of one more.
    fn count(&self) -> (u32, f32) {
        (self.detail as u32 + 1, self.detail - self.detail.floor())
    }

    /// A sum of octaves.
    pub fn fbm<const N: usize>(&self, place: [f32; N], is_normalized: bool) -> f32 {
        let (count, share) = self.count();
        let (mut frequency, mut amplitude) = (1.0, 1.0);
        let (mut sum, mut most) = (0.0, 0.0);
        for _ in 0..count {
            sum += perlin::signed(scaled(place, frequency)) * amplitude;
            most += amplitude;
            amplitude *= self.roughness;
            frequency *= self.lacunarity;
        }
        let finish = |sum: f32, most: f32| if is_normalized { 0.5 * sum / most + 0.5 } else { sum };
        if share == 0.0 {
            return finish(sum, most);
        }
        let longer = sum + perlin::signed(scaled(place, frequency)) * amplitude;
        mix(finish(sum, most), finish(longer, most + amplitude), share)
    }

    fn multifractal<const N: usize>(&self, mut place: [f32; N]) -> f32 {
        let (count, share) = self.count();
        let (mut value, mut amplitude) = (1.0, 1.0);
        for _ in 0..count {
            value *= amplitude * perlin::signed(place) + 1.0;
            amplitude *= self.roughness;
            place = scaled(place, self.lacunarity);
        }
        if share != 0.0 {
            value *= share * amplitude * perlin::signed(place) + 1.0;
        }
        value
    }

    fn hybrid_multifractal<const N: usize>(&self, mut place: [f32; N], offset: f32, gain: f32) -> f32 {
        /// Octaves that count less are left out.
        const LEAST_WEIGHT: f32 = 0.001;
        let (count, share) = self.count();
        let (mut value, mut amplitude, mut weight) = (0.0, 1.0, 1.0_f32);
        for octave in 0..=count {
            let part = if octave < count { 1.0 } else { share };
            if part == 0.0 || weight.is_nan() || weight <= LEAST_WEIGHT {
                break;
            }
            weight = weight.min(1.0);
            let signal = (perlin::signed(place) + offset) * amplitude;
            value += part * weight * signal;
            weight *= gain * signal;
            amplitude *= self.roughness;
            place = scaled(place, self.lacunarity);
        }
        value
    }

    /// The share of one more octave is left out, as in Blender.
    fn ridged_multifractal<const N: usize>(&self, mut place: [f32; N], offset: f32, gain: f32) -> f32 {
        let ridge = |place| {
            let height = offset - perlin::signed(place).abs();
            height * height
        };
        let mut signal = ridge(place);
        let (mut value, mut amplitude) = (signal, self.roughness);
        for _ in 1..self.count().0 {
            place = scaled(place, self.lacunarity);
            let weight = (signal * gain).clamp(0.0, 1.0);
            signal = ridge(place) * weight;
            value += signal * amplitude;
            amplitude *= self.roughness;
        }
        value
    }

    fn hetero_terrain<const N: usize>(&self, mut place: [f32; N], offset: f32) -> f32 {
        let (count, share) = self.count();
        let mut value = offset + perlin::signed(place);
        let mut amplitude = self.roughness;
        for octave in 1..=count {
            let part = if octave < count { 1.0 } else { share };
            if part == 0.0 {
                break;
            }
            place = scaled(place, self.lacunarity);
            value += part * (perlin::signed(place) + offset) * amplitude * value;
            amplitude *= self.roughness;
        }
        value
    }
}
