//! Cryptomattes: each matte's share of each pixel, exact under the filter of the picture.
//!
//! A filter wider than a pixel mixes samples of several tiles. Each tile sums the weights of its samples,
//! matte by matte, over the pixels that they reach ([`MatteSums`]), and [`develop`](super::develop) adds the
//! sums of several tiles for each pixel.

use std::ops::Range;

use super::reach::Spread;
use crate::cryptomatte::{Id, Kind, Mattes, RANKS};
use crate::frame::grid::Grid;
use crate::frame::planes::kernel::MOST_TAPS;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::LANES;
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, Tile};

/// Mattes of one kind in a pixel, with their shares: the largest ones, largest first.
pub type Ranked = [(Id, f32); RANKS];

/// Looks up the matte of each of a tile's cells; [`Id::NONE`] for cells without any.
pub fn ids_of_cells(frame: &FrameView, mattes: &Mattes, tile: &Tile, kind: Kind, ids: &mut Column<Id>) {
    for (cell, id) in ids.iter_mut().enumerate() {
        let model = tile.model[cell];
        *id = match model {
            EMPTY => Id::NONE,
            BACKGROUND => mattes.background,
            _ => match kind {
                Kind::Object => mattes.objects[model as usize],
                Kind::Material => mattes.materials[usize::from(tile.record[cell].material)],
                Kind::Group => {
                    let groups = &frame.scene.models[model as usize].mesh.groups;
                    mattes.groups[model as usize][groups.of(tile.record[cell].triangle)]
                }
            },
        };
    }
}

/// Ranks the mattes of a pixel by their `shares`, which add up to the pixel's coverage. A filter's negative
/// lobes may make some shares negative: those are left out, and the others scaled, so that they add up to a
/// coverage between 0 and 1.
pub fn rank(shares: &mut Vec<(Id, f32)>) -> Ranked {
    // sums must not depend on the order in which mattes were found: with a crop it is another
    shares.sort_unstable_by_key(|(id, _)| *id);
    let coverage = shares.iter().map(|(_, share)| share).sum::<f32>().clamp(0.0, 1.0);
    shares.retain(|(_, share)| *share > 0.0);
    let sum: f32 = shares.iter().map(|(_, share)| share).sum();
    if sum > coverage {
        shares.iter_mut().for_each(|(_, share)| *share *= coverage / sum);
        shares.retain(|(_, share)| *share > 0.0);
    }
    // mattes of equal shares must not be ordered by their samples
    shares.sort_unstable_by(|(id, share), (other_id, other)| other.total_cmp(share).then(id.cmp(other_id)));
    let mut ranked = [(Id::NONE, 0.0); RANKS];
    ranked.iter_mut().zip(shares.iter()).for_each(|(to, from)| *to = *from);
    ranked
}

/// Adds `more` to the share of `id`.
pub fn add_share(shares: &mut Vec<(Id, f32)>, id: Id, more: f32) {
    match shares.iter_mut().find(|(known, _)| *known == id) {
        Some((_, share)) => *share += more,
        None => shares.push((id, more)),
    }
}

/// Calls `each` with the number and the mattes of every pixel of a tile that shows any. A pixel is the mean
/// of its own cells.
pub fn rank_boxes(grid: &Grid, ids: &Column<Id>, mut each: impl FnMut(usize, &Ranked)) {
    let cells_of_pixels = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
    let share = (grid.samples_of_pixel() as f32).recip();
    let mut shares = Vec::new();
    for (pixel, cells) in cells_of_pixels.enumerate() {
        shares.clear();
        let ids = cells.iter().map(|cell| ids[usize::from(*cell)]);
        // counts, which are exact
        ids.filter(|id| *id != Id::NONE).for_each(|id| add_share(&mut shares, id, 1.0));
        if !shares.is_empty() {
            shares.iter_mut().for_each(|(_, count)| *count *= share);
            each(pixel, &rank(&mut shares));
        }
    }
}

/// Weights that one tile's samples add to the pixels that they reach, by matte. Keeps its memory from frame
/// to frame.
#[derive(Debug, Default)]
pub struct MatteSums {
    patches: Vec<Patch>,
    /// Sums of all patches, one patch after the other, in rows.
    sums: Vec<f32>,
}

/// Rectangle of the pixels that a matte's samples reach. Not the whole tile: there may be as many mattes as
/// cells.
#[derive(Debug, Clone)]
struct Patch {
    id: Id,
    /// Columns and rows, counted from the corner of the tile's halo.
    pixels: [Range<usize>; 2],
    /// Index of the first of its sums.
    first: usize,
}

impl MatteSums {
    /// Removes all sums.
    pub fn clear(&mut self) {
        self.patches.clear();
        self.sums.clear();
    }

    /// Spreads the weight of each sample of a tile over the pixels that it reaches.
    pub fn spread(&mut self, by: Spread, ids: &Column<Id>) {
        match by.taps() {
            2 => self.spread_by::<2>(by, ids),
            4 => self.spread_by::<4>(by, ids),
            6 => self.spread_by::<6>(by, ids),
            _ => self.spread_by::<MOST_TAPS>(by, ids),
        }
    }

    /// [`spread`](Self::spread) with a kernel that reaches `N` pixels in a row.
    fn spread_by<const N: usize>(&mut self, by: Spread, ids: &Column<Id>) {
        const NONE: u16 = u16::MAX;
        self.clear();
        let edge = by.edge;
        let with_matte = |first: usize| (0..LANES).filter(move |lane| ids[first + lane] != Id::NONE);
        let mut patch_of = [NONE; CELLS];
        for first in (0..CELLS).step_by(LANES).filter(|first| with_matte(*first).next().is_some()) {
            let reach = by.reach::<N>(first);
            for lane in with_matte(first) {
                let [left, top] = reach.corner(lane, edge);
                let number = self.patch(ids[first + lane], [left, top], N);
                let [columns, rows] = &mut self.patches[number].pixels;
                *columns = columns.start.min(left)..columns.end.max(left + N);
                *rows = rows.start.min(top)..rows.end.max(top + N);
                patch_of[first + lane] = number as u16;
            }
        }
        let mut end = 0;
        for patch in &mut self.patches {
            patch.first = end;
            end += patch.pixels.iter().map(ExactSizeIterator::len).product::<usize>();
        }
        self.sums.resize(end, 0.0);
        for first in (0..CELLS).step_by(LANES).filter(|first| with_matte(*first).next().is_some()) {
            let reach = by.reach::<N>(first);
            for lane in with_matte(first) {
                let Patch { pixels: [columns, rows], first: begin, .. } =
                    &self.patches[usize::from(patch_of[first + lane])];
                let [left, top] = reach.corner(lane, edge);
                let start = begin + (top - rows.start) * columns.len() + left - columns.start;
                reach.add_weights(lane, columns.len(), &mut self.sums[start..]);
            }
        }
    }

    /// Finds the patch of `id` and returns its number. A new patch has `reach` x `reach` pixels, the first of
    /// them at `first`.
    fn patch(&mut self, id: Id, first: [usize; 2], reach: usize) -> usize {
        // most samples are of the matte of the one before
        let known = self.patches.iter().rposition(|patch| patch.id == id);
        known.unwrap_or_else(|| {
            self.patches.push(Patch { id, pixels: first.map(|at| at..at + reach), first: 0 });
            self.patches.len() - 1
        })
    }

    /// Calls `add(id, at, sums)` for all runs of sums within the rectangle `pixels` of the picture. `corner`
    /// is the first pixel of the tile's halo, which may lie outside the picture. `at` is column and row of
    /// the first of `sums`.
    fn for_each_run(
        &self,
        corner: [isize; 2],
        pixels: &[Range<usize>; 2],
        mut add: impl FnMut(Id, [usize; 2], &[f32]),
    ) {
        for Patch { id, pixels: own, first } in &self.patches {
            let common = [0, 1].map(|axis| {
                let to_picture = |at: usize| (at as isize + corner[axis]).max(0) as usize;
                let [start, end] = [own[axis].start, own[axis].end].map(to_picture);
                start.max(pixels[axis].start)..end.min(pixels[axis].end)
            });
            let [columns, rows] = &common;
            if columns.is_empty() {
                continue;
            }
            for y in rows.clone() {
                let [left, row] = [(columns.start, 0), (y, 1)]
                    .map(|(at, axis)| (at as isize - corner[axis]) as usize - own[axis].start);
                let start = first + row * own[0].len() + left;
                add(*id, [columns.start, y], &self.sums[start..][..columns.len()]);
            }
        }
    }
}

/// Weights of each matte in a rectangle of `N` pixels, in rows.
#[derive(Debug)]
pub struct MattePlanes<const N: usize> {
    planes: Vec<(Id, [f32; N])>,
}

impl<const N: usize> Default for MattePlanes<N> {
    fn default() -> Self {
        Self { planes: Vec::new() }
    }
}

impl<const N: usize> MattePlanes<N> {
    /// Adds the sums of a tile to the rectangle `pixels` of the picture, in rows of `stride`.
    pub fn add(&mut self, sums: &MatteSums, corner: [isize; 2], pixels: &[Range<usize>; 2], stride: usize) {
        sums.for_each_run(corner, pixels, |id, [x, y], run| {
            let number = self.planes.iter().position(|(known, _)| *known == id).unwrap_or_else(|| {
                self.planes.push((id, [0.0; N]));
                self.planes.len() - 1
            });
            let start = (y - pixels[1].start) * stride + x - pixels[0].start;
            self.planes[number].1[start..].iter_mut().zip(run).for_each(|(sum, more)| *sum += more);
        });
    }

    /// Calls `each` with the number and the mattes of every pixel that shows any. `scales` convert weights to
    /// shares, pixel by pixel.
    pub fn rank(&self, scales: &[f32; N], mut each: impl FnMut(usize, &Ranked)) {
        let mut shares = Vec::with_capacity(self.planes.len());
        for (pixel, scale) in scales.iter().enumerate() {
            shares.clear();
            let planes = self.planes.iter().map(|(id, weights)| (*id, weights[pixel] * scale));
            shares.extend(planes.filter(|(_, share)| *share != 0.0));
            if !shares.is_empty() {
                each(pixel, &rank(&mut shares));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::film::reach::Weighing;
    use crate::frame::film::reach::edge;
    use crate::frame::grid::tests::settings;
    use crate::frame::planes::kernel::Kernel;
    use crate::settings::Filter;

    #[test]
    fn shares_are_sorted_and_add_up_to_the_coverage() {
        let mut shares = vec![(Id(5), 0.25), (Id(3), 0.25), (Id(9), 0.5)];
        let ranked = rank(&mut shares);
        assert_eq!(ranked[..4], [(Id(9), 0.5), (Id(3), 0.25), (Id(5), 0.25), (Id::NONE, 0.0)]);
        // beside an edge a filter overshoots: what it takes from one it has given to the other
        let ranked = rank(&mut vec![(Id(1), -0.125), (Id(2), 1.125)]);
        assert_eq!(ranked[..2], [(Id(2), 1.0), (Id::NONE, 0.0)]);
        let ranked = rank(&mut vec![(Id(1), -0.25), (Id(2), 0.5), (Id(3), 0.5)]);
        assert_eq!(ranked[..3], [(Id(2), 0.375), (Id(3), 0.375), (Id::NONE, 0.0)]);
        assert_eq!(rank(&mut vec![(Id(1), -0.1)]), [(Id::NONE, 0.0); RANKS]);
    }

    #[test]
    fn the_smallest_of_too_many_are_left_out() {
        let mut shares: Vec<(Id, f32)> = (1..=10).map(|number| (Id(number), number as f32 / 64.0)).collect();
        assert_eq!(rank(&mut shares).map(|(id, _)| id.0), [10, 9, 8, 7, 6, 5]);
    }

    #[test]
    fn sums_of_mattes_add_up_to_the_weights() {
        for samples in [1, 2, 3] {
            let grid = Grid::new(&settings(64, 64, samples));
            let place = |column: &Column<f32>, aside: f32| column.map(|at| at + aside);
            let (x, y) = (place(&grid.place_x, 0.25), place(&grid.place_y, 0.625));
            // five mattes, all over the tile, and cells without any
            let ids: Column<Id> =
                std::array::from_fn(|cell| Id((cell as u32).wrapping_mul(2654435761) >> 8).at(6));
            let mut sums = MatteSums::default();
            let kernel = Kernel::new(Filter::Mitchell, 2.0).expect("it is wide");
            let by = Spread::new(&kernel, &grid, [&x, &y], Weighing::Distance);
            sums.spread(by, &ids);
            let mut of_all = MattePlanes::<1600>::default();
            let edge = edge(&grid, kernel.halo());
            of_all.add(&sums, [0, 0], &[0..edge, 0..edge], 40);
            assert_eq!(of_all.planes.len(), 5);
            for wanted in 1..6 {
                let total: f32 =
                    of_all.planes.iter().find(|(id, _)| id.0 == wanted).expect("it is there").1.iter().sum();
                let count = ids.iter().filter(|id| id.0 == wanted).count() as f32;
                assert!((total - count).abs() < 1e-3 * count, "{samples}: {total}, not {count}");
            }
            // and in parts
            let mut in_parts = MattePlanes::<1600>::default();
            for (left, top) in [(0, 0), (8, 0), (0, 5), (8, 5)] {
                let [columns, rows] =
                    [(left, 8), (top, 5)].map(|(at, cut)| if at == 0 { 0..cut } else { cut..edge });
                let mut part = MattePlanes::<1600>::default();
                part.add(&sums, [0, 0], &[columns.clone(), rows.clone()], 40);
                for (id, weights) in part.planes {
                    let number =
                        in_parts.planes.iter().position(|(known, _)| *known == id).unwrap_or_else(|| {
                            in_parts.planes.push((id, [0.0; 1600]));
                            in_parts.planes.len() - 1
                        });
                    for (y, x) in rows.clone().flat_map(|y| columns.clone().map(move |x| (y, x))) {
                        in_parts.planes[number].1[y * 40 + x] +=
                            weights[(y - rows.start) * 40 + x - columns.start];
                    }
                }
            }
            for (id, weights) in &of_all.planes {
                let other = in_parts.planes.iter().find(|(known, _)| known == id).expect("it is there");
                assert!(other.1 == *weights, "{samples}: matte {}", id.0);
            }
        }
    }

    impl Id {
        /// One of `count` numbers, 0 included.
        fn at(self, count: u32) -> Self {
            Self(self.0 % count)
        }
    }
}
