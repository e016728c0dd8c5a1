//! The store itself: tiles of cells.

use glam::Vec3;
use half::f16;

use super::{Octahedral, Status, Tag};

/// Cells along a tile's edge.
pub const TILE: usize = 32;

/// Cells in a tile.
pub const CELLS: usize = TILE * TILE;

/// `model` of a sample of the background; its `point` is a direction then.
pub const BACKGROUND: u32 = u32::MAX;

/// `model` of a cell without a sample.
pub const EMPTY: u32 = u32::MAX - 1;

/// What projection reads of every sample: 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hot {
    /// Where the surface was hit, object space; for the background the direction, world space.
    pub point: Vec3,
    /// Index into [`Scene::models`](crate::scene::Scene::models), [`BACKGROUND`] or [`EMPTY`].
    pub model: u32,
}

impl Hot {
    /// No sample.
    pub const EMPTY: Self = Self { point: Vec3::ZERO, model: EMPTY };
}

/// What only a sample that stays in the picture needs: 28 bytes.
///
/// Directions and colours are rounded when a sample is *traced*, before anything is computed from them:
/// a sample that was kept is shaded from the same numbers as one that was just made.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cold {
    /// Index into [`Mesh::triangles`](crate::scene::Mesh::triangles).
    pub triangle: u32,
    /// Shading normal, object space, on the side from which the sample is seen.
    pub normal: Octahedral,
    /// The triangle's normal, object space, on the side from which the sample is seen.
    pub facet: Octahedral,
    /// Diffuse reflectance, texture included.
    pub albedo: [f16; 3],
    /// What does not depend on the eye: emission, ambient and diffuse light. Radiance, linear RGB.
    pub lit: [f16; 3],
    /// Rendered frames since the sample was traced; stays at the top.
    pub age: u16,
    /// In this frame.
    pub status: Status,
    /// Whether the eye sees the back of the triangle.
    pub from_behind: bool,
}

/// 32 x 32 cells.
#[derive(Debug, Clone)]
pub struct Tile {
    /// One a cell.
    pub hot: Vec<Hot>,
    /// One a cell.
    pub cold: Vec<Cold>,
    /// One a light for each cell, cell by cell.
    pub tags: Vec<Tag>,
}

/// All samples of a frame. Indices of samples run through the tiles in order.
#[derive(Debug, Clone)]
pub struct SampleStore {
    /// In rows from the top left.
    pub tiles: Vec<Tile>,
    lights: usize,
}

impl SampleStore {
    /// `tiles` tiles without a sample, for a scene of `lights` lights.
    pub fn empty(tiles: usize, lights: usize) -> Self {
        let tile = Tile {
            hot: vec![Hot::EMPTY; CELLS],
            cold: vec![Cold::default(); CELLS],
            tags: vec![Tag::default(); CELLS * lights],
        };
        Self { tiles: vec![tile; tiles], lights }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let cell = size_of::<Hot>() + size_of::<Cold>() + self.lights * size_of::<Tag>();
        self.tiles.len() * CELLS * cell
    }

    /// The tile and the cell in it of sample number `index`.
    #[inline]
    pub fn locate(&self, index: u32) -> (&Tile, usize) {
        (&self.tiles[index as usize / CELLS], index as usize % CELLS)
    }
}

/// Rounds a colour to what the store keeps; what is beyond a half float's range stays at its end.
#[inline]
pub fn to_half(color: Vec3) -> [f16; 3] {
    let [r, g, b] = color.clamp(Vec3::splat(-65504.0), Vec3::splat(65504.0)).to_array();
    [f16::from_f32(r), f16::from_f32(g), f16::from_f32(b)]
}

/// The colour that the store keeps.
#[inline]
pub fn from_half(color: [f16; 3]) -> Vec3 {
    let [r, g, b] = color;
    Vec3::new(r.to_f32(), g.to_f32(), b.to_f32())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_as_small_as_it_says() {
        assert_eq!((size_of::<Hot>(), size_of::<Cold>(), size_of::<Tag>()), (16, 28, 1));
    }
}
