//! Reprojection: the samples of the frame before move with their models, are projected into this frame's picture, and
//! serve its cells (the paper's "Reprojection Phase").
//!
//! Two passes. [`scatter`] projects every old sample and puts it into the bin of the tile that it falls into, and of
//! those beside which it may serve ([`Bins`]); [`gather`] then finds each cell's server, tile by tile, and copies it
//! into the new store.

use rayon::prelude::*;
use wide::i32x8;

use super::bins::{BinWriter, Bins, Projected8, STEPS};
use super::bits::{set_bits, surface_bits};
use super::estimate::LEAST_REUSED;
use super::grid::holds;
use super::plan::CameraChange;
use super::serve::Serving;
use super::stage::Stage;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{
    BACKGROUND, CELLS, EMPTY, Flags, LeavingStore, Octahedral, SampleStore, Spares, Status, TILE, Tag, Tile,
};
use crate::settings::Reuse;

/// Puts every sample of `old` into the bins of the tiles whose cells it may serve.
pub fn scatter(old: SampleStore, stage: &Stage, bins: &Bins) -> LeavingStore {
    /// Tiles that a worker takes at least before others may have the rest.
    const AT_LEAST: usize = 8;
    let grid = &*stage.view.grid;
    let halo = stage.reuse == Reuse::Target;
    let scatter_tile = |writer: &mut BinWriter, (number, tile): (usize, &Tile)| {
        for first in (0..CELLS).step_by(LANES) {
            let mut projected = project_lanes(stage, tile, first);
            projected.which &= !tile.copies[first / LANES];
            writer.add(grid, first, &projected, halo);
        }
        for first in (0..tile.spares.len()).step_by(LANES) {
            writer.add(grid, CELLS + first, &project_spares(stage, &tile.spares, first), halo);
        }
        writer.send(number as u32, bins)
    };
    let tiles = old.tiles.par_iter().map(AsRef::as_ref).enumerate().with_min_len(AT_LEAST);
    let until: Vec<u32> = tiles.map_init(BinWriter::default, scatter_tile).collect();
    LeavingStore::new(old, &until)
}

/// Where eight samples of `tile`, from cell `first` on, are projected to.
#[inline(always)]
pub fn project_lanes(stage: &Stage, tile: &Tile, first: usize) -> Projected8 {
    project(stage, &tile.model[first..first + LANES], stage.offsets(tile, first))
}

/// The same for up to eight spare samples.
fn project_spares(stage: &Stage, spares: &Spares, first: usize) -> Projected8 {
    let mut models = [EMPTY; LANES];
    let mut offsets = Vec3x8::ZERO;
    for (lane, spare) in spares.samples[first..].iter().take(LANES).enumerate() {
        models[lane] = spare.model;
        offsets.set_lane(lane, stage.offset(spare.point, spare.model));
    }
    project(stage, &models, offsets)
}

/// Where samples at `offsets` from the eye are projected to. The background is infinitely deep.
#[inline(always)]
fn project(stage: &Stage, models: &[u32], offsets: Vec3x8) -> Projected8 {
    let seen = stage.view.project(offsets);
    let grid = &stage.view.grid;
    let [is_sample, is_background] = [!Mask::equal(models, EMPTY), Mask::equal(models, BACKGROUND)];
    // no for what is not a number as well
    let is_before = seen.depth.gt(F32x8::splat(f32::MIN_POSITIVE));
    // before the picture's last cell ends, however it is rounded
    let steps = |at: F32x8, cells: u32| {
        let steps = (at * F32x8::splat(STEPS as f32)).to_whole();
        steps.min(i32x8::splat(cells as i32 * STEPS - 1)).to_array()
    };
    Projected8 {
        which: (is_sample & is_before & grid.inside(seen.x, seen.y)).bits(),
        depth: is_background.select(F32x8::splat(f32::INFINITY), seen.depth),
        x: steps(seen.x, grid.cells_x),
        y: steps(seen.y, grid.cells_y),
    }
}

/// Fills tile number `number` with what serves its cells. A cell that nothing serves is missed.
pub fn gather(
    old: &LeavingStore,
    stage: &Stage,
    bins: &Bins,
    number: usize,
    tile: &mut Tile,
    serving: &mut Serving,
) {
    bins.take(number, |runs| {
        serving.begin();
        runs.iter().for_each(|(source, run)| serving.add(*source, run));
    });
    let (grid, tiles) = (&stage.view.grid, |source| old.tile(source));
    let extent = grid.extent_of(number);
    serving.serve(stage.reuse, extent, &tiles);
    serving.fill(stage.reuse, extent, tile, &tiles);
    doubt(stage, &mut tile.spares);
    mark_outside(grid.extent(number), tile);
    let reused = tile.status.iter().filter(|status| status.is_reused()).count();
    if stage.chooses && reused < LEAST_REUSED {
        for cell in 0..CELLS {
            if tile.status[cell].is_reused() {
                tile.clear(cell, Status::Missed);
            }
        }
    }
}

/// Cells that are not in the picture.
fn mark_outside(extent: [u32; 2], tile: &mut Tile) {
    if extent != [TILE as u32; 2] {
        let beyond = tile.status.iter_mut().enumerate().filter(|(cell, _)| !holds(extent, *cell));
        beyond.for_each(|(_, status)| *status = Status::Outside);
    }
}

/// Spare samples are neither verified nor lit in this frame: what the plan says must be asked about them is not known
/// any more.
fn doubt(stage: &Stage, spares: &mut Spares) {
    let plan = stage.plan;
    let flags = [false, true].map(|moved| plan.doubts(moved));
    spares.set_flags(|spare| flags[usize::from(stage.moved(spare.model))]);
    for (light, slot) in (0..).zip(stage.slots) {
        if plan.keeps_all_tags(light) {
            continue;
        }
        let holds = |moved: bool, tag: Tag| plan.keeps_tag(light, moved, tag);
        spares.update_tags(
            *slot,
            |spare, tag| if holds(stage.moved(spare.model), tag) { tag } else { Tag::Unknown },
            |spare, tags| {
                let moved = stage.moved(spare.model);
                tags.without(|tag| !holds(moved, tag))
            },
        );
    }
}

/// Empties tile number `number` for a frame that is traced in full.
pub fn begin_base(stage: &Stage, number: usize, tile: &mut Tile) {
    tile.model.fill(EMPTY);
    tile.spares.clear();
    let extent = stage.view.grid.extent(number);
    for (cell, status) in tile.status.iter_mut().enumerate() {
        *status = if holds(extent, cell) { Status::Base } else { Status::Outside };
    }
}

/// Of eight cells, those whose sample is seen from the other side now: it was shaded for the side that the eye was on.
#[inline]
pub fn seen_from_behind(stage: &Stage, tile: &Tile, first: usize, flags: Flags) -> u8 {
    let models = &tile.model[first..first + LANES];
    let is_doubtful = stage.plan.camera == CameraChange::Moved || flags.has(Flags::UNSEEN);
    let moved = if is_doubtful { u8::MAX } else { stage.moved_bits(models) };
    let may_have_turned = moved & surface_bits(models);
    if may_have_turned == 0 {
        return 0;
    }
    let mut facets = Octahedral::unfold_lanes(tile.facets(first));
    for lane in set_bits(stage.displaced_bits(models)) {
        facets.set_lane(lane, stage.transform(models[lane]).facet(facets.lane(lane)));
    }
    let before = facets.dot(stage.offsets(tile, first)).lt(F32x8::ZERO);
    may_have_turned & !before.bits()
}
