//! Fractals of Perlin noise: Blender's Noise Texture node.
//!
//! The kinds are those of Musgrave in Ebert et al., "Texturing and Modeling: A Procedural Approach" (2003),
//! chapter 16, where the amplitude of an octave is a power of Roughness and its frequency one of Lacunarity.

use std::array;

use super::{Dimensions, finite8, hash, mix, perlin, place_of, scaled, sum_of};
use crate::lanes::{F32x8, Mask, Vec3x8};

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
    pub scale: F32x8,
    /// Octaves after the first, 0 to 15 (clamped). A fraction adds a share of the next.
    pub detail: F32x8,
    /// Amplitude of an octave as a share of that of the one before; at least 0 (clamped).
    pub roughness: F32x8,
    /// Frequency of an octave as a multiple of that of the one before.
    pub lacunarity: F32x8,
    /// Added to the noise of an octave; of the last three kinds.
    pub offset: F32x8,
    /// How fast an octave counts less where those before it are low; of the hybrid and the ridged kind.
    pub gain: F32x8,
    /// How far the place is moved by another noise.
    pub distortion: F32x8,
}

impl Default for NoiseInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: F32x8::splat(5.0),
            detail: F32x8::splat(2.0),
            roughness: F32x8::splat(0.5),
            lacunarity: F32x8::splat(2.0),
            offset: F32x8::splat(0.0),
            gain: F32x8::splat(1.0),
            distortion: F32x8::splat(0.0),
        }
    }
}

impl Noise {
    /// The output Factor at the first `lanes` places.
    pub fn value(&self, vector: Vec3x8, w: F32x8, inputs: &NoiseInputs, lanes: usize) -> F32x8 {
        match self.dimensions {
            Dimensions::One => self.value_at(moved::<1>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Two => self.value_at(moved::<2>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Three => self.value_at(moved::<3>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Four => self.value_at(moved::<4>(vector, w, inputs, lanes), inputs, lanes),
        }
    }

    /// The output Color. Its first part is [`Self::value`], so who needs both asks for this alone.
    pub fn color(&self, vector: Vec3x8, w: F32x8, inputs: &NoiseInputs, lanes: usize) -> Vec3x8 {
        match self.dimensions {
            Dimensions::One => self.color_at(moved::<1>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Two => self.color_at(moved::<2>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Three => self.color_at(moved::<3>(vector, w, inputs, lanes), inputs, lanes),
            Dimensions::Four => self.color_at(moved::<4>(vector, w, inputs, lanes), inputs, lanes),
        }
    }

    fn color_at<const N: usize>(&self, place: [F32x8; N], inputs: &NoiseInputs, lanes: usize) -> Vec3x8 {
        let elsewhere = |seed: usize| self.value_at(sum_of(place, seed_offset(seed)), inputs, lanes);
        // The seeds below N are those of the distortion.
        Vec3x8::from([self.value_at(place, inputs, lanes), elsewhere(N), elsewhere(N + 1)])
    }

    fn value_at<const N: usize>(&self, place: [F32x8; N], inputs: &NoiseInputs, lanes: usize) -> F32x8 {
        let octaves = Octaves {
            detail: inputs.detail.clamp(0.0, MOST_DETAIL),
            roughness: inputs.roughness.max(F32x8::ZERO),
            lacunarity: inputs.lacunarity,
            lanes,
        };
        let (offset, gain) = (inputs.offset, inputs.gain);
        finite8(match self.kind {
            FractalKind::Fbm => octaves.fbm(place, self.is_normalized),
            FractalKind::Multifractal => octaves.multifractal(place),
            FractalKind::HybridMultifractal => octaves.hybrid_multifractal(place, offset, gain),
            FractalKind::RidgedMultifractal => octaves.ridged_multifractal(place, offset, gain),
            FractalKind::HeteroTerrain => octaves.hetero_terrain(place, offset),
        })
    }
}

/// The place times the scale, moved by the distortion.
fn moved<const N: usize>(vector: Vec3x8, w: F32x8, inputs: &NoiseInputs, lanes: usize) -> [F32x8; N] {
    let place: [F32x8; N] = scaled(place_of(vector, w), inputs.scale);
    let is_moved = !inputs.distortion.is_zero();
    if !is_moved.any_of(lanes) {
        return place;
    }
    array::from_fn(|axis| {
        let noise = perlin::signed(sum_of(place, seed_offset(axis)), lanes);
        is_moved.select(place[axis] + noise * inputs.distortion, place[axis])
    })
}

/// How far away the noise of a seed is looked up, 100 to 200 on each axis: noise itself has no seed.
fn seed_offset<const N: usize>(seed: usize) -> [F32x8; N] {
    let seed = seed as f32;
    array::from_fn(|axis| {
        let share = if N == 1 { hash::unit([seed]) } else { hash::unit([seed, axis as f32]) };
        F32x8::splat(100.0 + share * 100.0)
    })
}

/// What all kinds of fractals share.
pub(super) struct Octaves {
    /// See [`NoiseInputs::detail`]; the caller clamps it.
    pub detail: F32x8,
    /// See [`NoiseInputs::roughness`].
    pub roughness: F32x8,
    /// See [`NoiseInputs::lacunarity`].
    pub lacunarity: F32x8,
    /// Number of places that count.
    pub lanes: usize,
}

impl Octaves {
    /// The number of octaves that count fully, and the share of one more.
    fn count(&self) -> (F32x8, F32x8) {
        let whole = self.detail.floor();
        (whole + 1.0, self.detail - whole)
    }

    /// The number of octaves from the first to the last that counts at any place; `has_share`: one more where it has a share.
    fn most(&self, has_share: bool) -> u32 {
        let of_lane = |detail: &f32| if has_share { detail.ceil() } else { detail.floor() };
        let most = self.detail.values()[..self.lanes].iter().map(of_lane).fold(0.0, f32::max);
        most as u32 + 1
    }

    /// A sum of octaves.
    pub fn fbm<const N: usize>(&self, place: [F32x8; N], is_normalized: bool) -> F32x8 {
        let (count, share) = self.count();
        let (mut frequency, mut amplitude) = (F32x8::ONE, F32x8::ONE);
        let (mut sum, mut most) = (F32x8::ZERO, F32x8::ZERO);
        let [mut longer, mut most_longer] = [F32x8::ONE; 2];
        for octave in 0..self.most(true) {
            let octave = F32x8::splat(octave as f32);
            let next = sum + perlin::signed(scaled(place, frequency), self.lanes) * amplitude;
            let most_next = most + amplitude;
            let (is_whole, is_last) = (octave.lt(count), octave.equals(count));
            (longer, most_longer) = (is_last.select(next, longer), is_last.select(most_next, most_longer));
            (sum, most) = (is_whole.select(next, sum), is_whole.select(most_next, most));
            amplitude = amplitude * self.roughness;
            frequency = frequency * self.lacunarity;
        }
        let finish = |sum: F32x8, most: F32x8| if is_normalized { sum * 0.5 / most + 0.5 } else { sum };
        let whole = finish(sum, most);
        share.is_zero().select(whole, mix(whole, finish(longer, most_longer), share))
    }

    fn multifractal<const N: usize>(&self, mut place: [F32x8; N]) -> F32x8 {
        let (count, share) = self.count();
        let (mut value, mut amplitude) = (F32x8::ONE, F32x8::ONE);
        for octave in 0..self.most(true) {
            let octave = F32x8::splat(octave as f32);
            let part = octave.lt(count).select(amplitude, share * amplitude);
            let next = value * (part * perlin::signed(place, self.lanes) + 1.0);
            value = counts(octave, count, share).select(next, value);
            amplitude = amplitude * self.roughness;
            place = scaled(place, self.lacunarity);
        }
        value
    }

    fn hybrid_multifractal<const N: usize>(
        &self,
        mut place: [F32x8; N],
        offset: F32x8,
        gain: F32x8,
    ) -> F32x8 {
        /// Octaves that count less are left out.
        const LEAST_WEIGHT: f32 = 0.001;
        let (count, share) = self.count();
        let (mut value, mut amplitude, mut weight) = (F32x8::ZERO, F32x8::ONE, F32x8::ONE);
        let mut goes_on = Mask::ALL;
        for octave in 0..self.most(true) {
            let octave = F32x8::splat(octave as f32);
            goes_on = goes_on & counts(octave, count, share) & weight.gt(F32x8::splat(LEAST_WEIGHT));
            if !goes_on.any_of(self.lanes) {
                break;
            }
            let part = octave.lt(count).select(F32x8::ONE, share);
            weight = weight.min(F32x8::ONE);
            let signal = (perlin::signed(place, self.lanes) + offset) * amplitude;
            value = goes_on.select(value + part * weight * signal, value);
            weight = weight * (gain * signal);
            amplitude = amplitude * self.roughness;
            place = scaled(place, self.lacunarity);
        }
        value
    }

    /// The share of one more octave is left out, as in Blender.
    fn ridged_multifractal<const N: usize>(
        &self,
        mut place: [F32x8; N],
        offset: F32x8,
        gain: F32x8,
    ) -> F32x8 {
        let ridge = |place| {
            let height = offset - perlin::signed(place, self.lanes).abs();
            height * height
        };
        let (count, _) = self.count();
        let mut signal = ridge(place);
        let (mut value, mut amplitude) = (signal, self.roughness);
        for octave in 1..self.most(false) {
            place = scaled(place, self.lacunarity);
            let weight = (signal * gain).clamp(0.0, 1.0);
            signal = ridge(place) * weight;
            value = F32x8::splat(octave as f32).lt(count).select(value + signal * amplitude, value);
            amplitude = amplitude * self.roughness;
        }
        value
    }

    fn hetero_terrain<const N: usize>(&self, mut place: [F32x8; N], offset: F32x8) -> F32x8 {
        let (count, share) = self.count();
        let mut value = offset + perlin::signed(place, self.lanes);
        let mut amplitude = self.roughness;
        for octave in 1..self.most(true) {
            let octave = F32x8::splat(octave as f32);
            let part = octave.lt(count).select(F32x8::ONE, share);
            place = scaled(place, self.lacunarity);
            let next = value + part * (perlin::signed(place, self.lanes) + offset) * amplitude * value;
            value = counts(octave, count, share).select(next, value);
            amplitude = amplitude * self.roughness;
        }
        value
    }
}

/// True where an octave counts, wholly or by a share.
#[inline(always)]
fn counts(octave: F32x8, count: F32x8, share: F32x8) -> Mask {
    octave.lt(count) | (octave.equals(count) & !share.is_zero())
}
