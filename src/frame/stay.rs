//! Reprojection when the camera neither moves nor turns nor zooms: what stands still stays in its cell, and
//! only the samples of models that moved are projected.
//!
//! [`lift`] takes these out of the store, [`scatter`] enters them in the [`Contest`] for the cells that they
//! fall into now, and [`settle`] puts the winners down, tile by tile, where no nearer sample stayed.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use super::contest::Contest;
use super::reproject::{scatter_lanes, seen_from_behind};
use super::stage::{Stage, set_bits};
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, SampleStore, Status, TagLayout, Tile};

/// Samples that have been taken out of a store. Keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Lifted {
    /// For each row of tiles, its samples, packed into as many tiles as they need.
    rows: Vec<Row>,
    /// Sample numbers of a row: as many as it has cells.
    in_row: usize,
    /// For each tile of the picture, whether a sample fell into it.
    touched: Vec<AtomicBool>,
}

#[derive(Debug, Default)]
struct Row {
    tiles: Vec<Tile>,
    len: usize,
}

impl Lifted {
    /// The tile and the cell in it of sample number `sample`.
    fn locate(&self, sample: u32) -> (&Tile, usize) {
        let (row, at) = (sample as usize / self.in_row, sample as usize % self.in_row);
        (&self.rows[row].tiles[at / CELLS], at % CELLS)
    }
}

/// Takes the samples of models that moved out of `store`; their cells are missed.
pub fn lift(store: &mut SampleStore, stage: &Stage, layout: &TagLayout, lifted: &mut Lifted) {
    let tiles_x = stage.view.grid.tiles_x as usize;
    let rows = store.tiles.len() / tiles_x;
    lifted.in_row = tiles_x * CELLS;
    lifted.rows.resize_with(rows, Row::default);
    lifted.touched.resize_with(store.tiles.len(), AtomicBool::default);
    lifted.touched.iter_mut().for_each(|touched| *touched.get_mut() = false);
    if !stage.plan.any_moved {
        lifted.rows.iter_mut().for_each(|row| row.len = 0);
        return;
    }
    store.tiles.par_chunks_mut(tiles_x).zip(&mut lifted.rows).for_each(|(tiles, row)| {
        row.len = 0;
        for tile in tiles {
            for first in (0..CELLS).step_by(LANES) {
                for lane in set_bits(stage.moved_bits(&tile.model[first..first + LANES])) {
                    row.take(tile, first + lane, layout);
                }
            }
        }
        row.close();
    });
}

impl Row {
    fn take(&mut self, tile: &mut Tile, cell: usize, layout: &TagLayout) {
        let (at, place) = (self.len / CELLS, self.len % CELLS);
        if at == self.tiles.len() {
            self.tiles.push(Tile::empty(layout));
        }
        self.tiles[at].take_over(place, tile, cell);
        self.tiles[at].age[place] = tile.age[cell];
        self.len += 1;
        tile.clear(cell, Status::Missed);
    }

    /// Empties what is left of the last tile.
    fn close(&mut self) {
        if let Some(tile) = self.tiles.get_mut(self.len / CELLS) {
            tile.model[self.len % CELLS..].fill(EMPTY);
        }
    }
}

/// Enters the samples that were lifted in the contest for the cells that they fall into.
pub fn scatter(lifted: &Lifted, stage: &Stage, contest: &Contest) {
    lifted.rows.par_iter().enumerate().for_each(|(row, samples)| {
        for first in (0..samples.len).step_by(LANES) {
            let tile = &samples.tiles[first / CELLS];
            let number = (row * lifted.in_row + first) as u32;
            scatter_lanes(stage, tile, first % CELLS, |lane, depth, target| {
                contest.enter(target, depth, number + lane);
                lifted.touched[target as usize / CELLS].store(true, Relaxed);
            });
        }
    });
}

/// Makes tile number `number` that of this frame: samples grow older, and winners of the contest take their
/// cells where nothing nearer stayed. Whether any did.
pub fn settle(lifted: &Lifted, stage: &Stage, contest: &Contest, number: usize, tile: &mut Tile) -> bool {
    let cells = tile.status.iter_mut().zip(&mut tile.age).zip(&tile.model);
    for ((status, age), _) in
        cells.filter(|((status, _), model)| **status != Status::Outside && **model != EMPTY)
    {
        *status = Status::Good;
        *age = age.saturating_add(1);
    }
    if !lifted.touched[number].load(Relaxed) {
        return false;
    }
    let mut any = false;
    contest.take_tile(number, |cell, winner| {
        if let Some(winner) = winner {
            let (from, at) = lifted.locate(winner.sample);
            any |= put_down(stage, tile, cell, from, at, winner.overlapped);
        }
    });
    any
}

/// Puts the sample in cell `at` of `from` into `cell`, unless a nearer one stayed there, or the eye sees it
/// from its other side now.
fn put_down(stage: &Stage, tile: &mut Tile, cell: usize, from: &Tile, at: usize, crowded: bool) -> bool {
    let (first, lane) = (at / LANES * LANES, at % LANES);
    if seen_from_behind(stage, from, first) >> lane & 1 != 0 {
        return false;
    }
    let depth = |tile: &Tile, cell: usize| {
        stage.offset(tile.point(cell), tile.model[cell]).dot(stage.view.camera.forward)
    };
    let is_taken = tile.model[cell] != EMPTY;
    if tile.is_surface(cell) && depth(tile, cell) <= depth(from, at) {
        return false;
    }
    tile.take_over(cell, from, at);
    tile.status[cell] = if crowded || is_taken { Status::Overlapped } else { Status::Good };
    tile.age[cell] = from.age[at].saturating_add(1);
    true
}
