//! Filtering: samples to pixels (the paper's "Filtering").
//!
//! Each tile is summed by itself into a [`TileFilm`], halo included; [`develop`](super::develop) then puts
//! the tiles together in their order, so that the picture does not depend on who was done first.
//!
//! Colours are filtered. Data (distance, position, normal, id, age) is never mixed: a pixel shows those of
//! its sample nearest to its centre. Status and rays are counts over the pixel's own samples.

use std::ops::{Add, Range};

use glam::Vec4;

use super::enhance::Light;
use super::grid::Grid;
use super::stage::{Stage, Workbench};
use super::trace_missed::is_traced;
use crate::lanes::{LANES, Lanes, Lanes3, Mask};
use crate::layers::Layers;
use crate::samples::{BACKGROUND, CELLS, Column, EMPTY, Status, TILE, Tile, load_colors};
use crate::settings::Filter;

/// `Z` of the background: finite, and far behind everything.
pub const BACKGROUND_Z: f32 = 1e10;

/// Steps in which the distance from a pixel's centre is told, for each pixel, squared.
const NEARNESS: f32 = 1024.0;

/// The planes of sums: numbers of those that begin a group.
pub mod sums {
    /// Of the weights.
    pub const WEIGHT: usize = 0;
    /// Of samples that show a surface.
    pub const ALPHA: usize = 1;
    /// Three colours each, from here on.
    pub const DIFFUSE: usize = 2;
    /// Diffuse reflectance.
    pub const ALBEDO: usize = 5;
    /// Highlights.
    pub const SPECULAR: usize = 8;
    /// In mirrors and off glass.
    pub const REFLECTION: usize = 11;
    /// Through glass.
    pub const REFRACTION: usize = 14;
    /// All of them.
    pub const COUNT: usize = 17;
}

/// The planes of data: numbers of those that begin a group.
pub mod data {
    /// Distance along the view axis.
    pub const Z: usize = 0;
    /// World space.
    pub const POSITION: usize = 1;
    /// World space.
    pub const NORMAL: usize = 4;
    /// Model's number, from 1 on.
    pub const ID: usize = 7;
    /// Frames since the sample was traced.
    pub const AGE: usize = 8;
    /// Share of the samples that are base, good, overlapped, missed, obscured.
    pub const STATUS: usize = 9;
    /// Rays: primary, verification, shadow, secondary.
    pub const RAYS: usize = 14;
    /// All of them.
    pub const COUNT: usize = 18;
}

/// The pixels that one tile's samples reach, plane by plane. Keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct TileFilm {
    /// Columns and rows of the tile's own pixels in the picture.
    pixels: [Range<u32>; 2],
    /// Pixels from one row of `data` to the next.
    stride: usize,
    /// Pixels around the tile that its samples reach.
    halo: usize,
    /// [`sums::COUNT`] planes of the tile's own pixels and the halo around them.
    sums: Vec<f32>,
    /// [`data::COUNT`] planes of the tile's own pixels.
    data: Vec<f32>,
    /// Which planes of `sums` are not zero throughout; the others are not written.
    is_some: [bool; sums::COUNT],
    /// Which planes of `data` are not zero throughout; the others are not written.
    has_data: [bool; data::COUNT],
    /// Nothing is written because the film shows the tile already.
    is_shown: bool,
}

impl TileFilm {
    /// Says that the film shows the tile already, a frame younger.
    pub fn stay(&mut self, grid: &Grid, number: usize) {
        self.pixels = grid.pixels(number);
        self.is_shown = true;
    }

    /// Whether the film shows the tile already, a frame younger.
    pub fn is_shown(&self) -> bool {
        self.is_shown
    }

    /// Columns and rows of the tile's own pixels in the picture.
    pub fn pixels(&self) -> [Range<usize>; 2] {
        self.pixels.clone().map(|range| range.start as usize..range.end as usize)
    }

    fn begin(&mut self, grid: &Grid, number: usize, filter: Filter) {
        self.is_shown = false;
        self.pixels = grid.pixels(number);
        self.stride = grid.tile_pixels as usize;
        self.halo = halo(filter) as usize;
        self.sums.resize(sums::COUNT * self.edge().pow(2), 0.0);
        self.data.resize(data::COUNT * self.stride.pow(2), 0.0);
        self.is_some = [false; sums::COUNT];
        self.has_data = [true; data::COUNT];
    }

    /// Pixels along an edge of a plane of sums.
    fn edge(&self) -> usize {
        self.stride + 2 * self.halo
    }

    /// Whether any of these planes of the sums is not zero throughout.
    pub fn has_sums(&self, planes: &[usize]) -> bool {
        planes.iter().any(|plane| self.is_some[*plane])
    }

    /// Whether this plane of the data is not zero throughout.
    pub fn has_data(&self, plane: usize) -> bool {
        self.has_data[plane]
    }

    /// Plane `plane` of the sums of a filter without a halo, in rows of [`stride`](Self::stride).
    pub fn own_sums(&self, plane: usize) -> &[f32] {
        &self.sums[plane * self.edge().pow(2)..][..self.edge().pow(2)]
    }

    /// The part of row `y` of plane `plane` of the sums that is in the picture, `width` pixels wide: its
    /// first column and its values. `None` where the tile does not reach the row, or has nothing but zeros.
    pub fn sums_in_row(&self, plane: usize, y: u32, width: usize) -> Option<(usize, &[f32])> {
        let row = (y as usize + self.halo).checked_sub(self.pixels[1].start as usize)?;
        if !self.is_some[plane] || row >= self.edge() {
            return None;
        }
        let left = self.pixels[0].start as usize;
        let (first, beyond) = (left.saturating_sub(self.halo), self.halo.saturating_sub(left));
        let start = (plane * self.edge() + row) * self.edge();
        let values = &self.sums[start + beyond..start + self.edge()];
        Some((first, &values[..values.len().min(width - first)]))
    }

    /// A row of plane `plane` of the data, from the tile's first pixel on.
    pub fn data_row(&self, plane: usize, row: usize) -> &[f32] {
        &self.data[plane * self.stride.pow(2)..][row * self.stride..][..self.stride]
    }

    /// Pixels from one row to the next.
    pub fn stride(&self) -> usize {
        self.stride
    }

    fn plane(&mut self, plane: usize) -> &mut [f32] {
        let size = self.edge().pow(2);
        &mut self.sums[plane * size..][..size]
    }
}

/// A worker's memory for this phase.
#[derive(Debug)]
pub struct Filtering {
    /// One where a surface is seen, zero elsewhere.
    alpha: Column<f32>,
    /// Zero for the background.
    albedo: Light,
    /// In cells, from the tile's corner.
    x: Column<f32>,
    y: Column<f32>,
    /// For each pixel the cell whose sample is nearest to its centre.
    nearest: Vec<u16>,
}

impl Default for Filtering {
    fn default() -> Self {
        let none = [0.0; CELLS];
        Self { alpha: none, albedo: [none; 3], x: none, y: none, nearest: Vec::new() }
    }
}

/// Sums the samples of tile number `number` into `film`.
pub fn filter(
    stage: &Stage,
    number: usize,
    tile: &Tile,
    bench: &mut Workbench,
    kernel: Filter,
    film: &mut TileFilm,
) {
    let grid = &*stage.view.grid;
    film.begin(grid, number, kernel);
    let mut filtering = std::mem::take(&mut bench.filtering);
    prepare(stage, tile, &mut filtering);
    let shows_samples = stage.layers.has(Layers::OF_ONE_SAMPLE);
    if kernel != Filter::Box || shows_samples && grid.samples > 1 {
        locate(stage, number, tile, &mut filtering);
    }
    sum_colors(stage, tile, bench, kernel, &filtering, film);
    if shows_samples {
        choose_nearest(grid, &mut filtering);
        write_data(stage, tile, &filtering.nearest, bench, film);
    }
    if stage.layers.has(Layers::STATUS) || stage.layers.has(Layers::RAYS) {
        write_counts(grid, tile, bench, film);
    }
    bench.filtering = filtering;
}

/// What is filtered beside light.
fn prepare(stage: &Stage, tile: &Tile, filtering: &mut Filtering) {
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let is_surface = Mask::of(|lane| models[lane] < EMPTY);
        is_surface.select(Lanes::splat(1.0), Lanes::ZERO).store(&mut filtering.alpha, first);
        if stage.layers.has(Layers::ALBEDO) {
            let [r, g, b] = &mut filtering.albedo;
            is_surface.select3(load_colors(&tile.albedo, first), Lanes3::ZERO).store([r, g, b], first);
        }
    }
}

/// Where in the tile the samples are seen. A sample's own cell holds it; rounding may say the next one.
fn locate(stage: &Stage, number: usize, tile: &Tile, filtering: &mut Filtering) {
    let grid = &stage.view.grid;
    let [left, top] = grid.tile_corner(number).map(|at| Lanes::splat(at as f32));
    for first in (0..CELLS).step_by(LANES) {
        let status = &tile.status[first..first + LANES];
        if status.iter().all(|status| is_traced(*status)) {
            // through the centres of their cells
            let centre = |column: &[f32]| Lanes::load(column, first) + Lanes::splat(0.5);
            centre(&grid.place_x).store(&mut filtering.x, first);
            centre(&grid.place_y).store(&mut filtering.y, first);
            continue;
        }
        let seen = stage.view.project(stage.offsets(tile, first));
        let inside = |at: Lanes, cell: Lanes| at.max(cell).min(cell + Lanes::splat(1.0));
        inside(seen.x - left, Lanes::load(&grid.place_x, first)).store(&mut filtering.x, first);
        inside(seen.y - top, Lanes::load(&grid.place_y, first)).store(&mut filtering.y, first);
    }
}

/// For each pixel the sample nearest to its centre; of several the first.
fn choose_nearest(grid: &Grid, filtering: &mut Filtering) {
    let Filtering { x, y, nearest, .. } = filtering;
    nearest.clear();
    let pixels = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
    if grid.samples == 1 {
        nearest.extend(pixels.map(|cells| cells[0]));
        return;
    }
    let (edge, scale) = (grid.tile_pixels as usize, (grid.samples as f32).recip());
    nearest.extend(pixels.enumerate().map(|(pixel, cells)| {
        let centre = [(pixel % edge) as f32 + 0.5, (pixel / edge) as f32 + 0.5];
        let distance = |cell: u16| {
            let aside = [x[usize::from(cell)] * scale - centre[0], y[usize::from(cell)] * scale - centre[1]];
            // in steps: of samples that are equally near but for rounding the first is shown
            ((aside[0] * aside[0] + aside[1] * aside[1]) * NEARNESS + 0.5) as u32
        };
        let first = (distance(cells[0]), cells[0]);
        let least = cells[1..].iter().map(|cell| (distance(*cell), *cell));
        least.fold(first, |best, next| if next.0 < best.0 { next } else { best }).1
    }));
}

/// Sums all planes that are filtered.
fn sum_colors(
    stage: &Stage,
    tile: &Tile,
    bench: &Workbench,
    kernel: Filter,
    filtering: &Filtering,
    film: &mut TileFilm,
) {
    let (grid, shown) = (&*stage.view.grid, &bench.radiance);
    let colors = [
        (sums::DIFFUSE, &shown.diffuse, true),
        (sums::ALBEDO, &filtering.albedo, stage.layers.has(Layers::ALBEDO)),
        (sums::SPECULAR, &shown.specular, shown.has_specular),
        (sums::REFLECTION, &shown.reflection, shown.has_secondary),
        (sums::REFRACTION, &shown.refraction, shown.has_secondary),
    ];
    let planes = colors.into_iter().filter(|(.., is_some)| *is_some);
    let planes =
        planes.flat_map(|(first, light, _)| light.iter().enumerate().map(move |(i, c)| (first + i, c)));
    let planes = std::iter::once((sums::ALPHA, &filtering.alpha)).chain(planes);
    match kernel {
        Filter::Box => {
            for (plane, column) in planes {
                film.is_some[plane] = true;
                let pixels = film.plane(plane);
                sum_pixels(grid, |cell| column[cell], |pixel, sum| pixels[pixel] = sum);
            }
        }
        Filter::Mitchell => {
            let mut columns = [None; sums::COUNT];
            planes.for_each(|(plane, column)| columns[plane] = Some(column));
            spread(grid, tile, filtering, &columns, film);
        }
    }
}

/// Adds up, for each pixel of a tile, the `value` of its samples' cells in their order, and calls
/// `put(pixel, sum)`.
///
/// For one and for four samples a pixel the blocks of 4 x 4 cells hold whole pixels: there no table is needed.
#[inline(always)]
fn sum_pixels<T: Copy + Add<Output = T>>(
    grid: &Grid,
    value: impl Fn(usize) -> T,
    mut put: impl FnMut(usize, T),
) {
    const BLOCKS: usize = TILE / 4;
    const HALF: usize = TILE / 2;
    match grid.samples {
        1 => {
            for cell in 0..CELLS {
                let (block, lane) = (cell / 16, cell % 16);
                let [x, y] = [block % BLOCKS * 4 + lane % 4, block / BLOCKS * 4 + lane / 4];
                put(y * TILE + x, value(cell));
            }
        }
        2 => {
            for block in 0..CELLS / 16 {
                let corner = block / BLOCKS * 2 * HALF + block % BLOCKS * 2;
                for (below, right) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let cell = block * 16 + below * 8 + right * 2;
                    let sum = value(cell) + value(cell + 1) + value(cell + 4) + value(cell + 5);
                    put(corner + below * HALF + right, sum);
                }
            }
        }
        _ => {
            let pixels = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
            for (pixel, cells) in pixels.enumerate() {
                // the remainder is the number itself: it spares a check
                let mut values = cells.iter().map(|cell| value(usize::from(*cell) % CELLS));
                if let Some(first) = values.next() {
                    put(pixel, values.fold(first, |sum, value| sum + value));
                }
            }
        }
    }
}

/// Spreads each sample over all pixels that the Mitchell filter reaches.
fn spread(
    grid: &Grid,
    tile: &Tile,
    filtering: &Filtering,
    columns: &[Option<&Column<f32>>; sums::COUNT],
    film: &mut TileFilm,
) {
    let (edge, scale) = (film.edge(), (grid.samples as f32).recip());
    let size = edge * edge;
    for (plane, column) in columns.iter().enumerate() {
        film.is_some[plane] = column.is_some() || plane == sums::WEIGHT;
        if film.is_some[plane] {
            film.plane(plane).fill(0.0);
        }
    }
    // where a plane begins, and what is spread into it
    let planes: Vec<(usize, &Column<f32>)> =
        columns.iter().enumerate().filter_map(|(plane, column)| Some((plane * size, (*column)?))).collect();
    for cell in (0..CELLS).filter(|cell| tile.model[*cell] != EMPTY) {
        let at = [filtering.x[cell] * scale, filtering.y[cell] * scale];
        // the centres of pixels first .. first + 3 are within two pixels; the halo's two come first
        let first = at.map(|at| (at + 0.5).floor());
        let (across, down) = (mitchell(at[0] + 0.5 - first[0]), mitchell(at[1] + 0.5 - first[1]));
        let start = first[1] as usize * edge + first[0] as usize;
        let weights = down.map(|down| Vec4::from_array(across) * down);
        add(&mut film.sums[sums::WEIGHT * size + start..], edge, &weights, 1.0);
        for (begin, column) in &planes {
            // most samples have neither highlight nor mirror
            if column[cell] != 0.0 {
                add(&mut film.sums[begin + start..], edge, &weights, column[cell]);
            }
        }
    }
}

/// Adds `value` to the 4 x 4 pixels at the start of `pixels`, which has `edge` in a row.
#[inline(always)]
fn add(pixels: &mut [f32], edge: usize, weights: &[Vec4; 4], value: f32) {
    let pixels = &mut pixels[..3 * edge + 4];
    for (row, weights) in weights.iter().enumerate() {
        let four = &mut pixels[row * edge..row * edge + 4];
        (Vec4::from_slice(four) + *weights * value).write_to_slice(four);
    }
}

/// How far a filter reaches, in pixels, beyond a sample's own pixel.
pub fn halo(filter: Filter) -> u32 {
    match filter {
        Filter::Box => 0,
        Filter::Mitchell => 2,
    }
}

/// Weights of the four pixels around a sample that lies `beyond` (0 to 1) the second one's centre: the cubic
/// with B = C = 1/3 (Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", SIGGRAPH 1988,
/// equation 8).
#[inline]
fn mitchell(beyond: f32) -> [f32; 4] {
    const B: f32 = 1.0 / 3.0;
    const C: f32 = 1.0 / 3.0;
    let near =
        |x: f32| ((12.0 - 9.0 * B - 6.0 * C) * x + (-18.0 + 12.0 * B + 6.0 * C)) * x * x + (6.0 - 2.0 * B);
    let far = |x: f32| {
        (((-B - 6.0 * C) * x + (6.0 * B + 30.0 * C)) * x + (-12.0 * B - 48.0 * C)) * x + (8.0 * B + 24.0 * C)
    };
    let [first, second] = [far(1.0 + beyond), near(beyond)];
    [first / 6.0, second / 6.0, near(1.0 - beyond) / 6.0, far(2.0 - beyond) / 6.0]
}

/// Writes the data of each pixel's nearest sample.
fn write_data(stage: &Stage, tile: &Tile, nearest: &[u16], bench: &mut Workbench, film: &mut TileFilm) {
    let (size, camera) = (film.stride.pow(2), &stage.view.camera);
    let [has_place, has_normal] = [Layers::POSITION, Layers::NORMAL].map(|layer| stage.layers.has(layer));
    let is_placed = has_place || has_normal || stage.layers.has(Layers::Z);
    for (pixel, cell) in nearest.iter().map(|cell| usize::from(*cell)).enumerate() {
        let mut put = |plane: usize, value: f32| film.data[plane * size + pixel] = value;
        let mut put_vectors = |place: glam::Vec3, normal: glam::Vec3| {
            if has_place {
                (0..3).for_each(|axis| put(data::POSITION + axis, place[axis]));
            }
            if has_normal {
                (0..3).for_each(|axis| put(data::NORMAL + axis, normal[axis]));
            }
        };
        match tile.model[cell] {
            EMPTY => continue,
            BACKGROUND => {
                put_vectors(glam::Vec3::ZERO, glam::Vec3::ZERO);
                put(data::Z, BACKGROUND_Z);
                put(data::ID, 0.0);
            }
            model => {
                if is_placed {
                    let (place, normal) = bench.placed.at(stage, tile, cell);
                    put_vectors(place, normal);
                    put(data::Z, (place - camera.eye).dot(camera.forward));
                }
                put(data::ID, (model + 1) as f32);
            }
        }
        put(data::AGE, f32::from(tile.age[cell]));
    }
    film.has_data[data::AGE] = tile.age.iter().any(|age| *age != 0);
}

/// Bits of a count of samples of one status: a pixel has up to 256.
const COUNT_BITS: u32 = 12;

/// One sample of this status, in a word that counts each status by itself.
fn one_of(status: Status) -> u64 {
    let at = match status {
        Status::Outside | Status::Empty => return 0,
        Status::Base => 0,
        Status::Good => 1,
        Status::Overlapped => 2,
        Status::Missed => 3,
        Status::Obscured => 4,
    };
    1 << (at * COUNT_BITS)
}

/// Counts the samples and the rays of each pixel.
fn write_counts(grid: &Grid, tile: &Tile, bench: &Workbench, film: &mut TileFilm) {
    let size = film.stride.pow(2);
    let share = (grid.samples_of_pixel() as f32).recip();
    let seen = tile.status.iter().fold(0, |seen, status| seen | one_of(*status));
    let counted = |counts: u64, at: usize| counts >> (at as u32 * COUNT_BITS) & ((1 << COUNT_BITS) - 1);
    let are_there: [bool; 5] = std::array::from_fn(|at| counted(seen, at) != 0);
    let [is_base, _, _, is_missed, is_obscured] = are_there;
    film.has_data[data::STATUS..][..are_there.len()].copy_from_slice(&are_there);
    film.has_data[data::RAYS] = is_base | is_missed | is_obscured;
    let planes = &mut film.data[data::STATUS * size..];
    sum_pixels(
        grid,
        |cell| one_of(tile.status[cell]),
        |pixel, counts| {
            for (at, is_there) in are_there.into_iter().enumerate() {
                if is_there {
                    planes[at * size + pixel] = counted(counts, at) as f32 * share;
                }
            }
            let traced = counted(counts, 0) + counted(counts, 3) + counted(counts, 4);
            planes[(data::RAYS - data::STATUS) * size + pixel] = traced as f32;
        },
    );
    let rays = &bench.cell_rays;
    for (plane, column) in (data::RAYS + 1..).zip([&rays.verification, &rays.shadow, &rays.secondary]) {
        film.has_data[plane] = column.iter().fold(0, |any, count| any | count) != 0;
        if film.has_data[plane] {
            let pixels = &mut film.data[plane * size..][..size];
            sum_pixels(grid, |cell| u32::from(column[cell]), |pixel, sum| pixels[pixel] = sum as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_summed_over_their_own_samples() {
        for samples in 1..=5 {
            let grid = Grid::new(&crate::frame::grid::tests::settings(64, 64, samples));
            let mut seen = vec![None; grid.tile_pixels.pow(2) as usize];
            // a sum of powers tells which cells are in it, at least by number and by their places
            let value = |cell: usize| (1 << 40) + (cell * cell) as u64;
            sum_pixels(&grid, value, |pixel, sum| assert_eq!(seen[pixel].replace(sum), None));
            for (pixel, cells) in grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel()).enumerate() {
                let sum = cells.iter().map(|cell| value(usize::from(*cell))).sum();
                assert_eq!(seen[pixel], Some(sum), "{samples} samples, pixel {pixel}");
            }
        }
    }

    #[test]
    fn mitchells_weights_add_up_to_one_wherever_the_sample_is() {
        for step in 0..=20 {
            let weights = mitchell(step as f32 / 20.0);
            let sum: f32 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-6, "{step}: {sum}");
        }
        let on_a_centre = mitchell(0.0);
        let wanted = [1.0 / 18.0, 8.0 / 9.0, 1.0 / 18.0, 0.0];
        assert!(on_a_centre.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{on_a_centre:?}");
    }
}
