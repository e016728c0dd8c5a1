//! Reprojection: the samples of the frame before move with their models and fall into the cells of this
//! frame's camera (the paper's "Reprojection Phase").
//!
//! Two passes. [`scatter`] projects every old sample and enters it in the [`Contest`] for its cell;
//! [`gather`] then brings each cell's winner, tile by tile, into the new store.

use rayon::prelude::*;

use super::contest::Contest;
use super::grid::holds;
use super::plan::CameraChange;
use super::stage::{Stage, set_bits, surface_bits};
use crate::lanes::{LANES, Lanes};
use crate::samples::{BACKGROUND, CELLS, EMPTY, Octahedral, SampleStore, Status, Tile};

/// Enters every sample of `old` in the contest for the cell that it falls into.
pub fn scatter(old: &SampleStore, stage: &Stage, contest: &Contest) {
    old.tiles.par_iter().enumerate().for_each(|(number, tile)| {
        for first in (0..CELLS).step_by(LANES) {
            scatter_lanes(stage, contest, number, tile, first);
        }
    });
}

#[inline]
fn scatter_lanes(stage: &Stage, contest: &Contest, number: usize, tile: &Tile, first: usize) {
    let models = &tile.model[first..first + LANES];
    let seen = stage.view.project(stage.offsets(tile, first));
    let moved = stage.moved_bits(models);
    let stands = stage.plan.camera == CameraChange::None;
    for (lane, model) in models.iter().enumerate().filter(|(_, model)| **model != EMPTY) {
        let depth = seen.depth.0[lane];
        // false for NaN as well
        if !(depth > f32::MIN_POSITIVE) {
            continue;
        }
        let index = (number * CELLS + first + lane) as u32;
        let stays = stands && moved >> lane & 1 == 0;
        let target =
            if stays { Some(index) } else { stage.view.grid.cell_at(seen.x.0[lane], seen.y.0[lane]) };
        if let Some(target) = target {
            contest.enter(target, if *model == BACKGROUND { f32::INFINITY } else { depth }, index);
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
}

/// When nothing moved, not even the camera: every sample stays where it is.
pub fn keep(tile: &mut Tile) {
    for (status, age) in tile.status.iter_mut().zip(&mut tile.age) {
        if *status != Status::Outside {
            *status = Status::Good;
            *age = age.saturating_add(1);
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
fn seen_from_behind(stage: &Stage, tile: &Tile, first: usize) -> u8 {
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
