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

use super::bins::{Bins, Projected8, STEPS};
use super::project::eight_spares;
use super::serve::Serving;
use crate::frame::grid::view::Cameras8;
use crate::frame::shot::frame_view::{FrameView, Neighbor};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{SampleStore, Spares, Tile};

/// Samples that another exposure lends, projected into bins.
#[derive(Clone, Copy)]
pub struct Beside<'c> {
    pub store: &'c SampleStore,
    pub bins: &'c Bins,
}

impl<'c> Beside<'c> {
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

/// Which of the samples that are projected another exposure has as well.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Copies {
    /// Those that are marked, of a picture's own.
    Shared,
    /// All: they are the other exposure's.
    All,
}

/// Bit mask of those of eight samples of a tile, from cell `first` on, that another exposure has as well, and that both see within a pixel now.
/// `projected`: as this one sees them.
#[inline(always)]
pub fn seen_twice(
    frame: &FrameView,
    copies: Copies,
    (tile, first): (&Tile, usize),
    projected: &Projected8,
) -> u8 {
    let Some(beside) = &frame.beside else { return 0 };
    let is_copy = |lane: usize| tile.record[first + lane].traced.is_shared();
    let among = if copies == Copies::All { u8::MAX } else { Mask::new(is_copy).bits() };
    if among == 0 {
        return 0;
    }
    let cameras = beside.view.cameras_at(|| tile.ticks(first));
    let offsets = frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first));
    among & seen_near((frame, beside), &cameras, offsets, projected)
}

/// The same of up to eight spare samples, from number `first` on.
pub fn spares_seen_twice(
    frame: &FrameView,
    copies: Copies,
    (spares, first): (&Spares, usize),
    projected: &Projected8,
) -> u8 {
    let Some(beside) = &frame.beside else { return 0 };
    let of_lanes = &spares.samples[first..];
    let is_copy = |lane: usize| of_lanes.get(lane).is_some_and(|spare| spare.record.traced.is_shared());
    let among = if copies == Copies::All { u8::MAX } else { Mask::new(is_copy).bits() };
    if among == 0 {
        return 0;
    }
    let (_, ticks, offsets) = eight_spares(frame, beside.view, spares, first);
    among & seen_near((frame, beside), &beside.view.cameras_at(|| ticks), offsets, projected)
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
