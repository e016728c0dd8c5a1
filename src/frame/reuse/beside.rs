//! Samples that two exposures share.
//!
//! The exposures of a frame see about the same surfaces. What comes into sight comes into that of all of them, and what each would trace for
//! itself, they trace once: where its own samples leave cells open, an exposure is lent those of the exposure [beside] it,
//! which has just been made. They are verified like its own, and it goes on with copies of them, light and all. This goes where
//! nothing moves but the camera: what a sample keeps is then the same for all exposures.
//!
//! *The samples of a pixel stay different ones.* A sample that both exposures saw in one pixel would count twice in it, and so would its
//! noise. So they share what they see a pixel apart: as before a camera that turns, or through a lens what is out of focus. Where a camera
//! comes to rest, or what it sees into focus, copies are [dropped](seen_twice) again.
//!
//! [beside]: crate::frame::lineage::exposure_beside

use rayon::prelude::*;

use super::bins::{BinWriter, Bins, Projected8, STEPS};
use super::project::{project_lanes, project_spares};
use super::serve::Serving;
use crate::frame::grid::view::Cameras8;
use crate::frame::shot::frame_view::{FrameView, Neighbor};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, CELLS, SampleStore, Spares, Tile};

/// Samples that another exposure lends, projected into bins.
#[derive(Clone, Copy)]
pub struct Beside<'c> {
    store: &'c SampleStore,
    bins: &'c Bins,
}

impl<'c> Beside<'c> {
    /// Puts the samples of `store` that may be shared into `bins`.
    pub fn scatter(store: &'c SampleStore, frame: &FrameView, bins: &'c mut Bins) -> Self {
        let grid = &*frame.view.grid;
        bins.open(grid.tiles());
        let scatter_tile = |writer: &mut BinWriter, (number, tile): (usize, &Tile)| {
            for first in (0..CELLS).step_by(LANES) {
                let mut projected = project_lanes(frame, tile, first);
                projected.which &= !tile.copies[first / LANES];
                projected.which &= !within_a_pixel(frame, (tile, first), &projected);
                writer.add(grid, first, &projected, true);
            }
            for first in (0..tile.spares.len()).step_by(LANES) {
                let mut projected = project_spares(frame, &tile.spares, first);
                projected.which &= !spares_within_a_pixel(frame, (&tile.spares, first), &projected);
                writer.add(grid, CELLS + first, &projected, true);
            }
            writer.send(number as u32, bins);
        };
        let tiles = store.tiles.par_iter().map(AsRef::as_ref).enumerate();
        tiles.for_each_init(BinWriter::default, scatter_tile);
        Self { store, bins }
    }

    /// Has `serving` know what is lent to tile number `number`, and fills its open cells: with the nearest such samples, where any are near
    /// enough.
    pub fn fill(&self, frame: &FrameView, number: usize, tile: &mut Tile, serving: &mut Serving) {
        self.bins.take(number, |runs| serving.add_lent(runs));
        serving.fill_open(frame.view.grid.extent(number), tile, &|source| self.tile(source));
    }

    /// Tile number `number` of the lender.
    pub fn tile(&self, number: u32) -> Option<&'c Tile> {
        self.store.tiles.get(number as usize).map(AsRef::as_ref)
    }
}

/// Bit mask of those of eight samples of a tile, from cell `first` on, that are shared although both exposures see them within a pixel now.
/// `projected`: as this one sees them.
#[inline(always)]
pub fn seen_twice(frame: &FrameView, tile: &Tile, first: usize, projected: &Projected8) -> u8 {
    if frame.beside.is_none() {
        return 0;
    }
    let shared = Mask::new(|lane| tile.record[first + lane].traced.is_shared()).bits();
    if shared == 0 { 0 } else { shared & within_a_pixel(frame, (tile, first), projected) }
}

/// The same for spare samples, from number `first` on.
pub fn spares_seen_twice(frame: &FrameView, spares: &Spares, first: usize, projected: &Projected8) -> u8 {
    if frame.beside.is_none() {
        return 0;
    }
    let of_lanes = &spares.samples[first..];
    let is_shared = |lane: usize| of_lanes.get(lane).is_some_and(|spare| spare.record.traced.is_shared());
    let shared = Mask::new(is_shared).bits();
    if shared == 0 { 0 } else { shared & spares_within_a_pixel(frame, (spares, first), projected) }
}

/// Bit mask of those of eight samples that both exposures see within a pixel.
#[inline(always)]
fn within_a_pixel(frame: &FrameView, (tile, first): (&Tile, usize), projected: &Projected8) -> u8 {
    let Some(beside) = &frame.beside else { return 0 };
    let cameras = beside.view.cameras_at(|| tile.ticks(first));
    let offsets = frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first));
    seen_near((frame, beside), &cameras, offsets, projected)
}

fn spares_within_a_pixel(frame: &FrameView, (spares, first): (&Spares, usize), projected: &Projected8) -> u8 {
    let Some(beside) = &frame.beside else { return 0 };
    let (mut ticks, mut offsets) = ([0; LANES], Vec3x8::ZERO);
    for (lane, spare) in spares.samples[first..].iter().take(LANES).enumerate() {
        ticks[lane] = spare.record.traced.tick();
        let from_own = frame.offset_of(spare, ticks[lane]);
        let apart = frame.view.eye(ticks[lane]) - beside.view.eye(ticks[lane]);
        offsets.set_lane(lane, if spare.model == BACKGROUND { from_own } else { from_own + apart });
    }
    seen_near((frame, beside), &beside.view.cameras_at(|| ticks), offsets, projected)
}

/// Bit mask of those of eight samples, at `offsets` from the eyes of the exposure beside, that its `cameras` see within a pixel of where they
/// are `projected`.
#[inline(always)]
fn seen_near(
    (frame, beside): (&FrameView, &Neighbor),
    cameras: &Cameras8,
    offsets: Vec3x8,
    projected: &Projected8,
) -> u8 {
    let (grid, seen) = (&*frame.view.grid, cameras.project(offsets));
    let cells = F32x8::splat(grid.samples as f32);
    let near = |own: [i32; LANES], other: F32x8, axis: usize| {
        let own = F32x8::new(own.map(|steps| steps as f32 / STEPS as f32));
        let other = other - F32x8::splat(grid.first[axis] as f32);
        ((other - own) / cells + F32x8::splat(beside.shift[axis])).abs().lt(F32x8::ONE)
    };
    (near(projected.x, seen.x, 0) & near(projected.y, seen.y, 1)).bits()
}
