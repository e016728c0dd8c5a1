//! A wall of bricks in the plane of X and Y: Blender's Brick Texture node.

use wide::{i32x8, u32x8};

use super::gradient::eased;
use super::{finite_vectors, finite8};
use crate::lanes::{F32x8, Mask, Vec3x8, signed, unsigned};

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
    pub color1: Vec3x8,
    /// Colour at the other end, linear RGB.
    pub color2: Vec3x8,
    /// Colour of the mortar, linear RGB.
    pub mortar: Vec3x8,
    /// Multiplies the place.
    pub scale: F32x8,
    /// Distance from a brick's edge to where its mortar ends.
    pub mortar_size: F32x8,
    /// Share of that distance on which mortar and brick blend.
    pub mortar_smooth: F32x8,
    /// Moves all tints: -1 is `color1` alone, 1 `color2` alone.
    pub bias: F32x8,
    /// Width of a brick, along X.
    pub brick_width: F32x8,
    /// Height of a row, along Y.
    pub row_height: F32x8,
}

impl Default for BrickInputs {
    /// Those of a new node.
    fn default() -> Self {
        Self {
            color1: Vec3x8::all_of(F32x8::splat(0.8)),
            color2: Vec3x8::all_of(F32x8::splat(0.2)),
            mortar: Vec3x8::ZERO,
            scale: F32x8::splat(5.0),
            mortar_size: F32x8::splat(0.02),
            mortar_smooth: F32x8::splat(0.1),
            bias: F32x8::splat(0.0),
            brick_width: F32x8::splat(0.5),
            row_height: F32x8::splat(0.25),
        }
    }
}

impl Brick {
    /// The output Factor: 1 in mortar, 0 in a brick, between in the blend.
    pub fn value(&self, vector: Vec3x8, inputs: &BrickInputs) -> F32x8 {
        let wall = self.at(vector, inputs);
        mortar(wall.to_edge, inputs)
    }

    /// The output Color, linear RGB.
    pub fn color(&self, vector: Vec3x8, inputs: &BrickInputs) -> Vec3x8 {
        let wall = self.at(vector, inputs);
        let (tint, mortar) = (wall.tint(inputs.bias), mortar(wall.to_edge, inputs));
        let brick = inputs.color1 * (F32x8::ONE - tint) + inputs.color2 * tint;
        finite_vectors(brick * (F32x8::ONE - mortar) + inputs.mortar * mortar)
    }

    /// Where places are in the wall.
    fn at(&self, vector: Vec3x8, inputs: &BrickInputs) -> InWall {
        let (mut x, y) = (vector.x * inputs.scale, vector.y * inputs.scale);
        let row = (y / inputs.row_height).floor().to_whole();
        let mut width = inputs.brick_width;
        if self.offset_frequency != 0 && self.squash_frequency != 0 {
            let squashed =
                is_one_in(row, self.squash_frequency).select(F32x8::splat(self.squash), F32x8::ONE);
            width = width * squashed;
            let moved = is_one_in(row, self.offset_frequency).select(width * self.offset, F32x8::ZERO);
            x = x + moved;
        }
        let number = (x / width).floor().to_whole();
        let across = x - width * F32x8::from_whole(number);
        let up = y - inputs.row_height * F32x8::from_whole(row);
        let to_edge = lesser(lesser(across, up), lesser(width - across, inputs.row_height - up));
        InWall { row, number, to_edge }
    }
}

/// A place in the wall.
struct InWall {
    row: i32x8,
    /// Number of the brick in its row.
    number: i32x8,
    /// Distance from the edge of the brick.
    to_edge: F32x8,
}

impl InWall {
    /// How far the brick's colour is from the first to the second, 0 to 1.
    fn tint(&self, bias: F32x8) -> F32x8 {
        let key = (self.row << 16) + (self.number & i32x8::splat(0xffff));
        finite8(random(unsigned(key)) + bias).clamp(0.0, 1.0)
    }
}

/// The smaller of each two numbers; the other one where one is a NaN.
fn lesser(a: F32x8, b: F32x8) -> F32x8 {
    b.equals(b).select(a.min(b), a)
}

/// True in rows whose number can be divided by the frequency.
fn is_one_in(row: i32x8, frequency: u32) -> Mask {
    match frequency {
        1 => Mask::ALL,
        // every other row as a rule
        2 => Mask::of_equal(unsigned(row & i32x8::splat(1)), u32x8::splat(0)),
        _ => {
            let row = row.to_array();
            Mask::new(|lane| i64::from(row[lane]) % i64::from(frequency) == 0)
        }
    }
}

/// How much mortar there is at a distance from the edge of a brick, 0 to 1.
fn mortar(to_edge: F32x8, inputs: &BrickInputs) -> F32x8 {
    let blend = (F32x8::ONE - to_edge / inputs.mortar_size) / inputs.mortar_smooth;
    let beside = inputs.mortar_smooth.is_zero().select(F32x8::ONE, finite8(eased(blend)));
    to_edge.ge(inputs.mortar_size).select(F32x8::ZERO, beside)
}

/// A random number of a brick, 0 to 1: the integer noise of Hugo Elias.
fn random(key: u32x8) -> F32x8 {
    let low_bits = u32x8::splat(0x7fff_ffff);
    let key = (key + u32x8::splat(1013)) & low_bits;
    let key = (key >> 13) ^ key;
    let cubic = key * (key * key * u32x8::splat(60_493) + u32x8::splat(19_990_303));
    let bits = (cubic + u32x8::splat(1_376_312_589)) & low_bits;
    F32x8::from_whole(signed(bits)) / 1_073_741_824.0 * 0.5
}
