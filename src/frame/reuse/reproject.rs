//! Reprojection: the samples of the frame before move with their models, are projected into this frame's
//! picture, and serve its cells (the paper's "Reprojection Phase").
//!
//! There are two passes. [`scatter`] projects every old sample and puts it into the bin of the tile that it
//! falls into, and into those of adjacent tiles whose cells it may serve ([`Bins`]). [`resolve`] then finds
//! each cell's server, tile by tile, and copies it into the new store.

use rayon::prelude::*;

use super::beside::{self, Beside, Copies};
use super::bins::{BinWriter, Bins};
use super::invalidate_spares::invalidate_spares;
use super::project::{project_lanes, project_spares};
use super::serve::{KEPT, KEPT_OF_SOME, Serving};
use crate::frame::grid::cells::CellSet;
use crate::frame::grid::holds;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, OldStore, SampleStore, Status, TILE, Tile};
use crate::settings::{Mode, Reuse};

/// Reciprocal of the least share of wanted cells that must reuse samples: tiles with fewer are traced whole.
const LEAST_REUSED: usize = 8;

/// Puts the samples of `old` into the bins of the tiles whose cells they may serve: but for those that would count [twice](beside::Copies).
/// Returns for each tile of `old` how many tiles of the new store must be done until it is not needed any more.
pub fn scatter(old: &SampleStore, frame: &FrameView, copies: Copies, bins: &Bins) -> Vec<u32> {
    /// Tiles that a worker takes at least before others may have the rest.
    const AT_LEAST: usize = 8;
    let grid = &*frame.view.grid;
    let halo = frame.settings.reuse == Reuse::Target;
    let scatter_tile = |writer: &mut BinWriter, (number, tile): (usize, &Tile)| {
        for first in (0..CELLS).step_by(LANES) {
            let mut projected = project_lanes(frame, tile, first);
            projected.which &= !tile.copies[first / LANES];
            projected.which &= !beside::seen_twice(frame, copies, (tile, first), &projected);
            writer.add(grid, first, &projected, halo);
        }
        for first in (0..tile.spares.len()).step_by(LANES) {
            let mut projected = project_spares(frame, &tile.spares, first);
            projected.which &= !beside::spares_seen_twice(frame, copies, (&tile.spares, first), &projected);
            writer.add(grid, CELLS + first, &projected, halo);
        }
        writer.send(number as u32, bins)
    };
    let tiles = old.tiles.par_iter().map(AsRef::as_ref).enumerate().with_min_len(AT_LEAST);
    tiles.map_init(BinWriter::default, scatter_tile).collect()
}

/// Fills tile number `number` with what serves its cells, of the samples of the frame before or else of those that are lent. A cell that
/// nothing serves is missed.
pub fn resolve(
    (old, beside): (&OldStore, Option<&Beside>),
    frame: &FrameView,
    bins: &Bins,
    number: usize,
    tile: &mut Tile,
    serving: &mut Serving,
) {
    bins.take(number, |runs| {
        serving.begin();
        runs.iter().for_each(|(source, run)| serving.add(*source, run, old.tile(*source)));
    });
    let (grid, tiles) = (&frame.view.grid, |source| old.tile(source));
    let extent = grid.extent(number);
    let wanted = frame.wanted_of(number);
    serving.serve(frame.settings.reuse, (extent, wanted), tile);
    let most_kept = if frame.wanted.is_some() { KEPT_OF_SOME } else { KEPT };
    serving.fill(frame.settings.reuse, extent, most_kept, tile, &tiles);
    invalidate_spares(frame, &mut tile.spares);
    mark_unwanted(wanted, tile);
    mark_outside(extent, tile);
    if let Some(beside) = beside {
        beside.fill(frame, number, tile, serving);
    }
    let reused = tile.status.iter().filter(|status| status.is_reused()).count();
    if frame.settings.mode == Mode::Auto && reused < wanted.count() / LEAST_REUSED {
        for cell in 0..CELLS {
            if tile.status[cell].is_reused() {
                tile.clear(cell, Status::Missed);
            }
        }
    }
}

/// Empties the cells that are not wanted.
fn mark_unwanted(wanted: &CellSet, tile: &mut Tile) {
    if *wanted != CellSet::ALL {
        let unwanted = tile.status.iter_mut().enumerate().filter(|(cell, _)| !wanted.has(*cell));
        unwanted.for_each(|(_, status)| *status = Status::Empty);
    }
}

/// Marks the cells that are not in the picture.
fn mark_outside(extent: [u32; 2], tile: &mut Tile) {
    if extent != [TILE as u32; 2] {
        let beyond = tile.status.iter_mut().enumerate().filter(|(cell, _)| !holds(extent, *cell));
        beyond.for_each(|(_, status)| *status = Status::Outside);
    }
}

/// Empties tile number `number` for a frame that is traced in full.
pub fn begin_base(frame: &FrameView, number: usize, tile: &mut Tile) {
    tile.model.fill(EMPTY);
    tile.spares.clear();
    let extent = frame.view.grid.extent(number);
    for (cell, status) in tile.status.iter_mut().enumerate() {
        *status = if holds(extent, cell) { Status::Base } else { Status::Outside };
    }
    mark_unwanted(frame.wanted_of(number), tile);
    mark_outside(extent, tile);
}
