//! Reprojection with a camera that neither moves nor turns nor zooms: samples of models at rest stay in their
//! cells, and only those of models that moved are projected.
//!
//! [`detach`] takes these out of the store, [`scatter`] puts them into the bins of the tiles that they fall
//! into now, and [`merge`] lets them serve the cells that have no sample any more, tile by tile. Spare
//! samples would be of little use: they are dropped when the camera comes to rest.

pub mod remake;
pub mod sight;
pub mod tile_state;

use rayon::prelude::*;

use self::tile_state::TileState;
use crate::frame::grid::bits::set_bits;
use crate::frame::reuse::bins::{BinWriter, Binned, Bins, STEPS, bin_origin};
use crate::frame::reuse::project::project_lanes;
use crate::frame::reuse::serve::Serving;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, SampleStore, Status, TagLayout, Tile};
use crate::settings::Reuse;

/// Samples that have been taken out of a store. Keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Detached {
    /// Samples of each row of tiles, packed into as many tiles as they need: no more than the row has.
    rows: Vec<Row>,
    /// Tiles in a row.
    tiles_x: usize,
}

#[derive(Debug, Default)]
struct Row {
    tiles: Vec<Tile>,
    len: usize,
}

impl Detached {
    /// Tile number `number`, counted as if all rows were full.
    fn tile(&self, number: u32) -> &Tile {
        let number = number as usize;
        &self.rows[number / self.tiles_x].tiles[number % self.tiles_x]
    }
}

/// Takes the samples of models that moved out of `store`; their cells become missed. `states` has one for
/// each tile.
pub fn detach(
    store: &mut SampleStore,
    states: &mut [TileState],
    frame: &FrameView,
    layout: &TagLayout,
    detached: &mut Detached,
) {
    let tiles_x = frame.view.grid.tiles_x as usize;
    let rows = store.tiles.len() / tiles_x;
    detached.tiles_x = tiles_x;
    detached.rows.resize_with(rows, Row::default);
    store.tiles.iter_mut().filter(|tile| !tile.spares.is_empty()).for_each(|tile| tile.spares.clear());
    if !frame.plan.any_moved {
        detached.rows.iter_mut().for_each(|row| row.len = 0);
        return;
    }
    let tiles = store.tiles.par_chunks_mut(tiles_x).zip(states.par_chunks_mut(tiles_x));
    tiles.zip(&mut detached.rows).for_each(|((tiles, states), row)| {
        row.len = 0;
        for (tile, _) in tiles.iter_mut().zip(states).filter(|(_, state)| state.may_have_moved(frame)) {
            for first in (0..CELLS).step_by(LANES) {
                for lane in set_bits(frame.moved_bits(&tile.model[first..first + LANES])) {
                    row.take(tile, first + lane, layout);
                }
            }
        }
        row.close();
    });
}

impl Row {
    fn take(&mut self, tile: &mut Tile, cell: usize, layout: &TagLayout) {
        if tile.copies[cell / LANES] >> (cell % LANES) & 1 == 0 {
            let (at, place) = (self.len / CELLS, self.len % CELLS);
            if at == self.tiles.len() {
                self.tiles.push(Tile::empty(layout));
            }
            self.tiles[at].copy_slot(place, tile, cell);
            self.len += 1;
        }
        tile.clear(cell, Status::Missed);
    }

    /// Empties the rest of the last tile.
    fn close(&mut self) {
        if let Some(tile) = self.tiles.get_mut(self.len / CELLS) {
            tile.model[self.len % CELLS..].fill(EMPTY);
        }
    }
}

/// Puts the detached samples into the bins of the tiles whose cells they may serve.
pub fn scatter(detached: &Detached, frame: &FrameView, bins: &Bins) {
    let grid = &*frame.view.grid;
    let halo = frame.settings.reuse == Reuse::Target;
    detached.rows.par_iter().enumerate().for_each_init(BinWriter::default, |writer, (row, samples)| {
        for (number, start) in (row * detached.tiles_x..).zip((0..samples.len).step_by(CELLS)) {
            let tile = &samples.tiles[start / CELLS];
            for first in (0..CELLS.min(samples.len - start)).step_by(LANES) {
                writer.add(grid, first, &project_lanes(frame, tile, first), halo);
            }
            writer.send(number as u32, bins);
        }
    });
}

/// Makes a tile in which nothing can have changed that of this frame: all its samples become good.
pub fn keep_all(tile: &mut Tile) {
    for status in &mut tile.status {
        *status = match *status {
            Status::Outside | Status::Empty => *status,
            _ => Status::Good,
        };
    }
}

/// Source number that stands for the tile itself, among the sources of its candidates.
const ITSELF: u32 = u32::MAX;

/// Looks up the tile that holds a candidate, by its source: the tile as it was, or one of the detached.
pub fn source_tile<'t>(detached: &'t Detached, before: Option<&'t Tile>, source: u32) -> Option<&'t Tile> {
    if source == ITSELF { before } else { Some(detached.tile(source)) }
}

/// Makes tile number `number` that of this frame: its samples stay, and cells without one are served by
/// samples that were projected into the tile. `before` becomes the tile as it was. Returns true if any cell
/// may have another sample.
pub fn merge(
    detached: &Detached,
    frame: &FrameView,
    bins: &Bins,
    number: usize,
    tile: &mut Tile,
    before: &mut Tile,
    serving: &mut Serving,
) -> bool {
    let cells = tile.status.iter_mut().zip(&tile.model);
    for (status, model) in cells {
        let stays = *model != EMPTY && *status != Status::Outside;
        *status = if stays { Status::Good } else { *status };
    }
    serving.begin();
    bins.take(number, |runs| {
        if runs.is_empty() {
            return false;
        }
        std::mem::swap(tile, before);
        let grid = &*frame.view.grid;
        let origin = bin_origin(grid, number);
        let end = grid.extent(number).map(|cells| (cells + 2) as i32 * STEPS);
        let mut own = Vec::with_capacity(CELLS);
        for first in (0..CELLS).step_by(LANES) {
            let projected = project_lanes(frame, before, first);
            for lane in set_bits(projected.which) {
                // a sample right before the eye may be projected far away, by rounding
                let at = [projected.x[lane] - origin[0], projected.y[lane] - origin[1]];
                if at.iter().zip(&end).all(|(at, end)| (0..*end).contains(at)) {
                    own.push(Binned::new(projected.depth.lane(lane), at, first + lane).word());
                }
            }
        }
        runs.iter().for_each(|(source, run)| serving.add(*source, run, None));
        serving.add(ITSELF, &own, None);
        let tiles = |source| source_tile(detached, Some(&*before), source);
        let (extent, wanted) = (grid.extent(number), frame.wanted_of(number));
        serving.serve(frame.settings.reuse, (extent, wanted), tile);
        serving.merge(before, tile, &tiles);
        true
    })
}
