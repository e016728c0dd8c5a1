//! Filtering: samples to pixels (the paper's "Filtering").
//!
//! Each tile writes its own pixels into its [`Window`] of the film. Where the filter is wider than a pixel,
//! colours stay sums in a [`TileFilm`], halo included: [`develop`](super::develop) adds up what neighbours have
//! for each pixel, in the tiles' order, so that the picture does not depend on who was done first.
//!
//! Colours are filtered; what is never mixed is in [`pixels`](super::pixels).

use std::ops::Range;

use glam::Vec4;
use half::f16;

use super::channels::{Channel, Picture, Source, Written, data, sums};
use super::enhance::{Light, Radiance};
use super::grid::Grid;
use super::pixels::{Planes, choose_nearest, count, reduce, take_data};
use super::stage::{Stage, Workbench};
use super::trace_missed::is_traced;
use super::window::Window;
use crate::lanes::{LANES, Lanes, Lanes3, Mask};
use crate::layers::Layers;
use crate::samples::{CELLS, Column, EMPTY, Tile, load_colors};
use crate::settings::Filter;

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
    /// On the way to the film.
    halves: Column<f16>,
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
            halves: [f16::ZERO; CELLS],
        }
    }
}

/// Makes pixels of the samples of tile number `number`, and writes what is finished into its `window` and what is
/// not into `film`. Says which channels hold anything.
pub fn filter(
    stage: &Stage,
    number: usize,
    tile: &Tile,
    bench: &mut Workbench,
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
    if picture.filter != Filter::Box || shows_samples && grid.samples > 1 {
        locate(stage, number, tile, filtering);
    }
    if picture.filter != Filter::Box {
        film.begin(grid, number, picture.filter);
    }
    sum_colors(stage, tile, radiance, picture.filter, filtering, film);
    let Filtering { x, y, nearest, data, .. } = &mut **filtering;
    if shows_samples {
        choose_nearest(grid, [x, y], nearest);
        take_data(stage, tile, placed, nearest, data);
    }
    if stage.layers.has(Layers::STATUS) || stage.layers.has(Layers::RAYS) {
        count(grid, tile, cell_rays, data);
    }
    finish(grid, number, picture, filtering, window)
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
    filtering: &mut Filtering,
    window: &mut Window,
) -> Written {
    let Filtering { sums, data, halves, .. } = filtering;
    let scale = (grid.samples_of_pixel() as f32).recip();
    let stride = grid.tile_pixels as usize;
    let pixels = grid.pixels(number).map(|range| range.start as usize..range.end as usize);
    let mut written = Written::default();
    let mut scaled = [0.0; CELLS];
    for (number, (channel, was_zero)) in picture.channels.iter().zip(&picture.was_zero).enumerate() {
        let values = match channel.source {
            Source::Data(number) => data.is_some[number].then(|| &data.columns[number]),
            Source::Filtered(_) if picture.filter != Filter::Box => continue,
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
                window.put(number, &pixels, values, stride, halves);
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

#[cfg(test)]
mod tests {
    use super::*;

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
