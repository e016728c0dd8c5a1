//! A film to write on; and, where a filter reaches across tiles, from the sums of tiles to its planes.
//!
//! Rows of pixels are written as soon as all tiles that reach them are done, while they are still in the
//! cache. Each pixel's sums are added in the order of the tiles.

use std::ops::Range;

use rayon::prelude::*;

use super::channels::{Channel, Picture, Source, channels, sums};
use super::filter::{TileFilm, halo};
use super::grid::Grid;
use crate::film::{Film, Plane, Values};
use crate::layers::Layers;
use crate::settings::Filter;

/// An undeveloped frame, to be written over `used` where that is of the same size. What a plane holds is
/// known only where it says that it is zero.
pub fn blank(grid: &Grid, layers: Layers, used: Option<Film>) -> Film {
    let (width, height) = (grid.width, grid.height);
    let names = || channels(layers).map(|channel| channel.name);
    let fits = |film: &Film| {
        (film.width, film.height) == (width, height) && names().eq(film.planes.iter().map(|plane| plane.name))
    };
    if let Some(film) = used.filter(fits) {
        return film;
    }
    let plane = |channel: Channel| {
        let values = channel.room(width as usize * height as usize);
        Plane { name: channel.name, kind: channel.kind, values, is_zero: true }
    };
    let planes = channels(layers).map(plane);
    Film { width, height, planes: planes.collect(), stamp: 0 }
}

/// Writes what reaches across tiles: rows of a film from top to bottom, band by band of tiles.
#[derive(Debug)]
pub struct Developer {
    filter: Filter,
    /// The first row that is not written yet.
    next: u32,
}

impl Developer {
    /// Begins with the top row.
    pub fn new(filter: Filter) -> Self {
        Self { filter, next: 0 }
    }

    /// Writes into `film` what the tiles of band `now` complete; `before` is the band above it, and the
    /// tiles of the next band begin with row `end` (the picture's height, if there is none).
    pub fn develop(
        &mut self,
        film: &mut Film,
        picture: &Picture,
        before: &[TileFilm],
        now: &[TileFilm],
        end: u32,
    ) {
        let (width, height) = (film.width as usize, film.height);
        let reached = if end < height { end - halo(self.filter) } else { height };
        let rows = self.next..reached.max(self.next);
        self.next = rows.end;
        let bands = [before, now];
        let scales = scales(bands, rows.clone(), width);
        let planes = film.planes.par_iter_mut().zip(&picture.channels).zip(&picture.was_zero);
        planes.for_each(|((plane, channel), was_zero)| {
            let Source::Filtered(sums) = channel.source else { return };
            let is_zero = bands.into_iter().flatten().all(|tile| !tile.has_sums(sums));
            plane.is_zero &= is_zero;
            if !is_zero || !was_zero {
                let most = if channel.name == "A" { 1.0 } else { f32::INFINITY };
                write_sums(sums, bands, rows.clone(), &scales, most, &mut plane.values, width);
            }
        });
    }
}

/// One over the sum of the weights of each pixel of some rows.
fn scales(bands: [&[TileFilm]; 2], rows: Range<u32>, width: usize) -> Vec<f32> {
    let mut weights = vec![0.0; rows.len() * width];
    weights.par_chunks_mut(width).zip(rows.into_par_iter()).for_each(|(out, y)| {
        add_up(&[sums::WEIGHT], bands, y, out);
        out.iter_mut().for_each(|weight| *weight = weight.recip());
    });
    weights
}

/// Writes the sums of tiles that share pixels, added up and scaled.
///
/// The Mitchell filter's negative lobes must make neither negative light nor more than `most`.
fn write_sums(
    sums: &[usize],
    bands: [&[TileFilm]; 2],
    rows: Range<u32>,
    scales: &[f32],
    most: f32,
    out: &mut Values,
    width: usize,
) {
    let mut row = vec![0.0; width];
    for (y, scales) in rows.zip(scales.chunks(width)) {
        row.fill(0.0);
        add_up(sums, bands, y, &mut row);
        for (sum, scale) in row.iter_mut().zip(scales) {
            *sum = (*sum * scale).max(0.0).min(most);
        }
        out.put(y as usize * width, &row);
    }
}

/// Adds to row `y` of the picture what the tiles have for it in `planes`, in the tiles' order.
fn add_up(planes: &[usize], bands: [&[TileFilm]; 2], y: u32, out: &mut [f32]) {
    for tile in bands.into_iter().flatten() {
        for plane in planes {
            let Some((first, sums)) = tile.sums_in_row(*plane, y, out.len()) else { continue };
            for (out, sum) in out[first..].iter_mut().zip(sums) {
                *out += sum;
            }
        }
    }
}
