//! A frame's work, tile by tile: each goes through all phases while it is in the cache.

pub mod contrast;
pub mod input;
pub mod level;
pub mod phases;
pub mod runs;
pub mod thread_scratch;

use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use rayon::prelude::*;

use self::contrast::TileColors;
use self::input::{FilmContents, Reused, Start, Work};
use self::phases::{TileParts, render_tile};
use self::runs::{Parts, TileRun, runs};
use self::thread_scratch::{PhaseSeconds, ThreadScratch};
use crate::film::Film;
use crate::frame::film::develop::{Bands, Developer, DirtyTiles, bands};
use crate::frame::film::spread::TileFilm;
use crate::frame::grid::Grid;
use crate::frame::planes::channels::{NonZeroPlanes, Picture};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::static_camera::remake::DirtyLevel;
use crate::frame::static_camera::tile_state::TileState;
use crate::samples::{SampleStore, TagLayout, TilePool};
use crate::stats::{RayCounts, SampleCounts, Seconds};

/// Sums over the tiles of a frame.
#[derive(Default)]
pub struct TileSum {
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    /// Nobody wanted the others.
    pub is_stopped: bool,
    written: NonZeroPlanes,
    phase_seconds: PhaseSeconds,
    /// Wall-clock seconds of projecting the samples of the frame before, ahead of all tiles.
    pub projecting: f64,
    /// Wall-clock seconds of the tiles.
    wall: f64,
    /// Wall-clock seconds of writing rows.
    develop: f64,
}

/// Memory of a renderer for the tiles of its frames. Kept from frame to frame.
pub struct FrameBuffers {
    /// Layout of the tiles' tags.
    layout: TagLayout,
    /// One for each tile.
    pub states: Vec<TileState>,
    /// Colours of each tile, if they are noted.
    pub colors: Vec<TileColors>,
    /// Seconds that each tile took when it was rendered last.
    seconds: Vec<f32>,
}

/// Memory in which frames are made, of whatever picture and level: nothing in it outlives a level of a frame, but tiles whose contents
/// mean nothing.
#[derive(Default)]
pub struct TileScratch {
    /// Tiles for stores to grow out of.
    pub pool: TilePool,
    /// One for each thread that has been at work.
    threads: Mutex<Vec<ThreadScratch>>,
    /// Sums of the band of tiles at work, and of the band before.
    bands: [Vec<TileFilm>; 2],
    /// Tiles whose sums other tiles need.
    dirty: DirtyTiles,
}

impl FrameBuffers {
    /// Nothing in it yet; for stores with tags as `layout` says.
    pub fn new(layout: TagLayout) -> Self {
        Self { layout, states: Vec::new(), colors: Vec::new(), seconds: Vec::new() }
    }

    /// Has a state for each tile.
    pub fn begin_frame(&mut self, grid: &Grid) {
        self.states.resize_with(grid.tiles(), TileState::default);
        self.colors.resize_with(grid.tiles(), TileColors::new);
        self.seconds.resize(grid.tiles(), 0.0);
    }

    /// Bytes of what is remembered of the tiles.
    pub fn state_bytes(&self) -> usize {
        let states = self.states.iter().map(|state| size_of_val(state) + state.trees.bytes()).sum::<usize>();
        let colors = self.colors.iter().map(|colors| size_of_val(&colors[..])).sum::<usize>();
        states + colors + size_of_val(&self.seconds[..])
    }

    /// Forgets what is known of the tiles, but for where in their cells their samples are.
    pub fn forget(&mut self) {
        for state in &mut self.states {
            *state = TileState::default();
        }
    }
}

/// Takes every tile through all phases, and writes the frame into `film`. `store` grows to all tiles of the
/// picture, unless it has them already.
///
/// Tiles go in bands of whole rows: between them old tiles that nobody wants any more are given back, and with a
/// wide filter all rows of pixels that no later band reaches are written. While the camera does not move, neither is
/// needed and bands are large: most tiles cost next to nothing, and threads wait for each other at each band's end.
pub fn run_tiles(
    frame: &FrameView,
    start: &mut Start,
    store: &mut SampleStore,
    (buffers, scratch): (&mut FrameBuffers, &mut TileScratch),
    film: &mut Film,
    shows: FilmContents,
) -> TileSum {
    let is_wide = frame.kernel.is_some();
    let picture = Picture::over(film, frame.kernel, frame.channels, frame.palette.brightest);
    let grid = &*frame.view.grid;
    let mut developer = Developer::default();
    let mut sum = TileSum::default();
    let is_free = !is_wide && matches!(start.reused, Reused::InPlace(..));
    let bands = bands(grid, tiles_in_band(if is_free { TILES_IN_PLACE } else { 0 }));
    let FrameBuffers { layout, states, colors, seconds } = buffers;
    let TileScratch { pool, threads, bands: [now, before], dirty } = scratch;
    dirty.clear();
    if let Some(kernel) = frame.kernel {
        dirty.set(
            grid,
            kernel.halo(),
            states.iter().enumerate().map(|(number, state)| {
                state.facts(frame, shows.is_last(number), false).remake() >= DirtyLevel::Picture
            }),
            |number| states[number].asks_beside,
        );
    }
    let mut above = 0;
    for rows in bands {
        let begin = Instant::now();
        let [done, end] = [rows.start, rows.end].map(|row| (row * grid.tiles_x) as usize);
        if let Reused::Projected(old, ..) = &mut start.reused {
            old.let_go(done, pool);
        }
        pool.grow(store, end, layout);
        let count = end - done;
        if now.len() < count {
            now.resize_with(count, TileFilm::default);
        }
        let work = Work { frame, layout, start, picture: &picture, dirty, shows };
        let parts = Parts {
            tiles: &mut store.tiles[done..end],
            states: &mut states[done..end],
            colors: &mut colors[done..end],
            films: &mut now[..count],
            seconds: &mut seconds[done..end],
        };
        let runs = runs(&work, rows.clone(), parts, film);
        sum = sum.plus(run_band(&work, runs, threads));
        if let Some(watch) = frame.watcher {
            watch(count);
        }
        if frame.stop.is_some_and(|stop| stop()) {
            sum.is_stopped = true;
            break;
        }
        let developing = Instant::now();
        sum.wall += (developing - begin).as_secs_f64();
        if is_wide {
            let bands = Bands { before: &before[..above], now: &now[..count], first: done };
            sum.written = sum.written.plus(developer.develop(film, &picture, grid, bands, dirty, rows.end));
            std::mem::swap(now, before);
            above = count;
        }
        sum.develop += developing.elapsed().as_secs_f64();
    }
    for (number, (plane, was_zero)) in film.planes.iter_mut().zip(&picture.was_zero).enumerate() {
        plane.is_zero = match shows {
            FilmContents::Coarser { .. } => *was_zero && sum.written.is_none(number),
            FilmContents::Nothing | FilmContents::Last => sum.written.is_zero(number, *was_zero),
        };
    }
    if let Reused::Projected(old, ..) = &mut start.reused {
        old.let_go(grid.tiles(), pool);
    }
    sum
}

/// Tiles in a band while the camera does not move: a picture of 1280 x 720 pixels at once, and little memory for windows.
const TILES_IN_PLACE: u32 = 1024;

/// Tiles in a band: enough for all threads, `least` at least.
pub fn tiles_in_band(least: u32) -> u32 {
    const TILES_A_THREAD: u32 = 32;
    least.max(TILES_A_THREAD * rayon::current_num_threads() as u32)
}

/// Takes tiles through all phases. Where much is new, a tile takes as long as whole rows of others: each worker takes the next
/// run when it is done with one, and the dearest come first, or all would wait for a worker that begins with one at the end.
fn run_band(work: &Work, mut runs: Vec<TileRun>, pool: &Mutex<Vec<ThreadScratch>>) -> TileSum {
    // those that cost about the same stay in their order: neighbours read the same tiles of the frame before
    runs.sort_by_cached_key(|run| std::cmp::Reverse(run.parts.expected_seconds().log2() as i32));
    let runs = Mutex::new(runs.into_iter());
    let worker = |_| {
        let mut scratch = lock(pool).pop().unwrap_or_default();
        let (mut samples, mut written) = (SampleCounts::default(), NonZeroPlanes::default());
        // not in the condition of a loop, which would hold the lock until the run is done
        let next = || lock(&runs).next();
        while let Some(run) = next() {
            let TileRun { first, parts: Parts { tiles, states, colors, films, seconds }, mut window } = run;
            let parts = tiles.iter_mut().zip(states).zip(colors).zip(films).zip(seconds);
            for (number, ((((tile, state), colors), film), seconds)) in (first..).zip(parts) {
                let begin = Instant::now();
                let parts = TileParts { tile, state, colors, film };
                let (of_tile, of_window) = render_tile(work, number, parts, &mut window, &mut scratch);
                samples += of_tile;
                written = written.plus(of_window);
                *seconds = begin.elapsed().as_secs_f32();
            }
        }
        let rays = std::mem::take(&mut scratch.trace.tally.counts);
        let phase_seconds = std::mem::take(&mut scratch.seconds);
        lock(pool).push(scratch);
        TileSum { samples, rays, written, phase_seconds, ..TileSum::default() }
    };
    let workers = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1);
    workers.map(worker).reduce(TileSum::default, TileSum::plus)
}

/// A worker that has panicked leaves nothing half-done behind these locks.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl TileSum {
    /// With those of more tiles, or of another level.
    pub fn plus(mut self, other: Self) -> Self {
        self.samples += other.samples;
        self.rays += other.rays;
        self.written = self.written.plus(other.written);
        self.phase_seconds += other.phase_seconds;
        self
    }

    /// Adds the wall-clock time of the tiles to the phases, split by what the workers spent in each.
    pub fn share_time(&self, seconds: &mut Seconds) {
        let PhaseSeconds { resolve, verify, trace, light, filter } = self.phase_seconds;
        let spent = resolve + verify + trace + light + filter;
        let scale = if spent > 0.0 { self.wall / spent } else { 0.0 };
        seconds.reproject += self.projecting + resolve * scale;
        seconds.verify += verify * scale;
        seconds.trace += trace * scale;
        seconds.light += light * scale;
        seconds.filter += filter * scale + self.develop;
    }
}
