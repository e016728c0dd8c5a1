//! Pixels that samples reach by a filter wider than a pixel, and their weights in each.

use wide::i32x8;

use super::areas::{Areas, in_pixels};
use crate::frame::grid::Grid;
use crate::frame::planes::kernel::Kernel;
use crate::lanes::{F32x8, LANES};
use crate::samples::Column;

/// Number of pixels along an edge of a tile with its halo.
pub fn edge(grid: &Grid, halo: u32) -> usize {
    (grid.tile_pixels + 2 * halo) as usize
}

/// A filter, and where the samples of a tile lie that it spreads.
#[derive(Clone, Copy)]
pub struct Spread<'a> {
    kernel: &'a Kernel,
    /// x and y of samples, in cells from the tile's corner.
    places: [&'a Column<f32>; 2],
    /// Areas of samples, for a filter that weighs by these.
    areas: Option<&'a Areas>,
    /// Edge of a cell, in pixels.
    cell: F32x8,
    /// Number of pixels along an edge of the tile with its halo.
    pub edge: usize,
}

impl<'a> Spread<'a> {
    /// Samples at these `places` of a tile: x and y, in cells from its corner. A filter that is not [by
    /// area](Kernel::is_by_area) leaves their `areas` alone.
    pub fn new(kernel: &'a Kernel, grid: &Grid, places: [&'a Column<f32>; 2], areas: &'a Areas) -> Self {
        let cell = F32x8::splat((grid.samples as f32).recip());
        let areas = Some(areas).filter(|_| kernel.is_by_area());
        Self { kernel, places, areas, cell, edge: edge(grid, kernel.halo()) }
    }

    /// Number of pixels that a sample reaches beyond its own.
    pub fn halo(&self) -> u32 {
        self.kernel.halo()
    }

    /// Computes which pixels eight samples reach. The kernel reaches `N` pixels in a row.
    #[inline(always)]
    pub fn reach<const N: usize>(&self, first: usize) -> Reach<N> {
        // the halo shifts places by N/2 pixels; the first pixel of a sample lies as many before it
        let at = self.places.map(|at| F32x8::load(at, first) * self.cell + F32x8::splat(0.5));
        let whole = at.map(F32x8::to_whole);
        let [x, y] = [0, 1].map(|axis| at[axis] - F32x8::from_whole(whole[axis]));
        let [across, down] = match self.areas {
            Some(areas) => {
                let [beside, above] = areas.sides(first).map(|sides| sides.map(|side| side * self.cell));
                [in_pixels::<N>(x, beside), in_pixels(y, above)]
            }
            None => [self.kernel.weights::<N>(x), self.kernel.weights(y)],
        };
        Reach {
            start: (whole[1] * i32x8::splat(self.edge as i32) + whole[0]).to_array(),
            weights: down.map(|down| across.map(|across| across * down)),
        }
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
