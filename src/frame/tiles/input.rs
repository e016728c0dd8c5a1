//! Input of the tiles of a level: samples of the frame before, and what the film shows already.

use crate::frame::film::develop::DirtyTiles;
use crate::frame::planes::channels::Picture;
use crate::frame::reuse::beside::Beside;
use crate::frame::reuse::bins::Bins;
use crate::frame::reuse::estimate::Estimate;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::static_camera::remake::TileFacts;
use crate::frame::static_camera::tile_state::TileState;
use crate::frame::static_camera::{Detached, source_tile};
use crate::samples::{OldStore, TagLayout, Tile};

/// The samples of the frame before, as far as this frame reuses them.
pub enum Reused<'c> {
    /// A base frame: none.
    None,
    /// The camera did not move: all are where they were, but for those of models that moved.
    InPlace(&'c Detached, &'c Bins),
    /// Samples of an earlier picture, projected into bins; and those that another exposure lends.
    Projected(OldStore<'c>, &'c Bins, Option<Beside<'c>>),
}

impl<'c> Reused<'c> {
    /// Lookup of the tiles with candidates, by number. `before`: the tile at work as it was in the frame before.
    pub fn sources<'t>(&'t self, before: Option<&'t Tile>) -> impl Fn(u32) -> Option<&'t Tile> {
        move |source| match self {
            Self::None => None,
            Self::InPlace(detached, _) => source_tile(detached, before, source),
            Self::Projected(old, ..) => old.tile(source),
        }
    }

    /// Lookup of the tiles with candidates that are lent, by number.
    pub fn lenders<'t>(&'t self) -> impl Fn(u32) -> Option<&'t Tile> {
        move |source| match self {
            Self::Projected(_, _, Some(beside)) => beside.tile(source),
            _ => None,
        }
    }
}

/// Input of a frame's tiles.
pub struct Start<'c> {
    /// Samples of the frame before.
    pub reused: Reused<'c>,
    /// Costs of the choice to reuse samples or not.
    pub estimate: Estimate,
}

/// Content of a film when a level of a frame begins.
#[derive(Debug, Clone, Copy)]
pub enum FilmContents<'a> {
    /// Nothing that is of use: all of it is written.
    Nothing,
    /// The frame before. What stays the same need not be written.
    Last,
    /// In a finer level: this frame as far as coarser levels have made it, and else the frame before, if `is_last`. For each
    /// tile whether a coarser level has written into it.
    Coarser { is_last: bool, written: &'a [bool] },
}

impl FilmContents<'_> {
    /// Returns true if it shows the frame before in tile number `number`.
    pub fn is_last(self, number: usize) -> bool {
        match self {
            Self::Nothing => false,
            Self::Last => true,
            Self::Coarser { is_last, written } => is_last && !written[number],
        }
    }
}

/// Input that all tiles of a level share.
#[derive(Clone, Copy)]
pub struct Work<'a> {
    pub frame: &'a FrameView<'a>,
    pub layout: &'a TagLayout,
    pub start: &'a Start<'a>,
    pub picture: &'a Picture,
    /// Whose colours must be written.
    pub dirty: &'a DirtyTiles,
    /// Content of the film: what stays the same need not be made again.
    pub shows: FilmContents<'a>,
}

impl Work<'_> {
    /// Facts about tile number `number` before its samples are brought up to date.
    pub fn facts(&self, number: usize, state: &TileState) -> TileFacts {
        state.facts(self.frame, self.shows.is_last(number), self.dirty.is_needed(number))
    }
}
