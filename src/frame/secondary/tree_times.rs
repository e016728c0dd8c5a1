//! Until when holds what rays beyond the first surface bring: found out for each cell of the tile at work while its rays are cast.
//!
//! All rays that a sample sends on, and those that they send on, are a tree. What it brings can change in the first frame in
//! which something that moves touches one of its segments, shadow rays included, in which a light changes, or in which what it
//! meets may gather another light ([`Until`]). What is met belongs to that: a model that moves touches the segment that ends on it.

use glam::Vec3;

use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::samples::CELLS;

/// What is found out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Asks {
    /// Nothing.
    #[default]
    Nothing,
    /// For each cell.
    Cells,
    /// For the tile as a whole: less is asked as soon as one of its rays is known not to hold for long.
    Tile,
}

/// A worker's memory for it.
#[derive(Debug, Default)]
pub struct TreeTimes {
    asks: Asks,
    /// By cell, or one for the tile.
    until: Vec<Until>,
}

impl TreeTimes {
    /// Nothing has been cast yet from the next tile.
    pub fn begin(&mut self, frame: &FrameView, asks: Asks) {
        self.asks = asks;
        self.until.clear();
        let count = match asks {
            Asks::Nothing => 0,
            Asks::Cells => CELLS,
            Asks::Tile => 1,
        };
        // most surfaces ask all lights, those that they do not face as well
        self.until.resize(count, frame.light_change);
    }

    /// Whether anything is asked.
    pub fn are_asked(&self) -> bool {
        self.asks != Asks::Nothing
    }

    /// Until when holds what the rays of `cell` bring; nothing is known where nothing was asked.
    pub fn of(&self, cell: usize) -> Until {
        match self.asks {
            Asks::Nothing => Until::UNKNOWN,
            Asks::Cells => self.until[cell],
            Asks::Tile => self.until[0],
        }
    }

    /// Notes that a part of what the rays of `cell` bring holds `until` then.
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
            Asks::Nothing => None,
            Asks::Cells => self.until.get_mut(cell as usize),
            Asks::Tile => self.until.first_mut(),
        }
    }
}
