//! Runs: the tiles of a band as workers take them, each with its own windows into the planes of the film.

use std::ops::Range;

use super::contrast::TileColors;
use super::input::Work;
use crate::film::Film;
use crate::frame::film::spread::TileFilm;
use crate::frame::planes::window::{Window, cut};
use crate::frame::static_camera::remake::DirtyLevel;
use crate::frame::static_camera::tile_state::TileState;
use crate::samples::Tile;

/// Tiles beside each other that one worker takes through all phases, one after the other.
pub struct TileRun<'a> {
    /// Number of the first one.
    pub first: usize,
    pub parts: Parts<'a>,
    pub window: Window<'a>,
}

/// Parts of consecutive tiles, one of each kind a tile.
pub struct Parts<'a> {
    pub tiles: &'a mut [Box<Tile>],
    pub states: &'a mut [TileState],
    pub colors: &'a mut [TileColors],
    pub films: &'a mut [TileFilm],
}

/// The runs of some rows of tiles. Windows have those planes alone that may be written: of tiles that the film shows
/// already, a frame younger, the age, and of clean tiles that it shows with another status, what is counted.
pub fn runs<'a>(work: &Work, rows: Range<u32>, parts: Parts<'a>, film: &'a mut Film) -> Vec<TileRun<'a>> {
    /// Tiles of a run: few enough that there is work for many, and enough that cutting costs little.
    const IN_RUN: usize = 4;
    let Parts { tiles, states, colors, films } = parts;
    let grid = &*work.frame.view.grid;
    let across = grid.tiles_x as usize;
    let columns = grid.axes[0].cuts(0..across, IN_RUN);
    let lines = grid.axes[1].cuts(rows.start as usize..rows.end as usize, 1);
    let first = rows.start as usize * across;
    let remakes: Vec<DirtyLevel> =
        (first..).zip(&*states).map(|(number, state)| work.facts(number, state).remake()).collect();
    let of_window = |remakes: &[DirtyLevel]| remakes.iter().copied().fold(DirtyLevel::Age, DirtyLevel::max);
    let remakes: Vec<DirtyLevel> =
        remakes.chunks(across).flat_map(|row| row.chunks(IN_RUN).map(of_window)).collect();
    let (channels, age) = (&work.picture.channels, work.picture.age());
    let is_wanted = |plane: usize, window: usize| match remakes[window] {
        DirtyLevel::Age => Some(plane) == age,
        DirtyLevel::Counts => Some(plane) == age || channels[plane].is_count(),
        DirtyLevel::Picture | DirtyLevel::Samples => true,
    };
    let windows = cut(&mut film.planes, &columns, &lines, is_wanted);
    let tiles = tiles.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let states = states.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let colors = colors.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let films = films.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let parts = tiles.zip(states).zip(colors).zip(films);
    let mut first = first;
    let runs = parts.zip(windows).map(|((((tiles, states), colors), films), window)| {
        let run = TileRun { first, parts: Parts { tiles, states, colors, films }, window };
        first += run.parts.tiles.len();
        run
    });
    runs.collect()
}
