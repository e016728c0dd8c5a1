//! From the sums of tiles to the planes of a finished frame.
//!
//! Rows of pixels are written as soon as all tiles that reach them are summed, while the sums are still in
//! the cache. Each pixel's sums are added in the order of the tiles.

use std::ops::Range;

use rayon::prelude::*;

use super::filter::{TileFilm, data, halo, sums};
use super::grid::Grid;
use crate::film::{Film, Plane, PlaneKind};
use crate::layers::Layers;
use crate::settings::{Filter, Settings};

/// Where a plane's value comes from.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// These sums together, over the sum of weights.
    Filtered(&'static [usize]),
    /// This datum.
    Data(usize),
}

/// A plane: name, kind, and where the value comes from.
type Channel = (&'static str, PlaneKind, Source);

/// The contract's planes.
const CHANNELS: [Channel; 37] = {
    use PlaneKind::{Float, Half};
    use Source::{Data, Filtered};
    use data::{AGE, ID, NORMAL, POSITION, RAYS, STATUS, Z};
    use sums::{ALBEDO, ALPHA, DIFFUSE, REFLECTION, REFRACTION, SPECULAR};
    [
        ("R", Half, Filtered(&[DIFFUSE, SPECULAR, REFLECTION, REFRACTION])),
        ("G", Half, Filtered(&[DIFFUSE + 1, SPECULAR + 1, REFLECTION + 1, REFRACTION + 1])),
        ("B", Half, Filtered(&[DIFFUSE + 2, SPECULAR + 2, REFLECTION + 2, REFRACTION + 2])),
        ("A", Half, Filtered(&[ALPHA])),
        ("diffuse.R", Half, Filtered(&[DIFFUSE])),
        ("diffuse.G", Half, Filtered(&[DIFFUSE + 1])),
        ("diffuse.B", Half, Filtered(&[DIFFUSE + 2])),
        ("specular.R", Half, Filtered(&[SPECULAR])),
        ("specular.G", Half, Filtered(&[SPECULAR + 1])),
        ("specular.B", Half, Filtered(&[SPECULAR + 2])),
        ("reflection.R", Half, Filtered(&[REFLECTION])),
        ("reflection.G", Half, Filtered(&[REFLECTION + 1])),
        ("reflection.B", Half, Filtered(&[REFLECTION + 2])),
        ("refraction.R", Half, Filtered(&[REFRACTION])),
        ("refraction.G", Half, Filtered(&[REFRACTION + 1])),
        ("refraction.B", Half, Filtered(&[REFRACTION + 2])),
        ("albedo.R", Half, Filtered(&[ALBEDO])),
        ("albedo.G", Half, Filtered(&[ALBEDO + 1])),
        ("albedo.B", Half, Filtered(&[ALBEDO + 2])),
        ("Z", Float, Data(Z)),
        ("P.X", Float, Data(POSITION)),
        ("P.Y", Float, Data(POSITION + 1)),
        ("P.Z", Float, Data(POSITION + 2)),
        ("N.X", Half, Data(NORMAL)),
        ("N.Y", Half, Data(NORMAL + 1)),
        ("N.Z", Half, Data(NORMAL + 2)),
        ("id.object", Float, Data(ID)),
        ("status.age", Half, Data(AGE)),
        ("status.base", Half, Data(STATUS)),
        ("status.good", Half, Data(STATUS + 1)),
        ("status.overlapped", Half, Data(STATUS + 2)),
        ("status.missed", Half, Data(STATUS + 3)),
        ("status.obscured", Half, Data(STATUS + 4)),
        ("rays.primary", Half, Data(RAYS)),
        ("rays.verification", Half, Data(RAYS + 1)),
        ("rays.shadow", Half, Data(RAYS + 2)),
        ("rays.secondary", Half, Data(RAYS + 3)),
    ]
};

/// Those of `layers`.
fn channels(layers: Layers) -> impl Iterator<Item = Channel> {
    CHANNELS.into_iter().filter(move |(name, ..)| layers.has_plane(name))
}

/// An undeveloped frame, to be written over `used` where that is of the same size. What a plane holds is
/// known only where it says that it is zero.
pub fn blank(grid: &Grid, layers: Layers, used: Option<Film>) -> Film {
    let (width, height) = (grid.width, grid.height);
    let names = || channels(layers).map(|(name, ..)| name);
    let fits = |film: &Film| {
        (film.width, film.height) == (width, height) && names().eq(film.planes.iter().map(|plane| plane.name))
    };
    if let Some(film) = used.filter(fits) {
        return film;
    }
    let plane = || vec![0.0; width as usize * height as usize];
    let planes = channels(layers).map(|(name, kind, _)| Plane { name, kind, data: plane(), is_zero: true });
    Film { width, height, planes: planes.collect(), stamp: 0 }
}

/// Writes the rows of a film from top to bottom, band by band of tiles.
#[derive(Debug)]
pub struct Developer {
    filter: Filter,
    /// Of the film's planes.
    channels: Vec<Channel>,
    /// Samples of a pixel.
    samples: usize,
    /// The first row of filtered planes that is not written yet.
    next: u32,
    /// For each plane, whether it was zero throughout before this frame.
    was_zero: Vec<bool>,
}

impl Developer {
    /// Begins with the top row of `film`.
    pub fn new(grid: &Grid, settings: &Settings, film: &mut Film) -> Self {
        let was_zero = film.planes.iter().map(|plane| plane.is_zero).collect();
        film.planes.iter_mut().for_each(|plane| plane.is_zero = true);
        let channels = channels(settings.layers).collect();
        Self { filter: settings.filter, channels, samples: grid.samples_of_pixel(), next: 0, was_zero }
    }

    /// Writes into `film` what the tiles of band `now` complete; `before` is the band above it, and the
    /// tiles of the next band begin with row `end` (the picture's height, if there is none).
    pub fn develop(&mut self, film: &mut Film, before: &[TileFilm], now: &[TileFilm], end: u32) {
        let (width, height) = (film.width as usize, film.height);
        let reached = if end < height { end - halo(self.filter) } else { height };
        let rows = self.next..reached.max(self.next);
        self.next = rows.end;
        let bands = [before, now];
        let scales = Scales::of(self, bands, rows.clone(), width);
        let planes = film.planes.par_iter_mut().zip(&self.channels).zip(&self.was_zero);
        planes.for_each(|((plane, (name, _, source)), was_zero)| match *source {
            Source::Data(number) => {
                let is_zero =
                    now.iter().all(|tile| !tile.has_data(number) && (*was_zero || !tile.is_shown()));
                plane.is_zero &= is_zero;
                if !is_zero || !was_zero {
                    write_data(number, now, &mut plane.data, width);
                }
            }
            Source::Filtered(sums) => {
                let is_zero = bands
                    .into_iter()
                    .flatten()
                    .all(|tile| !tile.has_sums(sums) && (*was_zero || !tile.is_shown()));
                plane.is_zero &= is_zero;
                if is_zero && *was_zero {
                    return;
                }
                match &scales {
                    Scales::All(scale) => write_sums(sums, now, &mut plane.data, width, *scale),
                    Scales::Each(scales) => {
                        let out = &mut plane.data[rows.start as usize * width..rows.end as usize * width];
                        out.fill(0.0);
                        for (y, out) in rows.clone().zip(out.chunks_mut(width)) {
                            add_up(sums, bands, y, out);
                        }
                        scale_sums(out, scales, if *name == "A" { 1.0 } else { f32::INFINITY });
                    }
                }
            }
        });
    }
}

/// One over the sum of the weights.
enum Scales {
    /// Of every pixel.
    All(f32),
    /// Of each pixel of some rows.
    Each(Vec<f32>),
}

impl Scales {
    fn of(developer: &Developer, bands: [&[TileFilm]; 2], rows: Range<u32>, width: usize) -> Self {
        if developer.filter == Filter::Box {
            return Self::All((developer.samples as f32).recip());
        }
        let mut weights = vec![0.0; rows.len() * width];
        weights.par_chunks_mut(width).zip(rows.into_par_iter()).for_each(|(out, y)| {
            add_up(&[sums::WEIGHT], bands, y, out);
            out.iter_mut().for_each(|weight| *weight = weight.recip());
        });
        Self::Each(weights)
    }
}

/// The Mitchell filter's negative lobes must make neither negative light nor more than all cover.
fn scale_sums(sums: &mut [f32], scales: &[f32], most: f32) {
    for (sum, scale) in sums.iter_mut().zip(scales) {
        *sum = (*sum * scale).max(0.0).min(most);
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

/// Writes the sums of tiles that share no pixel, added up and scaled.
fn write_sums(planes: &[usize], tiles: &[TileFilm], out: &mut [f32], width: usize, scale: f32) {
    for tile in tiles.iter().filter(|tile| !tile.is_shown()) {
        let [columns, rows] = tile.pixels();
        let some: Vec<&[f32]> = planes
            .iter()
            .filter(|plane| tile.has_sums(&[**plane]))
            .map(|plane| tile.own_sums(*plane))
            .collect();
        for (row, y) in rows.enumerate() {
            let out = &mut out[y * width..][columns.clone()];
            let in_row =
                |sums: &'_ [f32]| row * tile.stride()..row * tile.stride() + columns.len().min(sums.len());
            match some.as_slice() {
                [] => out.fill(0.0),
                [first, others @ ..] => {
                    for (out, sum) in out.iter_mut().zip(&first[in_row(first)]) {
                        *out = sum * scale;
                    }
                    for sums in others {
                        for (out, sum) in out.iter_mut().zip(&sums[in_row(sums)]) {
                            *out += sum * scale;
                        }
                    }
                }
            }
        }
    }
}

/// Writes a datum of each pixel. Where the film shows the tile already, only its age has changed.
fn write_data(number: usize, tiles: &[TileFilm], out: &mut [f32], width: usize) {
    const OLDEST: f32 = u16::MAX as f32;
    for tile in tiles {
        let [columns, rows] = tile.pixels();
        for (row, y) in rows.enumerate() {
            let out = &mut out[y * width..][columns.clone()];
            if tile.is_shown() {
                if number == data::AGE {
                    out.iter_mut().for_each(|age| *age = (*age + 1.0).min(OLDEST));
                }
            } else if tile.has_data(number) {
                out.copy_from_slice(&tile.data_row(number, row)[..columns.len()]);
            } else {
                out.fill(0.0);
            }
        }
    }
}
