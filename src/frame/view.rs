//! The grid of cells that a frame samples, as its camera sees it.
//!
//! Spaces: *cell space* has x to the right and y down from the top left corner of the picture, one unit a
//! cell; a pixel is N x N cells.

use glam::Vec3;

use crate::motion::CameraPose;
use crate::samples::{CELLS, TILE};
use crate::settings::Settings;

/// Cells and camera of one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where the frame is seen from.
    pub camera: CameraPose,
    /// Samples along a pixel's edge.
    pub samples: u32,
    /// Cells in a row.
    pub cells_x: u32,
    /// Cells in a column.
    pub cells_y: u32,
    /// Tiles in a row; the last may reach beyond the picture.
    pub tiles_x: u32,
    /// Tiles in a column.
    pub tiles_y: u32,
    /// Half the picture's size at distance 1, x and y.
    half: [f32; 2],
    /// Cells for a unit of x and y at distance 1.
    scale: [f32; 2],
}

/// A point in cell space, with its distance along the view axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Cells from the left.
    pub x: f32,
    /// Cells from the top.
    pub y: f32,
    /// Along the view axis, world units; infinite for the background.
    pub depth: f32,
}

impl View {
    /// The grid of `settings` behind `camera`.
    pub fn new(settings: &Settings, camera: CameraPose) -> Self {
        let (cells_x, cells_y) = (settings.width * settings.samples, settings.height * settings.samples);
        let aspect = settings.width as f32 / settings.height as f32;
        let half = [camera.tan_half_fov * aspect, camera.tan_half_fov];
        Self {
            camera,
            samples: settings.samples,
            cells_x,
            cells_y,
            tiles_x: cells_x.div_ceil(TILE as u32),
            tiles_y: cells_y.div_ceil(TILE as u32),
            half,
            scale: [0.5 * cells_x as f32 / half[0], 0.5 * cells_y as f32 / half[1]],
        }
    }

    /// Tiles of the store.
    pub fn tiles(&self) -> usize {
        self.tiles_x as usize * self.tiles_y as usize
    }

    /// From the eye through a point of cell space. Its part along the view axis is 1: lengths along the
    /// ray are distances along the axis.
    #[inline]
    pub fn direction(&self, x: f32, y: f32) -> Vec3 {
        let across = x / self.scale[0] - self.half[0];
        let down = y / self.scale[1] - self.half[1];
        self.camera.forward + across * self.camera.right - down * self.camera.up
    }

    /// Where `offset` (from the eye, world space) is seen; `None` behind the eye.
    #[inline]
    pub fn project(&self, offset: Vec3) -> Option<Projected> {
        let depth = offset.dot(self.camera.forward);
        // false for NaN as well
        (depth > f32::MIN_POSITIVE).then(|| Projected {
            x: (offset.dot(self.camera.right) / depth + self.half[0]) * self.scale[0],
            y: (-offset.dot(self.camera.up) / depth + self.half[1]) * self.scale[1],
            depth,
        })
    }

    /// Index of the cell that holds a point of cell space, in the store's order; `None` outside.
    #[inline]
    pub fn cell_at(&self, x: f32, y: f32) -> Option<u32> {
        // false for NaN as well
        let inside = x >= 0.0 && y >= 0.0 && x < self.cells_x as f32 && y < self.cells_y as f32;
        inside.then(|| self.index_of(x as u32, y as u32))
    }

    /// Index of the cell in column `x` and row `y`.
    #[inline]
    pub fn index_of(&self, x: u32, y: u32) -> u32 {
        const EDGE: u32 = TILE as u32;
        let tile = (y / EDGE) * self.tiles_x + x / EDGE;
        let (x, y) = (x % EDGE, y % EDGE);
        let block = (y / 4) * (EDGE / 4) + x / 4;
        tile * CELLS as u32 + block * 16 + (y % 4) * 4 + x % 4
    }

    /// Column and row of the first cell of tile number `tile`.
    pub fn tile_corner(&self, tile: usize) -> [u32; 2] {
        let tile = tile as u32;
        [(tile % self.tiles_x) * TILE as u32, (tile / self.tiles_x) * TILE as u32]
    }

    /// Whether the cell in column `x` and row `y` belongs to the picture.
    #[inline]
    pub fn holds(&self, [x, y]: [u32; 2]) -> bool {
        x < self.cells_x && y < self.cells_y
    }
}

/// Column and row, within its tile, of the cell that a tile stores as number `cell`.
#[inline]
pub fn cell_place(cell: usize) -> [u32; 2] {
    let (block, lane) = (cell / 16, cell % 16);
    let across = TILE / 4;
    [((block % across) * 4 + lane % 4) as u32, ((block / across) * 4 + lane / 4) as u32]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::settings::{Filter, Mode};

    /// A small picture for the tests of this room.
    pub fn settings(width: u32, height: u32, samples: u32) -> Settings {
        let (filter, mode) = (Filter::Box, Mode::Reproject);
        Settings { width, height, samples, filter, depth: 3, mode, base_every: 0, audit: false }
    }

    /// An eye at `eye` that looks along -Z with a right angle from top to bottom.
    pub fn camera(eye: Vec3) -> CameraPose {
        CameraPose { eye, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, tan_half_fov: 1.0 }
    }

    #[test]
    fn a_cells_ray_projects_back_into_the_cell() {
        let view = View::new(&settings(50, 37, 3), camera(Vec3::ZERO));
        for y in 0..view.cells_y {
            for x in 0..view.cells_x {
                let direction = view.direction(x as f32 + 0.5, y as f32 + 0.5);
                let seen = view.project(direction * 7.3).expect("before the eye");
                assert_eq!(view.cell_at(seen.x, seen.y), Some(view.index_of(x, y)));
                assert!((seen.depth - 7.3).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn every_cell_has_an_index_of_its_own() {
        let view = View::new(&settings(40, 36, 2), camera(Vec3::ZERO));
        let mut seen = vec![false; view.tiles() * CELLS];
        for y in 0..view.cells_y {
            for x in 0..view.cells_x {
                let index = view.index_of(x, y) as usize;
                assert!(!std::mem::replace(&mut seen[index], true));
                let corner = view.tile_corner(index / CELLS);
                let place = cell_place(index % CELLS);
                assert_eq!([corner[0] + place[0], corner[1] + place[1]], [x, y]);
            }
        }
    }

    #[test]
    fn up_is_the_top_and_right_is_the_right() {
        let view = View::new(&settings(64, 64, 1), camera(Vec3::ZERO));
        let seen = view.project(Vec3::new(0.5, 0.25, -1.0)).expect("before the eye");
        assert_eq!((seen.x, seen.y), (48.0, 24.0));
        assert_eq!(view.project(Vec3::Z), None);
        assert_eq!(view.cell_at(f32::NAN, 3.0), None);
        assert_eq!(view.cell_at(64.0, 3.0), None);
    }
}
