//! The grid of cells as the camera of one frame sees it.

use std::sync::Arc;

use glam::Vec3;

use super::grid::Grid;
use crate::geometry::Bounds;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::pose::CameraPose;
use crate::samples::TILE;

/// Cells and camera of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Where the frame is seen from.
    pub camera: CameraPose,
    /// What samples it.
    pub grid: Arc<Grid>,
    /// Half the picture's size at distance 1, x and y.
    half: [f32; 2],
    /// Cells for a unit of x and y at distance 1.
    scale: [f32; 2],
}

/// Eight points in cell space, with their distances along the view axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Cells from the left.
    pub x: F32x8,
    /// Cells from the top.
    pub y: F32x8,
    /// Along the view axis, world units. Only where this is positive does the point lie before the eye and
    /// `x` and `y` mean anything.
    pub depth: F32x8,
}

impl View {
    /// The grid behind `camera`.
    pub fn new(grid: &Arc<Grid>, camera: CameraPose) -> Self {
        let aspect = grid.width as f32 / grid.height as f32;
        let half = [camera.tan_half_fov * aspect, camera.tan_half_fov];
        let scale = [(grid.width, half[0]), (grid.height, half[1])]
            .map(|(pixels, half)| 0.5 * (pixels * grid.samples) as f32 / half);
        Self { camera, grid: Arc::clone(grid), half, scale }
    }

    /// From the eye through points of cell space. Their part along the view axis is 1: lengths along the
    /// rays are distances along the axis.
    #[inline(always)]
    pub fn directions(&self, x: F32x8, y: F32x8) -> Vec3x8 {
        let across = x / F32x8::splat(self.scale[0]) - F32x8::splat(self.half[0]);
        let down = y / F32x8::splat(self.scale[1]) - F32x8::splat(self.half[1]);
        let camera = &self.camera;
        Vec3x8::splat(camera.forward) + Vec3x8::splat(camera.right) * across - Vec3x8::splat(camera.up) * down
    }

    /// Around the [directions](Self::directions) through the cells of tile number `number`, and a cell beyond: rounding
    /// may say of a sample that it is seen there.
    pub(super) fn directions_of_tile(&self, number: usize) -> Bounds {
        let sides =
            self.grid.tile_corner(number).map(|at| [at as f32 - 1.0, (at + TILE as i32) as f32 + 1.0]);
        let side = |axis: usize, shift: usize| {
            let mut all = F32x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, sides[axis][lane >> shift & 1]));
            all
        };
        Bounds::of_lanes(self.directions(side(0, 0), side(1, 1)))
    }

    /// Where offsets (from the eye, world space) are seen.
    #[inline(always)]
    pub fn project(&self, offset: Vec3x8) -> Projected {
        let depth = offset.dot(Vec3x8::splat(self.camera.forward));
        let across = offset.dot(Vec3x8::splat(self.camera.right)) / depth;
        let down = -(offset.dot(Vec3x8::splat(self.camera.up)) / depth);
        Projected {
            x: (across + F32x8::splat(self.half[0])) * F32x8::splat(self.scale[0]),
            y: (down + F32x8::splat(self.half[1])) * F32x8::splat(self.scale[1]),
            depth,
        }
    }

    /// Where one offset is seen: x, y and depth. `None` behind the eye.
    pub fn project_one(&self, offset: Vec3) -> Option<Vec3> {
        let Projected { x, y, depth } = self.project(Vec3x8::splat(offset));
        // false for NaN as well
        (depth.lane(0) > f32::MIN_POSITIVE).then(|| Vec3::new(x.lane(0), y.lane(0), depth.lane(0)))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::frame::grid::tests::settings;
    use glam::{EulerRot, Quat};

    /// An eye at `eye` that looks along -Z with a right angle from top to bottom.
    pub fn camera(eye: Vec3) -> CameraPose {
        CameraPose { eye, right: Vec3::X, up: Vec3::Y, forward: Vec3::NEG_Z, tan_half_fov: 1.0 }
    }

    fn view(width: u32, height: u32, samples: u32) -> View {
        View::new(&Arc::new(Grid::new(&settings(width, height, samples))), camera(Vec3::ZERO))
    }

    #[test]
    fn a_cells_ray_projects_back_into_the_cell() {
        let view = view(50, 37, 3);
        for y in 0..view.grid.cells[1] {
            for x in 0..view.grid.cells[0] {
                let centre = [x, y].map(|at| F32x8::splat(at as f32 + 0.5));
                let direction = view.directions(centre[0], centre[1]).lane(4);
                let seen = view.project_one(direction * 7.3).expect("before the eye");
                let cells = view.grid.cells_at(F32x8::splat(seen.x), F32x8::splat(seen.y));
                assert_eq!(cells[0], view.grid.index_of([x, y]));
                assert!((seen.z - 7.3).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_tiles_directions_hold_those_of_its_cells_and_a_cell_beyond() {
        let turn = Quat::from_euler(EulerRot::YXZ, 0.7, -0.4, 0.3);
        let [right, up, forward] = [Vec3::X, Vec3::Y, Vec3::NEG_Z].map(|axis| turn * axis);
        for (width, height, samples) in [(70, 37, 1), (25, 15, 3), (8, 5, 11)] {
            let grid = Arc::new(Grid::new(&settings(width, height, samples)));
            let view = View::new(&grid, CameraPose { right, up, forward, ..camera(Vec3::ONE) });
            let (mut inside, mut outside) = (0, 0);
            for tile in 0..grid.tiles() {
                let around = view.directions_of_tile(tile);
                let ([left, top], edge) = (grid.tile_corner(tile), (grid.tile_pixels * samples) as i32);
                let [columns, rows] = grid.cells.map(|count| 0..count as i32);
                for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
                    let is_own = (left..left + edge).contains(&x) && (top..top + edge).contains(&y);
                    for (across, down) in [(-1.0, 0.5), (0.5, -1.0), (2.0, 1.5), (1.5, 2.0)] {
                        let at = [x as f32 + across, y as f32 + down].map(F32x8::splat);
                        let direction = Bounds::at(view.directions(at[0], at[1]).lane(0));
                        let is_in = around.union(direction) == around;
                        assert!(is_in || !is_own, "{samples}: {x} {y} of {tile}");
                        *if is_in { &mut inside } else { &mut outside } += 1;
                    }
                }
            }
            assert!(outside > inside, "{samples}: a tile is no more than it must be");
        }
    }

    #[test]
    fn up_is_the_top_and_right_is_the_right() {
        let view = view(64, 64, 1);
        let seen = view.project_one(Vec3::new(0.5, 0.25, -1.0)).expect("before the eye");
        assert_eq!((seen.x, seen.y), (48.0, 24.0));
        assert_eq!(view.project_one(Vec3::Z), None);
    }
}
