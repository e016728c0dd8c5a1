//! Filtering: samples to pixels (the paper's "Filtering").
//!
//! Each tile is summed by itself into a [`TileFilm`], halo included; [`develop`](super::develop) then adds
//! the tiles up in their order, so that the picture does not depend on who was done first.
//!
//! Colours are filtered. Data (distance, position, normal, id, age) is never mixed: a pixel shows those of
//! its sample nearest to its centre. Status and rays are counts over the pixel's own samples.

use glam::{Vec3, Vec4};

use super::enhance::Radiance;
use super::stage::{CellRays, Stage, Workbench};
use super::view::{View, cell_place};
use crate::samples::{BACKGROUND, EMPTY, Status, TILE, Tile, from_half};
use crate::settings::Filter;

/// `Z` of the background: finite, and far behind everything.
pub const BACKGROUND_Z: f32 = 1e10;

/// A pixel's sums, in rows of four floats that are added in one step.
///
/// Rows 0 to 2: picture and alpha; diffuse light and the sum of the weights; albedo. Rows 3 to 5: highlight,
/// reflection, refraction, which most samples do not have.
pub type Sums = [Vec4; 6];

/// Rows of [`Sums`] that every sample has.
const ALWAYS: usize = 3;

/// What a pixel shows of its sample nearest to the centre.
#[derive(Debug, Clone, Copy)]
pub struct Data {
    /// From the pixel's centre: squared, [`NEARNESS`] steps a pixel.
    pub distance: f32,
    /// Of the sample, in its tile.
    cell: u32,
    /// Z, P, N, id, age.
    pub values: [f32; 9],
}

/// Steps in which the distance from a pixel's centre is told.
const NEARNESS: f32 = 1024.0;

/// Light beyond this is cut, so that no sum of samples is infinite. Half floats end at 65504.
const MOST_LIGHT: f32 = 1e30;

/// No sample.
pub const NO_DATA: Data = Data { distance: f32::INFINITY, cell: 0, values: [0.0; 9] };

/// Samples by status (base, good, overlapped, missed, obscured), and rays by kind.
pub type Counts = [u32; 9];

/// The pixels that one tile's samples reach. Keeps its memory from frame to frame.
#[derive(Debug, Default)]
pub struct TileFilm {
    /// Of the first pixel; left of and above the picture for the halo of tiles at its rim.
    corner: [i32; 2],
    size: [usize; 2],
    /// One a pixel, in rows.
    pub sums: Vec<Sums>,
    /// One a pixel, in rows.
    pub data: Vec<Data>,
    /// One a pixel, in rows.
    pub counts: Vec<Counts>,
}

impl TileFilm {
    fn begin(&mut self, view: &View, number: usize, filter: Filter) {
        let (cells, halo) = (view.tile_corner(number), radius(filter).ceil() as i32);
        let edge = |cell: u32| (cell / view.samples) as i32;
        let last = |cell: u32, of: u32| (cell + TILE as u32).min(of).div_ceil(view.samples) as i32;
        let first = cells.map(|cell| edge(cell) - halo);
        let end = [last(cells[0], view.cells_x) + halo, last(cells[1], view.cells_y) + halo];
        self.corner = first;
        self.size = [(end[0] - first[0]) as usize, (end[1] - first[1]) as usize];
        let pixels = self.size[0] * self.size[1];
        refill(&mut self.sums, pixels, [Vec4::ZERO; 6]);
        refill(&mut self.data, pixels, NO_DATA);
        refill(&mut self.counts, pixels, [0; 9]);
    }

    fn at(&self, x: i32, y: i32) -> usize {
        (y - self.corner[1]) as usize * self.size[0] + (x - self.corner[0]) as usize
    }

    /// The part of row `y` of the picture that this tile reaches: first column and indices.
    pub fn row(&self, y: i32) -> Option<(i32, std::ops::Range<usize>)> {
        let row = usize::try_from(y - self.corner[1]).ok().filter(|row| *row < self.size[1])?;
        Some((self.corner[0], row * self.size[0]..(row + 1) * self.size[0]))
    }
}

fn refill<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    list.clear();
    list.resize(len, value);
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
    film.begin(stage.view, number, kernel);
    let corner = stage.view.tile_corner(number);
    let scale = (stage.view.samples as f32).recip();
    for (cell, (hot, cold)) in tile.hot.iter().zip(&tile.cold).enumerate() {
        if hot.model == EMPTY {
            continue;
        }
        let place = cell_place(cell);
        let place = [corner[0] + place[0], corner[1] + place[1]];
        // a sample's own cell holds it; rounding on the way back may say the next one
        let seen = stage.view.project(stage.offset(hot));
        let inside = |at: f32, cell: u32| at.clamp(cell as f32, (cell + 1) as f32) * scale;
        let (x, y) = seen.map_or((f32::MAX, f32::MAX), |seen| (seen.x, seen.y));
        let at = [inside(x, place[0]), inside(y, place[1])];
        let pixel = [(place[0] / stage.view.samples) as i32, (place[1] / stage.view.samples) as i32];
        let index = film.at(pixel[0], pixel[1]);

        let (values, rows) = channels(&bench.radiance[cell], hot.model != BACKGROUND, from_half(cold.albedo));
        match kernel {
            Filter::Box => add(&mut film.sums[index], &values, rows, 1.0),
            Filter::Mitchell => splat(film, at, &values, rows),
        }
        count(&mut film.counts[index], cold.status, bench.cell_rays[cell]);
        let aside = |axis: usize| at[axis] - pixel[axis] as f32 - 0.5;
        // in steps: of samples that are equally near but for rounding the first is shown
        let distance = ((aside(0).powi(2) + aside(1).powi(2)) * NEARNESS).round();
        if distance < film.data[index].distance {
            let depth = seen.map_or(BACKGROUND_Z, |seen| seen.depth);
            let mut values = NO_DATA.values;
            values[0] = depth;
            film.data[index] = Data { distance, cell: cell as u32, values };
        }
    }
    for shown in film.data.iter_mut().filter(|shown| shown.distance < f32::INFINITY) {
        shown.values = data(stage, tile, shown.cell as usize, shown.values[0], bench);
    }
}

/// What is filtered of a sample, and how many rows of it are not zero.
#[inline]
fn channels(radiance: &Radiance, surface: bool, albedo: Vec3) -> (Sums, usize) {
    let cut = |light: Vec3| light.max(Vec3::ZERO).min(Vec3::splat(MOST_LIGHT));
    let [diffuse, specular] = [cut(radiance.diffuse), cut(radiance.specular)];
    let [reflection, refraction] = [cut(radiance.reflection), cut(radiance.refraction)];
    let (alpha, albedo) = if surface { (1.0, albedo) } else { (0.0, Vec3::ZERO) };
    let sums = [
        (diffuse + specular + reflection + refraction).extend(alpha),
        diffuse.extend(1.0),
        albedo.extend(0.0),
        specular.extend(0.0),
        reflection.extend(0.0),
        refraction.extend(0.0),
    ];
    let plain = specular == Vec3::ZERO && reflection == Vec3::ZERO && refraction == Vec3::ZERO;
    (sums, if plain { ALWAYS } else { sums.len() })
}

#[inline]
fn add(sums: &mut Sums, values: &Sums, rows: usize, weight: f32) {
    for (sum, value) in sums[..ALWAYS].iter_mut().zip(&values[..ALWAYS]) {
        *sum += *value * weight;
    }
    if rows > ALWAYS {
        for (sum, value) in sums[ALWAYS..].iter_mut().zip(&values[ALWAYS..]) {
            *sum += *value * weight;
        }
    }
}

/// Adds a sample at `at` (pixels) to all pixels that the Mitchell filter spreads it over.
fn splat(film: &mut TileFilm, at: [f32; 2], values: &Sums, rows: usize) {
    // the centres of pixels first .. first + 3 are within two pixels
    let first = [(at[0] - 1.5).floor(), (at[1] - 1.5).floor()];
    let [across, down] = [0, 1].map(|axis| mitchell(at[axis] - 1.5 - first[axis]));
    for (row, down) in (0..).zip(down) {
        let start = film.at(first[0] as i32, first[1] as i32 + row);
        for (sums, across) in film.sums[start..start + 4].iter_mut().zip(&across) {
            add(sums, values, rows, across * down);
        }
    }
}

/// First row of pixels that tile number `number` or a later one reaches; `None` where there is none.
pub fn first_row_of(view: &View, number: usize, filter: Filter) -> Option<i32> {
    let cell = view.tile_corner(number)[1];
    (number < view.tiles()).then(|| (cell / view.samples) as i32 - radius(filter).ceil() as i32)
}

/// How far a filter reaches, in pixels, beyond a sample's own pixel.
pub fn radius(filter: Filter) -> f32 {
    match filter {
        Filter::Box => 0.0,
        Filter::Mitchell => 2.0,
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

#[inline]
fn count(counts: &mut Counts, status: Status, rays: CellRays) {
    let status = match status {
        Status::Base => 0,
        Status::Good => 1,
        Status::Overlapped => 2,
        Status::Missed => 3,
        Status::Obscured => 4,
        Status::Outside | Status::Empty => return,
    };
    counts[status] += 1;
    for (count, rays) in
        counts[5..].iter_mut().zip([rays.primary, rays.verification, rays.shadow, rays.secondary])
    {
        *count += u32::from(rays);
    }
}

/// The data channels of a sample, seen at `depth`.
fn data(stage: &Stage, tile: &Tile, cell: usize, depth: f32, bench: &mut Workbench) -> [f32; 9] {
    let (hot, cold) = (&tile.hot[cell], &tile.cold[cell]);
    let age = f32::from(cold.age);
    if hot.model == BACKGROUND {
        return [BACKGROUND_Z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, age];
    }
    let placed = bench.placed.get(stage, tile, cell);
    let (p, n) = (placed.point, placed.normal);
    [depth, p.x, p.y, p.z, n.x, n.y, n.z, (hot.model + 1) as f32, age]
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
