//! Sets of pixels that a level of refinement has to make.
//!
//! With adaptive samples a frame is made level by level (the paper's "adaptive supersampling"). The coarsest
//! level has samples in all pixels. Each finer one, twice as fine, has samples only in pixels that
//! [`contrast`](crate::frame::tiles::contrast) flags in the level before. A level is a chain of frames of its
//! own: its samples are reprojected, verified, lit and enhanced as any others, but in wanted cells only.
//! Samples that serve none stay as spare samples, and come back when their cells are wanted.

use std::ops::Range;

use rayon::prelude::*;

use super::Grid;
use super::cells::CellSet;
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
    use super::*;
    use crate::frame::grid::tests::settings;
    use crate::samples::CELLS;

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
}
