//! The cells of a picture and their layout in tiles.
//!
//! Spaces: *cell space* has x to the right and y down from the top left corner of the picture, one unit a
//! cell; a pixel is N x N cells. Cells of the overscan left of the picture and above it have negative places.
//! A tile holds as many whole pixels as fit into 32 x 32 cells, so that all samples of a pixel are in one
//! tile; where N does not divide 32, its last rows and columns stay unused.
//!
//! Tiles cover the *film*: the picture, or the part of it and of its surroundings that is rendered. Pixels of
//! the film are counted from its own corner.

pub mod around;
pub mod axis;
pub mod bits;
pub mod cells;
pub mod view;
pub mod wanted;

use std::ops::Range;

use wide::i32x8;

use self::axis::Axis;
use crate::exposure::Strata;
use crate::lanes::{F32x8, LANES, Mask};
use crate::samples::{CELLS, Column, TILE};
use crate::settings::Settings;
use crate::shade::sampling::hash_of;

/// The cells of a picture, or of the rendered part of it. One grid serves all frames of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Pixels across the picture.
    pub width: u32,
    /// Pixels down the picture.
    pub height: u32,
    /// N: samples along a pixel's edge.
    pub samples: u32,
    /// Pixels across and down the film.
    pub film: [u32; 2],
    /// First cell of the first tile, in cell space.
    pub first: [i32; 2],
    /// Cells in a row and in a column of all tiles.
    pub cells: [u32; 2],
    /// Layout of tiles, across and down.
    pub axes: [Axis; 2],
    /// Tiles in a row.
    pub tiles_x: u32,
    /// Tiles in a column.
    pub tiles_y: u32,
    /// Pixels along a tile's edge.
    pub tile_pixels: u32,
    /// Column, within its tile, of each cell of a tile.
    pub place_x: Column<f32>,
    /// Row, within its tile, of each cell of a tile.
    pub place_y: Column<f32>,
    /// Centre of each cell's pixel: pixels from the tile's left edge.
    pub center_x: Column<f32>,
    /// Centre of each cell's pixel: pixels from the tile's upper edge.
    pub center_y: Column<f32>,
    /// Number of each cell among the N x N cells of its pixel.
    pub number_in_pixel: Column<f32>,
    /// Cells of a tile's pixels: N x N numbers for each pixel, pixels in rows.
    pub cells_of_pixels: Vec<u16>,
    /// Summand of a cell's index, by column: see `index_of`.
    index_of_column: Vec<u32>,
    /// Summand of a cell's index, by row.
    index_of_row: Vec<u32>,
}

impl Grid {
    /// Creates the grid of pictures with these settings.
    pub fn new(settings: &Settings) -> Self {
        Self::reaching(settings, settings.filter_reach())
    }

    /// The grids of all levels of samples, the coarsest first, of each picture of frames with these `strata`. What finer levels are asked for
    /// depends on a pixel more around each; and a window that is shifted by a part of a pixel reaches one more.
    pub fn levels(settings: &Settings, strata: Strata) -> impl Iterator<Item = Self> {
        let all: Vec<u32> = settings.levels().collect();
        let finer = (0..all.len() as u32).rev();
        let shifted = u32::from(strata != Strata::ONE && !settings.filter.is_of_one_pixel());
        all.into_iter().zip(finer).map(move |(samples, finer)| {
            let reach = (settings.filter_reach() + shifted).max(finer);
            Self::reaching(&Settings { samples, ..settings.clone() }, reach)
        })
    }

    /// Like [`new`](Self::new), with tiles also for pixels within `reach` pixels of what is rendered.
    pub fn reaching(settings: &Settings, reach: u32) -> Self {
        let Settings { width, height, samples, overscan, .. } = *settings;
        let tile_pixels = TILE as u32 / samples;
        let film = settings.data_window();
        let axis = |size: u32, first: i32, count: u32| {
            Axis::new(size, overscan, first..first + count as i32, tile_pixels, reach)
        };
        let axes = [axis(width, film.x, film.width), axis(height, film.y, film.height)];
        let [tiles_x, tiles_y] = axes.each_ref().map(|axis| axis.count() as u32);
        let row_of_tiles = tiles_x * CELLS as u32;
        let indices = |axis: &Axis, tile_size: u32, place: fn(u32) -> u32| -> Vec<u32> {
            let cells = |tile: usize| {
                let count = axis.tile(tile).len() as u32 * samples;
                (0..count).map(move |at| tile as u32 * tile_size + place(at))
            };
            (0..axis.count()).flat_map(cells).collect()
        };
        let index_of_column = indices(&axes[0], CELLS as u32, across);
        let index_of_row = indices(&axes[1], row_of_tiles, down);
        Self {
            width,
            height,
            samples,
            film: [film.width, film.height],
            first: axes.each_ref().map(|axis| axis.all().start * samples as i32),
            cells: [&index_of_column, &index_of_row].map(|cells| cells.len() as u32),
            tiles_x,
            tiles_y,
            tile_pixels,
            place_x: std::array::from_fn(|cell| place(cell)[0] as f32),
            place_y: std::array::from_fn(|cell| place(cell)[1] as f32),
            center_x: std::array::from_fn(|cell| (place(cell)[0] / samples) as f32 + 0.5),
            center_y: std::array::from_fn(|cell| (place(cell)[1] / samples) as f32 + 0.5),
            number_in_pixel: std::array::from_fn(|cell| {
                let [x, y] = place(cell).map(|at| at % samples);
                (y * samples + x) as f32
            }),
            cells_of_pixels: cells_of_pixels(samples, tile_pixels),
            index_of_column,
            index_of_row,
            axes,
        }
    }

    /// Number of tiles of the store.
    pub fn tiles(&self) -> usize {
        self.tiles_x as usize * self.tiles_y as usize
    }

    /// Cells of pixel number `pixel` of a tile.
    #[inline]
    pub fn cells_of_pixel(&self, pixel: usize) -> &[u16] {
        &self.cells_of_pixels[pixel * self.samples_of_pixel()..][..self.samples_of_pixel()]
    }

    /// Number of samples in a pixel: N x N.
    pub fn samples_of_pixel(&self) -> usize {
        (self.samples * self.samples) as usize
    }

    /// Mask of those of eight points of cell space that lie in a tile. False for NaN.
    #[inline(always)]
    pub fn inside(&self, x: F32x8, y: F32x8) -> Mask {
        let within = |at: F32x8, axis: usize| {
            let (first, end) = (self.first[axis], self.first[axis] + self.cells[axis] as i32);
            F32x8::splat(first as f32).le(at) & at.lt(F32x8::splat(end as f32))
        };
        within(x, 0) & within(y, 1)
    }

    /// Columns or rows (axis 0 or 1) of eight points of cell space, in units of which a cell has `steps`,
    /// counted from the first tile's first cell. Points that are not [inside](Self::inside) are clamped to
    /// the rim.
    #[inline(always)]
    pub fn steps_from_first(&self, at: F32x8, axis: usize, steps: i32) -> [i32; LANES] {
        let from_first = (at - F32x8::splat(self.first[axis] as f32)) * F32x8::splat(steps as f32);
        // before the last cell ends, however it is rounded
        let last = i32x8::splat(self.cells[axis] as i32 * steps - 1);
        from_first.to_whole().max(i32x8::ZERO).min(last).to_array()
    }

    /// Indices of the cells that hold eight points of cell space, in the store's order. Points that are not
    /// [inside](Self::inside) get a cell at the rim.
    #[inline(always)]
    pub fn cells_at(&self, x: F32x8, y: F32x8) -> [u32; LANES] {
        let (columns, rows) = (self.steps_from_first(x, 0, 1), self.steps_from_first(y, 1, 1));
        std::array::from_fn(|lane| self.index_of([columns[lane] as u32, rows[lane] as u32]))
    }

    /// Number of cells along an edge of a tile.
    #[inline(always)]
    pub fn tile_edge(&self) -> u32 {
        self.tile_pixels * self.samples
    }

    /// Number of tiles in a row and in a column.
    #[inline(always)]
    pub fn tile_counts(&self) -> [u32; 2] {
        [self.tiles_x, self.tiles_y]
    }

    /// Number of the tile that holds the cell in this column and row, counted from the first tile's first
    /// cell.
    pub fn tile_at(&self, at: [u32; 2]) -> usize {
        self.index_of(at) as usize / CELLS
    }

    /// Column and row of tile number `tile`, in tiles.
    #[inline]
    pub fn place_of_tile(&self, tile: usize) -> [usize; 2] {
        [tile % self.tiles_x as usize, tile / self.tiles_x as usize]
    }

    /// Number for the pixel in this column and row of the picture: pixels of the picture count in rows; those
    /// of the overscan get a hash, which differs from these but for chance. The number does not depend on
    /// which part is rendered.
    pub fn number_of_pixel(&self, [x, y]: [i32; 2]) -> u32 {
        if (0..self.width as i32).contains(&x) && (0..self.height as i32).contains(&y) {
            return y as u32 * self.width + x as u32;
        }
        hash_of(&[x as f32, y as f32])
    }

    /// Index, in the store's order, of the cell in this column and row, counted from the first tile's first
    /// cell.
    #[inline]
    pub fn index_of(&self, [x, y]: [u32; 2]) -> u32 {
        self.index_of_column[x as usize] + self.index_of_row[y as usize]
    }

    /// Finds the cell at `place` (column, row) in or beside tile number `tile`, whose own first cell is in
    /// column and row 1. Returns the number of the tile that has it and its number in that tile, or `None`
    /// where the grid has no cell.
    pub fn cell_around(&self, tile: usize, place: [usize; 2]) -> Option<(usize, usize)> {
        let corner = self.tile_corner(tile);
        // counted from the first tile's first cell; no cell lies before that one
        let at = |axis: usize| ((corner[axis] - self.first[axis]) as u32 + place[axis] as u32).checked_sub(1);
        let [x, y] = [at(0)?, at(1)?];
        let is_in = x < self.cells[0] && y < self.cells[1];
        let index = is_in.then(|| self.index_of([x, y]) as usize)?;
        Some((index / CELLS, index % CELLS))
    }

    /// First cell of tile number `tile`, in cell space.
    #[inline]
    pub fn tile_corner(&self, tile: usize) -> [i32; 2] {
        let place = self.place_of_tile(tile);
        [0, 1].map(|axis| self.axes[axis].tile(place[axis]).start * self.samples as i32)
    }

    /// Column and row in the film of the first pixel of tile number `tile`; negative where the tile begins
    /// before the film.
    #[inline]
    pub fn corner_in_film(&self, tile: usize) -> [i32; 2] {
        let place = self.place_of_tile(tile);
        [0, 1].map(|axis| self.axes[axis].in_film(self.axes[axis].tile(place[axis]).start))
    }

    /// Columns and rows of the film that tile number `tile` shows in, counted from the film's corner.
    #[inline]
    pub fn pixels(&self, tile: usize) -> [Range<usize>; 2] {
        let place = self.place_of_tile(tile);
        [0, 1].map(|axis| self.axes[axis].film_of(place[axis]))
    }

    /// Number of the tile's first pixel that is in the film; a tile's pixels are numbered in rows.
    #[inline]
    pub fn first_in_film(&self, tile: usize) -> usize {
        let (corner, pixels) = (self.corner_in_film(tile), self.pixels(tile));
        let [x, y] = [0, 1].map(|axis| (pixels[axis].start as i32 - corner[axis]) as usize);
        y * self.tile_pixels as usize + x
    }

    /// Number of columns and rows of tile number `tile`, from its corner, that have cells.
    #[inline]
    pub fn extent(&self, tile: usize) -> [u32; 2] {
        let place = self.place_of_tile(tile);
        [0, 1].map(|axis| self.axes[axis].tile(place[axis]).len() as u32 * self.samples)
    }

    /// Number of cells of tile number `tile`.
    pub fn cells(&self, tile: usize) -> u64 {
        let [across, down] = self.extent(tile);
        u64::from(across * down)
    }

    /// Number of cells of all tiles.
    pub fn all_cells(&self) -> u64 {
        u64::from(self.cells[0]) * u64::from(self.cells[1])
    }
}

/// Returns true if a cell of a tile lies within its `extent`.
#[inline]
pub fn holds(extent: [u32; 2], cell: usize) -> bool {
    let [x, y] = place(cell);
    x < extent[0] && y < extent[1]
}

/// Column and row, within its tile, of the cell that a tile stores as number `cell`.
#[inline]
pub fn place(cell: usize) -> [u32; 2] {
    const BLOCKS: usize = TILE / 4;
    let (block, lane) = (cell / 16, cell % 16);
    [((block % BLOCKS) * 4 + lane % 4) as u32, ((block / BLOCKS) * 4 + lane / 4) as u32]
}

/// Number as which a tile stores the cell in this column and row.
#[inline]
pub fn cell_number([x, y]: [u32; 2]) -> usize {
    (across(x) + down(y)) as usize
}

/// Summand of a cell's number from its column `x` within the tile: tiles are stored in blocks of 4 x 4.
fn across(x: u32) -> u32 {
    (x / 4) * 16 + x % 4
}

/// Summand of a cell's number from its row `y` within the tile.
fn down(y: u32) -> u32 {
    (y / 4) * (TILE as u32 / 4) * 16 + (y % 4) * 4
}

fn cells_of_pixels(samples: u32, tile_pixels: u32) -> Vec<u16> {
    let pixels = (0..tile_pixels).flat_map(|y| (0..tile_pixels).map(move |x| [x * samples, y * samples]));
    let cells = pixels.flat_map(|[x, y]| {
        (0..samples).flat_map(move |j| (0..samples).map(move |i| (across(x + i) + down(y + j)) as u16))
    });
    cells.collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::layers::Layers;
    use crate::settings::{Filter, Mode};

    /// A small picture for the tests of this room.
    pub fn settings(width: u32, height: u32, samples: u32) -> Settings {
        let (filter, mode) = (Filter::Box, Mode::Reproject);
        Settings {
            width,
            height,
            samples,
            filter,
            depth: 3,
            mode,
            base_every: 0,
            layers: Layers::ALL,
            background: crate::settings::Backdrop::default(),
            ..Settings::default()
        }
    }

    #[test]
    fn every_cell_has_an_index_of_its_own() {
        for samples in [1, 2, 3, 5, 16] {
            let grid = Grid::new(&settings(40, 36, samples));
            let mut seen = vec![false; grid.tiles() * CELLS];
            for y in 0..grid.cells[1] {
                for x in 0..grid.cells[0] {
                    let index = grid.index_of([x, y]) as usize;
                    assert!(!std::mem::replace(&mut seen[index], true));
                    let corner = grid.tile_corner(index / CELLS);
                    let place = place(index % CELLS);
                    assert_eq!([0, 1].map(|axis| corner[axis] as u32 + place[axis]), [x, y]);
                    assert!(holds(grid.extent(index / CELLS), index % CELLS));
                }
            }
            let held = (0..seen.len()).filter(|i| holds(grid.extent(i / CELLS), i % CELLS)).count();
            assert_eq!(held as u64, grid.all_cells(), "and no other cell is held");
        }
    }

    #[test]
    fn a_pixels_samples_are_its_cells() {
        let grid = Grid::new(&settings(40, 36, 3));
        let (tile, pixel) = (grid.tiles_x as usize + 1, (7 * grid.tile_pixels + 4) as usize);
        let corner = grid.tile_corner(tile);
        for cell in &grid.cells_of_pixels[pixel * 9..][..9] {
            let place = place(usize::from(*cell));
            let at = [0, 1].map(|axis| (corner[axis] as u32 + place[axis]) / 3);
            assert_eq!(at, [grid.tile_pixels + 4, grid.tile_pixels + 7]);
        }
    }

    #[test]
    fn there_is_nothing_beyond_the_rim() {
        let grid = Grid::new(&settings(64, 64, 1));
        let inside = |x: f32, y: f32| grid.inside(F32x8::splat(x), F32x8::splat(y)).bits() == u8::MAX;
        assert!(!inside(f32::NAN, 3.0));
        assert!(!inside(64.0, 3.0));
        assert!(!inside(3.0, -0.001));
        assert!(inside(63.9, 63.9) && inside(0.0, -0.0));
        let cell_at = |x: f32, y: f32| grid.cells_at(F32x8::splat(x), F32x8::splat(y))[3];
        assert_eq!(cell_at(63.9, -0.0), grid.index_of([63, 0]));
        assert_eq!(cell_at(f32::NAN, 1e9), grid.index_of([0, 63]), "at the rim");
    }
}
