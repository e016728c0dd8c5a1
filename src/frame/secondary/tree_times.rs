//! Expiry of rays beyond the first surface: tracked per cell of the current tile while they are traced.
//!
//! All rays that a sample sends on, and those that they send on, are a tree. Its light can change in the
//! first frame in which something that moves touches one of its segments, shadow rays included, in which a
//! light changes, or in which a surface that it meets may gather other light ([`Until`]). Surfaces that move
//! are covered: a model that moves touches the segment that ends on it.

use glam::Vec3;

use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::samples::CELLS;

/// Granularity at which expiry is tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TreeGrain {
    /// None.
    #[default]
    Nothing,
    /// One for each cell.
    Cells,
    /// One for the tile as a whole: fewer tests are made as soon as one of its rays is known to expire early.
    Tile,
}

/// Expiry of the trees of a tile, as a worker tracks it.
#[derive(Debug, Default)]
pub struct TreeTimes {
    asks: TreeGrain,
    /// First frame in which light may differ: one a cell, or one for the tile.
    until: Vec<Until>,
}

impl TreeTimes {
    /// Resets the state for the next tile, from which nothing has been cast yet.
    pub fn begin(&mut self, frame: &FrameView, asks: TreeGrain) {
        self.asks = asks;
        self.until.clear();
        let count = match asks {
            TreeGrain::Nothing => 0,
            TreeGrain::Cells => CELLS,
            TreeGrain::Tile => 1,
        };
        // most surfaces ask all lights, even those that they do not face
        self.until.resize(count, frame.light_change);
    }

    /// Returns true if expiry is tracked.
    pub fn are_asked(&self) -> bool {
        self.asks != TreeGrain::Nothing
    }

    /// First frame in which the light of the rays of `cell` may differ; unknown if it is not tracked.
    pub fn of(&self, cell: usize) -> Until {
        match self.asks {
            TreeGrain::Nothing => Until::UNKNOWN,
            TreeGrain::Cells => self.until[cell],
            TreeGrain::Tile => self.until[0],
        }
    }

    /// Notes that a part of the light of the rays of `cell` is valid until `until`.
    pub fn note(&mut self, cell: u32, until: Until) {
        if let Some(known) = self.at(cell) {
            *known = until.min(*known);
        }
    }

    /// Notes that a ray of `cell` has met `model`.
    #[inline]
    pub fn note_met(&mut self, frame: &FrameView, cell: u32, model: u32) {
        if let Some(known) = self.at(cell) {
            *known = frame.change_of_met(model).min(*known);
        }
    }

    /// Notes a ray of `cell`: the segment `origin + t * direction`, t in `0..=far`.
    #[inline]
    pub fn note_segment(&mut self, frame: &FrameView, cell: u32, origin: Vec3, direction: Vec3, far: f32) {
        if let Some(known) = self.at(cell) {
            *known = frame.first_touch_before(origin, direction, far, *known);
        }
    }

    #[inline]
    fn at(&mut self, cell: u32) -> Option<&mut Until> {
        match self.asks {
            TreeGrain::Nothing => None,
            TreeGrain::Cells => self.until.get_mut(cell as usize),
            TreeGrain::Tile => self.until.first_mut(),
        }
    }
}
