//! Bands and rings: Blender's Wave Texture node.

use std::f32::consts::{FRAC_PI_2, TAU};

use super::finite8;
use super::fractal::Octaves;
use crate::lanes::{F32x8, Vec3x8};

/// Where the crests of the waves lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WaveShape {
    /// In planes across X.
    BandsX,
    /// In planes across Y.
    BandsY,
    /// In planes across Z.
    BandsZ,
    /// In planes across the diagonal of all three axes.
    BandsDiagonal,
    /// In cylinders about X.
    RingsX,
    /// In cylinders about Y.
    RingsY,
    /// In cylinders about Z.
    RingsZ,
    /// In spheres about the origin.
    RingsSpherical,
}

/// How the value goes along a wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum WaveProfile {
    /// A sine.
    Sine,
    /// Up evenly, and down at once.
    Saw,
    /// Up and down evenly.
    Triangle,
}

/// Options of the Wave Texture node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Wave {
    /// Where the crests lie: the node's Type and Direction.
    pub shape: WaveShape,
    /// How the value goes along a wave.
    pub profile: WaveProfile,
}

/// Inputs of the Wave Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaveInputs {
    /// Multiplies the place.
    pub scale: F32x8,
    /// How far noise moves the waves, radians.
    pub distortion: F32x8,
    /// Octaves of that noise after the first, 0 to 15 (clamped; Cycles does not, and computes ever more).
    pub detail: F32x8,
    /// Scale of that noise, besides `scale`.
    pub detail_scale: F32x8,
    /// Roughness of that noise: the amplitude of an octave as a share of that of the one before.
    pub detail_roughness: F32x8,
    /// Added to the phase, radians.
    pub phase_offset: F32x8,
}

impl Default for WaveInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: F32x8::splat(5.0),
            distortion: F32x8::splat(0.0),
            detail: F32x8::splat(2.0),
            detail_scale: F32x8::splat(1.0),
            detail_roughness: F32x8::splat(0.5),
            phase_offset: F32x8::splat(0.0),
        }
    }
}

impl Wave {
    /// The output Factor at the first `lanes` places, 0 to 1. The output Color is the same number three times.
    pub fn value(&self, vector: Vec3x8, inputs: &WaveInputs, lanes: usize) -> F32x8 {
        // A little off, so that a face on a whole number is not a matter of rounding.
        let place = (vector * inputs.scale + 0.000_001) * 0.999_999;
        let mut phase = self.phase(place) + inputs.phase_offset;
        let is_distorted = !inputs.distortion.is_zero();
        if is_distorted.any_of(lanes) {
            let octaves = Octaves {
                detail: inputs.detail.clamp(0.0, 15.0),
                roughness: inputs.detail_roughness,
                lacunarity: F32x8::splat(2.0),
                lanes,
            };
            let noise = octaves.fbm::<3>((place * inputs.detail_scale).into(), true);
            phase = is_distorted.select(phase + inputs.distortion * (noise * 2.0 - 1.0), phase);
        }
        let phase = finite8(phase);
        let turns = phase / TAU;
        match self.profile {
            WaveProfile::Sine => (phase - FRAC_PI_2).each(f32::sin) * 0.5 + 0.5,
            WaveProfile::Saw => turns - turns.floor(),
            WaveProfile::Triangle => (turns - (turns + 0.5).floor()).abs() * 2.0,
        }
    }

    /// The phase of the even waves, radians: a wave is `TAU / 20` long.
    fn phase(&self, place: Vec3x8) -> F32x8 {
        let Vec3x8 { x, y, z } = place;
        let length = |a: F32x8, b: F32x8| (a * a + b * b).sqrt();
        match self.shape {
            WaveShape::BandsX => x * 20.0,
            WaveShape::BandsY => y * 20.0,
            WaveShape::BandsZ => z * 20.0,
            WaveShape::BandsDiagonal => (x + y + z) * 10.0,
            WaveShape::RingsX => length(y, z) * 20.0,
            WaveShape::RingsY => length(x, z) * 20.0,
            WaveShape::RingsZ => length(x, y) * 20.0,
            WaveShape::RingsSpherical => place.length() * 20.0,
        }
    }
}
