//! Bands and rings: Blender's Wave Texture node.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::Vec3;

use super::finite;
use super::fractal::Octaves;

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
    pub scale: f32,
    /// How far noise moves the waves, radians.
    pub distortion: f32,
    /// Octaves of that noise after the first, 0 to 15 (clamped; Cycles does not, and computes ever more).
    pub detail: f32,
    /// Scale of that noise, besides `scale`.
    pub detail_scale: f32,
    /// Roughness of that noise: the amplitude of an octave as a share of that of the one before.
    pub detail_roughness: f32,
    /// Added to the phase, radians.
    pub phase_offset: f32,
}

impl Default for WaveInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            scale: 5.0,
            distortion: 0.0,
            detail: 2.0,
            detail_scale: 1.0,
            detail_roughness: 0.5,
            phase_offset: 0.0,
        }
    }
}

impl Wave {
    /// The output Factor, 0 to 1. The output Color is the same number three times.
    pub fn value(&self, vector: Vec3, inputs: &WaveInputs) -> f32 {
        // A little off, so that a face on a whole number is not a matter of rounding.
        let place = (vector * inputs.scale + 0.000_001) * 0.999_999;
        let mut phase = self.phase(place) + inputs.phase_offset;
        if inputs.distortion != 0.0 {
            let octaves = Octaves {
                detail: inputs.detail.clamp(0.0, 15.0),
                roughness: inputs.detail_roughness,
                lacunarity: 2.0,
            };
            let noise = octaves.fbm((place * inputs.detail_scale).to_array(), true);
            phase += inputs.distortion * (noise * 2.0 - 1.0);
        }
        let phase = finite(phase);
        match self.profile {
            WaveProfile::Sine => 0.5 + 0.5 * (phase - FRAC_PI_2).sin(),
            WaveProfile::Saw => phase / TAU - (phase / TAU).floor(),
            WaveProfile::Triangle => (phase / TAU - (phase / TAU + 0.5).floor()).abs() * 2.0,
        }
    }

    /// The output Color, 0 to 1: [`Self::value`] three times.
    pub fn color(&self, vector: Vec3, inputs: &WaveInputs) -> Vec3 {
        Vec3::splat(self.value(vector, inputs))
    }

    /// The phase of the even waves, radians: a wave is `TAU / 20` long.
    fn phase(&self, place: Vec3) -> f32 {
        match self.shape {
            WaveShape::BandsX => place.x * 20.0,
            WaveShape::BandsY => place.y * 20.0,
            WaveShape::BandsZ => place.z * 20.0,
            WaveShape::BandsDiagonal => place.element_sum() * 10.0,
            WaveShape::RingsX => place.with_x(0.0).length() * 20.0,
            WaveShape::RingsY => place.with_y(0.0).length() * 20.0,
            WaveShape::RingsZ => place.with_z(0.0).length() * 20.0,
            WaveShape::RingsSpherical => place.length() * 20.0,
        }
    }
}
