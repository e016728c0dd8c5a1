//! Verification: tests if the server of a cell is still seen (the paper's "Verification Phase", for the eye).
//!
//! Segments run from the eye to the sample, so that the rays of a tile start in one point (or side by side)
//! and stay together. The models that a segment is tested against are chosen by the
//! [plan](crate::frame::shot::plan::Plan).

use super::sight::{Outdated, look_up, segment_ends, segments};
use crate::frame::grid::bits::{count_bits, set_bits, status_bits, surface_bits};
use crate::frame::grid::cells::{BLOCK, CellSet};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::SightCheck;
use crate::frame::shot::tile_bounds::TileBounds;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::LANES;
use crate::samples::{CELLS, Flags, Status, Tile};
use crate::trace::{Coherence, Occluders, Purpose, SceneSubset};

/// Cells of a tile to be verified.
#[derive(Debug, Clone, Copy)]
pub struct Request<'a> {
    /// Number of the tile.
    pub number: usize,
    /// Cells whose samples are verified.
    pub cells: &'a CellSet,
    /// Those of them that are proven to be seen.
    pub proven: &'a CellSet,
    /// Bounds of at least the samples of models that did not move, if they are known.
    pub bounds: Option<&'a TileBounds>,
    /// Flags that any sample of the tile has.
    pub flags: Flags,
}

/// Turns cells of a `request` whose samples are hidden now into `Obscured`; only models `among` these can
/// hide them. Samples whose look is another one, as they are seen now, are looked up anew.
pub fn verify(
    frame: &FrameView,
    among: SceneSubset,
    tile: &mut Tile,
    request: &Request,
    scratch: &mut TraceScratch,
) {
    let Request { cells, bounds, flags, .. } = *request;
    for first in (0..CELLS).step_by(LANES) {
        let reused = status_bits(&tile.status[first..first + LANES], Status::is_reused);
        let asked = reused & cells.eight(first);
        if asked != 0 {
            let Outdated { ended, restyled, footprints } = Outdated::find(frame, tile, first, flags);
            for lane in set_bits(asked & ended) {
                tile.status[first + lane] = Status::Obscured;
            }
            for lane in set_bits(asked & restyled) {
                look_up(frame, tile, first + lane, footprints[lane]);
                scratch.has_looked_up = true;
            }
        }
    }
    if frame.view.camera.is_orthographic() {
        give_up_background(frame, tile, request);
    }
    let may_be_hidden = || match bounds {
        Some(bounds) => bounds.may_be_hidden(frame, request.number),
        None => TileBounds::samples(frame, tile).may_be_hidden(frame, request.number),
    };
    if frame.plan.sight_check(false) == SightCheck::Moved && may_be_hidden() {
        verify_against(SightCheck::Moved, &[Occluders::Moved], frame, tile, request, scratch);
    }
    let occluders: &[Occluders] = match among {
        SceneSubset::All => &[Occluders::Still, Occluders::Movable],
        SceneSubset::Still => &[Occluders::Still],
    };
    verify_against(SightCheck::Everything, occluders, frame, tile, request, scratch);
}

/// Marks samples of the background as hidden, in an orthographic view, where anything may hide them. They
/// have no place there by which they could be verified: their cells are traced, which takes a ray as well.
fn give_up_background(frame: &FrameView, tile: &mut Tile, request: &Request) {
    let is_in_doubt = match frame.plan.sight_check(false) {
        SightCheck::Everything => true,
        SightCheck::Moved => {
            let sights = frame.view.sights_of_tile(request.number);
            frame.moved_bounds.may_meet_sweep(&sights)
        }
        SightCheck::Nothing => false,
    };
    if !is_in_doubt {
        return;
    }
    for first in (0..CELLS).step_by(LANES) {
        let reused = status_bits(&tile.status[first..first + LANES], Status::is_reused);
        let background = !surface_bits(&tile.model[first..first + LANES]);
        for lane in set_bits(reused & background & request.cells.eight(first)) {
            tile.status[first + lane] = Status::Obscured;
        }
    }
}

/// Tests the segments of all samples whose check is `check` against `occluders`.
fn verify_against(
    check: SightCheck,
    occluders: &[Occluders],
    frame: &FrameView,
    tile: &mut Tile,
    request: &Request,
    scratch: &mut TraceScratch,
) {
    let Request { cells, proven, flags, .. } = *request;
    let [for_still, for_moved] = [false, true].map(|moved| frame.plan.sight_check(moved) == check);
    let any_unseen = flags.has(Flags::UNSEEN);
    let for_unseen = any_unseen && check == SightCheck::Everything;
    // samples of the background that are left in an orthographic view cannot be hidden
    let asks_background = !frame.view.camera.is_orthographic();
    if !for_still && !for_moved && !for_unseen {
        return;
    }
    scratch.begin_rays();
    let asked: [u16; CELLS / BLOCK] = std::array::from_fn(|block| {
        let bits = |half: usize| {
            let first = block * BLOCK + half;
            let moved = frame.moved_bits(&tile.model[first..first + LANES]);
            let unseen = if any_unseen { tile.flagged(first, Flags::UNSEEN) } else { 0 };
            let seen = if for_still { !moved } else { 0 } | if for_moved { moved } else { 0 };
            let checked = seen & !unseen | if for_unseen { unseen } else { 0 };
            let checked = if asks_background {
                checked
            } else {
                checked & surface_bits(&tile.model[first..first + LANES])
            };
            let reused = checked & status_bits(&tile.status[first..first + LANES], Status::is_reused);
            let asked = cells.eight(first) & !proven.eight(first);
            may_be_hidden_bits(check, frame, tile, first, reused & asked)
        };
        u16::from_le_bytes([bits(0), bits(LANES)])
    });
    push_segments(frame, tile, &asked, scratch);
    frame.set_ticks_of_samples(&mut scratch.rays, tile, &scratch.owners);
    scratch.tally.counts.verification += scratch.rays.count();
    scratch.begin_answers();
    for by in occluders {
        let blocked = &mut scratch.blocked;
        frame.tracer.blocked(&scratch.rays, *by, Purpose::Sight, Coherence::Coherent, blocked);
    }
    for (owners, blocked) in
        scratch.owners.chunks(BLOCK).zip(&scratch.blocked).filter(|(_, blocked)| **blocked != 0)
    {
        for (_, cell) in owners.iter().enumerate().filter(|(lane, _)| blocked >> lane & 1 != 0) {
            tile.status[*cell as usize] = Status::Obscured;
        }
    }
    if for_unseen {
        for first in (0..CELLS).step_by(LANES) {
            tile.unflag(first, (asked[first / BLOCK] >> (first % BLOCK)) as u8, Flags::UNSEEN);
        }
    }
}

/// Bit mask of those of eight samples that are `asked` for and may be hidden.
#[inline]
fn may_be_hidden_bits(check: SightCheck, frame: &FrameView, tile: &Tile, first: usize, asked: u8) -> u8 {
    if check != SightCheck::Moved || asked == 0 {
        return asked;
    }
    let ([origins, sights], far) =
        (frame.sights(tile, first), segment_ends(&tile.model[first..first + LANES]));
    asked & frame.moved_bounds.may_meet(origins, sights, far)
}

/// Adds the segments to the samples that are `asked` for, a bit each. Blocks of which most are asked for
/// become packets as they are; samples of other blocks are packed one after the other.
fn push_segments(frame: &FrameView, tile: &Tile, asked: &[u16; CELLS / BLOCK], scratch: &mut TraceScratch) {
    // a packet with a few empty lanes costs Embree no more than a full one, and packing rays anew costs more
    const LEAST_WHOLE: u32 = 12;
    for (first, asked) in (0..CELLS).step_by(BLOCK).zip(asked) {
        for half in [0, LANES] {
            let bits = (asked >> half) as u8;
            count_bits(bits, &mut scratch.tally.cells.verification[first + half..first + half + LANES]);
        }
        if asked.count_ones() >= LEAST_WHOLE {
            let segments = [first, first + LANES].map(|first| {
                let [origins, sights] = frame.sights(tile, first);
                (origins, sights, segment_ends(&tile.model[first..first + LANES]))
            });
            let triangles = std::array::from_fn::<_, BLOCK, _>(|lane| tile.record[first + lane].triangle);
            let own = [&tile.model[first..first + BLOCK], &triangles];
            scratch.rays.push_packet_to_samples(&segments, own, *asked);
            scratch.owners.extend(first as u32..(first + BLOCK) as u32);
        }
    }
    for (first, asked) in
        (0..CELLS).step_by(BLOCK).zip(asked).filter(|(_, asked)| asked.count_ones() < LEAST_WHOLE)
    {
        for half in [0, LANES] {
            let bits = (asked >> half) as u8;
            if bits != 0 {
                segments(frame, tile, first + half, bits, &mut scratch.rays);
                scratch.owners.extend(set_bits(bits).map(|lane| (first + half + lane) as u32));
            }
        }
    }
}
