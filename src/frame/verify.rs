//! Verification: is what serves a cell still seen? (the paper's "Verification Phase", for the eye)
//!
//! Segments run from the eye to the sample, so that the rays of a tile start in one point and stay
//! together; what the segment is tested against is the [plan](super::plan::Plan)'s to say.

use super::bits::{count_bits, set_bits, status_bits};
use super::plan::SightCheck;
use super::reproject::seen_from_behind;
use super::rest::Around;
use super::stage::{Stage, Workbench};
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, CELLS, Flags, Status, Tile};
use crate::trace::{Among, Blockers, Coherence, Purpose, RayBatch};

/// Where a verification segment ends, as a share of the way from the eye to the sample.
///
/// Short of 1 by what rounding may put between a sample and its neighbours on the same surface. The
/// sample's own triangle never counts, so that the rest can be this tight: an occluder nearer to the
/// sample than this is taken for the sample's own surface, and a hit on a neighbouring triangle costs one
/// ray and no error. The [audit](super::audit) tolerates no more.
pub const SEGMENT_END: f32 = 1.0 - 1e-5;

/// Cells of a block, which is a packet.
const BLOCK: usize = crate::trace::LANES;

/// Cells of a tile, a bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellSet([u16; CELLS / BLOCK]);

impl CellSet {
    /// All cells.
    pub const ALL: Self = Self([u16::MAX; CELLS / BLOCK]);

    /// Adds a cell.
    #[inline(always)]
    pub fn insert(&mut self, cell: usize) {
        self.0[cell / BLOCK] |= 1 << (cell % BLOCK);
    }

    /// Of eight cells from `first` on, those in it, a bit each.
    #[inline(always)]
    pub fn eight(&self, first: usize) -> u8 {
        (self.0[first / BLOCK] >> (first % BLOCK)) as u8
    }

    /// Whether no cell is in it.
    pub fn is_empty(&self) -> bool {
        self.0 == [0; CELLS / BLOCK]
    }
}

impl Default for CellSet {
    fn default() -> Self {
        Self([0; CELLS / BLOCK])
    }
}

/// Turns those of `cells` whose sample is hidden now into `Obscured`; nothing can hide them but what is `among`.
/// `around` has at least the samples of models that did not move, if that is known; `flags`: those that any sample has.
pub fn verify(
    stage: &Stage,
    among: Among,
    tile: &mut Tile,
    cells: &CellSet,
    around: Option<&Around>,
    flags: Flags,
    bench: &mut Workbench,
) {
    for first in (0..CELLS).step_by(LANES) {
        let reused = status_bits(&tile.status[first..first + LANES], Status::is_reused);
        let asked = reused & cells.eight(first);
        if asked != 0 {
            for lane in set_bits(asked & seen_from_behind(stage, tile, first, flags)) {
                tile.status[first + lane] = Status::Obscured;
            }
        }
    }
    let may_be_hidden = || match around {
        Some(around) => around.may_be_hidden(stage),
        None => Around::samples(stage, tile).may_be_hidden(stage),
    };
    if stage.plan.sight_check(false) == SightCheck::Moved && may_be_hidden() {
        verify_against(SightCheck::Moved, &[Blockers::Moved], stage, tile, cells, flags, bench);
    }
    let blockers: &[Blockers] = match among {
        Among::All => &[Blockers::Still, Blockers::Movable],
        Among::Still => &[Blockers::Still],
    };
    verify_against(SightCheck::Everything, blockers, stage, tile, cells, flags, bench);
}

/// Sends the segments of all samples whose check is `check` against `blockers`.
fn verify_against(
    check: SightCheck,
    blockers: &[Blockers],
    stage: &Stage,
    tile: &mut Tile,
    cells: &CellSet,
    flags: Flags,
    bench: &mut Workbench,
) {
    let [for_still, for_moved] = [false, true].map(|moved| stage.plan.sight_check(moved) == check);
    let any_unseen = flags.has(Flags::UNSEEN);
    let for_unseen = any_unseen && check == SightCheck::Everything;
    if !for_still && !for_moved && !for_unseen {
        return;
    }
    bench.begin_rays();
    let asked: [u16; CELLS / BLOCK] = std::array::from_fn(|block| {
        let bits = |half: usize| {
            let first = block * BLOCK + half;
            let moved = stage.moved_bits(&tile.model[first..first + LANES]);
            let unseen = if any_unseen { tile.flagged(first, Flags::UNSEEN) } else { 0 };
            let seen = if for_still { !moved } else { 0 } | if for_moved { moved } else { 0 };
            let checked = seen & !unseen | if for_unseen { unseen } else { 0 };
            let reused = checked & status_bits(&tile.status[first..first + LANES], Status::is_reused);
            may_be_hidden_bits(check, stage, tile, first, reused & cells.eight(first))
        };
        u16::from_le_bytes([bits(0), bits(LANES)])
    });
    push_segments(stage, tile, &asked, bench);
    bench.counts.verification += bench.rays.count();
    bench.begin_answers();
    for by in blockers {
        let blocked = &mut bench.blocked;
        stage.tracer.blocked(&bench.rays, *by, Purpose::Sight, Coherence::Coherent, blocked);
    }
    for (owners, blocked) in
        bench.owners.chunks(BLOCK).zip(&bench.blocked).filter(|(_, blocked)| **blocked != 0)
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
/// Of eight samples those that are `asked` for and may be hidden.
#[inline]
fn may_be_hidden_bits(check: SightCheck, stage: &Stage, tile: &Tile, first: usize, asked: u8) -> u8 {
    if check != SightCheck::Moved || asked == 0 {
        return asked;
    }
    let (offsets, far) = (stage.offsets(tile, first), segment_ends(&tile.model[first..first + LANES]));
    asked & stage.movers.may_meet(Vec3x8::splat(stage.view.camera.eye), offsets, far)
}

/// Sends the segments to the samples that are `asked` for, a bit each: blocks of which most are asked as the
/// packets that they are, and what is left one after the other.
fn push_segments(stage: &Stage, tile: &Tile, asked: &[u16; CELLS / BLOCK], bench: &mut Workbench) {
    // a packet with a few empty lanes costs Embree no more than a full one, and to pack rays anew is dearer
    const LEAST_WHOLE: u32 = 12;
    for (first, asked) in (0..CELLS).step_by(BLOCK).zip(asked) {
        for half in [0, LANES] {
            let bits = (asked >> half) as u8;
            count_bits(bits, &mut bench.cell_rays.verification[first + half..first + half + LANES]);
        }
        if asked.count_ones() >= LEAST_WHOLE {
            let ways = [first, first + LANES]
                .map(|first| (stage.offsets(tile, first), segment_ends(&tile.model[first..first + LANES])));
            let triangles = std::array::from_fn::<_, BLOCK, _>(|lane| tile.record[first + lane].triangle);
            let own = [&tile.model[first..first + BLOCK], &triangles];
            bench.rays.push_packet_to_samples(stage.view.camera.eye, ways, own, *asked);
            bench.owners.extend(first as u32..(first + BLOCK) as u32);
        }
    }
    for (first, asked) in
        (0..CELLS).step_by(BLOCK).zip(asked).filter(|(_, asked)| asked.count_ones() < LEAST_WHOLE)
    {
        for half in [0, LANES] {
            let bits = (asked >> half) as u8;
            if bits != 0 {
                segments(stage, tile, first + half, bits, &mut bench.rays);
                bench.owners.extend(set_bits(bits).map(|lane| (first + half + lane) as u32));
            }
        }
    }
}

/// Adds the segments from the eye to those of eight samples whose bit is set.
pub fn segments(stage: &Stage, tile: &Tile, first: usize, wanted: u8, rays: &mut RayBatch) {
    let models = &tile.model[first..first + LANES];
    // nothing is the background's own: its number is that of no hit
    let triangles = tile.triangles(first);
    let own = [models, &triangles[..]];
    let (eye, far) = (Vec3x8::splat(stage.view.camera.eye), segment_ends(models));
    rays.push_lanes_to_samples(eye, stage.offsets(tile, first), far, own, wanted);
}

/// Where the segments to eight samples end.
fn segment_ends(models: &[u32]) -> F32x8 {
    let background = Mask::equal(models, BACKGROUND);
    background.select(F32x8::splat(f32::INFINITY), F32x8::splat(SEGMENT_END))
}
