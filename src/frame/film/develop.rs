//! Blank films; and, where a filter reaches across tiles, the step from the sums of tiles to planes.
//!
//! Rows of pixels are written as soon as all tiles that reach them are done, while their sums are still in
//! the cache. Each pixel's sums are added in the order of the tiles, so that the picture does not depend on
//! the order in which threads finish them.

use std::ops::Range;

use rayon::prelude::*;

use super::mattes::MattePlanes;
use super::spread::{GROUPS, TileFilm};
use crate::cryptomatte::Kind;
use crate::film::{Film, Plane};
use crate::frame::grid::Grid;
use crate::frame::planes::channels::{
    Channel, MATTE_PLANES, NonZeroPlanes, Picture, PlaneSource, matte_planes, sums,
};
use crate::frame::planes::kernel::MOST_TAPS;
use crate::frame::planes::window::{Window, cut};
use crate::lanes::{F32x8, LANES};

/// Creates an undeveloped frame with these channels.
pub fn blank(grid: &Grid, channels: &[Channel]) -> Film {
    let [width, height] = grid.film;
    let plane = |channel: &Channel| {
        let values = channel.room(width as usize * height as usize);
        Plane { name: channel.name.clone(), kind: channel.kind, values, is_zero: true }
    };
    let planes = channels.iter().map(plane);
    Film { width, height, planes: planes.collect() }
}

/// Sums that the tiles of two adjacent bands add to their pixels. Of the band above, the last tiles are
/// looked up.
#[derive(Clone, Copy)]
pub struct Bands<'a> {
    /// Films of the tiles of the band above.
    pub before: &'a [TileFilm],
    /// Films of the tiles of the band at work.
    pub now: &'a [TileFilm],
    /// Number of the first tile of `now`.
    pub first: usize,
}

impl<'a> Bands<'a> {
    fn film(&self, tile: usize) -> &'a TileFilm {
        match tile.checked_sub(self.first) {
            Some(place) => &self.now[place],
            None => &self.before[self.before.len() + tile - self.first],
        }
    }
}

/// Tiles whose contribution to their pixels may differ from the frame before. Where only unchanged tiles
/// reach, the film is left as it is.
#[derive(Debug, Default)]
pub struct DirtyTiles {
    /// True for each tile whose contribution may differ.
    is_changed: Vec<bool>,
    /// True for each tile whose sums are needed, since it reaches a piece that is written.
    is_needed: Vec<bool>,
}

impl DirtyTiles {
    /// Resets to the state for a filter that does not reach across tiles: no sums are needed.
    pub fn clear(&mut self) {
        self.is_needed.clear();
    }

    /// Sets the state of all tiles, in their order, for a filter that reaches `halo` pixels beyond them. What a tile contributes of
    /// which `asks_beside` is true depends on what the tiles beside it show.
    pub fn set(
        &mut self,
        grid: &Grid,
        halo: u32,
        is_changed: impl Iterator<Item = bool>,
        asks_beside: impl Fn(usize) -> bool,
    ) {
        self.is_changed.clear();
        self.is_changed.extend(is_changed);
        self.is_needed.clone_from(&self.is_changed);
        let [columns, rows] = grid.tile_counts().map(|count| count as usize);
        for tile in (0..grid.tiles()).filter(|tile| !self.is_needed[*tile] && asks_beside(*tile)) {
            let [x, y] = grid.place_of_tile(tile);
            self.is_changed[tile] = x > 0 && self.is_needed[tile - 1]
                || y > 0 && self.is_needed[tile - columns]
                || x + 1 < columns && self.is_needed[tile + 1]
                || y + 1 < rows && self.is_needed[tile + columns];
        }
        self.is_needed.clone_from(&self.is_changed);
        // two tiles that reach the same piece have pixels no farther apart than this
        let apart = PIECE.map(|size| 2 * halo as i32 + size as i32 - 1);
        if !self.is_changed.contains(&false) {
            return;
        }
        let across = grid.tiles_x as usize;
        for tile in (0..grid.tiles()).filter(|tile| self.is_changed[*tile]) {
            let place = grid.place_of_tile(tile);
            let [columns, rows] = [0, 1].map(|axis| {
                let pixels = grid.axes[axis].tile(place[axis]);
                grid.axes[axis].tiles_between(pixels.start - apart[axis]..pixels.end + apart[axis], false)
            });
            for row in rows {
                self.is_needed[row * across + columns.start..row * across + columns.end].fill(true);
            }
        }
    }

    /// Returns true if the sums of tile number `tile` are needed.
    pub fn is_needed(&self, tile: usize) -> bool {
        self.is_needed.get(tile).is_some_and(|needed| *needed)
    }
}

/// Divides the rows of tiles into bands of at least `tiles` tiles. A band has more rows of pixels than any
/// filter reaches, so that two bands at most reach a row of pixels; only the last may have fewer.
pub fn bands(grid: &Grid, tiles: u32) -> Vec<Range<u32>> {
    // with the margin of a window that is shifted on either side
    const LEAST_PIXELS: usize = MOST_TAPS + 2;
    let rows = tiles.div_ceil(grid.tiles_x);
    let (mut bands, mut start, mut pixels) = (Vec::new(), 0, 0);
    for row in 0..grid.tiles_y {
        pixels += grid.axes[1].tile(row as usize).len();
        if row + 1 == grid.tiles_y || row + 1 - start >= rows && pixels >= LEAST_PIXELS {
            bands.push(start..row + 1);
            (start, pixels) = (row + 1, 0);
        }
    }
    bands
}

/// Writes the planes that are filtered across tiles: rows of a film from top to bottom, as bands of tiles are
/// done.
#[derive(Debug, Default)]
pub struct Developer {
    /// First row of the film that is not written yet.
    next: u32,
}

/// Columns and rows that are summed at once: their sums stay in the nearest caches.
const PIECE: [usize; 2] = [32, 8];

const PIXELS: usize = PIECE[0] * PIECE[1];

impl Developer {
    /// Writes into `film` the filtered planes of the rows that `bands` complete, except where the film
    /// already shows them. The tiles of the next band begin with row `end` of tiles. Returns the channels
    /// that hold anything.
    pub fn develop(
        &mut self,
        film: &mut Film,
        picture: &Picture,
        grid: &Grid,
        bands: Bands,
        dirty: &DirtyTiles,
        end: u32,
    ) -> NonZeroPlanes {
        let Some(halo) = picture.kernel.map(|kernel| kernel.halo()) else { return NonZeroPlanes::default() };
        let (axes, height) = (&grid.axes, film.height as i32);
        let reached = match axes[1].tile(end as usize - 1).end {
            _ if end == grid.tiles_y => height,
            next => (axes[1].in_film(next) - halo as i32).clamp(self.next as i32, height),
        };
        let rows = self.next as usize..reached as usize;
        self.next = reached as u32;
        let width = film.width as usize;
        let stands = |pixels: &[Range<usize>; 2]| {
            !tiles_that_reach(grid, halo, pixels).any(|tile| dirty.is_changed[tile])
        };
        // rows, and true where nothing is to be written
        let some_rows: Vec<(Range<usize>, bool)> = axes[1]
            .pieces(rows, PIECE[1])
            .into_iter()
            .map(|rows| (rows.clone(), stands(&[0..width, rows])))
            .collect();
        let is_wanted =
            |plane: usize, window: usize| !some_rows[window].1 && picture.channels[plane].is_filtered();
        let (first, ends) = (some_rows.iter().map(|(rows, _)| rows.start).take(1), some_rows.iter());
        let cuts: Vec<usize> = first.chain(ends.map(|(rows, _)| rows.end)).collect();
        let whole = [0, width];
        let windows = cut(&mut film.planes, &cuts, |_| &whole, is_wanted);
        let columns = axes[0].pieces(0..width, PIECE[0]);
        let write_rows = |(mut window, (rows, all_stands)): (Window, &(Range<usize>, bool))| {
            if *all_stands {
                return NonZeroPlanes::SHOWN;
            }
            columns.iter().fold(NonZeroPlanes::default(), |written, columns| {
                let pixels = [columns.clone(), rows.clone()];
                written.plus(match stands(&pixels) {
                    true => NonZeroPlanes::SHOWN,
                    false => write_piece(picture, grid, (bands, halo), &pixels, &mut window),
                })
            })
        };
        windows
            .into_par_iter()
            .zip(&some_rows)
            .map(write_rows)
            .reduce(NonZeroPlanes::default, NonZeroPlanes::plus)
    }
}

/// Lower limit of the total weight of a pixel's samples: a sixteenth of what one sample in the pixel's centre
/// contributes.
const LEAST_WEIGHT: f32 = 1.0 / 16.0;

/// Writes the filtered planes of the rectangle `pixels`.
fn write_piece(
    picture: &Picture,
    grid: &Grid,
    (bands, halo): (Bands, u32),
    pixels: &[Range<usize>; 2],
    window: &mut Window,
) -> NonZeroPlanes {
    // rows come from far memory; they are fetched while the sums are read. Which planes will be written is
    // known only then: most of those that were not zero
    let filtered = picture.channels.iter().zip(&picture.was_zero).enumerate();
    for (number, _) in filtered.filter(|(_, (channel, was_zero))| channel.is_filtered() && !**was_zero) {
        window.prefetch(number, pixels);
    }
    // few groups are shown
    let mut groups: [Vec<F32x8>; GROUPS] = Default::default();
    let mut is_some = [false; sums::COUNT];
    for tile in tiles_that_reach(grid, halo, pixels) {
        let film = bands.film(tile);
        film.for_each_run(grid, tile, pixels, |group, [x, y], run| {
            groups[group].resize(PIXELS, F32x8::ZERO);
            let start = (y - pixels[1].start) * PIECE[0] + x - pixels[0].start;
            for (sum, more) in groups[group][start..].iter_mut().zip(run) {
                *sum = *sum + *more;
            }
        });
        is_some.iter_mut().enumerate().for_each(|(plane, is_some)| *is_some |= film.has(&[plane]));
    }
    let column = |plane: usize| -> [f32; PIXELS] {
        let (group, lane) = (&groups[plane / LANES], plane % LANES);
        std::array::from_fn(|pixel| group[pixel].lane(lane))
    };
    // negative lobes of samples that lie unevenly could cancel nearly all of the weight
    let scales = column(sums::WEIGHT).map(|weight| weight.max(LEAST_WEIGHT).recip());
    let mattes = mattes_of_piece(picture, grid, (bands, halo), pixels, &scales);
    let mut written = NonZeroPlanes::default();
    for (number, (channel, was_zero)) in picture.channels.iter().zip(&picture.was_zero).enumerate() {
        let planes = match channel.source {
            PlaneSource::Filtered(planes) => planes,
            PlaneSource::Data(_) => continue,
            PlaneSource::Matte(plane) => {
                match mattes.get(plane).filter(|values| !values.is_empty()) {
                    Some(values) => {
                        written.note(number);
                        window.put(number, pixels, values, PIECE[0]);
                    }
                    None if *was_zero => {}
                    None => window.clear(number, pixels),
                }
                continue;
            }
        };
        let mut some = planes.iter().filter(|plane| is_some[**plane]);
        let Some(first) = some.next() else {
            if !was_zero {
                window.clear(number, pixels);
            }
            continue;
        };
        let mut values = column(*first);
        for plane in some {
            values.iter_mut().zip(column(*plane)).for_each(|(value, more)| *value += more);
        }
        let [least, most] = channel.limits(picture.brightest);
        for (value, scale) in values.iter_mut().zip(&scales) {
            *value = (*value * scale).max(least).min(most);
        }
        written.note(number);
        window.put(number, pixels, &values, PIECE[0]);
    }
    written
}

/// Planes of mattes of the rectangle `pixels`, by number; a plane that is zero throughout is empty. No planes
/// if no layer shows mattes.
fn mattes_of_piece(
    picture: &Picture,
    grid: &Grid,
    (bands, halo): (Bands, u32),
    pixels: &[Range<usize>; 2],
    scales: &[f32; PIXELS],
) -> Vec<Vec<f32>> {
    let shows = |kind: &Kind| {
        let first = PlaneSource::Matte(matte_planes(*kind).start);
        picture.channels.iter().any(|channel| channel.source == first)
    };
    let mut planes = Vec::new();
    for kind in Kind::ALL.into_iter().filter(shows) {
        planes.resize(MATTE_PLANES, Vec::new());
        let mut sums = MattePlanes::<PIXELS>::default();
        for tile in tiles_that_reach(grid, halo, pixels) {
            let corner = grid.corner_in_film(tile).map(|at| at as isize - halo as isize);
            sums.add(&bands.film(tile).mattes[kind as usize], corner, pixels, PIECE[0]);
        }
        let first = matte_planes(kind).start;
        sums.rank(scales, |pixel, ranked| {
            let ranked = (first..).step_by(2).zip(ranked).take_while(|(_, (_, share))| *share > 0.0);
            for (plane, (id, share)) in ranked {
                for (plane, value) in [(plane, id.as_float()), (plane + 1, *share)] {
                    planes[plane].resize(PIXELS, 0.0);
                    planes[plane][pixel] = value;
                }
            }
        });
    }
    planes
}

/// Numbers of the tiles whose samples reach any of these pixels of the film, in order. Pixels of the picture
/// take no samples from the overscan, so that they are the same with it as without.
fn tiles_that_reach(
    grid: &Grid,
    halo: u32,
    pixels: &[Range<usize>; 2],
) -> impl Iterator<Item = usize> + use<> {
    let of_picture = (0..2).all(|axis| grid.axes[axis].is_picture(&pixels[axis]));
    let [columns, rows] = [0, 1].map(|axis| grid.axes[axis].tiles_within(&pixels[axis], halo, of_picture));
    let across = grid.tiles_x as usize;
    rows.flat_map(move |row| columns.clone().map(move |column| row * across + column))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::film::reach::Spread;
    use crate::frame::film::reach::Weighing;
    use crate::frame::film::spread::spread;
    use crate::frame::grid::{holds, tests::settings};
    use crate::frame::planes::channels::channels;
    use crate::frame::planes::kernel::Kernel;
    use crate::layers::Layers;
    use crate::samples::{CELLS, EMPTY, TagLayout, Tile};
    use crate::scene::LightGroups;
    use crate::settings::{Filter, Settings};

    #[test]
    fn a_colour_and_a_ramp_come_out_as_they_are() {
        for (width, height, samples) in [(1, 1, 1), (1, 70, 1), (65, 33, 1), (65, 33, 3), (20, 11, 16)] {
            let settings = Settings {
                filter: Filter::Mitchell,
                layers: Layers::NONE,
                background: crate::settings::Backdrop::default(),
                ..settings(width, height, samples)
            };
            let grid = Grid::new(&settings);
            let kernel = Kernel::new(settings.filter, 2.0);
            let films = films(&grid, kernel.as_ref().expect("it is wide"));
            let mut dirty = DirtyTiles::default();
            dirty.set(&grid, 2, std::iter::repeat_n(true, grid.tiles()), |_| false);
            // in one band, and in bands of rows of tiles that hold eight pixels at least
            for least in [u32::MAX, 0] {
                let channels: Vec<Channel> = channels(settings.layers, &LightGroups::default()).collect();
                let mut film = blank(&grid, &channels);
                let picture = Picture::over(&film, kernel, &channels, glam::Vec3::ONE);
                let (mut developer, mut before) = (Developer::default(), 0..0);
                let mut written = NonZeroPlanes::default();
                for Range { start, end } in bands(&grid, least) {
                    let now = (start * grid.tiles_x) as usize..(end * grid.tiles_x) as usize;
                    let bands = Bands { before: &films[before], now: &films[now.clone()], first: now.start };
                    written = written.plus(developer.develop(&mut film, &picture, &grid, bands, &dirty, end));
                    before = now;
                }
                let values = |plane: usize| film.planes[plane].values.to_floats();
                let is_all = |plane: usize, wanted: f32| {
                    values(plane).iter().all(|value| (value - wanted).abs() <= wanted * 1e-3)
                };
                assert_eq!(film.planes.iter().map(|plane| &*plane.name).collect::<String>(), "RGBA");
                assert!(is_all(0, 0.75), "{width} x {height}, {samples}: {:?}", values(0));
                assert!(is_all(2, 0.0) && is_all(3, 1.0));
                // away from the rim, where pixels have samples on all sides: what one tile adds too little or
                // twice would pull neighbours towards its own side
                let ramp = values(1);
                for (y, x) in (2..height.max(2) - 2).flat_map(|y| (2..width.max(2) - 2).map(move |x| (y, x)))
                {
                    let (got, wanted) =
                        (ramp[(y * width + x) as usize], ramp_at(x as f32 + 0.5, y as f32 + 0.5));
                    assert!((got - wanted).abs() <= wanted * 1e-3, "{samples}: {x} {y}: {got}, not {wanted}");
                }
                assert!(written.is_zero(2, true) && !written.is_zero(0, true));
            }
        }
    }

    #[test]
    fn a_piece_that_is_written_has_the_sums_of_all_tiles_that_reach_it() {
        for samples in [1, 2, 3, 11] {
            let grid = Grid::new(&settings(300, 200, samples));
            let [tiles_x, tiles_y] = [grid.tiles_x, grid.tiles_y].map(|count| count as usize);
            let mut dirty = DirtyTiles::default();
            let changed = tiles_y / 2 * tiles_x + tiles_x / 2;
            dirty.set(&grid, 2, (0..grid.tiles()).map(|tile| tile == changed), |_| false);
            // pieces may begin in any row
            for (left, top) in
                (0..300).step_by(PIECE[0]).flat_map(|left| (0..200).map(move |top| (left, top)))
            {
                let pixels = [left..(left + PIECE[0]).min(300), top..(top + PIECE[1]).min(200)];
                let reach = || tiles_that_reach(&grid, 2, &pixels);
                if reach().any(|tile| tile == changed) {
                    assert!(reach().all(|tile| dirty.is_needed(tile)), "{samples}: {pixels:?}");
                }
            }
            let needed = (0..grid.tiles()).filter(|tile| dirty.is_needed(*tile)).count();
            assert!(needed < grid.tiles(), "{samples}: {needed}");
        }
    }

    /// Ramp that rises to the right and downwards; `x` and `y` in pixels.
    fn ramp_at(x: f32, y: f32) -> f32 {
        1.0 + 0.01 * x + 0.02 * y
    }

    /// Films of tiles whose samples are all of the same red, a third of it a highlight, and of a green that
    /// rises.
    fn films(grid: &Grid, kernel: &Kernel) -> Vec<TileFilm> {
        let (one, red, shine) = ([1.0; CELLS], [0.5; CELLS], [0.25; CELLS]);
        let mut columns = [None; sums::COUNT];
        columns[sums::ALPHA] = Some(&one);
        columns[sums::DIFFUSE] = Some(&red);
        columns[sums::SPECULAR] = Some(&shine);
        let film_of = |number: usize| {
            let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
            let extent = grid.extent(number);
            for (cell, model) in tile.model.iter_mut().enumerate() {
                *model = if holds(extent, cell) { 0 } else { EMPTY };
            }
            let place = |column: &[f32; CELLS]| column.map(|at| at + 0.5);
            let (x, y) = (place(&grid.place_x), place(&grid.place_y));
            let [left, top] = grid.corner_in_film(number).map(|at| at as f32);
            let in_pixels = |at: f32| at / grid.samples as f32;
            let ramp =
                std::array::from_fn(|cell| ramp_at(left + in_pixels(x[cell]), top + in_pixels(y[cell])));
            let mut columns = columns;
            columns[sums::DIFFUSE + 1] = Some(&ramp);
            let mut film = TileFilm::default();
            let by = Spread::new(kernel, grid, [&x, &y], Weighing::Distance);
            spread(by, &tile, &columns, &mut film);
            film
        };
        (0..grid.tiles()).map(film_of).collect()
    }
}
