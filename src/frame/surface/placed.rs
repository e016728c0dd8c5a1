//! Samples in world space.

use super::hits::place;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{LANES, Vec3x8};
use crate::samples::{CELLS, Column, Octahedral, Tile};

/// Surfaces of eight samples in world space. Normals have unit length and point to the eye's side. The values
/// of a lane without a surface mean nothing.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Places in this frame.
    pub point: Vec3x8,
    /// Shading normals.
    pub normal: Vec3x8,
    /// Normals of the triangles.
    pub geometric_normal: Vec3x8,
}

impl Placed {
    /// Transforms the samples of the eight cells from `first` on to world space. The result is the same to
    /// the bit for the same sample and pose, so that values computed from it may be kept.
    #[inline]
    pub fn of(frame: &FrameView, tile: &Tile, first: usize) -> Self {
        let point = tile.points(first);
        let (normals, geometric_normals) = (tile.normals(first), tile.geometric_normals(first));
        let geometric_normal = Octahedral::unfold_lanes(geometric_normals);
        // flat meshes: both normals are the same
        let normal =
            if normals == geometric_normals { geometric_normal } else { Octahedral::unfold_lanes(normals) };
        let mut placed = Self { point, normal, geometric_normal };
        let Self { point, normal, geometric_normal } = &mut placed;
        let triangle = |lane: usize| tile.record[first + lane].triangle;
        place(frame, &tile.model[first..first + LANES], triangle, [point, normal, geometric_normal]);
        placed
    }
}

/// Samples of one tile in world space. Each is placed once a frame, when a phase first asks for it.
#[derive(Debug)]
pub struct PlacedTile {
    /// Points, world space. The values of a cell without a surface mean nothing.
    pub point: [Column<f32>; 3],
    /// Shading normals, world space.
    pub normal: [Column<f32>; 3],
    geometric_normal: [Column<f32>; 3],
    /// True for each eight cells that are placed.
    is_ready: [bool; CELLS / LANES],
}

impl PlacedTile {
    /// Clears the state for the next tile.
    pub fn begin_tile(&mut self) {
        self.is_ready.fill(false);
    }

    /// Samples in the eight cells from `first` on, which must not change until the next tile.
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

    /// Places all samples of the tile that are not placed yet.
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
