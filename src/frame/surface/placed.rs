//! Samples in world space.

use super::hits::place;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{LANES, Vec3x8};
use crate::samples::{CELLS, Column, Octahedral, Tile};

/// Eight samples' surfaces in world space. Normals have unit length and point to the eye's side. What is in
/// a lane without a surface means nothing.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Where they are in this frame.
    pub point: Vec3x8,
    /// For shading.
    pub normal: Vec3x8,
    /// Of the triangles.
    pub geometric_normal: Vec3x8,
}

impl Placed {
    /// Takes the samples of the eight cells from `first` on to world space. Always the same floats for the
    /// same sample and pose: what is computed from them may be kept.
    #[inline]
    pub fn of(frame: &FrameView, tile: &Tile, first: usize) -> Self {
        let point = tile.points(first);
        let (normals, geometric_normals) = (tile.normals(first), tile.geometric_normals(first));
        let geometric_normal = Octahedral::unfold_lanes(geometric_normals);
        // flat meshes: one vector is both
        let normal =
            if normals == geometric_normals { geometric_normal } else { Octahedral::unfold_lanes(normals) };
        let mut placed = Self { point, normal, geometric_normal };
        let Self { point, normal, geometric_normal } = &mut placed;
        let triangle = |lane: usize| tile.record[first + lane].triangle;
        place(frame, &tile.model[first..first + LANES], triangle, [point, normal, geometric_normal]);
        placed
    }
}

/// The samples of one tile that some phase has asked for: each is placed once a frame.
#[derive(Debug)]
pub struct PlacedTile {
    /// World space. What is in a cell without a surface means nothing.
    pub point: [Column<f32>; 3],
    /// For shading, world space.
    pub normal: [Column<f32>; 3],
    geometric_normal: [Column<f32>; 3],
    /// For each eight cells.
    is_ready: [bool; CELLS / LANES],
}

impl PlacedTile {
    /// Forgets the tile before.
    pub fn begin_tile(&mut self) {
        self.is_ready.fill(false);
    }

    /// The samples in the eight cells from `first` on, which must stay the same until the next tile.
    #[inline]
    pub fn get(&mut self, frame: &FrameView, tile: &Tile, first: usize) -> Placed {
        if self.is_ready[first / LANES] {
            return Placed {
                point: load(&self.point, first),
                normal: load(&self.normal, first),
                geometric_normal: load(&self.geometric_normal, first),
            };
        }
        let placed = Placed::of(frame, tile, first);
        store(placed.point, &mut self.point, first);
        store(placed.normal, &mut self.normal, first);
        store(placed.geometric_normal, &mut self.geometric_normal, first);
        self.is_ready[first / LANES] = true;
        placed
    }

    /// Places all samples of the tile that nobody has asked for yet.
    pub fn complete(&mut self, frame: &FrameView, tile: &Tile) {
        for first in (0..CELLS).step_by(LANES) {
            if !self.is_ready[first / LANES] {
                self.get(frame, tile, first);
            }
        }
    }
}

impl Default for PlacedTile {
    fn default() -> Self {
        let columns = [[0.0; CELLS]; 3];
        Self { point: columns, normal: columns, geometric_normal: columns, is_ready: [false; CELLS / LANES] }
    }
}

#[inline(always)]
fn load([x, y, z]: &[Column<f32>; 3], first: usize) -> Vec3x8 {
    Vec3x8::load([x, y, z], first)
}

#[inline(always)]
fn store(values: Vec3x8, [x, y, z]: &mut [Column<f32>; 3], first: usize) {
    values.store([x, y, z], first);
}
