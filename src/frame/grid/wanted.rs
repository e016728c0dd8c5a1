//! Sets of pixels that a level of refinement has to make.
//!
//! With adaptive samples a frame is made level by level (the paper's "adaptive supersampling"). The coarsest
//! level has samples in all pixels. Each finer one, twice as fine, has samples only in pixels that
//! [`contrast`](crate::frame::tiles::contrast) flags in the level before. A level is a chain of frames of its
//! own: its samples are reprojected, verified, lit and enhanced as any others, but in wanted cells only.
//! Samples that serve none stay as spare samples, and come back when their cells are wanted.

use std::ops::Range;

use rayon::prelude::*;

use super::around::{ROW, around};
use super::cells::CellSet;
use super::{Grid, holds};
use crate::samples::saved::CellMask;

/// A flag for each pixel of the picture and of its overscan.
#[derive(Debug, Clone, Default)]
pub struct PixelFlags {
    /// Column and row of the first pixel; negative in the overscan.
    corner: [i32; 2],
    width: usize,
    flags: Vec<bool>,
}

impl PixelFlags {
    /// Creates flags, none set, for the pixels of all tiles of `grid`.
    pub fn none(grid: &Grid) -> Self {
        let [columns, rows] = grid.axes.each_ref().map(|axis| axis.all());
        let flags = vec![false; columns.len() * rows.len()];
        Self { corner: [columns.start, rows.start], width: columns.len(), flags }
    }

    /// Flags of these columns in row `y`, as far as they exist, and the number of columns that are missing
    /// before the first.
    fn of_row(&self, columns: &Range<i32>, y: i32) -> (usize, &[bool]) {
        let row = usize::try_from(y - self.corner[1]).ok();
        let row = row.and_then(|row| self.flags.chunks_exact(self.width.max(1)).nth(row)).unwrap_or(&[]);
        let place = |x: i32| usize::try_from(x - self.corner[0]).unwrap_or(0).min(row.len());
        let before = (self.corner[0] - columns.start).clamp(0, columns.len() as i32);
        (before as usize, &row[place(columns.start)..place(columns.end)])
    }

    /// Slices of the flags, one for each row of tiles of `grid`, from the first on: all pixel rows of these
    /// tiles, each `width` long.
    pub fn rows_of_tiles<'f>(&'f mut self, grid: &Grid) -> Vec<&'f mut [bool]> {
        let mut left = &mut self.flags[..];
        let heights = (0..grid.axes[1].count()).map(|row| grid.axes[1].tile(row).len() * self.width);
        let mut rows = Vec::new();
        for count in heights {
            let (own, below) = left.split_at_mut(count);
            left = below;
            rows.push(own);
        }
        rows
    }

    /// Number of pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }
}

/// Wanted cells of each tile of a level. They are always all cells of whole pixels.
#[derive(Debug, Clone, Default)]
pub struct Wanted {
    tiles: Vec<CellSet>,
}

impl Wanted {
    /// Cells of the flagged pixels, in the tiles of `grid`.
    pub fn new(flags: &PixelFlags, grid: &Grid) -> Self {
        let of_tile = |number: usize| {
            let place = grid.place_of_tile(number);
            let [columns, rows] = [0, 1].map(|axis| grid.axes[axis].tile(place[axis]));
            let mut cells = CellSet::default();
            for (y, row) in rows.zip(0..) {
                let (first, flags) = flags.of_row(&columns, y);
                if !flags.contains(&true) {
                    continue;
                }
                for (column, _) in (first..).zip(flags).filter(|(_, is_flagged)| **is_flagged) {
                    let pixel = row * grid.tile_pixels as usize + column;
                    grid.cells_of_pixel(pixel).iter().for_each(|cell| cells.insert(usize::from(*cell)));
                }
            }
            cells
        };
        Self { tiles: (0..grid.tiles()).into_par_iter().map(of_tile).collect() }
    }

    /// Converts the cells to bits, a mask for each tile.
    pub fn to_masks(&self) -> Vec<CellMask> {
        self.tiles.iter().copied().map(CellSet::to_mask).collect()
    }

    /// Inverse of [`to_masks`](Self::to_masks).
    pub fn from_masks(masks: Vec<CellMask>) -> Self {
        Self { tiles: masks.iter().map(CellSet::from_mask).collect() }
    }

    /// Wanted cells of tile number `number`.
    pub fn tile(&self, number: usize) -> &CellSet {
        &self.tiles[number]
    }

    /// Calls `each` for every cell in or beside tile number `number` of `grid` that exists and is not wanted,
    /// with its number [among the cells in and around](super::around::AROUND) the tile.
    pub fn unwanted_around(&self, grid: &Grid, number: usize, mut each: impl FnMut(usize)) {
        // cells beyond the extent are not the tile's own; the next tile's are in the same place
        let extent = grid.extent(number);
        let own = CellSet::ALL.without(&self.tiles[number]);
        own.numbers().filter(|cell| holds(extent, *cell)).for_each(|cell| each(around(cell)));
        let cells = extent.map(|count| count as usize);
        let mut beside = |column: usize, row: usize| {
            if grid.cell_around(number, [column, row]).is_some_and(|(tile, cell)| !self.tiles[tile].has(cell))
            {
                each(row * ROW + column);
            }
        };
        (0..=cells[0] + 1)
            .for_each(|column| [0, cells[1] + 1].into_iter().for_each(|row| beside(column, row)));
        (1..=cells[1]).for_each(|row| [0, cells[0] + 1].into_iter().for_each(|column| beside(column, row)));
    }

    /// Adds the cells that were wanted `before`. Calls `each`, for tiles with newly wanted cells, with the
    /// tile's number and these cells.
    pub fn keep(&mut self, before: &Self, mut each: impl FnMut(usize, &CellSet)) {
        for (number, (now, before)) in self.tiles.iter_mut().zip(&before.tiles).enumerate() {
            let new = now.without(before);
            if !new.is_empty() {
                each(number, &new);
            }
            *now = now.or(before);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::frame::grid::tests::settings;
    use crate::samples::CELLS;
    use crate::settings::{PixelRect, Settings};

    #[test]
    fn the_cells_of_flagged_pixels_are_wanted() {
        let [coarse, fine] = [1, 4].map(|samples| Grid::new(&settings(70, 40, samples)));
        let mut flags = PixelFlags::none(&coarse);
        let flagged = [[0, 0], [31, 31], [32, 31], [69, 39]];
        for [x, y] in flagged {
            flags.flags[y * flags.width + x] = true;
        }
        let count = |columns: Range<i32>, y: i32| {
            let (before, flags) = flags.of_row(&columns, y);
            (before, flags.len(), flags.iter().filter(|is_flagged| **is_flagged).count())
        };
        assert_eq!([count(68..72, 39), count(-2..2, 0), count(-4..-1, 0)], [(0, 2, 1), (2, 2, 1), (3, 0, 0)]);
        assert_eq!([count(0..9, 40), count(0..9, -1)], [(0, 0, 0); 2], "beyond the rim");
        let wanted = Wanted::new(&flags, &fine);
        let mut seen = Vec::new();
        for tile in 0..fine.tiles() {
            let corner = fine.tile_corner(tile);
            for cell in (0..CELLS).filter(|cell| wanted.tile(tile).has(*cell)) {
                let place = super::super::place(cell);
                seen.push([0, 1].map(|axis| (corner[axis] as usize + place[axis] as usize) / 4));
            }
        }
        seen.sort_unstable();
        let all: Vec<[usize; 2]> = flagged.into_iter().flat_map(|pixel| [pixel; 16]).collect();
        assert_eq!(seen, all);
    }

    #[test]
    fn what_was_wanted_stays_so() {
        let grid = Grid::new(&settings(64, 32, 2));
        let with = |pixel: usize| {
            let mut flags = PixelFlags::none(&grid);
            flags.flags[pixel] = true;
            Wanted::new(&flags, &grid)
        };
        let (before, mut now) = (with(3), with(20));
        let mut new = Vec::new();
        now.keep(&before, |number, cells| new.push((number, *cells)));
        assert_eq!(new, [(1, *with(20).tile(1))]);
        assert_eq!((now.tile(0), now.tile(1)), (before.tile(0), with(20).tile(1)));
    }

    #[test]
    fn cells_around_a_tile_that_nobody_asks_for_are_those_that_a_search_finds() {
        let crop = Some(PixelRect { x: 5, y: 3, width: 60, height: 30 });
        // three: tiles of 30 cells
        for settings in
            [settings(70, 40, 2), settings(47, 23, 3), Settings { overscan: 5, crop, ..settings(70, 40, 3) }]
        {
            let grid = Grid::new(&settings);
            let mut flags = PixelFlags::none(&grid);
            (0..).zip(&mut flags.flags).for_each(|(pixel, flag)| *flag = pixel * pixel % 7 < 3);
            let wanted = Wanted::new(&flags, &grid);
            let places = |tile: usize| {
                let (corner, extent, wanted) = (grid.tile_corner(tile), grid.extent(tile), wanted.tile(tile));
                let cells = (0..CELLS).filter(move |cell| holds(extent, *cell) && !wanted.has(*cell));
                cells.map(move |cell| {
                    let place = super::super::place(cell);
                    [0, 1].map(|axis| corner[axis] + place[axis] as i32)
                })
            };
            let unwanted: HashSet<[i32; 2]> = (0..grid.tiles()).flat_map(|tile| places(tile)).collect();
            for tile in 0..grid.tiles() {
                let (corner, [columns, rows]) = (grid.tile_corner(tile), grid.extent(tile));
                let all = (0..=rows as usize + 1)
                    .flat_map(|row| (0..=columns as usize + 1).map(move |column| [column, row]));
                let is_unwanted = |[column, row]: &[usize; 2]| {
                    unwanted.contains(&[corner[0] + *column as i32 - 1, corner[1] + *row as i32 - 1])
                };
                let expected: Vec<usize> =
                    all.filter(is_unwanted).map(|[column, row]| row * ROW + column).collect();
                let mut found = Vec::new();
                wanted.unwanted_around(&grid, tile, |cell| found.push(cell));
                found.sort_unstable();
                assert_eq!(found, expected, "tile {tile} of {:?}", grid.cells);
            }
        }
    }
}
