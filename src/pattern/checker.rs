//! A checkerboard in space: Blender's Checker Texture node.

use wide::{i32x8, u32x8};

use super::finite_vectors;
use crate::lanes::{F32x8, Mask, Vec3x8, unsigned};

/// The Checker Texture node, which has no options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Checker;

/// Inputs of the Checker Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckerInputs {
    /// Colour of the cubes where the factor is 1, linear RGB.
    pub color1: Vec3x8,
    /// Colour of the others, linear RGB.
    pub color2: Vec3x8,
    /// Multiplies the place: the number of cubes in a unit.
    pub scale: F32x8,
}

impl Default for CheckerInputs {
    /// Those of a new node.
    fn default() -> Self {
        let gray = |value| Vec3x8::all_of(F32x8::splat(value));
        Self { color1: gray(0.8), color2: gray(0.2), scale: F32x8::splat(5.0) }
    }
}

impl Checker {
    /// The output Factor: 1 or 0.
    pub fn value(&self, vector: Vec3x8, inputs: &CheckerInputs) -> F32x8 {
        is_first(vector, inputs).select(F32x8::ONE, F32x8::ZERO)
    }

    /// The output Color, linear RGB.
    pub fn color(&self, vector: Vec3x8, inputs: &CheckerInputs) -> Vec3x8 {
        finite_vectors(is_first(vector, inputs).select3(inputs.color1, inputs.color2))
    }
}

/// True in the cubes where the factor is 1: where one coordinate is odd, or all three are.
fn is_first(vector: Vec3x8, inputs: &CheckerInputs) -> Mask {
    let [x, y, z] = <[F32x8; 3]>::from(vector * inputs.scale).map(lowest_bit);
    Mask::of_equal(unsigned(x ^ y ^ z), u32x8::splat(1))
}

/// 1 if the whole part of a coordinate is odd, else 0.
fn lowest_bit(coordinate: F32x8) -> i32x8 {
    // A little off, so that a face on a whole number is not a matter of rounding.
    let floor = ((coordinate + 0.000_001) * 0.999_999).floor();
    // All larger floats are even.
    let has_odd = floor.abs().lt(F32x8::splat(16_777_216.0));
    has_odd.select(floor, F32x8::ZERO).to_whole() & i32x8::splat(1)
}
