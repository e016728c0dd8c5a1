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
use crate::samples::{BACKGROUND, CELLS, EMPTY, Octahedral, SampleStore, Status, Tile};

/// Enters every sample of `old` in the contest for the cell that it falls into.
pub fn scatter(old: &SampleStore, stage: &Stage, contest: &Contest) {
    old.tiles.par_iter().enumerate().for_each(|(number, tile)| {
        for first in (0..CELLS).step_by(LANES) {
            let sample = (number * CELLS + first) as u32;
            scatter_lanes(stage, tile, first, |lane, depth, target| {
                contest.enter(target, depth, sample + lane);
            });
        }
    });
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

/// Fills tile number `number` with the winners of its cells. A cell that nobody won is missed.
///
/// A sample that the eye sees from the other side now is dropped: it was shaded for the side that the
/// eye was on.
pub fn gather(old: &SampleStore, stage: &Stage, contest: &Contest, number: usize, tile: &mut Tile) {
    let extent = stage.view.grid.extent(number);
    for cell in 0..CELLS {
        let Some(winner) = contest.take((number * CELLS + cell) as u32) else {
            tile.clear(cell, if holds(extent, cell) { Status::Missed } else { Status::Outside });
            continue;
        };
        let (from, at) = old.locate(winner.sample);
        tile.take_over(cell, from, at);
        tile.status[cell] = if winner.overlapped { Status::Overlapped } else { Status::Good };
        tile.age[cell] = from.age[at].saturating_add(1);
    }
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
