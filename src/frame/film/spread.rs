//! Filters wider than a pixel: a sample spreads over all pixels within the filter's radius, those of other
//! tiles included.
//!
//! A tile's contribution to pixels stays in a [`TileFilm`]; [`develop`](super::develop) adds those of
//! neighbours for each pixel.

use std::ops::Range;

use super::mattes::MatteSums;
use super::reach::{Spread, edge};
use crate::cryptomatte::Kind;
use crate::frame::grid::Grid;
use crate::frame::planes::channels::sums;
use crate::frame::planes::kernel::MOST_TAPS;
use crate::lanes::{F32x8, LANES};
use crate::samples::{CELLS, Column, EMPTY, Tile};

/// Number of groups. Eight planes of sums make a group: a pixel's eight sums lie side by side, and grow
/// together.
pub const GROUPS: usize = sums::COUNT.div_ceil(LANES);

/// Sums that one tile's samples add to the pixels that they reach. Keeps its memory from frame to frame.
#[derive(Debug)]
pub struct TileFilm {
    /// Sums of each group: the tile's pixels and the halo around them, in rows. Values of a group in which no
    /// plane `is_some` mean nothing.
    groups: [Vec<F32x8>; GROUPS],
    /// True for each plane that is not zero throughout.
    is_some: [bool; sums::COUNT],
    /// Halo of the filter: pixels around the tile.
    halo: u32,
    /// Sums of mattes by kind, for the kinds that a layer shows.
    pub mattes: [MatteSums; Kind::ALL.len()],
}

impl Default for TileFilm {
    fn default() -> Self {
        Self {
            groups: Default::default(),
            is_some: [false; sums::COUNT],
            halo: 0,
            mattes: Default::default(),
        }
    }
}

impl TileFilm {
    /// Returns true if any of these planes of sums is not zero throughout.
    pub fn has(&self, planes: &[usize]) -> bool {
        planes.iter().any(|plane| self.is_some[*plane])
    }

    fn has_group(&self, group: usize) -> bool {
        self.is_some.chunks(LANES).nth(group).is_some_and(|planes| planes.contains(&true))
    }

    /// Calls `add(group, at, sums)` for every row of the rectangle `pixels` of the film that samples of the
    /// tile reach. `number` is the tile's. `at` is column and row of the first of `sums`, which are one a
    /// pixel, from left to right.
    pub fn for_each_run(
        &self,
        grid: &Grid,
        number: usize,
        pixels: &[Range<usize>; 2],
        mut add: impl FnMut(usize, [usize; 2], &[F32x8]),
    ) {
        let edge = edge(grid, self.halo);
        // of the halo, in the film
        let corner = grid.corner_in_film(number).map(|at| at - self.halo as i32);
        let common = [0, 1].map(|axis| {
            let reached = [corner[axis], corner[axis] + edge as i32].map(|at| at.max(0) as usize);
            pixels[axis].start.max(reached[0])..pixels[axis].end.min(reached[1])
        });
        let [columns, rows] = &common;
        if columns.is_empty() {
            return;
        }
        for group in (0..GROUPS).filter(|group| self.has_group(*group)) {
            for y in rows.clone() {
                let [x, row] =
                    [(columns.start, 0), (y, 1)].map(|(at, axis)| (at as i32 - corner[axis]) as usize);
                add(group, [columns.start, y], &self.groups[group][row * edge + x..][..columns.len()]);
            }
        }
    }
}

/// Spreads each sample of a tile over the pixels that it reaches. `columns` are the values to be summed, `None` where all
/// are zero.
pub fn spread(by: Spread, tile: &Tile, columns: &[Option<&Column<f32>>; sums::COUNT], film: &mut TileFilm) {
    match by.taps() {
        2 => spread_by::<2>(by, tile, columns, film),
        4 => spread_by::<4>(by, tile, columns, film),
        6 => spread_by::<6>(by, tile, columns, film),
        _ => spread_by::<MOST_TAPS>(by, tile, columns, film),
    }
}

/// [`spread`] where each sample reaches `N` pixels in a row.
fn spread_by<const N: usize>(
    by: Spread,
    tile: &Tile,
    columns: &[Option<&Column<f32>>; sums::COUNT],
    film: &mut TileFilm,
) {
    static NOTHING: Column<f32> = [0.0; CELLS];
    static ONE: Column<f32> = [1.0; CELLS];
    film.halo = by.halo();
    let edge = by.edge;
    film.is_some = columns.map(|column| column.is_some());
    film.is_some[sums::WEIGHT] = true;
    let has_group: [bool; GROUPS] = std::array::from_fn(|group| film.has_group(group));
    for (sums, _) in film.groups.iter_mut().zip(has_group).filter(|(_, has_any)| *has_any) {
        sums.clear();
        sums.resize(edge * edge, F32x8::ZERO);
    }
    let column = |plane: usize| match plane {
        sums::WEIGHT => &ONE,
        _ => columns.get(plane).copied().flatten().unwrap_or(&NOTHING),
    };
    let columns: [[&Column<f32>; LANES]; GROUPS] =
        std::array::from_fn(|group| std::array::from_fn(|lane| column(group * LANES + lane)));
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let reach = by.reach::<N>(first);
        for lane in (0..LANES).filter(|lane| models[*lane] != EMPTY) {
            for group in (0..GROUPS).filter(|group| has_group[*group]) {
                let value = F32x8::new(columns[group].map(|column| column[first + lane]));
                // most samples have neither highlight nor mirror
                if group == 0 || value != F32x8::ZERO {
                    reach.add(lane, value, edge, &mut film.groups[group]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;
    use crate::frame::film::reach::Weighing;
    use crate::frame::planes::kernel::Kernel;
    use crate::settings::Filter;

    #[test]
    fn a_sample_reaches_the_pixels_around_it() {
        let grid = Grid::new(&crate::frame::grid::tests::settings(64, 64, 1));
        let mut tile = Tile::empty(&crate::samples::TagLayout::new(std::iter::empty()));
        // the cell in column 5 of row 2, a little right of its centre and above it
        let cell = grid.index_of([5, 2]) as usize;
        tile.model[cell] = 0;
        let (mut x, mut y, mut value) = ([0.0; CELLS], [0.0; CELLS], [0.0; CELLS]);
        (x[cell], y[cell], value[cell]) = (5.75, 2.25, 3.0);
        let mut columns = [None; sums::COUNT];
        columns[sums::SPECULAR + 1] = Some(&value);
        let mut film = TileFilm::default();
        let kernel = Kernel::new(Filter::Mitchell, 2.0).unwrap();
        let by = Spread::new(&kernel, &grid, [&x, &y], Weighing::Distance);
        spread(by, &tile, &columns, &mut film);
        assert!(film.has(&[sums::SPECULAR + 1]) && !film.has(&[sums::SPECULAR, sums::ALPHA]));
        let weights = |beyond| kernel.weights::<4>(F32x8::splat(beyond));
        let (across, down) = (weights(0.25), weights(0.75));
        let mut reached = 0;
        film.for_each_run(&grid, 0, &[0..36, 0..36], |group, [left, y], run| {
            for (x, sums) in (left..).zip(run).filter(|(_, sums)| **sums != F32x8::ZERO) {
                let weight = across[x - 4].lane(0) * down[y].lane(0);
                let plane = [sums::WEIGHT, (sums::SPECULAR + 1) % LANES][group];
                assert_eq!(sums.lane(plane), weight * [1.0, 3.0][group], "{x} {y}");
                reached += 1;
            }
        });
        assert_eq!(reached, 2 * 4 * 4);
    }
}
