//! Reprojection: the samples of the frame before move with their models and fall into the cells of this
//! frame's camera (the paper's "Reprojection Phase").
//!
//! Two passes. [`scatter`] projects every old sample and enters it in the [`Contest`] for its cell;
//! [`gather`] then brings each cell's winner, tile by tile, into the new store.

use rayon::prelude::*;

use super::contest::Contest;
use super::foresee::LEAST_REUSED;
use super::grid::holds;
use super::plan::CameraChange;
use super::stage::{Stage, set_bits, surface_bits};
use crate::lanes::{LANES, Lanes};
use crate::samples::{
    BACKGROUND, CELLS, EMPTY, LeavingStore, Move, Octahedral, SampleStore, Status, Tile, locate,
};

/// Enters every sample of `old` in the contest for the cell that it falls into.
pub fn scatter(old: SampleStore, stage: &Stage, contest: &Contest) -> LeavingStore {
    let scatter_tile = |(number, tile): (usize, &Tile)| {
        let mut last = None;
        for first in (0..CELLS).step_by(LANES) {
            let sample = (number * CELLS + first) as u32;
            scatter_lanes(stage, tile, first, |lane, depth, target| {
                contest.enter(target, depth, sample + lane);
                last = last.max(Some(target));
            });
        }
        last.map_or(0, |target| locate(target).0 + 1)
    };
    let until: Vec<u32> = old.tiles.par_iter().map(AsRef::as_ref).enumerate().map(scatter_tile).collect();
    LeavingStore::new(old, &until)
}

/// Calls `fall(lane, depth, cell)` for each of eight samples that falls into a cell of the picture, at a
/// depth that is infinite for the background.
#[inline(always)]
pub fn scatter_lanes(stage: &Stage, tile: &Tile, first: usize, mut fall: impl FnMut(u32, f32, u32)) {
    let models = &tile.model[first..first + LANES];
    let seen = stage.view.project(stage.offsets(tile, first));
    for (lane, model) in models.iter().enumerate().filter(|(_, model)| **model != EMPTY) {
        let depth = seen.depth.0[lane];
        // false for NaN as well
        let is_before = depth > f32::MIN_POSITIVE;
        let cell = stage.view.grid.cell_at(seen.x.0[lane], seen.y.0[lane]);
        if let Some(cell) = cell.filter(|_| is_before) {
            fall(lane as u32, if *model == BACKGROUND { f32::INFINITY } else { depth }, cell);
        }
    }
}

/// A worker's memory for this phase: for each tile of the old store that samples come from, which ones.
#[derive(Debug, Default)]
pub struct Gathering {
    /// The first `used` are of the tile at work; the others keep their memory.
    sources: Vec<(u32, Vec<Move>)>,
    used: usize,
    /// The one that was named last.
    latest: usize,
}

impl Gathering {
    /// Forgets all moves.
    fn clear(&mut self) {
        self.used = 0;
    }

    /// Notes that a sample of tile `tile` moves.
    #[inline(always)]
    fn note(&mut self, tile: u32, way: Move) {
        // neighbours come from the same tile, mostly
        if self.used == 0 || self.sources[self.latest].0 != tile {
            let known = self.sources[..self.used].iter().position(|(number, _)| *number == tile);
            self.latest = known.unwrap_or_else(|| self.open(tile));
        }
        self.sources[self.latest].1.push(way);
    }

    #[cold]
    fn open(&mut self, tile: u32) -> usize {
        if self.used == self.sources.len() {
            self.sources.push(Default::default());
        }
        let (number, moves) = &mut self.sources[self.used];
        *number = tile;
        moves.clear();
        self.used += 1;
        self.used - 1
    }
}

/// Fills tile number `number` with the winners of its cells. A cell that nobody won is missed.
///
/// A sample that the eye sees from the other side now is dropped: it was shaded for the side that the
/// eye was on.
pub fn gather(
    old: &LeavingStore,
    stage: &Stage,
    contest: &Contest,
    number: usize,
    tile: &mut Tile,
    gathering: &mut Gathering,
) {
    let extent = stage.view.grid.extent(number);
    gathering.clear();
    contest.take_tile(number, |cell, winner| match winner {
        Some(winner) => {
            let (source, from) = locate(winner.sample);
            gathering.note(source, Move { to: cell as u16, from });
            tile.status[cell] = if winner.overlapped { Status::Overlapped } else { Status::Good };
        }
        None => tile.clear(cell, if holds(extent, cell) { Status::Missed } else { Status::Outside }),
    });
    for (source, moves) in &gathering.sources[..gathering.used] {
        if let Some(from) = old.tile(*source) {
            tile.take_over_all(from, moves);
        }
    }
    grow_older(tile);
    for first in (0..CELLS).step_by(LANES) {
        for lane in set_bits(seen_from_behind(stage, tile, first)) {
            tile.clear(first + lane, Status::Missed);
        }
    }
    let reused = tile.status.iter().filter(|status| status.is_reused()).count();
    if stage.chooses && reused < LEAST_REUSED {
        for cell in 0..CELLS {
            if tile.status[cell].is_reused() {
                tile.clear(cell, Status::Missed);
            }
        }
    }
}

/// Each sample is a frame older.
fn grow_older(tile: &mut Tile) {
    for (age, model) in tile.age.iter_mut().zip(&tile.model) {
        *age = age.saturating_add(u16::from(*model != EMPTY));
    }
}

/// Empties tile number `number` for a frame that is traced in full.
pub fn begin_base(stage: &Stage, number: usize, tile: &mut Tile) {
    tile.model.fill(EMPTY);
    tile.age.fill(0);
    let extent = stage.view.grid.extent(number);
    for (cell, status) in tile.status.iter_mut().enumerate() {
        *status = if holds(extent, cell) { Status::Base } else { Status::Outside };
    }
}

/// Of eight cells, those whose sample is seen from the other side now.
#[inline]
pub fn seen_from_behind(stage: &Stage, tile: &Tile, first: usize) -> u8 {
    let models = &tile.model[first..first + LANES];
    let moved = if stage.plan.camera == CameraChange::Moved { u8::MAX } else { stage.moved_bits(models) };
    let may_have_turned = moved & surface_bits(models);
    if may_have_turned == 0 {
        return 0;
    }
    let mut facets = Octahedral::unfold_lanes(&tile.facet, first);
    for lane in set_bits(stage.displaced_bits(models)) {
        facets.set_lane(lane, stage.transform(models[lane]).facet(facets.lane(lane)));
    }
    let before = facets.dot(stage.offsets(tile, first)).lt(Lanes::ZERO);
    may_have_turned & !before.bits()
}
