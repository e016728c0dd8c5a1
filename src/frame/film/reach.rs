//! Pixels that samples reach by a filter wider than a pixel, and their weights in each.

use wide::i32x8;

use super::areas::{Areas, SLOPED_TAPS, in_pixels};
use crate::frame::grid::Grid;
use crate::frame::planes::kernel::Kernel;
use crate::lanes::{F32x8, LANES};
use crate::samples::Column;

/// Number of pixels along an edge of a tile with its halo.
pub fn edge(grid: &Grid, halo: u32) -> usize {
    (grid.tile_pixels + 2 * halo) as usize
}

/// What samples weigh by.
#[derive(Clone, Copy)]
pub enum Weighing<'a> {
    /// By their distances: samples that lie at their targets.
    Distance,
    /// By their distances and by their areas: where samples lie close together each counts less, so that the silhouette between two surfaces
    /// does not depend on how closely they are sampled.
    DistanceAndArea(&'a Areas),
    /// By their areas: samples that lie at their targets.
    Area(&'a Areas),
    /// By their areas, which slope.
    SlopedArea(&'a Areas),
}

/// A filter, and where the samples of a tile lie that it spreads.
#[derive(Clone, Copy)]
pub struct Spread<'a> {
    kernel: &'a Kernel,
    /// x and y of the places where samples count, in cells from the tile's corner.
    places: [&'a Column<f32>; 2],
    by: Weighing<'a>,
    /// Edge of a cell, in pixels.
    cell: F32x8,
    /// Number of pixels along an edge of the tile with its halo.
    pub edge: usize,
}

impl<'a> Spread<'a> {
    /// Samples that count at these `places` of a tile: x and y, in cells from its corner.
    pub fn new(kernel: &'a Kernel, grid: &Grid, places: [&'a Column<f32>; 2], by: Weighing<'a>) -> Self {
        let cell = F32x8::splat((grid.samples as f32).recip());
        Self { kernel, places, by, cell, edge: edge(grid, kernel.halo()) }
    }

    /// Number of pixels that a sample reaches beyond its own, at most.
    pub fn halo(&self) -> u32 {
        self.kernel.halo()
    }

    /// Number of pixels in a row that each sample reaches.
    pub fn taps(&self) -> usize {
        match self.by {
            Weighing::Distance | Weighing::DistanceAndArea(_) => self.kernel.taps(),
            Weighing::Area(_) => 2,
            Weighing::SlopedArea(_) => SLOPED_TAPS,
        }
    }

    /// Computes which pixels eight samples reach: `N` in a row, as [`taps`](Self::taps) says.
    #[inline(always)]
    pub fn reach<const N: usize>(&self, first: usize) -> Reach<N> {
        // the halo shifts places by as many pixels; the first pixel of a sample lies N/2 before it
        let margin = self.kernel.margin() as f32;
        let at = [0, 1].map(|axis| {
            let shift = F32x8::splat(0.5 + (self.kernel.shift[axis] + margin));
            F32x8::load(self.places[axis], first) * self.cell + shift
        });
        let whole = at.map(F32x8::to_whole);
        let [x, y] = [0, 1].map(|axis| at[axis] - F32x8::from_whole(whole[axis]));
        let [across, down] = match self.by {
            Weighing::Distance => [self.kernel.weights::<N>(x), self.kernel.weights(y)],
            Weighing::DistanceAndArea(areas) => {
                let [width, height] = areas.extents(first);
                [
                    self.kernel.weights::<N>(x).map(|weight| weight * width),
                    self.kernel.weights::<N>(y).map(|weight| weight * height),
                ]
            }
            Weighing::Area(areas) => {
                let [beside, above] = areas.sides(first).map(|sides| sides.map(|side| side * self.cell));
                [in_pixels::<N>(x, beside), in_pixels(y, above)]
            }
            Weighing::SlopedArea(areas) => areas.sloped::<N>(first),
        };
        let shift = ((self.halo() - self.kernel.margin()) as usize - N / 2) * (self.edge + 1);
        let start = whole[1] * i32x8::splat(self.edge as i32) + whole[0] + i32x8::splat(shift as i32);
        Reach { start: start.to_array(), weights: down.map(|down| across.map(|across| across * down)) }
    }
}

/// The N x N pixels that each of eight samples reaches, with the samples' weights there.
pub struct Reach<const N: usize> {
    /// First pixel of each sample: its number in rows of `edge` pixels, halo included.
    start: [i32; LANES],
    /// Weights of the eight samples in each pixel, in rows.
    weights: [[F32x8; N]; N],
}

impl<const N: usize> Reach<N> {
    /// Column and row of the first pixel that sample `lane` reaches.
    #[inline(always)]
    pub fn corner(&self, lane: usize, edge: usize) -> [usize; 2] {
        let start = self.start[lane] as usize;
        [start % edge, start / edge]
    }

    /// Adds the weights of sample `lane` to `pixels`: rows of `stride`, from the first pixel that it reaches.
    #[inline(always)]
    pub fn add_weights(&self, lane: usize, stride: usize, pixels: &mut [f32]) {
        for (row, weights) in pixels.chunks_mut(stride).zip(&self.weights) {
            row.iter_mut().zip(weights).for_each(|(pixel, weight)| *pixel += weight.lane(lane));
        }
    }

    /// Adds `value`, that of sample `lane`, times its weights to its pixels.
    #[inline(always)]
    pub fn add(&self, lane: usize, value: F32x8, edge: usize, pixels: &mut [F32x8]) {
        let pixels = &mut pixels[self.start[lane] as usize..][..(N - 1) * edge + N];
        for (row, weights) in self.weights.iter().enumerate() {
            let in_row = &mut pixels[row * edge..row * edge + N];
            for (pixel, weight) in in_row.iter_mut().zip(weights) {
                *pixel = *pixel + value * F32x8::splat(weight.lane(lane));
            }
        }
    }
}
