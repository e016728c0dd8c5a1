//! A frame's work, tile by tile: each goes through all phases while it is in the cache.

use std::ops::Range;
use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use super::beyond::Beyond;
use super::bins::Bins;
use super::channels::{Picture, Written};
use super::develop::{Bands, Developer, Standing};
use super::filter;
use super::grid::Grid;
use super::mitchell::TileFilm;
use super::rest::Memo;
use super::stage::{Stage, Workbench, WorkerSeconds};
use super::stay::{self, Detached};
use super::verify::CellSet;
use super::window::{Window, cut};
use super::{audit, enhance, light, reproject, trace_missed, verify};
use crate::film::Film;
use crate::samples::{LeavingStore, SampleStore, Status, TagLayout, Tile, TilePool};
use crate::settings::{Filter, Reuse, Settings};
use crate::stats::{AuditCounts, RayCounts, SampleCounts, Seconds};

/// Where a frame's samples come from.
pub enum Source<'c> {
    /// A base frame: nowhere.
    Nothing,
    /// The camera stands: they are where they were, but for those of models that moved.
    Stay(&'c Detached, &'c Bins),
    /// The store of the frame before, and what falls from it.
    Fall(LeavingStore, &'c Bins),
}

/// What the tiles of a frame add up to.
#[derive(Default)]
pub struct TileSum {
    /// By status.
    pub samples: SampleCounts,
    /// By kind.
    pub rays: RayCounts,
    written: Written,
    worker_seconds: WorkerSeconds,
    /// Wall-clock seconds of the tiles.
    wall: f64,
    /// Wall-clock seconds of writing rows.
    develop: f64,
}

/// What the tiles of a frame are worked at with. Keeps its memory from frame to frame.
pub struct Workshop {
    /// Tiles for the store to grow out of.
    pub pool: TilePool,
    /// Of their tags.
    layout: TagLayout,
    /// One for each thread that has been at work.
    benches: Mutex<Vec<Workbench>>,
    /// Sums of the band of tiles at work, and of the band before.
    bands: [Vec<TileFilm>; 2],
    /// One for each tile.
    pub memos: Vec<Memo>,
    /// Of the frame at work.
    standing: Standing,
}

impl Workshop {
    /// Nothing in it yet; for stores with tags as `layout` says.
    pub fn new(layout: TagLayout) -> Self {
        Self {
            pool: TilePool::new(layout.clone()),
            layout,
            benches: Mutex::default(),
            bands: Default::default(),
            memos: Vec::new(),
            standing: Standing::default(),
        }
    }

    /// Has as many memos as there are tiles.
    pub fn begin_frame(&mut self, grid: &Grid) {
        self.memos.resize_with(grid.tiles(), Memo::default);
    }

    /// Bytes of what is remembered of the tiles.
    pub fn memo_bytes(&self) -> usize {
        let beyond = |memo: &Memo| memo.beyond.as_ref().map_or(0, Beyond::bytes);
        self.memos.iter().map(|memo| size_of_val(memo) + beyond(memo)).sum()
    }

    /// Forgets what is known of the tiles, but for where in their cells their samples are.
    pub fn forget(&mut self) {
        for memo in &mut self.memos {
            *memo = Memo::default();
        }
    }
}

/// Takes every tile through all phases, and writes the frame into `film`. `store` grows to all tiles of the
/// picture, unless it has them already.
///
/// `film_is_last`: it shows the frame before. What stays the same need not be written then.
///
/// Tiles go in bands of whole rows: between them old tiles that nobody wants any more are given back, and with a
/// wide filter all rows of pixels that no later band reaches are written. Before a camera at rest, where neither is
/// needed, bands are large: most tiles are next to free, and threads wait for each other at each band's end.
pub fn run_tiles(
    stage: &Stage,
    source: &mut Source,
    settings: &Settings,
    store: &mut SampleStore,
    shop: &mut Workshop,
    film: &mut Film,
    film_is_last: bool,
) -> TileSum {
    let is_wide = settings.filter != Filter::Box;
    let picture = Picture::over(film, settings);
    film.planes.iter_mut().for_each(|plane| plane.is_zero = true);
    let grid = &*stage.view.grid;
    let mut developer = Developer::default();
    let mut sum = TileSum::default();
    let is_free = !is_wide && matches!(source, Source::Stay(..));
    let band_rows = band_rows(grid, if is_free { TILES_AT_REST } else { 0 });
    let Workshop { pool, layout, benches, bands: [now, before], memos, standing } = shop;
    standing.clear();
    if is_wide {
        standing.set(grid, memos.iter().map(|memo| !(film_is_last && memo.stands())));
    }
    let mut above = 0;
    for first in (0..grid.tiles_y).step_by(band_rows as usize) {
        let start = Instant::now();
        let rows = first..(first + band_rows).min(grid.tiles_y);
        let [done, end] = [rows.start, rows.end].map(|row| (row * grid.tiles_x) as usize);
        if let Source::Fall(old, _) = source {
            old.let_go(done, pool);
        }
        pool.grow(store, end);
        let count = end - done;
        if now.len() < count {
            now.resize_with(count, TileFilm::default);
        }
        let work = Work { stage, layout, source, picture: &picture, standing, film_is_last };
        let parts = (&mut store.tiles[done..end], &mut memos[done..end], &mut now[..count]);
        let runs = runs(&work, rows.clone(), parts, film);
        sum = sum.plus(run_band(&work, runs, benches));
        let developing = Instant::now();
        sum.wall += (developing - start).as_secs_f64();
        if is_wide {
            let end = (rows.end * grid.tile_pixels).min(grid.height);
            let bands = Bands { before: &before[..above], now: &now[..count], first: done };
            sum.written = sum.written.plus(developer.develop(film, &picture, grid, bands, standing, end));
            std::mem::swap(now, before);
            above = count;
        }
        sum.develop += developing.elapsed().as_secs_f64();
    }
    for (number, (plane, was_zero)) in film.planes.iter_mut().zip(&picture.was_zero).enumerate() {
        plane.is_zero &= sum.written.is_zero(number, *was_zero);
    }
    if let Source::Fall(old, _) = source {
        old.let_go(grid.tiles(), pool);
    }
    sum
}

/// Tiles in a band before a camera at rest: a picture of 1280 x 720 pixels at once, and little memory for windows.
const TILES_AT_REST: u32 = 1024;

/// Rows of tiles in a band: enough tiles for all threads, `least` at least, and more pixels than any filter reaches
/// across, so that a row of pixels is reached by two bands at most.
pub fn band_rows(grid: &Grid, least: u32) -> u32 {
    const TILES_A_THREAD: u32 = 32;
    const LEAST_PIXELS: u32 = 8;
    let tiles = least.max(TILES_A_THREAD * rayon::current_num_threads() as u32);
    let for_threads = tiles.div_ceil(grid.tiles_x);
    for_threads.max(LEAST_PIXELS.div_ceil(grid.tile_pixels))
}

/// Tiles beside each other that one worker takes through all phases, one after the other.
struct Run<'a> {
    /// Number of the first one.
    first: usize,
    tiles: &'a mut [Box<Tile>],
    memos: &'a mut [Memo],
    films: &'a mut [TileFilm],
    window: Window<'a>,
}

/// The runs of some rows of tiles. Windows have those planes alone that may be written: of tiles that the film shows
/// already, a frame younger, the age, and of tiles at rest that it shows with another status, what is counted.
fn runs<'a>(
    work: &Work,
    rows: Range<u32>,
    (tiles, memos, films): (&'a mut [Box<Tile>], &'a mut [Memo], &'a mut [TileFilm]),
    film: &'a mut Film,
) -> Vec<Run<'a>> {
    /// Tiles of a run: few enough that there is work for many, and enough that cutting costs little.
    const IN_RUN: usize = 4;
    let grid = &*work.stage.view.grid;
    let (across, pixels) = (grid.tiles_x as usize, grid.tile_pixels as usize);
    let lines = [rows.start, rows.end].map(|row| (row * grid.tile_pixels).min(grid.height) as usize);
    let width = film.width as usize;
    let outcome_of = |(number, memo): (usize, &Memo)| {
        if memo.is_at_rest { work.outcome_if_same(number, memo) } else { Outcome::New }
    };
    let first = rows.start as usize * across;
    let outcomes: Vec<Outcome> = (first..).zip(&*memos).map(outcome_of).collect();
    let of_window = |outcomes: &[Outcome]| outcomes.iter().copied().fold(Outcome::AsBefore, Outcome::max);
    let outcomes: Vec<Outcome> =
        outcomes.chunks(across).flat_map(|row| row.chunks(IN_RUN).map(of_window)).collect();
    let (channels, age) = (&work.picture.channels, work.picture.age());
    let is_wanted = |plane: usize, window: usize| match outcomes[window] {
        Outcome::AsBefore => Some(plane) == age,
        Outcome::Counts => Some(plane) == age || channels[plane].is_count(),
        Outcome::New => true,
    };
    let windows = cut(&mut film.planes, width, lines[0]..lines[1], [IN_RUN * pixels, pixels], is_wanted);
    let tiles = tiles.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let memos = memos.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let films = films.chunks_mut(across).flat_map(|row| row.chunks_mut(IN_RUN));
    let mut first = first;
    let runs = tiles.zip(memos).zip(films).zip(windows).map(|(((tiles, memos), films), window)| {
        let run = Run { first, tiles, memos, films, window };
        first += run.tiles.len();
        run
    });
    runs.collect()
}

/// What is to be done with every tile.
#[derive(Clone, Copy)]
struct Work<'a> {
    stage: &'a Stage<'a>,
    layout: &'a TagLayout,
    source: &'a Source<'a>,
    picture: &'a Picture,
    /// Of which tiles the colours stand in the film.
    standing: &'a Standing,
    /// Whether the film shows the frame before: what stays the same need not be made again.
    film_is_last: bool,
}

impl Work<'_> {
    /// What must be written of tile number `number` if its samples stay the same.
    fn outcome_if_same(&self, number: usize, memo: &Memo) -> Outcome {
        // the sums of what the film shows cost rays again
        let casts_rays = memo.goes_on && self.standing.is_needed(number);
        let is_shown = self.film_is_last && memo.shows_samples();
        match is_shown && !casts_rays {
            false => Outcome::New,
            true if memo.is_settled => Outcome::AsBefore,
            true => Outcome::Counts,
        }
    }
}

/// Takes tiles through all phases.
fn run_band(work: &Work, runs: Vec<Run>, benches: &Mutex<Vec<Workbench>>) -> TileSum {
    let lock = || benches.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    runs.into_par_iter()
        .fold(
            || (lock().pop().unwrap_or_default(), SampleCounts::default(), Written::default()),
            |(mut bench, mut samples, mut written), run| {
                let Run { first, tiles, memos, films, mut window } = run;
                for (number, ((tile, memo), film)) in (first..).zip(tiles.iter_mut().zip(memos).zip(films)) {
                    let outcome = infer_tile(work, number, tile, memo, &mut bench);
                    let begin = Instant::now();
                    let Work { stage, picture, standing, .. } = *work;
                    if standing.is_needed(number) {
                        filter::sum(stage, number, tile, &mut bench, film);
                    }
                    written = written.plus(match outcome {
                        Outcome::AsBefore => filter::stay(stage, number, picture, &mut window),
                        Outcome::Counts => {
                            filter::recount(stage, number, tile, &mut bench, picture, &mut window)
                        }
                        Outcome::New => filter::filter(stage, number, tile, &mut bench, picture, &mut window),
                    });
                    bench.seconds.filter += begin.elapsed().as_secs_f64();
                    samples += match outcome {
                        Outcome::AsBefore => {
                            let good = stage.view.grid.cells(number);
                            debug_assert_eq!(count_samples(tile).good, good, "tile {number}");
                            SampleCounts { good, ..SampleCounts::default() }
                        }
                        _ => count_samples(tile),
                    };
                }
                (bench, samples, written)
            },
        )
        .map(|(mut bench, samples, written)| {
            let rays = std::mem::take(&mut bench.counts);
            let worker_seconds = std::mem::take(&mut bench.seconds);
            lock().push(bench);
            TileSum { samples, rays, written, worker_seconds, ..TileSum::default() }
        })
        .reduce(TileSum::default, TileSum::plus)
}

/// Audits every sample of a finished frame. `differs`: for each pixel, whether the film shows anything else there than
/// the samples do; empty if it is known not to.
pub fn audit_tiles(stage: &Stage, store: &SampleStore, differs: &[bool]) -> AuditCounts {
    let tiles = store.tiles.par_iter().enumerate();
    let audit = tiles.map(|(number, tile)| audit::audit(stage, number, tile, differs));
    audit.reduce(AuditCounts::default, |mut a, b| {
        a += b;
        a
    })
}

/// One tile of one frame, from the samples of the frame before to what its cells show, as far as the film does not
/// show that already.
fn infer_tile(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    memo: &mut Memo,
    bench: &mut Workbench,
) -> Outcome {
    let Work { stage, standing, .. } = *work;
    let outcome = work.outcome_if_same(number, memo);
    if memo.is_at_rest && outcome == Outcome::AsBefore && !standing.is_needed(number) {
        return outcome;
    }
    bench.begin_tile();
    let change = if memo.is_at_rest {
        let begin = Instant::now();
        stay::keep_all(tile);
        bench.seconds.gather += begin.elapsed().as_secs_f64();
        Change::None
    } else {
        update_samples(work, number, tile, memo, bench)
    };
    if change != Change::None {
        memo.rest = None;
    }
    memo.is_settled = change == Change::None;
    memo.is_known = true;
    let outcome = match change {
        Change::None => outcome,
        Change::Rays => outcome.max(Outcome::Counts),
        Change::Samples => Outcome::New,
    };
    if outcome == Outcome::New || standing.is_needed(number) {
        let begin = Instant::now();
        enhance::enhance(stage, tile, bench);
        memo.goes_on = bench.radiance.has_secondary;
        memo.is_settled &= !memo.goes_on;
        if memo.goes_on && stage.notes_ways {
            std::mem::swap(memo.beyond.get_or_insert_default(), &mut bench.bounces.beyond);
        } else {
            memo.beyond = None;
        }
        bench.seconds.enhance += begin.elapsed().as_secs_f64();
    }
    outcome
}

/// Candidates that a cell asks at most, one after the other.
const MOST_ASKED: usize = 4;

/// Brings a tile's samples and their light up to date. Says how they differ from those of the frame before.
fn update_samples(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    memo: &mut Memo,
    bench: &mut Workbench,
) -> Change {
    let Work { stage, layout, source, .. } = *work;
    let mut clock = Instant::now();
    let mut lap = || std::mem::replace(&mut clock, Instant::now()).elapsed().as_secs_f64();
    let before = bench.counts;
    if let Some(estimate) = stage.estimate {
        estimate.count(number, &mut bench.counts, &mut bench.cell_rays);
    }
    bench.serving.begin();
    let took_cells = match source {
        Source::Nothing => {
            reproject::begin_base(stage, number, tile);
            true
        }
        Source::Stay(detached, bins) => {
            let before = bench.before.get_or_insert_with(|| Box::new(Tile::empty(layout)));
            stay::merge(detached, stage, bins, number, tile, before, &mut bench.serving)
        }
        Source::Fall(old, bins) => {
            reproject::gather(old, stage, bins, number, tile, &mut bench.serving);
            true
        }
    };
    bench.seconds.gather += lap();
    let among = stage.in_sight(number);
    let mut probes = CellSet::default();
    if !matches!(source, Source::Nothing) {
        let around = memo.rest.as_ref().map(|rest| &rest.around);
        let mut serving = std::mem::take(&mut bench.serving);
        let before = bench.before.take();
        let mut cells = CellSet::ALL;
        for asked in 1.. {
            verify::verify(stage, among, tile, &cells, around, serving.flags(), bench);
            let next = match source {
                _ if asked == MOST_ASKED => None,
                Source::Nothing => None,
                Source::Stay(detached, _) => {
                    serving.ask_next(stage.reuse, tile, &stay::tiles(detached, before.as_deref()))
                }
                Source::Fall(old, _) => serving.ask_next(stage.reuse, tile, &|source| old.tile(source)),
            };
            match next {
                Some(next) => cells = next,
                None => break,
            }
        }
        if matches!(source, Source::Fall(..)) && stage.reuse == Reuse::Target {
            let extent = stage.view.grid.extent_of(number);
            probes = serving.probes(extent, tile);
        }
        (bench.serving, bench.before) = (serving, before);
    }
    let flags = bench.serving.flags();
    bench.seconds.verify += lap();
    trace_missed::trace_missed(stage, number, among, tile, &probes, bench);
    bench.seconds.trace += lap();
    let (light_changed, around) = light::light(stage, tile, flags, bench);
    memo.around = around;
    bench.seconds.enhance += lap();
    if took_cells || light_changed || bench.counts.primary != before.primary {
        Change::Samples
    } else if bench.counts != before {
        Change::Rays
    } else {
        Change::None
    }
}

/// How a tile differs from what it was in the frame before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Change {
    /// Not at all: a frame older.
    None,
    /// Rays were cast, and met nothing that was not there before.
    Rays,
    /// In samples or light.
    Samples,
}

/// What of a tile must be written into the film: more and more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    /// Its age: all else stands there, colours perhaps apart that reach across tiles.
    AsBefore,
    /// Its age, and what its samples are counted by; all else as above.
    Counts,
    /// All.
    New,
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
    fn plus(mut self, other: Self) -> Self {
        self.samples += other.samples;
        self.rays += other.rays;
        self.written = self.written.plus(other.written);
        self.worker_seconds += other.worker_seconds;
        self
    }

    /// Adds the wall-clock time of the tiles to the phases, split by what the workers spent in each.
    pub fn share_time(&self, seconds: &mut Seconds) {
        let WorkerSeconds { gather, verify, trace, enhance, filter } = self.worker_seconds;
        let spent = gather + verify + trace + enhance + filter;
        let scale = if spent > 0.0 { self.wall / spent } else { 0.0 };
        seconds.reproject += gather * scale;
        seconds.verify += verify * scale;
        seconds.trace += trace * scale;
        seconds.enhance += enhance * scale;
        seconds.filter += filter * scale + self.develop;
    }
}
