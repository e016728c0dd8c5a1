//! From the sums of tiles to the planes of a finished frame.
//!
//! Rows of pixels are written as soon as all tiles that reach them are summed, so that the sums are still in
//! the cache. Each pixel's sums are added in the order of the tiles.

use glam::Vec4;
use rayon::prelude::*;

use super::filter::{Counts, Data, NO_DATA, Sums, TileFilm};
use super::view::View;
use crate::film::{Film, Plane, PlaneKind};

/// The contract's planes: name, kind, and where the value comes from.
const CHANNELS: [(&str, PlaneKind, Source); 37] = {
    use PlaneKind::{Float, Half};
    use Source::{Filtered, Nearest, Rays, Share};
    [
        ("R", Half, Filtered(0, 0)),
        ("G", Half, Filtered(0, 1)),
        ("B", Half, Filtered(0, 2)),
        ("A", Half, Filtered(0, 3)),
        ("diffuse.R", Half, Filtered(1, 0)),
        ("diffuse.G", Half, Filtered(1, 1)),
        ("diffuse.B", Half, Filtered(1, 2)),
        ("specular.R", Half, Filtered(3, 0)),
        ("specular.G", Half, Filtered(3, 1)),
        ("specular.B", Half, Filtered(3, 2)),
        ("reflection.R", Half, Filtered(4, 0)),
        ("reflection.G", Half, Filtered(4, 1)),
        ("reflection.B", Half, Filtered(4, 2)),
        ("refraction.R", Half, Filtered(5, 0)),
        ("refraction.G", Half, Filtered(5, 1)),
        ("refraction.B", Half, Filtered(5, 2)),
        ("albedo.R", Half, Filtered(2, 0)),
        ("albedo.G", Half, Filtered(2, 1)),
        ("albedo.B", Half, Filtered(2, 2)),
        ("Z", Float, Nearest(0)),
        ("P.X", Float, Nearest(1)),
        ("P.Y", Float, Nearest(2)),
        ("P.Z", Float, Nearest(3)),
        ("N.X", Half, Nearest(4)),
        ("N.Y", Half, Nearest(5)),
        ("N.Z", Half, Nearest(6)),
        ("id.object", Float, Nearest(7)),
        ("status.age", Half, Nearest(8)),
        ("status.base", Half, Share(0)),
        ("status.good", Half, Share(1)),
        ("status.overlapped", Half, Share(2)),
        ("status.missed", Half, Share(3)),
        ("status.obscured", Half, Share(4)),
        ("rays.primary", Half, Rays(5)),
        ("rays.verification", Half, Rays(6)),
        ("rays.shadow", Half, Rays(7)),
        ("rays.secondary", Half, Rays(8)),
    ]
};

/// Where a plane's value comes from.
#[derive(Debug, Clone, Copy)]
enum Source {
    /// The sum in this row and place, over the sum of weights.
    Filtered(usize, usize),
    /// This value of the sample nearest to the centre.
    Nearest(usize),
    /// This count, over the pixel's samples.
    Share(usize),
    /// This count.
    Rays(usize),
}

/// An undeveloped frame, written over `used` where that is of the same size.
pub fn blank(view: &View, used: Option<Film>) -> Film {
    let (width, height) = (view.cells_x / view.samples, view.cells_y / view.samples);
    if let Some(film) = used.filter(|film| (film.width, film.height) == (width, height)) {
        return film;
    }
    let data = vec![0.0; (width * height) as usize];
    let planes = CHANNELS.iter().map(|&(name, kind, _)| Plane { name, kind, data: data.clone() });
    Film { width, height, planes: planes.collect() }
}

/// Writes the rows of a film from top to bottom.
pub struct Developer<'f> {
    /// For each row that is not written yet, its part of each plane.
    rows: std::vec::IntoIter<Vec<&'f mut [f32]>>,
    width: usize,
    next: i32,
}

impl<'f> Developer<'f> {
    /// Begins with the top row of `film`, which is [blank](blank).
    pub fn new(film: &'f mut Film) -> Self {
        let (width, height) = (film.width as usize, film.height as usize);
        let mut rows: Vec<Vec<&mut [f32]>> = Vec::with_capacity(height);
        rows.resize_with(height, || Vec::with_capacity(CHANNELS.len()));
        for plane in &mut film.planes {
            for (row, part) in rows.iter_mut().zip(plane.data.chunks_mut(width)) {
                row.push(part);
            }
        }
        Self { rows: rows.into_iter(), width, next: 0 }
    }

    /// Writes the rows above row `end`. `bands` hold all tiles that reach these rows, in their order.
    pub fn develop_until(&mut self, end: i32, bands: [&[TileFilm]; 2]) {
        let first = self.next;
        self.next = end.max(first);
        let rows: Vec<_> = self.rows.by_ref().take((self.next - first) as usize).collect();
        let width = self.width;
        rows.into_par_iter().enumerate().with_min_len(4).for_each_init(
            || Row::new(width),
            |row, (i, planes)| {
                row.add_up(bands, first + i as i32);
                row.write(planes);
            },
        );
    }
}

/// One row of pixels while it is added up.
struct Row {
    sums: Vec<Sums>,
    data: Vec<Data>,
    counts: Vec<Counts>,
}

impl Row {
    fn new(width: usize) -> Self {
        Self { sums: vec![[Vec4::ZERO; 6]; width], data: vec![NO_DATA; width], counts: vec![[0; 9]; width] }
    }

    /// Adds up what the tiles have for row `y`, in the tiles' order.
    fn add_up(&mut self, bands: [&[TileFilm]; 2], y: i32) {
        self.sums.fill([Vec4::ZERO; 6]);
        self.data.fill(NO_DATA);
        self.counts.fill([0; 9]);
        for tile in bands.into_iter().flatten() {
            self.add_tile(tile, y);
        }
    }

    fn add_tile(&mut self, tile: &TileFilm, y: i32) {
        let Some((first, indices)) = tile.row(y) else { return };
        for (x, index) in (first..).zip(indices) {
            let Some(x) = usize::try_from(x).ok().filter(|x| *x < self.sums.len()) else { continue };
            for (sum, more) in self.sums[x].iter_mut().zip(&tile.sums[index]) {
                *sum += *more;
            }
            if tile.data[index].distance < self.data[x].distance {
                self.data[x] = tile.data[index];
            }
            for (sum, count) in self.counts[x].iter_mut().zip(&tile.counts[index]) {
                *sum += count;
            }
        }
    }

    /// Writes the row into the row of each plane.
    fn write(&mut self, planes: Vec<&mut [f32]>) {
        for sums in &mut self.sums {
            let scale = sums[1].w.recip();
            // the Mitchell filter's negative lobes must make neither negative light nor more than all cover
            *sums = sums.map(|sum| (sum * scale).max(Vec4::ZERO));
            sums[0].w = sums[0].w.min(1.0);
        }
        for ((_, _, source), plane) in CHANNELS.iter().zip(planes) {
            match *source {
                Source::Filtered(row, place) => {
                    fill(plane, &self.sums, |sums| sums[row].to_array()[place]);
                }
                Source::Nearest(i) => fill(plane, &self.data, |data| data.values[i]),
                Source::Rays(i) => fill(plane, &self.counts, |counts| counts[i] as f32),
                Source::Share(i) => fill(plane, &self.counts, |counts| {
                    counts[i] as f32 / counts[..5].iter().sum::<u32>() as f32
                }),
            }
        }
    }
}

fn fill<T>(plane: &mut [f32], pixels: &[T], value: impl Fn(&T) -> f32) {
    for (out, pixel) in plane.iter_mut().zip(pixels) {
        *out = value(pixel);
    }
}
