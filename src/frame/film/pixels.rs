//! Values of pixels that are not filtered. Data (distance, position, normal, id, age) is never mixed: a pixel
//! shows that of its sample nearest to its centre. Status and rays are counts over the pixel's own samples.

use glam::{Vec2, Vec3};

use crate::frame::grid::Grid;
use crate::frame::planes::channels::data;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::motion_vectors::MotionVectors;
use crate::frame::surface::placed::PlacedTile;
use crate::frame::surface::ray_tally::CellRays;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::samples::{CELLS, Column, EMPTY, Status, TILE, Tile};
use crate::scene::on_mesh::OnMesh;
use crate::scene::{RenderSpace, Scene};
use crate::shade::surface::{Corners, each_curved};

/// `Z` of the background: finite, and far behind everything.
pub const BACKGROUND_Z: f32 = 1e10;

/// Upper limit of ages: the greatest number that a half float holds.
pub const OLDEST: u32 = 65_504;

/// Steps per squared pixel in which squared distances from a pixel's centre are compared.
const NEARNESS: f32 = 1024.0;

/// Number of blocks of 4 x 4 cells in a row of a tile.
const BLOCKS: usize = TILE / 4;

/// `N` planes of a tile's pixels, in rows, each from the start of its column. Keeps its memory.
#[derive(Debug)]
pub struct Planes<const N: usize> {
    /// Values, plane by plane.
    pub columns: Vec<Column<f32>>,
    /// True for each plane that holds anything. The others are zero throughout: their columns mean nothing.
    pub is_some: [bool; N],
}

impl<const N: usize> Default for Planes<N> {
    fn default() -> Self {
        Self { columns: vec![[0.0; CELLS]; N], is_some: [false; N] }
    }
}

impl<const N: usize> Planes<N> {
    /// Empties all planes.
    pub fn begin(&mut self) {
        self.is_some = [false; N];
    }

    /// Opens plane `number`, to be filled in part: all zeros if it held nothing.
    pub fn open_zeroed(&mut self, number: usize) -> &mut Column<f32> {
        if !self.is_some[number] {
            self.columns[number].fill(0.0);
        }
        self.open(number)
    }

    /// Opens plane `number`, to be filled.
    pub fn open(&mut self, number: usize) -> &mut Column<f32> {
        self.is_some[number] = true;
        &mut self.columns[number]
    }
}

/// Joins the values of the cells of each pixel of a tile by `joined`.
///
/// For one and for four samples a pixel the blocks of 4 x 4 cells hold whole pixels: no table is needed
/// there, and whole blocks are joined at once.
#[inline(always)]
pub fn reduce(grid: &Grid, column: &Column<f32>, joined: impl Fn(f32, f32) -> f32, pixels: &mut Column<f32>) {
    const HALF: usize = TILE / 2;
    match grid.samples {
        1 => in_rows(column, pixels),
        2 => {
            for (block, cells) in column.chunks_exact(16).enumerate() {
                let corner = block / BLOCKS * 2 * HALF + block % BLOCKS * 2;
                let beside: [f32; 8] =
                    std::array::from_fn(|pair| joined(cells[2 * pair], cells[2 * pair + 1]));
                let below = |pair: usize| joined(beside[pair], beside[pair + 2]);
                pixels[corner..][..2].copy_from_slice(&[below(0), below(1)]);
                pixels[corner + HALF..][..2].copy_from_slice(&[below(4), below(5)]);
            }
        }
        _ => {
            let cells_of_pixels = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
            for (pixel, cells) in pixels.iter_mut().zip(cells_of_pixels) {
                // the remainder is the number itself: it spares a check
                let values = cells.iter().map(|cell| column[usize::from(*cell) % CELLS]);
                *pixel = values.reduce(&joined).unwrap_or(0.0);
            }
        }
    }
}

/// Copies the values of a tile's cells from blocks into rows. With one sample a pixel these are the values of
/// the pixels.
#[inline(always)]
fn in_rows<T: Copy>(column: &Column<T>, pixels: &mut Column<T>) {
    for (block, cells) in column.chunks_exact(16).enumerate() {
        let corner = block / BLOCKS * 4 * TILE + block % BLOCKS * 4;
        for (row, cells) in cells.chunks_exact(4).enumerate() {
            pixels[corner + row * TILE..][..4].copy_from_slice(cells);
        }
    }
}

/// Chooses for each pixel of a tile the cell whose sample is nearest to its centre; among equally near ones
/// the first. `x` and `y` are in cells, from the tile's corner.
pub fn choose_nearest(grid: &Grid, [x, y]: [&Column<f32>; 2], nearest: &mut Vec<u16>) {
    nearest.clear();
    let cells = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
    // a rank is the distance in steps, times the number of samples, plus the sample's number in its pixel:
    // the least one names the sample
    let (scale, samples) = ((grid.samples as f32).recip(), grid.samples_of_pixel() as f32);
    let aside = |at: f32, centre: f32| at * scale - centre;
    let centres = grid.center_x.iter().zip(&grid.center_y).zip(&grid.number_in_pixel);
    let mut ranks = [0.0; CELLS];
    for ((rank, (x, y)), ((center_x, center_y), number)) in ranks.iter_mut().zip(x.iter().zip(y)).zip(centres)
    {
        let [x, y] = [aside(*x, *center_x), aside(*y, *center_y)];
        // in steps: among samples that are equally near but for rounding, the first is shown
        *rank = ((x * x + y * y) * NEARNESS + 0.5).floor() * samples + number;
    }
    let mut least = [0.0; CELLS];
    reduce(grid, &ranks, f32::min, &mut least);
    least.iter_mut().for_each(|rank| *rank -= (*rank / samples).floor() * samples);
    nearest.extend(cells.zip(&least).map(|(cells, number)| cells[*number as usize]));
}

/// Takes the data of each pixel's nearest sample.
pub fn take_data(
    frame: &FrameView,
    tile: &Tile,
    placed: &mut PlacedTile,
    nearest: &[u16],
    data: &mut Planes<{ data::COUNT }>,
) {
    let grid = &frame.view.grid;
    let [has_place, has_normal] = [Layers::POSITION, Layers::NORMAL].map(|layer| frame.layers.has(layer));
    let has_depth = frame.layers.has(Layers::Z);
    if has_place || has_normal {
        placed.complete(frame, tile);
    }
    if has_place {
        for (axis, column) in placed.point.iter().enumerate() {
            take(grid, nearest, column, data.open(data::POSITION + axis));
        }
    }
    if has_normal {
        for (axis, column) in placed.normal.iter().enumerate() {
            take(grid, nearest, column, data.open(data::NORMAL + axis));
        }
    }
    let mut models = [EMPTY; CELLS];
    take(grid, nearest, &tile.model, &mut models);
    let is_surface = |first: usize| Mask::less(&models[first..first + LANES], EMPTY);
    if has_depth {
        let mut depths = [0.0; CELLS];
        for first in (0..CELLS).step_by(LANES) {
            let cameras = frame.cameras(tile, first);
            let depth =
                frame.offsets_from(cameras.eye, (tile, first), || tile.ticks(first)).dot(cameras.forward);
            (depth * F32x8::splat(frame.scene.space.length_of_files(1.0))).store(&mut depths, first);
        }
        let z = data.open(data::Z);
        take(grid, nearest, &depths, z);
        for first in (0..CELLS).step_by(LANES) {
            let depth = F32x8::load(z, first);
            is_surface(first).select(depth, F32x8::splat(BACKGROUND_Z)).store(z, first);
        }
    }
    convert_to_files(&frame.scene.space, data);
    // the background has no position and no normal
    for number in data::POSITION..data::NORMAL + 3 {
        let column = &mut data.columns[number];
        for first in (0..CELLS).step_by(LANES).take_while(|_| data.is_some[number]) {
            is_surface(first).select(F32x8::load(column, first), F32x8::ZERO).store(column, first);
        }
    }
    if frame.layers.has(Layers::OBJECT) {
        // the background's number is the greatest, so that adding 1 wraps to 0
        for (id, model) in data.open(data::ID).iter_mut().zip(&models) {
            *id = model.wrapping_add(1) as f32;
        }
    }
    // pixels of one sample have no other to choose
    let cells = if grid.samples == 1 { &grid.cells_of_pixels[..] } else { nearest };
    if let Some(vectors) = frame.motion_vectors {
        write_motion(frame.scene, vectors, tile, cells, data);
    }
    if frame.layers.has(Layers::MATERIAL) {
        for (number, cell) in data.open_zeroed(data::MATERIAL).iter_mut().zip(cells) {
            let cell = usize::from(*cell);
            let is_surface = tile.model[cell] < EMPTY;
            *number = if is_surface { f32::from(tile.record[cell].material) + 1.0 } else { 0.0 };
        }
    }
    if frame.layers.has(Layers::UV) {
        write_uv(frame, tile, cells, data);
    }
    if frame.layers.has(Layers::STATUS) {
        let ages: Column<u32> = std::array::from_fn(|cell| match tile.status[cell].is_reused() {
            true => (frame.rendered - tile.record[cell].traced.frame()).min(OLDEST),
            false => 0,
        });
        if ages.iter().fold(0, |any, age| any | age) != 0 {
            let mut shown = [0; CELLS];
            take(grid, nearest, &ages, &mut shown);
            for (age, frames) in data.open(data::AGE).iter_mut().zip(shown) {
                *age = frames as f32;
            }
        }
    }
}

/// Writes the motion vectors of the samples in `cells`, one for each pixel.
fn write_motion(
    scene: &Scene,
    vectors: &MotionVectors,
    tile: &Tile,
    cells: &[u16],
    data: &mut Planes<{ data::COUNT }>,
) {
    let at_rest = vectors.is_at_rest();
    for (first, _) in [data::BACKWARD, data::FORWARD].into_iter().zip(at_rest).filter(|(_, rests)| *rests) {
        data.open(first + 2).fill(1.0);
    }
    if at_rest == [true; 2] {
        return;
    }
    let mut of_pixels = [[Some(Vec2::ZERO); 2]; CELLS];
    for (of_pixel, cell) in of_pixels.iter_mut().zip(cells) {
        let cell = usize::from(*cell);
        let (point, model) = (tile.point(cell), tile.model[cell]);
        if model != EMPTY {
            *of_pixel = vectors.of(scene, point, (model, tile.record[cell].triangle));
        }
    }
    let planes = [(0, data::BACKWARD, 1.0), (1, data::FORWARD, 1.0), (1, data::FROM_NEXT, -1.0)];
    for (which, first, sign) in planes {
        for axis in 0..2 {
            let column = data.open(first + axis).iter_mut();
            let length = |vector: Option<Vec2>| vector.unwrap_or_default()[axis];
            // with 0 added, so that no zero is negative: values in the film are compared with these bit by
            // bit
            column.zip(&of_pixels).for_each(|(value, vectors)| *value = sign * length(vectors[which]) + 0.0);
        }
    }
    for (which, first) in [data::BACKWARD, data::FORWARD].into_iter().enumerate() {
        let known = of_pixels.iter().map(|vectors| f32::from(u8::from(vectors[which].is_some())));
        data.open(first + 2).iter_mut().zip(known).for_each(|(value, known)| *value = known);
    }
}

/// Writes the texture coordinates of the samples in `cells`, one for each pixel: at the stored points, where
/// textures are looked up.
fn write_uv(frame: &FrameView, tile: &Tile, cells: &[u16], data: &mut Planes<{ data::COUNT }>) {
    let planes = [data::UV, data::UV + 1, data::UV + 2];
    planes.iter().for_each(|plane| _ = data.open_zeroed(*plane));
    for (group, cells) in cells.chunks(LANES).enumerate() {
        let surface = |lane: usize| {
            let cell = usize::from(*cells.get(lane)?);
            let model = frame.scene.models.get(tile.model[cell] as usize)?;
            Some((&*model.mesh, tile.record[cell].triangle, tile.point(cell)))
        };
        let (mut corners, mut points) = (Corners::NONE, Vec3x8::ZERO);
        for (lane, (mesh, triangle, point)) in (0..LANES).filter_map(|lane| Some((lane, surface(lane)?))) {
            corners.set(lane, mesh, triangle);
            points.set_lane(lane, point);
        }
        let mut weights = corners.weights_at(points);
        let of = |lane| surface(lane).map(|(mesh, triangle, _)| (mesh, triangle));
        each_curved(
            corners.curved(),
            |lane| of(lane).expect("it was set above"),
            |lane, of, primitive| {
                let at = of.weights(primitive, points.lane(lane));
                weights.iter_mut().zip(at).for_each(|(weight, at)| weight.set_lane(lane, at));
            },
        );
        for (lane, (mesh, triangle, _)) in (0..LANES).filter_map(|lane| Some((lane, surface(lane)?))) {
            let uv = OnMesh::new(mesh, triangle, weights.map(|weight| weight.lane(lane))).uv();
            let is_there = f32::from(u8::from(mesh.has_uvs()));
            for (plane, value) in planes.into_iter().zip([uv.x, uv.y, is_there]) {
                // no zero is negative: values in the film are compared with these bit by bit
                data.columns[plane][group * LANES + lane] = value + 0.0;
            }
        }
    }
}

/// Converts positions to the space of the shot's files.
fn convert_to_files(space: &RenderSpace, data: &mut Planes<{ data::COUNT }>) {
    if space.is_of_files() || !data.is_some[data::POSITION] {
        return;
    }
    let [x, y, z] = &mut data.columns[data::POSITION..data::POSITION + 3] else { return };
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        [*x, *y, *z] = space.point_of_files(Vec3::new(*x, *y, *z)).as_vec3().to_array();
    }
}

/// Copies to each pixel the value that `column` has for its nearest sample.
#[inline(always)]
fn take<T: Copy>(grid: &Grid, nearest: &[u16], column: &Column<T>, pixels: &mut Column<T>) {
    if grid.samples == 1 {
        return in_rows(column, pixels);
    }
    for (pixel, cell) in pixels.iter_mut().zip(nearest) {
        // the remainder is the number itself: it spares a check
        *pixel = column[usize::from(*cell) % CELLS];
    }
}

/// Counts the samples and the rays of each pixel, if a layer shows either.
pub fn count(frame: &FrameView, tile: &Tile, rays: &CellRays, data: &mut Planes<{ data::COUNT }>) {
    if !(frame.layers.has(Layers::STATUS) || frame.layers.has(Layers::RAYS)) {
        return;
    }
    let grid = &*frame.view.grid;
    const STATUSES: [Status; 5] =
        [Status::Base, Status::Good, Status::Overlapped, Status::Missed, Status::Obscured];
    let share = (grid.samples_of_pixel() as f32).recip();
    let sum = |column: &Column<f32>, pixels: &mut Column<f32>| {
        reduce(grid, column, |sum, value| sum + value, pixels);
    };
    let mut column = [0.0; CELLS];
    // no early exit: so many statuses are compared at once
    let has = |status: Status| tile.status.iter().fold(false, |any, other| any | (*other == status));
    let is_there = STATUSES.map(has);
    for ((status, number), is_there) in STATUSES.into_iter().zip(data::STATUS..).zip(is_there) {
        if !is_there {
            continue;
        }
        for (count, other) in column.iter_mut().zip(&tile.status) {
            *count = f32::from(u8::from(*other == status));
        }
        sum(&column, data.open(number));
        data.columns[number].iter_mut().for_each(|count| *count *= share);
    }
    for (number, counts) in
        (data::RAYS..).zip([&rays.primary, &rays.verification, &rays.shadow, &rays.secondary])
    {
        if counts.iter().fold(0, |any, count| any | count) != 0 {
            for (count, rays) in column.iter_mut().zip(counts) {
                *count = f32::from(*rays);
            }
            sum(&column, data.open(number));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_made_of_their_own_samples() {
        for samples in 1..=5 {
            let grid = Grid::new(&crate::frame::grid::tests::settings(64, 64, samples));
            let column = std::array::from_fn(|cell| ((cell * 37) % CELLS) as f32);
            let (mut sums, mut least) = ([0.0; CELLS], [0.0; CELLS]);
            reduce(&grid, &column, |sum, value| sum + value, &mut sums);
            reduce(&grid, &column, f32::min, &mut least);
            for (pixel, cells) in grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel()).enumerate() {
                let values = || cells.iter().map(|cell| column[usize::from(*cell)]);
                assert_eq!(sums[pixel], values().sum::<f32>(), "{samples} samples, pixel {pixel}");
                assert_eq!(least[pixel], values().fold(f32::MAX, f32::min));
            }
        }
    }

    #[test]
    fn a_pixel_shows_its_nearest_sample_and_of_several_the_first() {
        let grid = Grid::new(&crate::frame::grid::tests::settings(64, 64, 2));
        let (mut x, mut y, mut nearest) = ([0.0; CELLS], [0.0; CELLS], Vec::new());
        let of_pixel = |pixel: usize| &grid.cells_of_pixels[pixel * 4..][..4];
        // all in the centres of their cells, but for the third of pixel 18
        for cell in 0..CELLS {
            x[cell] = grid.place_x[cell] + 0.5;
            y[cell] = grid.place_y[cell] + 0.5;
        }
        x[usize::from(of_pixel(18)[2])] += 0.2;
        choose_nearest(&grid, [&x, &y], &mut nearest);
        assert_eq!(nearest.len(), 16 * 16);
        for (pixel, nearest) in nearest.iter().enumerate() {
            assert_eq!(*nearest, of_pixel(pixel)[if pixel == 18 { 2 } else { 0 }], "{pixel}");
        }
    }
}
