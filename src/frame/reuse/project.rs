//! Projection of samples of the frame before into this frame.

use super::bins::{Projected8, STEPS};
use crate::exposure::Tick;
use crate::frame::grid::view::{Cameras8, View};
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, EMPTY, Spares, Tile};

/// Projects eight samples of `tile`, from cell `first` on.
#[inline(always)]
pub fn project_lanes(frame: &FrameView, tile: &Tile, first: usize) -> Projected8 {
    let cameras = frame.cameras(tile, first);
    let offsets = frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first));
    project(frame, &cameras, &tile.model[first..first + LANES], offsets)
}

/// Projects up to eight spare samples, from number `first` on.
pub fn project_spares(frame: &FrameView, spares: &Spares, first: usize) -> Projected8 {
    let (models, ticks, offsets) = eight_spares(frame, frame.view, spares, first);
    project(frame, &frame.view.cameras_at(|| ticks), &models, offsets)
}

/// Models, ticks and offsets from the eyes of `view` of up to eight spare samples, from number `first` on; the others are [`EMPTY`].
pub fn eight_spares(
    frame: &FrameView,
    view: &View,
    spares: &Spares,
    first: usize,
) -> ([u32; LANES], [Tick; LANES], Vec3x8) {
    let (mut models, mut ticks, mut offsets) = ([EMPTY; LANES], [0; LANES], Vec3x8::ZERO);
    for (lane, spare) in spares.samples[first..].iter().take(LANES).enumerate() {
        models[lane] = spare.model;
        ticks[lane] = spare.record.traced.tick();
        let (eye, of) = (view.eye(ticks[lane]), (spare.model, spare.record.triangle));
        offsets.set_lane(lane, frame.offset_from(eye, spare.point, of, ticks[lane]));
    }
    (models, ticks, offsets)
}

/// Projects samples at `offsets` from the eye. The background is infinitely deep; samples of models that have
/// disappeared are in no tile.
#[inline(always)]
fn project(frame: &FrameView, cameras: &Cameras8, models: &[u32], offsets: Vec3x8) -> Projected8 {
    let seen = cameras.project(offsets);
    let grid = &frame.view.grid;
    let [mut is_sample, is_background] = [!Mask::equal(models, EMPTY), Mask::equal(models, BACKGROUND)];
    if frame.view.camera.is_orthographic() {
        // the background has no place of its own: all of it is seen along the view axis
        is_sample = is_sample & !is_background;
    }
    // false for NaN as well
    let is_before = seen.depth.gt(F32x8::splat(f32::MIN_POSITIVE));
    Projected8 {
        which: (is_sample & is_before & grid.inside(seen.x, seen.y)).bits() & !frame.hidden_bits(models),
        depth: is_background.select(F32x8::splat(f32::INFINITY), frame.view.ranked_depth(seen.depth)),
        x: grid.steps_from_first(seen.x, 0, STEPS),
        y: grid.steps_from_first(seen.y, 1, STEPS),
    }
}
