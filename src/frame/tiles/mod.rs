//! A frame's work, tile by tile: each goes through all phases while it is in the cache.

pub mod contrast;
pub mod level;
pub mod thread_scratch;

use std::ops::Range;
use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use self::contrast::{TileColors, note_colors};
use self::thread_scratch::{PhaseSeconds, ThreadScratch};
use crate::changes::Until;
use crate::film::Film;
use crate::frame::film::develop::{Bands, Developer, DirtyTiles, bands};
use crate::frame::film::filter::{self, Shown};
use crate::frame::film::spread::TileFilm;
use crate::frame::grid::Grid;
use crate::frame::grid::cells::CellSet;
use crate::frame::light::{direct, indirect, occlusion};
use crate::frame::planes::channels::{Picture, Written};
use crate::frame::planes::window::{Window, cut};
use crate::frame::reuse::bins::Bins;
use crate::frame::reuse::estimate::Estimate;
use crate::frame::reuse::verify::Request;
use crate::frame::reuse::{reproject, trace_missed, verify};
use crate::frame::secondary::enhance;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::static_camera::remake::{Change, Remake, TileFacts};
use crate::frame::static_camera::tile_state::TileState;
use crate::frame::static_camera::{self, Detached};
use crate::samples::{Flags, LeavingStore, SampleStore, Status, TagLayout, Tile, TilePool};
use crate::settings::Reuse;
use crate::stats::{RayCounts, SampleCounts, Seconds};

/// The samples of the frame before, as far as this frame reuses them.
pub enum Reused<'c> {
    /// A base frame: none.
    None,
    /// The camera did not move: all are where they were, but for those of models that moved.
    InPlace(&'c Detached, &'c Bins),
    /// The store of the frame before, and its samples in bins.
    Projected(LeavingStore, &'c Bins),
}

/// What a frame begins with.
pub struct Start<'c> {
    /// Of the frame before.
    pub reused: Reused<'c>,
    /// What it took to choose whether to reuse samples.
    pub estimate: Estimate,
}

/// What the tiles of a frame add up to.
#[derive(Default)]
pub struct TileSum {
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    /// Nobody wanted the others.
    pub is_stopped: bool,
    written: Written,
    phase_seconds: PhaseSeconds,
    /// Wall-clock seconds of the tiles.
    wall: f64,
    /// Wall-clock seconds of writing rows.
    develop: f64,
}

/// Memory of a renderer for the tiles of its frames. Kept from frame to frame.
pub struct FrameBuffers {
    /// Tiles for the store to grow out of.
    pub pool: TilePool,
    /// Of their tags.
    layout: TagLayout,
    /// One for each thread that has been at work.
    scratch: Mutex<Vec<ThreadScratch>>,
    /// Sums of the band of tiles at work, and of the band before.
    bands: [Vec<TileFilm>; 2],
    /// One for each tile.
    pub states: Vec<TileState>,
    /// What each tile shows, if that is noted.
    pub colors: Vec<TileColors>,
    /// Of the frame at work.
    dirty: DirtyTiles,
}

impl FrameBuffers {
    /// Nothing in it yet; for stores with tags as `layout` says.
    pub fn new(layout: TagLayout) -> Self {
        Self {
            pool: TilePool::new(layout.clone()),
            layout,
            scratch: Mutex::default(),
            bands: Default::default(),
            states: Vec::new(),
            colors: Vec::new(),
            dirty: DirtyTiles::default(),
        }
    }

    /// Has a state for each tile.
    pub fn begin_frame(&mut self, grid: &Grid) {
        self.states.resize_with(grid.tiles(), TileState::default);
        self.colors.resize_with(grid.tiles(), TileColors::new);
    }

    /// Bytes of what is remembered of the tiles.
    pub fn state_bytes(&self) -> usize {
        let states = self.states.iter().map(|state| size_of_val(state) + state.trees.bytes()).sum::<usize>();
        states + self.colors.iter().map(|colors| size_of_val(&colors[..])).sum::<usize>()
    }

    /// Takes what others have to work in: nothing in it outlives a frame.
    pub fn take_room_from(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.scratch, &mut other.scratch);
        std::mem::swap(&mut self.bands, &mut other.bands);
    }

    /// Forgets what is known of the tiles, but for where in their cells their samples are.
    pub fn forget(&mut self) {
        for state in &mut self.states {
            *state = TileState::default();
        }
    }
}

/// What a film shows when a level of a frame begins.
#[derive(Debug, Clone, Copy)]
pub enum Shows<'a> {
    /// Nothing that is of use: all of it is written.
    Nothing,
    /// The frame before. What stays the same need not be written.
    Last,
    /// In a finer level: this frame as far as coarser levels have made it, and else the frame before, if `is_last`. For each
    /// tile whether a coarser level has written into it.
    Coarser { is_last: bool, written: &'a [bool] },
}

impl Shows<'_> {
    /// Whether it shows the frame before in tile number `number`.
    fn is_last(self, number: usize) -> bool {
        match self {
            Self::Nothing => false,
            Self::Last => true,
            Self::Coarser { is_last, written } => is_last && !written[number],
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
    buffers: &mut FrameBuffers,
    film: &mut Film,
    shows: Shows,
) -> TileSum {
    let is_wide = frame.kernel.is_some();
    let picture = Picture::over(film, frame.kernel, frame.channels, frame.palette.brightest);
    let grid = &*frame.view.grid;
    let mut developer = Developer::default();
    let mut sum = TileSum::default();
    let is_free = !is_wide && matches!(start.reused, Reused::InPlace(..));
    let bands = bands(grid, tiles_in_band(if is_free { TILES_IN_PLACE } else { 0 }));
    let FrameBuffers { pool, layout, scratch, bands: [now, before], states, colors, dirty } = buffers;
    dirty.clear();
    if let Some(kernel) = frame.kernel {
        dirty.set(
            grid,
            kernel.halo(),
            states.iter().enumerate().map(|(number, state)| {
                state.facts(frame, shows.is_last(number), false).remake() >= Remake::Picture
            }),
        );
    }
    let mut above = 0;
    for rows in bands {
        let begin = Instant::now();
        let [done, end] = [rows.start, rows.end].map(|row| (row * grid.tiles_x) as usize);
        if let Reused::Projected(old, _) = &mut start.reused {
            old.let_go(done, pool);
        }
        pool.grow(store, end);
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
        };
        let runs = runs(&work, rows.clone(), parts, film);
        sum = sum.plus(run_band(&work, runs, scratch));
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
            Shows::Coarser { .. } => *was_zero && sum.written.is_none(number),
            Shows::Nothing | Shows::Last => sum.written.is_zero(number, *was_zero),
        };
    }
    if let Reused::Projected(old, _) = &mut start.reused {
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

/// Tiles beside each other that one worker takes through all phases, one after the other.
struct Run<'a> {
    /// Number of the first one.
    first: usize,
    parts: Parts<'a>,
    window: Window<'a>,
}

/// What there is for each of some tiles.
struct Parts<'a> {
    tiles: &'a mut [Box<Tile>],
    states: &'a mut [TileState],
    colors: &'a mut [TileColors],
    films: &'a mut [TileFilm],
}

/// The runs of some rows of tiles. Windows have those planes alone that may be written: of tiles that the film shows
/// already, a frame younger, the age, and of clean tiles that it shows with another status, what is counted.
fn runs<'a>(work: &Work, rows: Range<u32>, parts: Parts<'a>, film: &'a mut Film) -> Vec<Run<'a>> {
    /// Tiles of a run: few enough that there is work for many, and enough that cutting costs little.
    const IN_RUN: usize = 4;
    let Parts { tiles, states, colors, films } = parts;
    let grid = &*work.frame.view.grid;
    let across = grid.tiles_x as usize;
    let columns = grid.axes[0].cuts(0..across, IN_RUN);
    let lines = grid.axes[1].cuts(rows.start as usize..rows.end as usize, 1);
    let first = rows.start as usize * across;
    let remakes: Vec<Remake> =
        (first..).zip(&*states).map(|(number, state)| work.facts(number, state).remake()).collect();
    let of_window = |remakes: &[Remake]| remakes.iter().copied().fold(Remake::Age, Remake::max);
    let remakes: Vec<Remake> =
        remakes.chunks(across).flat_map(|row| row.chunks(IN_RUN).map(of_window)).collect();
    let (channels, age) = (&work.picture.channels, work.picture.age());
    let is_wanted = |plane: usize, window: usize| match remakes[window] {
        Remake::Age => Some(plane) == age,
        Remake::Counts => Some(plane) == age || channels[plane].is_count(),
        Remake::Picture | Remake::Samples => true,
    };
    let windows = cut(&mut film.planes, &columns, &lines, is_wanted);
    let tiles = tiles.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let states = states.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let colors = colors.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let films = films.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let parts = tiles.zip(states).zip(colors).zip(films);
    let mut first = first;
    let runs = parts.zip(windows).map(|((((tiles, states), colors), films), window)| {
        let run = Run { first, parts: Parts { tiles, states, colors, films }, window };
        first += run.parts.tiles.len();
        run
    });
    runs.collect()
}

/// What is to be done with every tile.
#[derive(Clone, Copy)]
struct Work<'a> {
    frame: &'a FrameView<'a>,
    layout: &'a TagLayout,
    start: &'a Start<'a>,
    picture: &'a Picture,
    /// Whose colours must be written.
    dirty: &'a DirtyTiles,
    /// What the film shows: what stays the same need not be made again.
    shows: Shows<'a>,
}

impl Work<'_> {
    /// What is known of tile number `number` before its samples are brought up to date.
    fn facts(&self, number: usize, state: &TileState) -> TileFacts {
        state.facts(self.frame, self.shows.is_last(number), self.dirty.is_needed(number))
    }
}

/// Takes tiles through all phases.
fn run_band(work: &Work, runs: Vec<Run>, scratch: &Mutex<Vec<ThreadScratch>>) -> TileSum {
    let lock = || scratch.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    runs.into_par_iter()
        .fold(
            || (lock().pop().unwrap_or_default(), SampleCounts::default(), Written::default()),
            |(mut scratch, mut samples, mut written), run| {
                let Run { first, parts: Parts { tiles, states, colors, films }, mut window } = run;
                let parts = tiles.iter_mut().zip(states).zip(colors).zip(films);
                for (number, (((tile, state), colors), film)) in (first..).zip(parts) {
                    let remake = infer_tile(work, number, tile, state, &mut scratch);
                    state.was_written = remake >= Remake::Picture;
                    let shows_any = !work.frame.wanted_of(number).is_empty();
                    if work.frame.notes_colors && state.was_written && shows_any {
                        note_colors(&scratch.radiance, colors);
                    }
                    let begin = Instant::now();
                    let Work { frame, picture, dirty, .. } = *work;
                    let ThreadScratch { filtering, radiance, placed, trace, .. } = &mut scratch;
                    let cell_rays = &*trace.tally.cells;
                    if dirty.is_needed(number) {
                        filter::sum(frame, number, tile, filtering, radiance, film);
                    }
                    written = written.plus(match remake {
                        Remake::Age => filter::stay(frame, number, picture, &mut window),
                        Remake::Counts => {
                            filter::recount(frame, number, tile, filtering, cell_rays, picture, &mut window)
                        }
                        Remake::Picture | Remake::Samples => {
                            let shown = Shown { radiance, placed, cell_rays };
                            filter::filter(frame, number, tile, filtering, shown, picture, &mut window)
                        }
                    });
                    scratch.seconds.filter += begin.elapsed().as_secs_f64();
                    samples += match remake {
                        Remake::Age if frame.wanted.is_none() => {
                            let good = frame.view.grid.cells(number);
                            debug_assert_eq!(count_samples(tile).good, good, "tile {number}");
                            SampleCounts { good, ..SampleCounts::default() }
                        }
                        _ => count_samples(tile),
                    };
                }
                (scratch, samples, written)
            },
        )
        .map(|(mut scratch, samples, written)| {
            let rays = std::mem::take(&mut scratch.trace.tally.counts);
            let phase_seconds = std::mem::take(&mut scratch.seconds);
            lock().push(scratch);
            TileSum { samples, rays, written, phase_seconds, ..TileSum::default() }
        })
        .reduce(TileSum::default, TileSum::plus)
}

/// One tile of one frame, from the samples of the frame before to what its cells show, as far as the film does not
/// show that already: what is to be written of it.
fn infer_tile(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    state: &mut TileState,
    scratch: &mut ThreadScratch,
) -> Remake {
    let Work { frame, .. } = *work;
    let mut facts = work.facts(number, state);
    if facts.remake() == Remake::Age && !facts.is_needed {
        return Remake::Age;
    }
    scratch.begin_tile();
    if facts.samples == Change::None {
        let begin = Instant::now();
        static_camera::keep_all(tile);
        scratch.seconds.gather += begin.elapsed().as_secs_f64();
    } else {
        facts.samples = update_samples(work, number, tile, state, scratch);
    }
    if facts.samples != Change::None {
        state.content = None;
    }
    let remake = facts.remake();
    state.was_quiet = facts.samples == Change::None;
    state.is_known = true;
    if (remake >= Remake::Picture || facts.is_needed) && !frame.wanted_of(number).is_empty() {
        let begin = Instant::now();
        let ThreadScratch { radiance, bounces, placed, trace, .. } = &mut *scratch;
        let casts_rays =
            enhance::enhance(frame, tile, radiance, bounces, Some(&mut state.trees), placed, trace);
        state.goes_on = radiance.has_secondary;
        state.was_quiet &= !casts_rays;
        scratch.seconds.enhance += begin.elapsed().as_secs_f64();
    }
    remake
}

/// Candidates that a cell asks at most, one after the other.
const MOST_ASKED: usize = 4;

/// Brings a tile's samples and their light up to date. Says how they differ from those of the frame before.
fn update_samples(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    state: &mut TileState,
    scratch: &mut ThreadScratch,
) -> Change {
    let Work { frame, layout, start: Start { reused, estimate }, .. } = *work;
    let ThreadScratch { trace, seconds, serving, before, lighting, placed, paths, occlusion, roots, .. } =
        scratch;
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
    let counts_before = trace.tally.counts;
    estimate.count(number, &mut trace.tally);
    state.trees.note_roots(tile, roots);
    serving.begin();
    let took_cells = match reused {
        Reused::None => {
            reproject::begin_base(frame, number, tile);
            true
        }
        Reused::InPlace(detached, bins) => {
            let before = before.get_or_insert_with(|| Box::new(Tile::empty(layout)));
            static_camera::merge(detached, frame, bins, number, tile, before, serving)
        }
        Reused::Projected(old, bins) => {
            reproject::gather(old, frame, bins, number, tile, serving);
            true
        }
    };
    seconds.gather += lap();
    if frame.wanted_of(number).is_empty() {
        (state.until, state.bounds) = (Until::FOREVER, None);
        return Change::Samples;
    }
    let among = frame.in_sight(number);
    let mut probes = CellSet::default();
    if !matches!(reused, Reused::None) {
        let bounds = state.content.as_ref().map(|content| &content.bounds);
        let mut cells = CellSet::ALL;
        for asked in 1.. {
            let request = Request { number, cells: &cells, bounds, flags: serving.flags() };
            verify::verify(frame, among, tile, &request, trace);
            let next = match reused {
                _ if asked == MOST_ASKED => None,
                Reused::None => None,
                Reused::InPlace(detached, _) => {
                    serving.ask_next(frame.reuse, tile, &static_camera::tiles(detached, before.as_deref()))
                }
                Reused::Projected(old, _) => serving.ask_next(frame.reuse, tile, &|source| old.tile(source)),
            };
            match next {
                Some(next) => cells = next,
                None => break,
            }
        }
        if frame.reuse == Reuse::Target {
            probes = serving.probes(tile);
        }
    }
    let mut flags = serving.flags();
    seconds.verify += lap();
    trace_missed::trace_missed(frame, number, among, tile, &probes, trace);
    tile.spares.trim();
    state.trees.forget_others(tile, roots);
    seconds.trace += lap();
    let (gathered_changed, until) = indirect::gather(frame, tile, placed, paths, &mut trace.tally);
    let (openness_changed, open_until) =
        occlusion::find_openness(frame, tile, placed, occlusion, &mut trace.tally);
    flags = flags.with(Flags::STALE.when(gathered_changed || openness_changed));
    state.until = until.min(open_until);
    let (light_changed, bounds) = direct::light(frame, tile, flags, lighting, placed, &mut trace.tally);
    state.bounds = bounds;
    seconds.enhance += lap();
    let counts = trace.tally.counts;
    if took_cells || light_changed || openness_changed || counts.primary != counts_before.primary {
        Change::Samples
    } else if counts != counts_before {
        Change::Rays
    } else {
        Change::None
    }
}

fn count_samples(tile: &Tile) -> SampleCounts {
    // few enough for a byte to count them: many are counted at once
    const FEW: usize = 128;
    let count_few =
        |few: &[Status], wanted| few.iter().fold(0, |count: u8, status| count + u8::from(*status == wanted));
    let count = |wanted: Status| tile.status.chunks(FEW).map(|few| u64::from(count_few(few, wanted))).sum();
    SampleCounts {
        base: count(Status::Base),
        good: count(Status::Good),
        overlapped: count(Status::Overlapped),
        missed: count(Status::Missed),
        obscured: count(Status::Obscured),
        spare: tile.spares.len() as u64,
    }
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
        let PhaseSeconds { gather, verify, trace, enhance, filter } = self.phase_seconds;
        let spent = gather + verify + trace + enhance + filter;
        let scale = if spent > 0.0 { self.wall / spent } else { 0.0 };
        seconds.reproject += gather * scale;
        seconds.verify += verify * scale;
        seconds.trace += trace * scale;
        seconds.enhance += enhance * scale;
        seconds.filter += filter * scale + self.develop;
    }
}
