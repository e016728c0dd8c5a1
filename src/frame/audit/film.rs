//! The audit of the film: every tile is made again from the finished samples, and compared with the film.
//!
//! Before a camera at rest most pixels are left from the frame before
//! ([`remake`](crate::frame::static_camera::remake)). A tile that is wrongly taken to be clean shows colours
//! that no sample has any more, which no look at samples finds. Made again means highlights, reflections and
//! refractions as well: the same rays meet the same surfaces, so pixels must be equal to the bit. Planes that
//! count rays are left out: rays that were spared are not counted.

use rayon::prelude::*;

use crate::film::{Film, Plane};
use crate::frame::film::develop::{Bands, Developer, DirtyTiles, bands, blank};
use crate::frame::film::filter;
use crate::frame::film::spread::TileFilm;
use crate::frame::grid::Grid;
use crate::frame::planes::channels::Picture;
use crate::frame::planes::window::cut;
use crate::frame::secondary::enhance;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::tiles::thread_scratch::ThreadScratch;
use crate::frame::tiles::tiles_in_band;
use crate::samples::SampleStore;

/// Flags each pixel of `film`, in rows, that differs in any plane from what the samples of the `levels` give;
/// these are from the coarsest to the finest. Nothing but the result is changed, and no rays are counted.
pub fn differing_pixels(levels: &[(FrameView, &SampleStore)], film: &Film) -> Vec<bool> {
    let Some((coarsest, _)) = levels.first() else { return Vec::new() };
    let mut anew = blank(&coarsest.view.grid, coarsest.channels);
    let picture = Picture::over(&anew, coarsest.kernel, coarsest.channels, coarsest.palette.brightest);
    for (number, (frame, store)) in levels.iter().enumerate() {
        // planes that a coarser level has written may not be zero any more
        let was_zero = vec![number == 0; picture.was_zero.len()];
        let picture = Picture { was_zero, channels: picture.channels.clone(), ..picture };
        make_anew(frame, store, &picture, &mut anew);
    }
    let mut differs = vec![false; film.width as usize * film.height as usize];
    let planes = film.planes.iter().zip(&anew.planes);
    for (shown, anew) in planes.filter(|(shown, _)| !shown.name.starts_with("rays_")) {
        differs
            .par_iter_mut()
            .enumerate()
            .for_each(|(pixel, differs)| *differs |= is_other(shown, anew, pixel));
    }
    differs
}

fn is_other(shown: &Plane, anew: &Plane, pixel: usize) -> bool {
    let [value, anew] = [shown, anew].map(|plane| plane.values.get(pixel).to_bits());
    // a plane that is known to be zero is neither read by writers of files nor cleared for the next frame
    value != anew || shown.is_zero && value != 0
}

/// Cells of tile number `number` whose pixels differ. None if `differs` is empty.
pub fn differing_cells(grid: &Grid, number: usize, differs: &[bool]) -> Vec<usize> {
    let [columns, rows] = grid.pixels(number);
    let (first, [left, top]) = (grid.first_in_film(number), [columns.start, rows.start]);
    let mut cells = Vec::new();
    for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
        if differs.get(y * grid.film[0] as usize + x) == Some(&true) {
            let pixel = first + (y - top) * grid.tile_pixels as usize + x - left;
            let of_pixel =
                &grid.cells_of_pixels[pixel * grid.samples_of_pixel()..][..grid.samples_of_pixel()];
            cells.extend(of_pixel.iter().map(|cell| usize::from(*cell)));
        }
    }
    cells
}

/// Makes the picture of a level of a finished frame from its samples, and writes it into `film`.
fn make_anew(frame: &FrameView, store: &SampleStore, picture: &Picture, film: &mut Film) {
    let grid = &*frame.view.grid;
    let is_wide = frame.kernel.is_some();
    let (mut developer, mut dirty) = (Developer::default(), DirtyTiles::default());
    if let Some(kernel) = frame.kernel {
        dirty.set(grid, kernel.halo(), std::iter::repeat_n(true, grid.tiles()), |_| false);
    }
    let [mut now, mut before]: [Vec<TileFilm>; 2] = Default::default();
    let columns = grid.axes[0].borders(0..=grid.tiles_x as usize);
    for rows in bands(grid, tiles_in_band(0)) {
        let [start, end] = [rows.start, rows.end].map(|row| (row * grid.tiles_x) as usize);
        let lines = grid.axes[1].borders(rows.start as usize..=rows.end as usize);
        let windows = cut(&mut film.planes, &lines, |_| &columns, |_, _| true);
        now.resize_with(end - start, TileFilm::default);
        let tiles = store.tiles[start..end].par_iter().zip(&mut now).zip(windows).enumerate();
        tiles.for_each_init(ThreadScratch::default, |scratch, (place, ((tile, sums), mut window))| {
            let number = start + place;
            scratch.begin_tile();
            let ThreadScratch { radiance, bounces, placed, trace, filtering, .. } = scratch;
            enhance::enhance(frame, (number, tile), radiance, bounces, None, placed, trace);
            if is_wide {
                filter::sum(frame, number, tile, filtering, radiance, trace, sums);
            }
            let shown = filter::FilterInput { radiance, placed, cell_rays: &trace.tally.cells };
            filter::filter(frame, number, tile, filtering, shown, picture, &mut window);
        });
        if is_wide {
            let bands = Bands { before: &before, now: &now, first: start };
            developer.develop(film, picture, grid, bands, &dirty, rows.end);
            std::mem::swap(&mut now, &mut before);
        }
    }
}
