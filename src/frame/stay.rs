//! Reprojection when the camera neither moves nor turns nor zooms: what stands still stays in its cell, and
//! only the samples of models that moved are projected.
//!
//! [`lift`] takes these out of the store, [`scatter`] puts them on the lists of the tiles that they fall into now
//! ([`Falls`]), and [`settle`] puts the winners down, tile by tile, where no nearer sample stayed.

use rayon::prelude::*;

use super::contest::{Contest, Falls, Sorter};
use super::reproject::{project_lanes, seen_from_behind};
use super::rest::Memo;
use super::stage::{Stage, set_bits};
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, Move, SampleStore, Status, TagLayout, Tile};

/// Samples that have been taken out of a store. Keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct Lifted {
    /// For each row of tiles, its samples, packed into as many tiles as they need: no more than it has.
    rows: Vec<Row>,
    /// Tiles in a row.
    tiles_x: usize,
}

#[derive(Debug, Default)]
struct Row {
    tiles: Vec<Tile>,
    len: usize,
}

impl Lifted {
    /// Tile number `number`, counted as if all rows were full.
    fn tile(&self, number: u32) -> &Tile {
        let number = number as usize;
        &self.rows[number / self.tiles_x].tiles[number % self.tiles_x]
    }
}

/// Takes the samples of models that moved out of `store`; their cells are missed. `memos` has one for each tile.
pub fn lift(
    store: &mut SampleStore,
    memos: &mut [Memo],
    stage: &Stage,
    layout: &TagLayout,
    lifted: &mut Lifted,
) {
    let tiles_x = stage.view.grid.tiles_x as usize;
    let rows = store.tiles.len() / tiles_x;
    lifted.tiles_x = tiles_x;
    lifted.rows.resize_with(rows, Row::default);
    if !stage.plan.any_moved {
        lifted.rows.iter_mut().for_each(|row| row.len = 0);
        return;
    }
    let tiles = store.tiles.par_chunks_mut(tiles_x).zip(memos.par_chunks_mut(tiles_x));
    tiles.zip(&mut lifted.rows).for_each(|((tiles, memos), row)| {
        row.len = 0;
        for (tile, memo) in tiles.iter_mut().zip(memos).filter(|(_, memo)| memo.may_have_moved(stage)) {
            catch_up(tile, memo);
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

/// Puts the samples that were lifted on the lists of the tiles that they fall into, but for those that the eye sees
/// from their other side now.
pub fn scatter(lifted: &Lifted, stage: &Stage, falls: &Falls) {
    lifted.rows.par_iter().enumerate().for_each_init(Sorter::default, |sorter, (row, samples)| {
        for (number, start) in (row * lifted.tiles_x..).zip((0..samples.len).step_by(CELLS)) {
            let tile = &samples.tiles[start / CELLS];
            for first in (0..CELLS.min(samples.len - start)).step_by(LANES) {
                let mut fall = project_lanes(stage, tile, first);
                fall.which &= !seen_from_behind(stage, tile, first);
                sorter.add(first, fall);
            }
            sorter.send(number as u32, falls);
        }
    });
}

/// Makes a tile at rest that of this frame.
pub fn grow_older(tile: &mut Tile, memo: &mut Memo) {
    for status in &mut tile.status {
        *status = if *status == Status::Outside { Status::Outside } else { Status::Good };
    }
    memo.frames_behind = memo.frames_behind.saturating_add(1);
    catch_up(tile, memo);
}

/// Gives the samples of `tile` the age that they have.
pub fn catch_up(tile: &mut Tile, memo: &mut Memo) {
    let frames = std::mem::take(&mut memo.frames_behind);
    if frames > 0 {
        // of cells without a sample the age means nothing
        tile.age.iter_mut().for_each(|age| *age = age.saturating_add(frames));
    }
}

/// Makes tile number `number` that of this frame: samples grow older, and winners of the contest take their
/// cells where nothing nearer stayed. Whether any did.
pub fn settle(
    lifted: &Lifted,
    stage: &Stage,
    falls: &Falls,
    number: usize,
    tile: &mut Tile,
    contest: &mut Contest,
) -> bool {
    let cells = tile.status.iter_mut().zip(&mut tile.age).zip(&tile.model);
    for ((status, age), model) in cells {
        let stays = *model != EMPTY && *status != Status::Outside;
        *status = if stays { Status::Good } else { *status };
        *age = age.saturating_add(u16::from(stays));
    }
    falls.take(number, |list| {
        if list.is_empty() {
            return false;
        }
        let mut winners: Vec<(u32, Move)> = Vec::new();
        contest.hold(list, |source, moves| winners.extend(moves.iter().map(|way| (source, *way))));
        let mut any = false;
        for (source, way) in winners {
            let [to, from] = [way.to, way.from].map(usize::from);
            let is_crowded = contest.fallen()[to] > 1;
            any |= put_down(stage, tile, to, lifted.tile(source), from, is_crowded);
        }
        any
    })
}

/// Puts the sample in cell `at` of `from` into `cell`, unless a nearer one stayed there.
fn put_down(stage: &Stage, tile: &mut Tile, cell: usize, from: &Tile, at: usize, crowded: bool) -> bool {
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
