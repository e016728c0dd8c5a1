//! Psychedelic colours: Blender's Magic Texture node.

use std::f32::consts::TAU;

use glam::Vec3;

use super::finite_vector;

/// Options of the Magic Texture node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Magic {
    /// Number of times that the waves are fed into each other; 10 at most.
    pub depth: u32,
}

/// Inputs of the Magic Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MagicInputs {
    /// Multiplies the place.
    pub scale: f32,
    /// How strongly a wave is fed into the next.
    pub distortion: f32,
}

impl Default for MagicInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self { scale: 5.0, distortion: 1.0 }
    }
}

impl Magic {
    /// The output Factor: the mean of the colour.
    pub fn value(&self, vector: Vec3, inputs: &MagicInputs) -> f32 {
        self.color(vector, inputs).dot(Vec3::splat(1.0 / 3.0))
    }

    /// The output Color, linear RGB; 0 to 1 where the distortion is not 0, and -0.5 to 1.5 else or without
    /// depth.
    pub fn color(&self, vector: Vec3, inputs: &MagicInputs) -> Vec3 {
        let MagicInputs { scale, distortion } = *inputs;
        // Large numbers lose little by this, and a sum of them stays finite. With another scale than 1 it
        // makes seams, which Blender has up to 5.0: later it wraps the scaled place.
        let [x, y, z] = vector.to_array().map(|value| super::finite(value) % TAU);
        let wave = |sum: f32| super::finite(sum * 5.0 * scale);
        let mut waves = Vec3::new(wave(x + y + z).sin(), wave(-x + y - z).cos(), -wave(-x - y + z).cos());
        if self.depth > 0 {
            waves *= distortion;
        }
        for step in 0..self.depth.min(10) {
            waves = fed(waves, step, distortion);
        }
        if distortion != 0.0 {
            waves /= 2.0 * distortion;
        }
        finite_vector(Vec3::splat(0.5) - waves)
    }
}

/// One wave replaced by a wave of all three.
fn fed(waves: Vec3, step: u32, distortion: f32) -> Vec3 {
    let Vec3 { x, y, z } = waves;
    match step {
        0 => Vec3::new(x, -(x - y + z).cos() * distortion, z),
        1 => Vec3::new((x - y - z).cos() * distortion, y, z),
        2 => Vec3::new(x, y, (-x - y - z).sin() * distortion),
        3 => Vec3::new(-(-x + y - z).cos() * distortion, y, z),
        4 => Vec3::new(x, -(-x + y + z).sin() * distortion, z),
        5 => Vec3::new(x, -(-x + y + z).cos() * distortion, z),
        6 => Vec3::new((x + y + z).cos() * distortion, y, z),
        7 => Vec3::new(x, y, (x + y - z).sin() * distortion),
        8 => Vec3::new(-(-x - y + z).cos() * distortion, y, z),
        _ => Vec3::new(x, -(x - y + z).sin() * distortion, z),
    }
}
