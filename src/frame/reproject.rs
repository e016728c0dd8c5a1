//! Reprojection: the samples of the frame before move with their models and fall into the cells of this
//! frame's camera (the paper's "Reprojection Phase").
//!
//! Two passes. [`scatter`] projects every old sample and enters it in the [`Contest`] for its cell;
//! [`gather`] then brings each cell's winner, row by row, into the new store.

use rayon::prelude::*;

use super::contest::Contest;
use super::plan::CameraChange;
use super::stage::Stage;
use super::view::cell_place;
use crate::samples::{BACKGROUND, CELLS, Cold, EMPTY, Hot, SampleStore, Status, Tag, Tile};

/// Enters every sample of `old` in the contest for the cell that it falls into.
pub fn scatter(old: &SampleStore, stage: &Stage, contest: &Contest) {
    old.tiles.par_iter().enumerate().for_each(|(tile, samples)| {
        for (cell, hot) in samples.hot.iter().enumerate() {
            if hot.model == EMPTY {
                continue;
            }
            let index = (tile * CELLS + cell) as u32;
            let Some(seen) = stage.view.project(stage.offset(hot)) else { continue };
            let depth = if hot.model == BACKGROUND { f32::INFINITY } else { seen.depth };
            let stays = stage.plan.camera == CameraChange::None && !stage.moved(hot);
            let target = if stays { Some(index) } else { stage.view.cell_at(seen.x, seen.y) };
            if let Some(target) = target {
                contest.enter(target, depth, index);
            }
        }
    });
}

/// Fills tile number `number` with the winners of its cells. A cell that nobody won is missed.
///
/// A sample that the eye sees from the other side now is dropped: it was shaded for the side that the
/// eye was on.
pub fn gather(old: &SampleStore, stage: &Stage, contest: &Contest, number: usize, tile: &mut Tile) {
    let lights = stage.pose.lights.len();
    let corner = stage.view.tile_corner(number);
    for cell in 0..CELLS {
        let place = cell_place(cell);
        if !stage.view.holds([corner[0] + place[0], corner[1] + place[1]]) {
            clear(tile, cell, lights, Status::Outside);
            continue;
        }
        let Some(winner) = contest.take((number * CELLS + cell) as u32) else {
            clear(tile, cell, lights, Status::Missed);
            continue;
        };
        let (from, at) = old.locate(winner.sample);
        let (hot, cold) = (&from.hot[at], &from.cold[at]);
        if !still_seen_from_its_side(stage, hot, cold) {
            clear(tile, cell, lights, Status::Missed);
            continue;
        }
        tile.hot[cell] = *hot;
        tile.cold[cell] = Cold {
            status: if winner.overlapped { Status::Overlapped } else { Status::Good },
            age: cold.age.saturating_add(1),
            ..*cold
        };
        tile.tags[cell * lights..][..lights].copy_from_slice(&from.tags[at * lights..][..lights]);
    }
}

/// When nothing moved, not even the camera: every sample stays where it is.
pub fn keep(tile: &mut Tile) {
    for cold in &mut tile.cold {
        if cold.status != Status::Outside {
            cold.status = Status::Good;
            cold.age = cold.age.saturating_add(1);
        }
    }
}

/// Empties tile number `number` for a frame that is traced in full.
pub fn begin_base(stage: &Stage, number: usize, tile: &mut Tile) {
    let lights = stage.pose.lights.len();
    let corner = stage.view.tile_corner(number);
    for cell in 0..CELLS {
        let place = cell_place(cell);
        let inside = stage.view.holds([corner[0] + place[0], corner[1] + place[1]]);
        clear(tile, cell, lights, if inside { Status::Base } else { Status::Outside });
    }
}

fn clear(tile: &mut Tile, cell: usize, lights: usize, status: Status) {
    tile.hot[cell] = Hot::EMPTY;
    tile.cold[cell] = Cold { status, ..Cold::default() };
    tile.tags[cell * lights..][..lights].fill(Tag::Unknown);
}

#[inline]
fn still_seen_from_its_side(stage: &Stage, hot: &Hot, cold: &Cold) -> bool {
    let may_have_turned = stage.plan.camera == CameraChange::Moved || stage.moved(hot);
    if hot.model == BACKGROUND || !may_have_turned {
        return true;
    }
    let facet = stage.transform(hot.model).facet(cold.facet.unfold());
    facet.dot(stage.offset(hot)) < 0.0
}
