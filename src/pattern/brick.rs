//! A wall of bricks in the plane of X and Y: Blender's Brick Texture node.

use glam::Vec3;

use super::gradient::eased;
use super::{finite, finite_vector};

/// Options of the Brick Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brick {
    /// How far a moved row is moved, as a share of a brick's width.
    pub offset: f32,
    /// One row in so many is moved. With 0, here or as the squash frequency, none is moved or squashed.
    pub offset_frequency: u32,
    /// Width of the bricks of a squashed row, as a multiple of the others'.
    pub squash: f32,
    /// One row in so many is squashed.
    pub squash_frequency: u32,
}

impl Default for Brick {
    /// Those of a new node.
    fn default() -> Self {
        Self { offset: 0.5, offset_frequency: 2, squash: 1.0, squash_frequency: 2 }
    }
}

/// Inputs of the Brick Texture node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrickInputs {
    /// Colour at one end of the bricks' tints, linear RGB.
    pub color1: Vec3,
    /// Colour at the other end, linear RGB.
    pub color2: Vec3,
    /// Colour of the mortar, linear RGB.
    pub mortar: Vec3,
    /// Multiplies the place.
    pub scale: f32,
    /// Distance from a brick's edge to where its mortar ends.
    pub mortar_size: f32,
    /// Share of that distance on which mortar and brick blend.
    pub mortar_smooth: f32,
    /// Moves all tints: -1 is `color1` alone, 1 `color2` alone.
    pub bias: f32,
    /// Width of a brick, along X.
    pub brick_width: f32,
    /// Height of a row, along Y.
    pub row_height: f32,
}

impl Default for BrickInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            color1: Vec3::splat(0.8),
            color2: Vec3::splat(0.2),
            mortar: Vec3::ZERO,
            scale: 5.0,
            mortar_size: 0.02,
            mortar_smooth: 0.1,
            bias: 0.0,
            brick_width: 0.5,
            row_height: 0.25,
        }
    }
}

impl Brick {
    /// The output Factor: 1 in mortar, 0 in a brick, between in the blend.
    pub fn value(&self, vector: Vec3, inputs: &BrickInputs) -> f32 {
        self.tint_and_mortar(vector, inputs).1
    }

    /// The output Color, linear RGB.
    pub fn color(&self, vector: Vec3, inputs: &BrickInputs) -> Vec3 {
        let (tint, mortar) = self.tint_and_mortar(vector, inputs);
        let brick = inputs.color1 * (1.0 - tint) + inputs.color2 * tint;
        finite_vector(brick * (1.0 - mortar) + inputs.mortar * mortar)
    }

    /// How far the brick's colour is from the first to the second, 0 to 1, and the output Factor.
    fn tint_and_mortar(&self, vector: Vec3, inputs: &BrickInputs) -> (f32, f32) {
        let (x, y) = (vector.x * inputs.scale, vector.y * inputs.scale);
        let row = (y / inputs.row_height).floor() as i32;
        let is_one_in = |frequency: u32| i64::from(row) % i64::from(frequency) == 0;
        let (mut width, mut x) = (inputs.brick_width, x);
        if self.offset_frequency != 0 && self.squash_frequency != 0 {
            width *= if is_one_in(self.squash_frequency) { self.squash } else { 1.0 };
            x += if is_one_in(self.offset_frequency) { width * self.offset } else { 0.0 };
        }
        let number = (x / width).floor() as i32;
        let across = x - width * number as f32;
        let up = y - inputs.row_height * row as f32;
        let to_edge = across.min(up).min((width - across).min(inputs.row_height - up));
        let key = (row << 16).wrapping_add(number & 0xffff) as u32;
        (finite(random(key) + inputs.bias).clamp(0.0, 1.0), mortar(to_edge, inputs))
    }
}

/// How much mortar there is at a distance from the edge of a brick, 0 to 1.
fn mortar(to_edge: f32, inputs: &BrickInputs) -> f32 {
    if to_edge >= inputs.mortar_size {
        0.0
    } else if inputs.mortar_smooth == 0.0 {
        1.0
    } else {
        finite(eased((1.0 - to_edge / inputs.mortar_size) / inputs.mortar_smooth))
    }
}

/// A random number of a brick, 0 to 1: the integer noise of Hugo Elias.
fn random(key: u32) -> f32 {
    let key = key.wrapping_add(1013) & 0x7fff_ffff;
    let key = (key >> 13) ^ key;
    let cubic = key.wrapping_mul(key.wrapping_mul(key).wrapping_mul(60_493).wrapping_add(19_990_303));
    let bits = cubic.wrapping_add(1_376_312_589) & 0x7fff_ffff;
    0.5 * (bits as f32 / 1_073_741_824.0)
}
