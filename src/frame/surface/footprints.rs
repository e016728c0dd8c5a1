//! Places on surfaces that samples and beams stand for: textures are filtered over them.
//!
//! A sample stands for its cell, or for its part of a cell that exposures share. The width of that place follows the distance, and the root of the angle at which the surface is
//! seen: a filter that is as wide in all directions is a little too sharp across the line of sight and a little too blurred along
//! it. Beams that mirrors and glass send on become wider as they go, as if surfaces were flat. Light paths stand for parts of all
//! directions; their width depends on nothing but the way that they have gone, so that what they bring can be kept.

use crate::frame::grid::view::View;
use crate::lanes::{F32x8, Vec3x8};
use crate::scene::Scene;

/// Least cosine between line of sight and normal that counts: places are four times as wide as at a right angle, at most.
const LEAST_COSINE: f32 = 1.0 / 16.0;

/// Width of a light path's beam for each unit of length. Narrow for the part of all directions for which a path stands: what a path
/// shows of a texture is right also where it is short.
pub const SPREAD_OF_PATHS: f32 = 1.0 / 16.0;

/// Widths of cells on surfaces, world space: the surfaces are seen along `sights`, vectors from the origins of lines of sight, and
/// have these normals, of any length.
#[inline(always)]
pub fn cell_widths(view: &View, sights: Vec3x8, normals: Vec3x8) -> F32x8 {
    let (spread, squared) = (view.spread_of_sample(), sights.dot(sights));
    let cosine = sights.dot(normals).abs() / (squared * normals.dot(normals)).sqrt();
    // of NaN, where a length is 0, this is the least one
    let cosine = cosine.max(F32x8::splat(LEAST_COSINE));
    let [by_distance, fixed] = [spread.by_distance, spread.fixed].map(F32x8::splat);
    (squared.sqrt() * by_distance + fixed) / cosine.sqrt()
}

/// Returns true if `material` has pictures that are filtered.
#[inline]
pub fn has_textures(scene: &Scene, material: u16) -> bool {
    scene.materials[usize::from(material)].is_filtered()
}
