//! The grid of cells as the camera of one frame sees it.

use std::sync::Arc;

use glam::Vec3;

use super::{Grid, place};
use crate::exposure::{Strata, TICKS, Tick};
use crate::geometry::{Bounds, SweptBox};
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::pose::CameraPose;
use crate::samples::{Apart, TILE};
use crate::scene::camera::Projection;

/// 2^32 over the golden ratio.
const GOLDEN: u32 = 2_654_435_769;

/// Camera and grid of one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Camera of the frame; of an exposure, that in its middle.
    pub camera: CameraPose,
    /// Cells of the picture.
    pub grid: Arc<Grid>,
    /// The picture before `camera`.
    window: Window,
    /// Cameras at the ticks of an exposure, with the pictures before them; empty where all are `camera`.
    ticks: Vec<(CameraPose, Window)>,
    /// Number that the ticks of cells follow from: each exposure has another.
    pattern: u32,
    /// Division of the samples among exposures, each of which has such a grid.
    strata: Strata,
}

/// Place and scale of a picture before a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Window {
    /// Offset from the picture's left edge and from its top to the view axis: lengths at distance 1, or world
    /// units with an orthographic camera.
    axis: [f32; 2],
    /// Cells per unit of `axis`, across and down.
    scale: [f32; 2],
}

impl Window {
    fn new(grid: &Grid, camera: &CameraPose) -> Self {
        let [half, middle] = camera.frustum(grid.width as f32 / grid.height as f32);
        let scale = [(grid.width, half[0]), (grid.height, half[1])]
            .map(|(pixels, half)| 0.5 * (pixels * grid.samples) as f32 / half);
        Self { axis: [half[0] - middle[0], half[1] + middle[1]], scale }
    }
}

/// The camera as eight cells, or samples, see with it: each at its own tick.
#[derive(Debug, Clone, Copy)]
pub struct Cameras8 {
    /// Positions of the eye, world space.
    pub eye: Vec3x8,
    right: Vec3x8,
    up: Vec3x8,
    /// Axes into the picture.
    pub forward: Vec3x8,
    axis: [F32x8; 2],
    scale: [F32x8; 2],
    projection: Projection,
}

/// Eight points in cell space, with their depths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Column, in cells from the picture's left edge.
    pub x: F32x8,
    /// Row, in cells from the picture's top.
    pub y: F32x8,
    /// Distance along the view axis, world units. `x` and `y` mean something only where this is positive:
    /// there the point lies before the camera.
    pub depth: F32x8,
}

/// Width of a cell at a right angle to its line of sight.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// World units for each unit of distance.
    pub by_distance: f32,
    /// World units at any distance.
    pub fixed: f32,
}

impl View {
    /// Creates the view of `camera` through `grid`, which has all samples.
    pub fn new(grid: &Arc<Grid>, camera: CameraPose) -> Self {
        Self {
            camera,
            grid: Arc::clone(grid),
            window: Window::new(grid, &camera),
            ticks: Vec::new(),
            pattern: 0,
            strata: Strata::ONE,
        }
    }

    /// Creates the view of a camera, with what it is at its ticks, through the `grid` of one of several exposures, number `exposure`.
    pub fn of_exposure(
        grid: &Arc<Grid>,
        (camera, at_ticks): (CameraPose, &[CameraPose]),
        (strata, exposure): (Strata, usize),
    ) -> Self {
        let tick = |camera: &CameraPose| (*camera, Window::new(grid, camera));
        Self {
            ticks: at_ticks.iter().map(tick).collect(),
            pattern: (exposure as u32).wrapping_mul(GOLDEN),
            strata,
            ..Self::new(grid, camera)
        }
    }

    /// The cameras at all ticks: one, where all are the same.
    pub fn cameras(&self) -> impl Iterator<Item = &CameraPose> {
        let one = self.ticks.is_empty().then_some(&self.camera);
        self.ticks.iter().map(|(camera, _)| camera).chain(one)
    }

    /// Position of the eye at a tick.
    #[inline(always)]
    pub fn eye(&self, tick: Tick) -> Vec3 {
        self.camera_at(tick).eye
    }

    /// The camera at a tick.
    #[inline(always)]
    pub fn camera_at(&self, tick: Tick) -> &CameraPose {
        self.ticks.get(usize::from(tick)).map_or(&self.camera, |(camera, _)| camera)
    }

    /// The camera at the ticks that `ticks` gives for eight lanes: it is only called where that says which.
    #[inline(always)]
    pub fn cameras_at(&self, ticks: impl FnOnce() -> [Tick; LANES]) -> Cameras8 {
        if self.ticks.is_empty() { self.middle() } else { self.gathered(ticks()) }
    }

    /// The camera in the middle of the exposure, for eight lanes.
    #[inline(always)]
    pub fn middle(&self) -> Cameras8 {
        let Self { camera, window: Window { axis, scale }, .. } = self;
        let CameraPose { eye, right, up, forward, projection, .. } = *camera;
        let [eye, right, up, forward] = [eye, right, up, forward].map(Vec3x8::splat);
        let [axis, scale] = [axis, scale].map(|of| of.map(F32x8::splat));
        Cameras8 { eye, right, up, forward, axis, scale, projection }
    }

    #[inline(always)]
    fn gathered(&self, ticks: [Tick; LANES]) -> Cameras8 {
        let all: [&(CameraPose, Window); LANES] = ticks.map(|tick| &self.ticks[usize::from(tick)]);
        let number = |of: &dyn Fn(&(CameraPose, Window)) -> f32| F32x8::new(all.map(of));
        let vector = |of: fn(&CameraPose) -> Vec3| Vec3x8 {
            x: F32x8::new(all.map(|(camera, _)| of(camera).x)),
            y: F32x8::new(all.map(|(camera, _)| of(camera).y)),
            z: F32x8::new(all.map(|(camera, _)| of(camera).z)),
        };
        Cameras8 {
            eye: vector(|camera| camera.eye),
            right: vector(|camera| camera.right),
            up: vector(|camera| camera.up),
            forward: vector(|camera| camera.forward),
            axis: [0, 1].map(|at| number(&|(_, window)| window.axis[at])),
            scale: [0, 1].map(|at| number(&|(_, window)| window.scale[at])),
            projection: self.camera.projection,
        }
    }

    /// Ticks of the cells in these columns and rows of the picture.
    #[inline(always)]
    pub fn ticks_of_cells(&self, [x, y]: [[i32; LANES]; 2]) -> [Tick; LANES] {
        std::array::from_fn(|lane| self.tick_of_cell([x[lane], y[lane]]))
    }

    /// Tick of a cell of tile number `tile`.
    #[inline(always)]
    pub fn tick_in_tile(&self, tile: usize, cell: usize) -> Tick {
        self.tick_beside(tile, place(cell).map(|at| at as i32))
    }

    /// Tick of the cell in this column and row of tile number `tile`, or beside it.
    #[inline(always)]
    pub fn tick_beside(&self, tile: usize, place: [i32; 2]) -> Tick {
        let corner = self.grid.tile_corner(tile);
        self.tick_of_cell([0, 1].map(|axis| corner[axis] + place[axis]))
    }

    /// Tick of the cell in this column and row of the picture: whole shares of the plastic number apart, so that cells
    /// near each other have ticks that are spread as evenly as can be (M. Roberts, "The Unreasonable Effectiveness of
    /// Quasirandom Sequences", 2018).
    #[inline(always)]
    pub fn tick_of_cell(&self, [x, y]: [i32; 2]) -> Tick {
        /// 2^32 over the plastic number, and over its square.
        const SHARES: [u32; 2] = [3_242_174_889, 2_447_445_414];
        let [x, y] = [(x, SHARES[0]), (y, SHARES[1])].map(|(at, share)| (at as u32).wrapping_mul(share));
        let all = self.pattern.wrapping_add(x).wrapping_add(y);
        (all >> (u32::BITS - TICKS.ilog2())) as Tick
    }

    /// Growth of a cell with the distance from the eye.
    pub fn spread(&self) -> Spread {
        let cell = 1.0 / self.window.scale[1];
        match self.camera.projection {
            Projection::Perspective => Spread { by_distance: cell, fixed: 0.0 },
            Projection::Orthographic => Spread { by_distance: 0.0, fixed: cell },
        }
    }

    /// Growth with the distance from the eye of what a sample stands for: a cell as wide as if all exposures had one grid.
    pub fn spread_of_sample(&self) -> Spread {
        let Spread { by_distance, fixed } = self.spread();
        let across = self.strata.across as f32;
        Spread { by_distance: by_distance / across, fixed: fixed / across }
    }

    /// Bound of how far apart the cameras of an exposure see a point; and the largest distance of one from the eye, for each unit of depth.
    pub fn apart(&self) -> (Apart, f32) {
        // lines of sight change evenly over the picture, so most at a corner; and they are 1 long along the view axis
        let [right, bottom] = self.grid.cells.map(|cells| cells as f32);
        let [left, top] = self.grid.first.map(|first| first as f32);
        let side =
            |ends: [f32; 2], shift: usize| F32x8::new(std::array::from_fn(|lane| ends[lane >> shift & 1]));
        let corners = [side([left - 1.0, left + right + 1.0], 0), side([top - 1.0, top + bottom + 1.0], 1)];
        let directions = |cameras: Cameras8| cameras.rays(corners[0], corners[1])[1];
        let lanes = |vectors: Vec3x8| (0..LANES).map(move |lane| vectors.lane(lane));
        let middle = directions(self.middle());
        let at_ticks =
            || (0..self.ticks.len() as Tick).map(|tick| directions(self.cameras_at(|| [tick; LANES])));
        let slant =
            at_ticks().chain([middle]).flat_map(lanes).fold(1.0, |most, way| f32::max(most, way.length()));
        let eyes = self.cameras().fold(Bounds::EMPTY, |all, camera| all.with(camera.eye));
        // from the middle: ways of eyes, and changes of directions
        let apart = || {
            let ways = self.ticks.iter().map(|(camera, _)| camera.eye - self.camera.eye);
            ways.zip(at_ticks().map(|directions| directions - middle))
        };
        // they cross where the changes make up for the ways, as well as they do: least squares
        let (along, square) = apart().fold((0.0, 0.0), |(along, square), (way, changes)| {
            let all_along: f32 = lanes(changes).map(|change| change.dot(way)).sum();
            (along + all_along, square + LANES as f32 * way.length_squared())
        });
        let focus = if square > f32::MIN_POSITIVE { -along / square } else { 0.0 };
        let most = apart().flat_map(|(way, changes)| lanes(changes).map(move |change| change + way * focus));
        // any two of them
        let turn = 2.0 * most.fold(0.0, |most, turn| f32::max(most, turn.length()));
        (Apart { turn, way: (eyes.high - eyes.low).length(), focus }, slant)
    }

    /// Depths as keys that order samples.
    #[inline(always)]
    pub fn ranked_depth(&self, depth: F32x8) -> F32x8 {
        match self.camera.projection {
            Projection::Perspective => depth,
            Projection::Orthographic => {
                // a float's bits grow by 2^23 where it doubles: here for each height of the picture
                let heights = depth / F32x8::splat(2.0 * self.camera.half_height);
                let mut ranked = F32x8::ZERO;
                (0..LANES).for_each(|lane| {
                    let bits = (heights.lane(lane) * 8_388_608.0) as u32;
                    ranked.set_lane(lane, f32::from_bits(bits.min(f32::MAX.to_bits())));
                });
                ranked
            }
        }
    }

    /// Bounds of all lines of sight through the cells of tile number `number` and one cell around it: by
    /// rounding, a sample may be found to be seen there.
    pub fn sights_of_tile(&self, number: usize) -> SweptBox {
        let sides =
            self.grid.tile_corner(number).map(|at| [at as f32 - 1.0, (at + TILE as i32) as f32 + 1.0]);
        let side = |axis: usize, shift: usize| {
            let mut all = F32x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, sides[axis][lane >> shift & 1]));
            all
        };
        let at_tick =
            |tick: Tick| self.cameras_at(|| [tick; LANES]).rays(side(0, 0), side(1, 1)).map(Bounds::of_lanes);
        let [origins, directions] =
            (1..self.ticks.len() as Tick).map(at_tick).fold(at_tick(0), |[origins, directions], more| {
                [origins.union(more[0]), directions.union(more[1])]
            });
        SweptBox::fans(&origins, &directions)
    }

    /// Projects one offset from the eye at a tick: x, y and depth. `None` behind the eye.
    pub fn project_one(&self, offset: Vec3, tick: Tick) -> Option<Vec3> {
        let Projected { x, y, depth } = self.cameras_at(|| [tick; LANES]).project(Vec3x8::splat(offset));
        // false for NaN as well
        (depth.lane(0) > f32::MIN_POSITIVE).then(|| Vec3::new(x.lane(0), y.lane(0), depth.lane(0)))
    }
}

impl Cameras8 {
    /// Lines of sight through points of cell space: origins and directions. Directions have the length 1
    /// along the view axis, so that a ray's parameter is a distance along that axis.
    #[inline(always)]
    pub fn rays(&self, x: F32x8, y: F32x8) -> [Vec3x8; 2] {
        let Self { eye, right, up, forward, axis, scale, projection } = *self;
        let (across, down) = (x / scale[0] - axis[0], y / scale[1] - axis[1]);
        let (right, down) = (right * across, up * down);
        match projection {
            Projection::Perspective => [eye, forward + right - down],
            Projection::Orthographic => [eye + right - down, forward],
        }
    }

    /// Vectors from the origins of lines of sight to the points at `offsets` from the eye. In an orthographic
    /// view the background is not a point: all of it is seen along the view axis.
    #[inline(always)]
    pub fn sights(&self, offsets: Vec3x8) -> Vec3x8 {
        match self.projection {
            Projection::Perspective => offsets,
            Projection::Orthographic => self.forward * offsets.dot(self.forward),
        }
    }

    /// Origins of the lines of sight to the points at `offsets` from the eye.
    #[inline(always)]
    pub fn origins(&self, offsets: Vec3x8) -> Vec3x8 {
        match self.projection {
            Projection::Perspective => self.eye,
            Projection::Orthographic => self.eye + (offsets - self.sights(offsets)),
        }
    }

    /// Projects offsets from the eye (world space) into cell space.
    #[inline(always)]
    pub fn project(&self, offset: Vec3x8) -> Projected {
        let Self { right, up, forward, axis, scale, projection, .. } = self;
        let depth = offset.dot(*forward);
        let (mut across, mut up) = (offset.dot(*right), offset.dot(*up));
        if *projection == Projection::Perspective {
            (across, up) = (across / depth, up / depth);
        }
        Projected { x: (across + axis[0]) * scale[0], y: (-up + axis[1]) * scale[1], depth }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::frame::grid::tests::settings;
    use glam::{EulerRot, Quat};

    /// An eye at `eye` that looks along -Z with a right angle from top to bottom.
    pub fn camera(eye: Vec3) -> CameraPose {
        CameraPose {
            eye,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            projection: Projection::Perspective,
            half_height: 1.0,
            shift: [0.0; 2],
            clip: crate::pose::Clip::NONE,
        }
    }

    /// Views of both projections, straight and shifted, from an eye in the origin.
    fn views(width: u32, height: u32, samples: u32) -> Vec<View> {
        let grid = Arc::new(Grid::new(&settings(width, height, samples)));
        let mut views = Vec::new();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            for shift in [[0.0; 2], [0.25, -0.75]] {
                views.push(View::new(&grid, CameraPose { projection, shift, ..camera(Vec3::ZERO) }));
            }
        }
        views
    }

    #[test]
    fn a_cells_ray_projects_back_into_the_cell() {
        for view in views(50, 37, 3) {
            for y in 0..view.grid.cells[1] {
                for x in 0..view.grid.cells[0] {
                    let centre = [x, y].map(|at| F32x8::splat(at as f32 + 0.5));
                    let [origin, direction] = view.middle().rays(centre[0], centre[1]).map(|all| all.lane(4));
                    let offset = origin + direction * 7.3;
                    let seen = view.project_one(offset, 0).expect("before the camera");
                    let cells = view.grid.cells_at(F32x8::splat(seen.x), F32x8::splat(seen.y));
                    assert_eq!(cells[0], view.grid.index_of([x, y]));
                    assert!((seen.z - 7.3).abs() < 1e-5);
                    let [from, sight] = [
                        view.middle().origins(Vec3x8::splat(offset)),
                        view.middle().sights(Vec3x8::splat(offset)),
                    ];
                    assert!(
                        from.lane(1).abs_diff_eq(origin, 1e-5)
                            && sight.lane(1).abs_diff_eq(direction * 7.3, 1e-5)
                    );
                }
            }
        }
    }

    #[test]
    fn a_shift_moves_the_picture_by_a_share_of_its_longer_side() {
        let at = |view: &View| {
            view.project_one(Vec3::new(0.1, 0.2, -1.0), 0).expect("before the camera").truncate()
        };
        for pair in views(50, 37, 3).chunks(2) {
            let moved = at(&pair[1]) - at(&pair[0]);
            assert!(moved.abs_diff_eq(glam::Vec2::new(-0.25, -0.75) * 150.0, 1e-3), "{moved}");
        }
    }

    #[test]
    fn a_tiles_sights_hold_those_of_its_cells_and_a_cell_beyond() {
        let turn = Quat::from_euler(EulerRot::YXZ, 0.7, -0.4, 0.3);
        let [right, up, forward] = [Vec3::X, Vec3::Y, Vec3::NEG_Z].map(|axis| turn * axis);
        let all = [(70, 37, 1), (25, 15, 3), (8, 5, 11)];
        for view in all.iter().flat_map(|(width, height, samples)| views(*width, *height, *samples)) {
            let grid = Arc::clone(&view.grid);
            let view = View::new(&grid, CameraPose { right, up, forward, eye: Vec3::ONE, ..view.camera });
            let (mut inside, mut outside) = (0, 0);
            for tile in 0..grid.tiles() {
                let around = view.sights_of_tile(tile);
                let ([left, top], edge) = (grid.tile_corner(tile), (grid.tile_pixels * grid.samples) as i32);
                let [columns, rows] = grid.cells.map(|count| 0..count as i32);
                for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
                    let is_own = (left..left + edge).contains(&x) && (top..top + edge).contains(&y);
                    for (across, down) in [(-1.0, 0.5), (0.5, -1.0), (2.0, 1.5), (1.5, 2.0)] {
                        let at = [x as f32 + across, y as f32 + down].map(F32x8::splat);
                        let [origin, direction] = view.middle().rays(at[0], at[1]).map(|all| all.lane(0));
                        let is_in = around.meets(&Bounds::at(origin + 5.0 * direction));
                        assert!(is_in || !is_own, "{}: {x} {y} of {tile}", grid.samples);
                        *if is_in { &mut inside } else { &mut outside } += 1;
                    }
                }
            }
            assert!(outside > inside, "{}: a tile is no more than it must be", grid.samples);
        }
    }

    #[test]
    fn depths_of_an_orthographic_view_rise_by_equal_ratios() {
        let view = views(64, 64, 1).pop().expect("there are some");
        let ranked = |depth: f32| view.ranked_depth(F32x8::splat(depth)).lane(3);
        // the picture is 2 high
        assert_eq!(ranked(2.0 * 21.0) / ranked(2.0 * 20.0), 2.0);
        assert!(ranked(1e-3) < ranked(1.0) && ranked(1e30).is_finite() && ranked(0.0) >= 0.0);
    }

    #[test]
    fn up_is_the_top_and_right_is_the_right() {
        for view in views(64, 64, 1).into_iter().step_by(2) {
            let seen = view.project_one(Vec3::new(0.5, 0.25, -1.0), 0).expect("before the camera");
            assert_eq!((seen.x, seen.y), (48.0, 24.0));
            assert_eq!(view.project_one(Vec3::Z, 0), None);
        }
    }
}
