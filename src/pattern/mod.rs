//! Procedural textures: what the texture nodes of Blender 5.0 give, as pure functions of a place.
//!
//! A place is a `vector` (the node's Vector input) and `w` (its W input, the fourth axis). Each pattern has a
//! struct with the options of its node, which are the same all over an object, and a struct with its inputs,
//! which a node graph may compute anew at each place. Cycles is the reference for all of them.
//!
//! Places and inputs come eight at a time, and what a lane gives depends on what is in it alone, to the bit. Of the
//! eight only the first `lanes` count: those beyond give anything. Patterns that are rarely used are computed place by place.
//!
//! No input makes a pattern panic, and all outputs are finite, also where Cycles gives an infinity or no
//! number.

use std::array;

use glam::Vec3;

use crate::lanes::{F32x8, Real, Vec3x8};

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

/// The places with the `N` axes of [`Dimensions`] of that number.
#[inline(always)]
fn place_of<const N: usize>(vector: Vec3x8, w: F32x8) -> [F32x8; N] {
    if N == 1 { [w; N] } else { array::from_fn(|axis| [vector.x, vector.y, vector.z, w][axis]) }
}

/// The sum of two places.
#[inline(always)]
fn sum_of<T: Real, const N: usize>(first: [T; N], second: [T; N]) -> [T; N] {
    array::from_fn(|axis| first[axis] + second[axis])
}

/// The difference of two places.
#[inline(always)]
fn difference<T: Real, const N: usize>(first: [T; N], second: [T; N]) -> [T; N] {
    array::from_fn(|axis| first[axis] - second[axis])
}

/// The place with all axes multiplied.
#[inline(always)]
fn scaled<T: Real, const N: usize>(place: [T; N], factor: T) -> [T; N] {
    place.map(|value| value * factor)
}

/// The dot product.
#[inline(always)]
fn dot<T: Real, const N: usize>(first: [T; N], second: [T; N]) -> T {
    (0..N).fold(T::of(0.0), |sum, axis| sum + first[axis] * second[axis])
}

/// Between two numbers: the first where `share` is 0, the second where it is 1.
#[inline(always)]
fn mix<T: Real>(first: T, second: T, share: T) -> T {
    first * (T::of(1.0) - share) + second * share
}

/// The number if it is finite, the largest of its sign if it is infinite, and 0 if it is none.
#[inline(always)]
fn finite(value: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(f32::MIN, f32::MAX) }
}

/// [`finite`] of eight numbers.
#[inline(always)]
fn finite8(value: F32x8) -> F32x8 {
    value.equals(value).select(value.clamp(f32::MIN, f32::MAX), F32x8::ZERO)
}

/// [`finite`] of each part of eight vectors.
#[inline(always)]
fn finite_vectors(value: Vec3x8) -> Vec3x8 {
    value.each(finite8)
}

/// [`finite`] of each part.
fn finite_vector(value: Vec3) -> Vec3 {
    Vec3::from_array(value.to_array().map(finite))
}
