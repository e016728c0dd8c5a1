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
    /// Seconds that each tile took when it was rendered last.
    pub seconds: &'a mut [f32],
}

impl<'a> Parts<'a> {
    /// Seconds that these tiles may take: as many as they took before.
    pub fn expected_seconds(&self) -> f32 {
        self.seconds.iter().sum()
    }

    /// Takes the parts of the first `count` tiles out of these.
    fn take(&mut self, count: usize) -> Self {
        fn first<'a, T>(parts: &mut &'a mut [T], count: usize) -> &'a mut [T] {
            let (taken, left) = std::mem::take(parts).split_at_mut(count);
            *parts = left;
            taken
        }
        Self {
            tiles: first(&mut self.tiles, count),
            states: first(&mut self.states, count),
            colors: first(&mut self.colors, count),
            films: first(&mut self.films, count),
            seconds: first(&mut self.seconds, count),
        }
    }
}

/// The runs of some rows of tiles. Windows have those planes alone that may be written: of tiles that the film shows
/// already, a frame younger, the age, and of clean tiles that it shows with another status, what is counted.
pub fn runs<'a>(work: &Work, rows: Range<u32>, mut parts: Parts<'a>, film: &'a mut Film) -> Vec<TileRun<'a>> {
    /// Runs of each thread, at least: the fewer, the longer all wait for the one that ends last.
    const OF_THREAD: usize = 8;
    let grid = &*work.frame.view.grid;
    let across = grid.tiles_x as usize;
    let most_seconds = parts.expected_seconds() / (OF_THREAD * rayon::current_num_threads()) as f32;
    let borders: Vec<Vec<usize>> =
        parts.seconds.chunks(across).map(|row| borders_of_runs(row, most_seconds)).collect();
    let columns: Vec<Vec<usize>> =
        borders.iter().map(|borders| grid.axes[0].borders(borders.iter().copied())).collect();
    let lines = grid.axes[1].borders(rows.start as usize..=rows.end as usize);
    let first = rows.start as usize * across;
    let tiles_of_runs = (first..)
        .step_by(across)
        .zip(&borders)
        .flat_map(|(first, borders)| borders.windows(2).map(move |run| first + run[0]..first + run[1]));
    let tiles_of_runs: Vec<Range<usize>> = tiles_of_runs.collect();
    let remake = |tile: usize| work.facts(tile, &parts.states[tile - first]).remake();
    let remake = |tiles: &Range<usize>| tiles.clone().map(remake).fold(DirtyLevel::Age, DirtyLevel::max);
    let remakes: Vec<DirtyLevel> = tiles_of_runs.iter().map(remake).collect();
    let (channels, age) = (&work.picture.channels, work.picture.age());
    let is_wanted = |plane: usize, window: usize| match remakes[window] {
        DirtyLevel::Age => Some(plane) == age,
        DirtyLevel::Counts => Some(plane) == age || channels[plane].is_count(),
        DirtyLevel::Picture | DirtyLevel::Samples => true,
    };
    let windows = cut(&mut film.planes, &lines, |row| &columns[row], is_wanted);
    let run = |(tiles, window): (Range<usize>, Window<'a>)| TileRun {
        first: tiles.start,
        parts: parts.take(tiles.len()),
        window,
    };
    tiles_of_runs.into_iter().zip(windows).map(run).collect()
}

/// Divides a row of tiles, which took these `seconds`, into runs: of few tiles, so that there is work for all workers, but
/// not of one each, because cutting costs as well; and of one tile where it takes long. Returns where runs begin, and
/// the end of the last.
fn borders_of_runs(seconds: &[f32], most_seconds: f32) -> Vec<usize> {
    const MOST_TILES: usize = 4;
    let (mut borders, mut begin, mut sum) = (vec![0], 0, 0.0);
    for (tile, seconds) in seconds.iter().enumerate() {
        if tile > begin && (tile - begin == MOST_TILES || sum + seconds > most_seconds) {
            borders.push(tile);
            (begin, sum) = (tile, 0.0);
        }
        sum += seconds;
    }
    borders.push(seconds.len());
    borders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_takes_long_is_a_run_by_itself() {
        assert_eq!(borders_of_runs(&[0.0; 9], 0.0), [0, 4, 8, 9]);
        assert_eq!(borders_of_runs(&[1.0; 9], 4.0), [0, 4, 8, 9]);
        assert_eq!(borders_of_runs(&[1.0, 1.0, 9.0, 1.0, 2.0, 2.0], 4.0), [0, 2, 3, 5, 6]);
        assert_eq!(borders_of_runs(&[9.0], 4.0), [0, 1]);
    }
}
