//! A checkerboard in space: Blender's Checker Texture node.

use glam::Vec3;

use super::finite_vector;

/// The Checker Texture node, which has no options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Checker;

/// Inputs of the Checker Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckerInputs {
    /// Colour of the cubes where the factor is 1, linear RGB.
    pub color1: Vec3,
    /// Colour of the others, linear RGB.
    pub color2: Vec3,
    /// Multiplies the place: the number of cubes in a unit.
    pub scale: f32,
}

impl Default for CheckerInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self { color1: Vec3::splat(0.8), color2: Vec3::splat(0.2), scale: 5.0 }
    }
}

impl Checker {
    /// The output Factor: 1 or 0.
    pub fn value(&self, vector: Vec3, inputs: &CheckerInputs) -> f32 {
        let [x, y, z] = (vector * inputs.scale).to_array().map(is_odd);
        if (x == y) == z { 1.0 } else { 0.0 }
    }

    /// The output Color, linear RGB.
    pub fn color(&self, vector: Vec3, inputs: &CheckerInputs) -> Vec3 {
        finite_vector(if self.value(vector, inputs) == 1.0 { inputs.color1 } else { inputs.color2 })
    }
}

/// Whether the whole part of a coordinate is odd.
fn is_odd(coordinate: f32) -> bool {
    // A little off, so that a face on a whole number is not a matter of rounding.
    let floor = ((coordinate + 0.000_001) * 0.999_999).floor();
    // All larger floats are even.
    floor.abs() < 16_777_216.0 && floor as i32 & 1 == 1
}
