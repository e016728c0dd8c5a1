//! Samples in world space.

use glam::Vec3;

use super::stage::Stage;
use crate::samples::{CELLS, Cold, Hot, Tile};

/// A sample's surface in world space. Normals have unit length and point to the eye's side.
#[derive(Debug, Clone, Copy, Default)]
pub struct Placed {
    /// Where it is in this frame.
    pub point: Vec3,
    /// For shading.
    pub normal: Vec3,
    /// Of the triangle.
    pub facet: Vec3,
}

impl Placed {
    /// Takes a sample to world space. Always the same floats for the same sample and pose: what is
    /// computed from them may be kept.
    #[inline]
    pub fn of(stage: &Stage, hot: &Hot, cold: &Cold) -> Self {
        let transform = stage.transform(hot.model);
        let facet = transform.normal(cold.facet.unfold());
        Self {
            point: transform.point(hot.point),
            // flat meshes: one vector is both
            normal: if cold.normal == cold.facet { facet } else { transform.normal(cold.normal.unfold()) },
            facet,
        }
    }
}

/// The samples of one tile that some phase has asked for: each is placed once a frame.
#[derive(Debug, Default)]
pub struct PlacedTile {
    placed: Vec<Placed>,
    is_ready: Vec<bool>,
}

impl PlacedTile {
    /// Forgets the tile before.
    pub fn begin_tile(&mut self) {
        self.placed.resize(CELLS, Placed::default());
        self.is_ready.clear();
        self.is_ready.resize(CELLS, false);
    }

    /// The sample in `cell`, which must lie on a surface and stay the same until the next tile.
    #[inline]
    pub fn get(&mut self, stage: &Stage, tile: &Tile, cell: usize) -> Placed {
        if !self.is_ready[cell] {
            self.placed[cell] = Placed::of(stage, &tile.hot[cell], &tile.cold[cell]);
            self.is_ready[cell] = true;
        }
        self.placed[cell]
    }
}
