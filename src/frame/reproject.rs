//! Reprojection: the samples of the frame before move with their models and fall into the cells of this
//! frame's camera (the paper's "Reprojection Phase").
//!
//! Two passes. [`scatter`] projects every old sample and puts it on the list of the tile that it falls into
//! ([`Falls`]); [`gather`] then brings each cell's winner, tile by tile, into the new store.

use rayon::prelude::*;

use super::contest::{Contest, Falls, LanesFall, Sorter};
use super::foresee::LEAST_REUSED;
use super::grid::holds;
use super::plan::CameraChange;
use super::stage::{Stage, set_bits, surface_bits};
use crate::lanes::{F32x8, LANES, Mask};
use crate::samples::{
    BACKGROUND, CELLS, Column, EMPTY, LeavingStore, Octahedral, SampleStore, Status, TILE, Tile,
};

/// Puts every sample of `old` on the list of the tile that it falls into.
pub fn scatter(old: SampleStore, stage: &Stage, falls: &Falls) -> LeavingStore {
    /// Tiles that a worker takes at least before others may have the rest.
    const AT_LEAST: usize = 8;
    let scatter_tile = |sorter: &mut Sorter, (number, tile): (usize, &Tile)| {
        for first in (0..CELLS).step_by(LANES) {
            sorter.add(first, project_lanes(stage, tile, first));
        }
        sorter.send(number as u32, falls)
    };
    let tiles = old.tiles.par_iter().map(AsRef::as_ref).enumerate().with_min_len(AT_LEAST);
    let until: Vec<u32> = tiles.map_init(Sorter::default, scatter_tile).collect();
    LeavingStore::new(old, &until)
}

/// Where eight samples of `tile`, from cell `first` on, fall. The background is infinitely deep.
#[inline(always)]
pub fn project_lanes(stage: &Stage, tile: &Tile, first: usize) -> LanesFall {
    let models = &tile.model[first..first + LANES];
    let seen = stage.view.project(stage.offsets(tile, first));
    let grid = &stage.view.grid;
    let [is_sample, is_background] = [!Mask::equal(models, EMPTY), Mask::equal(models, BACKGROUND)];
    // no for what is not a number as well
    let is_before = seen.depth.gt(F32x8::splat(f32::MIN_POSITIVE));
    LanesFall {
        which: (is_sample & is_before & grid.inside(seen.x, seen.y)).bits(),
        depth: is_background.select(F32x8::splat(f32::INFINITY), seen.depth),
        cells: grid.cells_at(seen.x, seen.y),
    }
}

/// Fills tile number `number` with the winners of its cells. A cell that nobody won is missed.
///
/// A sample that the eye sees from the other side now is dropped: it was shaded for the side that the
/// eye was on.
pub fn gather(
    old: &LeavingStore,
    stage: &Stage,
    falls: &Falls,
    number: usize,
    tile: &mut Tile,
    contest: &mut Contest,
) {
    falls.take(number, |list| {
        contest.hold(list, |source, moves| {
            if let Some(from) = old.tile(source) {
                tile.take_over_all(from, moves);
            }
        });
    });
    mark_fallen(tile, contest.fallen());
    let extent = stage.view.grid.extent(number);
    if extent != [TILE as u32; 2] {
        let beyond = tile.status.iter_mut().enumerate().filter(|(cell, _)| !holds(extent, *cell));
        beyond.for_each(|(_, status)| *status = Status::Outside);
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

/// Cells into which nothing has `fallen` are missed; the samples in the others are a frame older.
fn mark_fallen(tile: &mut Tile, fallen: &Column<u8>) {
    // without a branch: all columns are gone through many cells at a time
    for (status, fallen) in tile.status.iter_mut().zip(fallen) {
        *status = match *fallen {
            0 => Status::Missed,
            1 => Status::Good,
            _ => Status::Overlapped,
        };
    }
    for (model, fallen) in tile.model.iter_mut().zip(fallen) {
        *model = if *fallen == 0 { EMPTY } else { *model };
    }
    for (age, fallen) in tile.age.iter_mut().zip(fallen) {
        *age = if *fallen == 0 { 0 } else { age.saturating_add(1) };
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
    let before = facets.dot(stage.offsets(tile, first)).lt(F32x8::ZERO);
    may_have_turned & !before.bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::TagLayout;

    #[test]
    fn what_has_fallen_says_what_a_cell_holds() {
        let mut tile = Tile::empty(&TagLayout::of(std::iter::empty()));
        tile.model.fill(3);
        tile.age = std::array::from_fn(|cell| if cell % 2 == 0 { 5 } else { u16::MAX });
        let fallen = std::array::from_fn(|cell| (cell % 3) as u8);
        mark_fallen(&mut tile, &fallen);
        for cell in 0..CELLS {
            let grown = if cell % 2 == 0 { 6 } else { u16::MAX };
            let wanted = match cell % 3 {
                0 => (Status::Missed, EMPTY, 0),
                1 => (Status::Good, 3, grown),
                _ => (Status::Overlapped, 3, grown),
            };
            assert_eq!((tile.status[cell], tile.model[cell], tile.age[cell]), wanted, "{cell}");
        }
    }
}
