//! Procedural textures: what the texture nodes of Blender 5.0 give, as pure functions of a place.
//!
//! A place is a `vector` (the node's Vector input) and `w` (its W input, the fourth axis). Each pattern has a
//! struct with the options of its node, which are the same all over an object, and a struct with its inputs,
//! which a node graph may compute anew at each place. Cycles is the reference for all of them.
//!
//! No input makes a pattern panic, and all outputs are finite, also where Cycles gives an infinity or no
//! number.

use std::array;

use glam::Vec3;

pub mod brick;
pub mod checker;
pub mod fractal;
pub mod gabor;
pub mod gradient;
pub mod hash;
pub mod magic;
pub mod perlin;
pub mod voronoi;
mod voronoi_cells;
pub mod wave;
pub mod white;

#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;

/// Axes on which a pattern depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Dimensions {
    /// W alone.
    One,
    /// X and Y of the vector.
    Two,
    /// The vector.
    Three,
    /// The vector and W.
    Four,
}

/// The place with the `N` axes of [`Dimensions`] of that number.
fn place_of<const N: usize>(vector: Vec3, w: f32) -> [f32; N] {
    if N == 1 { [w; N] } else { array::from_fn(|axis| [vector.x, vector.y, vector.z, w][axis]) }
}

/// The sum of two places.
fn sum_of<const N: usize>(first: [f32; N], second: [f32; N]) -> [f32; N] {
    array::from_fn(|axis| first[axis] + second[axis])
}

/// The difference of two places.
fn difference<const N: usize>(first: [f32; N], second: [f32; N]) -> [f32; N] {
    array::from_fn(|axis| first[axis] - second[axis])
}

/// The place with all axes multiplied.
fn scaled<const N: usize>(place: [f32; N], factor: f32) -> [f32; N] {
    place.map(|value| value * factor)
}

/// The dot product.
fn dot<const N: usize>(first: [f32; N], second: [f32; N]) -> f32 {
    (0..N).map(|axis| first[axis] * second[axis]).sum()
}

/// Between two numbers: the first where `share` is 0, the second where it is 1.
fn mix(first: f32, second: f32, share: f32) -> f32 {
    first * (1.0 - share) + second * share
}

/// The number if it is finite, the largest of its sign if it is infinite, and 0 if it is none.
fn finite(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(f32::MIN, f32::MAX) }
}

/// [`finite`] of each part.
fn finite_vector(value: Vec3) -> Vec3 {
    Vec3::from_array(value.to_array().map(finite))
}
