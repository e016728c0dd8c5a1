//! Filtering: samples to pixels (the paper's "Filtering").
//!
//! Each tile writes its own pixels into its [`Window`] of the film. Where the filter is wider than a pixel,
//! colours stay sums in a [`TileFilm`], halo included: [`develop`](super::develop) adds up what neighbours have
//! for each pixel, in the tiles' order, so that the picture does not depend on who was done first.
//!
//! Colours are filtered. Data (distance, position, normal, id, age) is never mixed: a pixel shows those of
//! its sample nearest to its centre. Status and rays are counts over the pixel's own samples.

use std::ops::Range;

use glam::Vec4;

use super::channels::{Channel, Picture, Source, Written, data, sums};
use super::enhance::{Light, Radiance};
use super::grid::Grid;
use super::placed::PlacedTile;
use super::stage::{CellRays, Stage, Workbench};
use super::trace_missed::is_traced;
use super::window::{Rounding, Window};
use crate::lanes::{LANES, Lanes, Lanes3, Mask};
use crate::layers::Layers;
use crate::samples::{CELLS, Column, EMPTY, Status, TILE, Tile, load_colors};
use crate::settings::Filter;

/// `Z` of the background: finite, and far behind everything.
pub const BACKGROUND_Z: f32 = 1e10;

/// Steps in which the distance from a pixel's centre is told, for each pixel, squared.
const NEARNESS: f32 = 1024.0;

/// `N` planes of a tile's pixels, in rows, each from the start of its column. Keeps its memory.
#[derive(Debug)]
struct Planes<const N: usize> {
    columns: Vec<Column<f32>>,
    /// Which planes hold anything. What is in the others means nothing: they are zero throughout.
    is_some: [bool; N],
}

impl<const N: usize> Default for Planes<N> {
    fn default() -> Self {
        Self { columns: vec![[0.0; CELLS]; N], is_some: [false; N] }
    }
}

impl<const N: usize> Planes<N> {
    /// Nothing in any plane.
    fn begin(&mut self) {
        self.is_some = [false; N];
    }

    /// Plane `number`, to be filled.
    fn open(&mut self, number: usize) -> &mut Column<f32> {
        self.is_some[number] = true;
        &mut self.columns[number]
    }
}

/// What one tile's samples add to the pixels that they reach, where the filter has a halo. Keeps its memory from
/// frame to frame.
#[derive(Debug, Default)]
pub struct TileFilm {
    /// Columns and rows of the tile's own pixels in the picture.
    pixels: [Range<u32>; 2],
    /// Pixels along the tile's edge.
    stride: usize,
    /// Pixels around the tile that its samples reach.
    halo: usize,
    /// [`sums::COUNT`] planes of the tile's own pixels and the halo around them.
    sums: Vec<f32>,
    /// Which planes are not zero throughout; the others are not written.
    is_some: [bool; sums::COUNT],
}

impl TileFilm {
    fn begin(&mut self, grid: &Grid, number: usize, filter: Filter) {
        self.pixels = grid.pixels(number);
        self.stride = grid.tile_pixels as usize;
        self.halo = halo(filter) as usize;
        self.sums.resize(sums::COUNT * self.edge().pow(2), 0.0);
        self.is_some = [false; sums::COUNT];
    }

    /// Pixels along an edge of a plane.
    fn edge(&self) -> usize {
        self.stride + 2 * self.halo
    }

    /// Whether any of these sums is not zero throughout.
    pub fn has_sums(&self, planes: &[usize]) -> bool {
        planes.iter().any(|plane| self.is_some[*plane])
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
    /// Of a filter without a halo: sums of the tile's pixels.
    sums: Planes<{ sums::COUNT }>,
    /// Of the tile's pixels.
    data: Planes<{ data::COUNT }>,
    rounding: Rounding,
}

impl Default for Filtering {
    fn default() -> Self {
        let none = [0.0; CELLS];
        Self {
            alpha: none,
            albedo: [none; 3],
            x: none,
            y: none,
            nearest: Vec::new(),
            sums: Planes::default(),
            data: Planes::default(),
            rounding: Rounding::default(),
        }
    }
}

/// Makes pixels of the samples of tile number `number`, and writes what is finished into its `window` and what is
/// not into `film`. Says which channels hold anything.
#[expect(clippy::too_many_arguments, reason = "each is a thing by itself")]
pub fn filter(
    stage: &Stage,
    number: usize,
    tile: &Tile,
    bench: &mut Workbench,
    kernel: Filter,
    picture: &Picture,
    window: &mut Window,
    film: &mut TileFilm,
) -> Written {
    let grid = &*stage.view.grid;
    let Workbench { filtering, placed, radiance, cell_rays, .. } = bench;
    filtering.sums.begin();
    filtering.data.begin();
    prepare(stage, tile, filtering);
    let shows_samples = stage.layers.has(Layers::OF_ONE_SAMPLE);
    if kernel != Filter::Box || shows_samples && grid.samples > 1 {
        locate(stage, number, tile, filtering);
    }
    if kernel != Filter::Box {
        film.begin(grid, number, kernel);
    }
    sum_colors(stage, tile, radiance, kernel, filtering, film);
    if shows_samples {
        choose_nearest(grid, filtering);
        take_data(stage, tile, placed, filtering);
    }
    if stage.layers.has(Layers::STATUS) || stage.layers.has(Layers::RAYS) {
        count(grid, tile, cell_rays, &mut filtering.data);
    }
    finish(grid, number, picture, kernel, filtering, window)
}

/// Says that the film shows tile number `number` already, a frame younger.
pub fn stay(stage: &Stage, number: usize, picture: &Picture, window: &mut Window) -> Written {
    const OLDEST: f32 = u16::MAX as f32;
    let pixels = stage.view.grid.pixels(number).map(|range| range.start as usize..range.end as usize);
    let is_age = |channel: &Channel| channel.source == Source::Data(data::AGE);
    if let Some(age) = picture.channels.iter().position(is_age) {
        window.count_up(age, &pixels, OLDEST);
    }
    Written::SHOWN
}

/// Writes what needs no neighbours.
fn finish(
    grid: &Grid,
    number: usize,
    picture: &Picture,
    kernel: Filter,
    filtering: &mut Filtering,
    window: &mut Window,
) -> Written {
    let Filtering { sums, data, rounding, .. } = filtering;
    let scale = (grid.samples_of_pixel() as f32).recip();
    let stride = grid.tile_pixels as usize;
    let pixels = grid.pixels(number).map(|range| range.start as usize..range.end as usize);
    let mut written = Written::default();
    let mut scaled = [0.0; CELLS];
    for (number, (channel, was_zero)) in picture.channels.iter().zip(&picture.was_zero).enumerate() {
        let values = match channel.source {
            Source::Data(number) => data.is_some[number].then(|| &data.columns[number]),
            Source::Filtered(_) if kernel != Filter::Box => continue,
            Source::Filtered(numbers) => {
                let mut some = numbers.iter().filter(|number| sums.is_some[**number]);
                some.next().map(|first| {
                    for (pixel, sum) in scaled.iter_mut().zip(&sums.columns[*first]) {
                        *pixel = sum * scale;
                    }
                    for number in some {
                        for (pixel, sum) in scaled.iter_mut().zip(&sums.columns[*number]) {
                            *pixel += sum * scale;
                        }
                    }
                    &scaled
                })
            }
        };
        match values {
            Some(values) => {
                written.note(number);
                window.put(number, &pixels, values, stride, rounding);
            }
            None if *was_zero => {}
            None => window.clear(number, &pixels),
        }
    }
    written
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
    let cells = grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel());
    if grid.samples == 1 {
        nearest.extend(cells.map(|cells| cells[0]));
        return;
    }
    // the number of a sample in its pixel comes after how near it is: the least says which one it is
    let (scale, samples) = ((grid.samples as f32).recip(), grid.samples_of_pixel() as f32);
    let aside = |at: f32, centre: f32| at * scale - centre;
    let centres = grid.center_x.iter().zip(&grid.center_y).zip(&grid.number_in_pixel);
    let mut ranks = [0.0; CELLS];
    for ((rank, (x, y)), ((center_x, center_y), number)) in
        ranks.iter_mut().zip(x.iter().zip(&*y)).zip(centres)
    {
        let [x, y] = [aside(*x, *center_x), aside(*y, *center_y)];
        // in steps: of samples that are equally near but for rounding the first is shown
        *rank = ((x * x + y * y) * NEARNESS + 0.5).floor() * samples + number;
    }
    let mut least = [0.0; CELLS];
    reduce(grid, &ranks, f32::min, &mut least);
    least.iter_mut().for_each(|rank| *rank -= (*rank / samples).floor() * samples);
    nearest.extend(cells.zip(&least).map(|(cells, number)| cells[*number as usize]));
}

/// Sums all planes that are filtered.
fn sum_colors(
    stage: &Stage,
    tile: &Tile,
    shown: &Radiance,
    kernel: Filter,
    filtering: &mut Filtering,
    film: &mut TileFilm,
) {
    let grid = &*stage.view.grid;
    let Filtering { alpha, albedo, sums: own, x, y, .. } = filtering;
    let colors = [
        (sums::DIFFUSE, &shown.diffuse, true),
        (sums::ALBEDO, &*albedo, stage.layers.has(Layers::ALBEDO)),
        (sums::SPECULAR, &shown.specular, shown.has_specular),
        (sums::REFLECTION, &shown.reflection, shown.has_secondary),
        (sums::REFRACTION, &shown.refraction, shown.has_secondary),
    ];
    let planes = colors.into_iter().filter(|(.., is_some)| *is_some);
    let planes =
        planes.flat_map(|(first, light, _)| light.iter().enumerate().map(move |(i, c)| (first + i, c)));
    let planes = std::iter::once((sums::ALPHA, &*alpha)).chain(planes);
    match kernel {
        Filter::Box => {
            for (plane, column) in planes {
                reduce(grid, column, |sum, value| sum + value, own.open(plane));
            }
        }
        Filter::Mitchell => {
            let mut columns = [None; sums::COUNT];
            planes.for_each(|(plane, column)| columns[plane] = Some(column));
            spread(grid, tile, [x, y], &columns, film);
        }
    }
}

/// For each pixel of a tile the values of its samples' cells, `joined`.
///
/// For one and for four samples a pixel the blocks of 4 x 4 cells hold whole pixels: there no table is needed,
/// and whole blocks are joined at once.
#[inline(always)]
fn reduce(grid: &Grid, column: &Column<f32>, joined: impl Fn(f32, f32) -> f32, pixels: &mut Column<f32>) {
    const BLOCKS: usize = TILE / 4;
    const HALF: usize = TILE / 2;
    match grid.samples {
        1 => {
            for (block, cells) in column.chunks_exact(16).enumerate() {
                let corner = block / BLOCKS * 4 * TILE + block % BLOCKS * 4;
                for (row, cells) in cells.chunks_exact(4).enumerate() {
                    pixels[corner + row * TILE..][..4].copy_from_slice(cells);
                }
            }
        }
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

/// Spreads each sample over all pixels that the Mitchell filter reaches.
fn spread(
    grid: &Grid,
    tile: &Tile,
    [x, y]: [&Column<f32>; 2],
    columns: &[Option<&Column<f32>>; sums::COUNT],
    film: &mut TileFilm,
) {
    let (edge, scale) = (film.edge(), (grid.samples as f32).recip());
    let size = edge * edge;
    for (plane, column) in columns.iter().enumerate() {
        if column.is_some() || plane == sums::WEIGHT {
            film.is_some[plane] = true;
            film.sums[plane * size..][..size].fill(0.0);
        }
    }
    let sums = &mut film.sums;
    // where a plane begins, and what is spread into it
    let planes: Vec<(usize, &Column<f32>)> =
        columns.iter().enumerate().filter_map(|(plane, column)| Some((plane * size, (*column)?))).collect();
    for cell in (0..CELLS).filter(|cell| tile.model[*cell] != EMPTY) {
        let at = [x[cell] * scale, y[cell] * scale];
        // the centres of pixels first .. first + 3 are within two pixels; the halo's two come first
        let first = at.map(|at| (at + 0.5).floor());
        let (across, down) = (mitchell(at[0] + 0.5 - first[0]), mitchell(at[1] + 0.5 - first[1]));
        let start = first[1] as usize * edge + first[0] as usize;
        let weights = down.map(|down| Vec4::from_array(across) * down);
        add(&mut sums[sums::WEIGHT * size + start..], edge, &weights, 1.0);
        for (begin, column) in &planes {
            // most samples have neither highlight nor mirror
            if column[cell] != 0.0 {
                add(&mut sums[begin + start..], edge, &weights, column[cell]);
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

/// The data of each pixel's nearest sample.
fn take_data(stage: &Stage, tile: &Tile, placed: &mut PlacedTile, filtering: &mut Filtering) {
    let Filtering { nearest, data, .. } = filtering;
    let [has_place, has_normal] = [Layers::POSITION, Layers::NORMAL].map(|layer| stage.layers.has(layer));
    let has_depth = stage.layers.has(Layers::Z);
    if has_place || has_normal || has_depth {
        placed.complete(stage, tile);
    }
    if has_place || has_depth {
        for (axis, column) in placed.point.iter().enumerate() {
            take(nearest, column, data.open(data::POSITION + axis));
        }
    }
    if has_normal {
        for (axis, column) in placed.normal.iter().enumerate() {
            take(nearest, column, data.open(data::NORMAL + axis));
        }
    }
    let mut models = [EMPTY; CELLS];
    take(nearest, &tile.model, &mut models);
    let is_surface = |first: usize| Mask::of(|lane| models[first + lane] < EMPTY);
    if has_depth {
        let camera = &stage.view.camera;
        let [eye, forward] = [camera.eye, camera.forward].map(Lanes3::splat);
        let [z, x, y, w] = &mut data.columns[data::Z..data::NORMAL] else { return };
        for first in (0..CELLS).step_by(LANES) {
            let depth = (Lanes3::load([x, y, w], first) - eye).dot(forward);
            is_surface(first).select(depth, Lanes::splat(BACKGROUND_Z)).store(z, first);
        }
        data.is_some[data::Z] = true;
    }
    // the background is nowhere
    for number in data::POSITION..data::NORMAL + 3 {
        let column = &mut data.columns[number];
        for first in (0..CELLS).step_by(LANES).take_while(|_| data.is_some[number]) {
            is_surface(first).select(Lanes::load(column, first), Lanes::ZERO).store(column, first);
        }
    }
    if stage.layers.has(Layers::ID) {
        // the background's number is the greatest: one more is none
        for (id, model) in data.open(data::ID).iter_mut().zip(&models) {
            *id = model.wrapping_add(1) as f32;
        }
    }
    if stage.layers.has(Layers::STATUS) && tile.age.iter().fold(0, |any, age| any | age) != 0 {
        let mut ages = [0; CELLS];
        take(nearest, &tile.age, &mut ages);
        for (age, frames) in data.open(data::AGE).iter_mut().zip(ages) {
            *age = f32::from(frames);
        }
    }
}

/// For each pixel what `column` holds for its nearest sample.
fn take<T: Copy>(nearest: &[u16], column: &Column<T>, pixels: &mut Column<T>) {
    for (pixel, cell) in pixels.iter_mut().zip(nearest) {
        // the remainder is the number itself: it spares a check
        *pixel = column[usize::from(*cell) % CELLS];
    }
}

/// Counts the samples and the rays of each pixel.
fn count(grid: &Grid, tile: &Tile, rays: &CellRays, data: &mut Planes<{ data::COUNT }>) {
    const STATUSES: [Status; 5] =
        [Status::Base, Status::Good, Status::Overlapped, Status::Missed, Status::Obscured];
    let share = (grid.samples_of_pixel() as f32).recip();
    let sum = |column: &Column<f32>, pixels: &mut Column<f32>| {
        reduce(grid, column, |sum, value| sum + value, pixels);
    };
    let mut column = [0.0; CELLS];
    let mut count_those = |number: usize, unit: f32, is_one: &dyn Fn(Status) -> bool| {
        for (count, status) in column.iter_mut().zip(&tile.status) {
            *count = f32::from(u8::from(is_one(*status)));
        }
        sum(&column, data.open(number));
        data.columns[number].iter_mut().for_each(|count| *count *= unit);
    };
    for (status, number) in STATUSES.into_iter().zip(data::STATUS..) {
        // no early way out: many are compared at once
        if tile.status.iter().fold(false, |any, other| any | (*other == status)) {
            count_those(number, share, &|other| other == status);
        }
    }
    if tile.status.iter().fold(false, |any, status| any | is_traced(*status)) {
        count_those(data::RAYS, 1.0, &is_traced);
    }
    for (number, counts) in (data::RAYS + 1..).zip([&rays.verification, &rays.shadow, &rays.secondary]) {
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
        let mut filtering = Filtering::default();
        let of_pixel = |pixel: usize| &grid.cells_of_pixels[pixel * 4..][..4];
        // all in the centres of their cells, but for the third of pixel 18
        for cell in 0..CELLS {
            filtering.x[cell] = grid.place_x[cell] + 0.5;
            filtering.y[cell] = grid.place_y[cell] + 0.5;
        }
        filtering.x[usize::from(of_pixel(18)[2])] += 0.2;
        choose_nearest(&grid, &mut filtering);
        assert_eq!(filtering.nearest.len(), 16 * 16);
        for (pixel, nearest) in filtering.nearest.iter().enumerate() {
            assert_eq!(*nearest, of_pixel(pixel)[if pixel == 18 { 2 } else { 0 }], "{pixel}");
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
