//! The phases of a tile: the paper's overview, in its order.
//!
//! | the paper's phase | calls of [`render_tile`] |
//! |---|---|
//! | Reprojection | `resolve`: samples of the frame before serve cells |
//! | Verification, for the eye | `verify_servers` |
//! | primary rays | `trace_missed` |
//! | Verification, for shadows; Color Calculation | `indirect`, `reflected`, `occlusion`, `direct`: light that is kept, and does not depend on the eye |
//! | Enhancement | `enhance`: light that depends on the eye |
//! | Filtering | `filter` |
//!
//! Before a camera at rest most tiles need none of them, or the last ones alone: see [`remake`](crate::frame::static_camera::remake).

use std::time::Instant;

use super::contrast::{TileColors, note_colors};
use super::input::{Reused, Start, Work};
use super::thread_scratch::ThreadScratch;
use crate::changes::Until;
use crate::frame::film::filter::{self, FilterInput};
use crate::frame::film::spread::TileFilm;
use crate::frame::grid::cells::CellSet;
use crate::frame::light::{direct, indirect, occlusion, reflected};
use crate::frame::planes::channels::NonZeroPlanes;
use crate::frame::planes::window::Window;
use crate::frame::reuse::own_triangle;
use crate::frame::reuse::proofs;
use crate::frame::reuse::target::Seen;
use crate::frame::reuse::verify::{self, Request};
use crate::frame::reuse::{reproject, trace_missed};
use crate::frame::secondary::enhance;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::static_camera;
use crate::frame::static_camera::remake::{Change, DirtyLevel};
use crate::frame::static_camera::sight;
use crate::frame::static_camera::tile_state::TileState;
use crate::samples::{Flags, Sample, Status, Tile};
use crate::settings::Reuse;
use crate::stats::SampleCounts;
use crate::trace::SceneSubset;

/// The parts of one tile: its samples, and all that is remembered of it or adds up in it.
pub struct TileParts<'a> {
    pub tile: &'a mut Tile,
    pub state: &'a mut TileState,
    /// Its colours, for finer levels of samples.
    pub colors: &'a mut TileColors,
    /// Sums of a wide filter.
    pub film: &'a mut TileFilm,
}

/// Seconds since the phase at work began.
struct Clock(Instant);

impl Clock {
    /// Adds what has passed to the `seconds` of a phase. The next one begins.
    fn lap(&mut self, seconds: &mut f64) {
        *seconds += std::mem::replace(&mut self.0, Instant::now()).elapsed().as_secs_f64();
    }
}

/// Takes tile number `number` through all phases that it needs, from the samples of the frame before to its pixels in `window`. Returns
/// what was written.
pub fn render_tile(
    work: &Work,
    number: usize,
    parts: TileParts,
    window: &mut Window,
    scratch: &mut ThreadScratch,
) -> (SampleCounts, NonZeroPlanes) {
    let TileParts { tile, state, colors, film } = parts;
    let remake = infer_tile(work, number, tile, state, scratch);
    state.was_written = remake >= DirtyLevel::Picture;
    if work.frame.notes_colors && state.was_written && !work.frame.wanted_of(number).is_empty() {
        note_colors(&scratch.radiance, colors);
    }
    let mut clock = Clock(Instant::now());
    let written = write_pixels(work, number, remake, (tile, film, state), window, scratch);
    clock.lap(&mut scratch.seconds.filter);
    (samples_of(work.frame, number, remake, tile), written)
}

/// Brings samples, light and colours of a tile up to date, as far as the film does not show them already. Returns what must be written.
fn infer_tile(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    state: &mut TileState,
    scratch: &mut ThreadScratch,
) -> DirtyLevel {
    let Work { frame, .. } = *work;
    let mut facts = work.facts(number, state);
    if facts.remake() == DirtyLevel::Age {
        return DirtyLevel::Age;
    }
    scratch.begin_tile();
    let mut clock = Clock(Instant::now());
    if facts.samples == Change::None {
        static_camera::keep_all(tile);
        clock.lap(&mut scratch.seconds.resolve);
    } else {
        facts.samples = update_samples(work, number, tile, state, scratch);
        clock = Clock(Instant::now());
    }
    if facts.samples != Change::None {
        state.content = None;
    }
    let remake = facts.remake();
    state.was_quiet = facts.samples == Change::None;
    state.is_known = true;
    if (remake >= DirtyLevel::Picture || facts.is_needed) && !frame.wanted_of(number).is_empty() {
        let ThreadScratch { radiance, bounces, placed, trace, .. } = &mut *scratch;
        let trees = Some(&mut state.trees);
        let casts_rays = enhance::enhance(frame, (number, tile), radiance, bounces, trees, placed, trace);
        state.shows_mirrored = !bounces.mirrors.of_tile.used.is_empty();
        std::mem::swap(&mut state.mirrored, &mut bounces.mirrors.of_tile);
        state.goes_on = radiance.is_followed;
        state.was_quiet &= !casts_rays;
        clock.lap(&mut scratch.seconds.light);
    }
    remake
}

/// Brings a tile's samples and their light up to date. Returns how they differ from those of the frame before.
fn update_samples(
    work: &Work,
    number: usize,
    tile: &mut Tile,
    state: &mut TileState,
    scratch: &mut ThreadScratch,
) -> Change {
    let Work { frame, start: Start { estimate, .. }, .. } = *work;
    let mut clock = Clock(Instant::now());
    let counts_before = scratch.trace.tally.counts;
    estimate.count(number, &mut scratch.trace.tally);
    let asked = std::mem::take(&mut state.asked);
    scratch.trace.tally.counts.primary += asked.count() as u64;
    asked.numbers().for_each(|cell| scratch.trace.tally.cells.primary[cell] += 1);
    state.trees.note_roots(tile, &mut scratch.roots);

    let took_cells = resolve(work, number, tile, scratch);
    clock.lap(&mut scratch.seconds.resolve);
    if frame.wanted_of(number).is_empty() {
        (state.until, state.bounds) = (Until::FOREVER, None);
        return Change::Samples;
    }

    let among = frame.in_sight(number);
    let asked = verify_servers(work, number, among, tile, state, scratch);
    clock.lap(&mut scratch.seconds.verify);

    trace_cells(work, number, among, (tile, &asked), scratch);
    let ThreadScratch { trace, seconds, lighting, placed, paths, occlusion, roots, serving, .. } = scratch;
    let flags = serving.flags();
    tile.spares.trim();
    state.trees.forget_others(tile, roots);
    clock.lap(&mut seconds.trace);

    let ticks = frame.ticks_of(tile);
    let frame = &FrameView { ticks: ticks.as_ref(), ..*frame };
    let (indirect_changed, until) = indirect::gather(frame, tile, placed, paths, &mut trace.tally);
    let (reflected_changed, reflected_until) = reflected::renew(frame, tile, placed, paths, &mut trace.tally);
    let (openness_changed, open_until) =
        occlusion::find_openness(frame, tile, placed, occlusion, &mut trace.tally);
    let is_stale = indirect_changed || openness_changed || trace.has_looked_up;
    let flags = flags.with(Flags::STALE.when(is_stale));
    let (light_changed, bounds) = direct::light(frame, tile, flags, lighting, placed, &mut trace.tally);
    tile.compact();
    (state.until, state.bounds) = (until.min(open_until).min(reflected_until), bounds);
    clock.lap(&mut seconds.light);

    let counts = trace.tally.counts;
    let kept_light_changed = light_changed || openness_changed || reflected_changed;
    if took_cells || kept_light_changed || counts.primary != counts_before.primary {
        Change::Samples
    } else if counts != counts_before {
        Change::Rays
    } else {
        Change::None
    }
}

/// Finds for each cell the sample of the frame before that serves it, if there is one. Returns true if any cell was given another one.
fn resolve(work: &Work, number: usize, tile: &mut Tile, scratch: &mut ThreadScratch) -> bool {
    let Work { frame, layout, start: Start { reused, .. }, .. } = *work;
    let ThreadScratch { serving, before, .. } = scratch;
    serving.begin();
    match reused {
        Reused::None => {
            reproject::begin_base(frame, number, tile);
            true
        }
        Reused::InPlace(detached, bins) => {
            let before = before.get_or_insert_with(|| Box::new(Tile::empty(layout)));
            static_camera::merge(detached, frame, bins, number, tile, before, serving)
        }
        Reused::Projected(old, bins, beside) => {
            reproject::resolve((old, beside.as_ref()), frame, bins, number, tile, serving);
            true
        }
    }
}

/// Candidates that a cell asks at most, one after the other.
const MOST_ASKED: usize = 4;

/// Verifies the samples that serve cells; where one is hidden, the next candidate is asked. Returns the cells whose targets are to be asked
/// what they see.
fn verify_servers(
    work: &Work,
    number: usize,
    among: SceneSubset,
    tile: &mut Tile,
    state: &TileState,
    scratch: &mut ThreadScratch,
) -> CellSet {
    let Work { frame, start: Start { reused, .. }, .. } = *work;
    let ThreadScratch { serving, before, trace, proofs, .. } = scratch;
    if matches!(reused, Reused::None) {
        return CellSet::default();
    }
    let is_still = among == SceneSubset::Still;
    let mut proven = frame
        .proofs
        .map_or(CellSet::default(), |of_frame| proofs::find(frame, of_frame, is_still, tile, proofs));
    let content = state.content.as_ref();
    let mut cells = CellSet::ALL;
    for asked in 1.. {
        let bounds = content.map(|content| &content.bounds);
        let request = Request { number, cells: &cells, proven: &proven, bounds, flags: serving.flags() };
        verify::verify(frame, among, tile, &request, trace);
        if asked == MOST_ASKED {
            break;
        }
        match serving.ask_next(frame.settings.reuse, tile, &reused.sources(before.as_deref())) {
            Some(next) => (cells, proven) = (next, proven.without(&next)),
            None => break,
        }
    }
    if frame.settings.reuse == Reuse::Paper {
        return CellSet::default();
    }
    let given = serving.given(tile).without(&proven);
    let may_see_moved = frame.plan.any_moved
        && matches!(reused, Reused::InPlace(..))
        && content.is_none_or(|content| content.sight.may_be_hidden(frame, number));
    if may_see_moved { given.or(&sight::in_doubt(frame, number, tile, trace)) } else { given }
}

/// Traces what is missing, and asks the targets of the cells in `asked` what they see.
fn trace_cells(
    work: &Work,
    number: usize,
    among: SceneSubset,
    (tile, asked): (&mut Tile, &CellSet),
    scratch: &mut ThreadScratch,
) {
    let Work { frame, start: Start { reused, .. }, .. } = *work;
    let ThreadScratch { serving, before, trace, .. } = scratch;
    let asked = &asked.without(&own_triangle::confirmed(frame, number, among, (tile, asked), trace));
    let (sources, lenders) = (reused.sources(before.as_deref()), reused.lenders());
    let moved = |model: u32| frame.moved(model);
    let mut replace = |tile: &mut Tile, cell: usize, seen: &Seen| {
        let shows = |sample: &Sample| seen.is_shown_by(frame, sample);
        serving.replace(cell, tile, moved, (&sources, &lenders), shows)
    };
    trace_missed::trace_missed(frame, number, among, (tile, asked), &mut replace, trace);
}

/// Writes of a tile what the film does not show yet.
fn write_pixels(
    work: &Work,
    number: usize,
    remake: DirtyLevel,
    (tile, film, state): (&Tile, &mut TileFilm, &mut TileState),
    window: &mut Window,
    scratch: &mut ThreadScratch,
) -> NonZeroPlanes {
    let Work { frame, picture, dirty, .. } = *work;
    let ThreadScratch { filtering, radiance, placed, trace, .. } = scratch;
    if dirty.is_needed(number) {
        state.asks_beside = filter::sum(frame, number, tile, filtering, radiance, trace, film);
        // which took rays
        state.was_quiet &= !state.asks_beside;
    }
    let cell_rays = &*trace.tally.cells;
    match remake {
        DirtyLevel::Age => filter::stay(frame, number, picture, window),
        DirtyLevel::Counts => filter::recount(frame, number, tile, filtering, cell_rays, picture, window),
        DirtyLevel::Picture | DirtyLevel::Samples => {
            let shown = FilterInput { radiance, placed, cell_rays };
            filter::filter(frame, number, tile, filtering, shown, picture, window)
        }
    }
}

/// Counts the samples of a tile by status.
fn samples_of(frame: &FrameView, number: usize, remake: DirtyLevel, tile: &Tile) -> SampleCounts {
    if remake == DirtyLevel::Age && frame.wanted.is_none() {
        let good = frame.view.grid.cells(number);
        debug_assert_eq!(count_samples(tile).good, good, "tile {number}");
        return SampleCounts { good, ..SampleCounts::default() };
    }
    count_samples(tile)
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
