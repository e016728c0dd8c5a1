//! Verification: is what was reprojected still seen? (the paper's "Verification Phase", for the eye)
//!
//! Segments run from the eye to the sample, so that the rays of a tile start in one point and stay
//! together; what the segment is tested against is the [plan](super::plan::Plan)'s to say.

use super::movers::{Bounds, Sweep};
use super::plan::SightCheck;
use super::stage::{Stage, Workbench, bit, count_bits, set_bits};
use crate::lanes::{LANES, Lanes, Lanes3, Mask};
use crate::samples::{BACKGROUND, CELLS, Status, Tile};
use crate::trace::{Blockers, Coherence, Purpose, RayBatch};

/// Where a verification segment ends, as a share of the way from the eye to the sample.
///
/// Short of 1 by what rounding may put between a sample and its neighbours on the same surface. The
/// sample's own triangle never counts, so that the rest can be this tight: an occluder nearer to the
/// sample than this is taken for the sample's own surface, and a hit on a neighbouring triangle costs one
/// ray and no error. The [audit](super::audit) tolerates no more.
pub const SEGMENT_END: f32 = 1.0 - 1e-5;

/// Turns reused samples that are hidden now into `Obscured`.
pub fn verify(stage: &Stage, tile: &mut Tile, bench: &mut Workbench) {
    verify_against(SightCheck::Moved, &[Blockers::Moved], stage, tile, bench);
    verify_against(SightCheck::Everything, &[Blockers::Still, Blockers::Movable], stage, tile, bench);
}

/// Sends the segments of all samples whose check is `check` against `blockers`.
fn verify_against(
    check: SightCheck,
    blockers: &[Blockers],
    stage: &Stage,
    tile: &mut Tile,
    bench: &mut Workbench,
) {
    let [for_still, for_moved] = [false, true].map(|moved| stage.plan.sight_check(moved) == check);
    if !for_still && !for_moved {
        return;
    }
    if check == SightCheck::Moved && !may_be_hidden(stage, tile) {
        return;
    }
    bench.begin_rays();
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let moved = stage.moved_bits(models);
        let checked = if for_still { !moved } else { 0 } | if for_moved { moved } else { 0 };
        let asked = checked & reused_bits(&tile.status[first..first + LANES]);
        if asked != 0 {
            push_segments(check, stage, tile, first, asked, bench);
        }
    }
    bench.counts.verification += bench.rays.len() as u64;
    bench.begin_answers();
    for by in blockers {
        let blocked = &mut bench.blocked;
        stage.tracer.blocked(&bench.rays, *by, Purpose::Sight, Coherence::Coherent, blocked);
    }
    for (ray, cell) in bench.owners.iter().enumerate() {
        if bit(&bench.blocked, ray) {
            tile.status[*cell as usize] = Status::Obscured;
        }
    }
}

/// Whether anything that moved may be between the eye and any sample of a tile. A `false` is certain.
fn may_be_hidden(stage: &Stage, tile: &Tile) -> bool {
    let eye = stage.view.camera.eye;
    let [surfaces, sky] = [false, true].map(|background| Bounds::of_samples(stage, tile, background));
    let hides = |bounds: &Bounds, sweep: Sweep| !bounds.is_empty() && stage.movers.may_meet_sweep(&sweep);
    hides(&surfaces, Sweep::between(&Bounds::at(eye), &surfaces)) || hides(&sky, Sweep::fan(eye, &sky))
}

/// Of eight cells, those whose sample was there in the frame before.
#[inline]
fn reused_bits(status: &[Status]) -> u8 {
    status.iter().enumerate().fold(0, |bits, (lane, status)| bits | u8::from(status.is_reused()) << lane)
}

/// Sends the segments to those of eight samples that are `asked` for and may be hidden.
fn push_segments(
    check: SightCheck,
    stage: &Stage,
    tile: &Tile,
    first: usize,
    mut asked: u8,
    bench: &mut Workbench,
) {
    if check == SightCheck::Moved {
        let (offsets, far) = (stage.offsets(tile, first), segment_ends(&tile.model[first..first + LANES]));
        asked &= stage.movers.may_meet(Lanes3::splat(stage.view.camera.eye), offsets, far);
    }
    segments(stage, tile, first, asked, &mut bench.rays);
    bench.owners.extend(set_bits(asked).map(|lane| (first + lane) as u32));
    count_bits(asked, &mut bench.cell_rays.verification[first..first + LANES]);
}

/// Adds the segments from the eye to those of eight samples whose bit is set.
pub fn segments(stage: &Stage, tile: &Tile, first: usize, wanted: u8, rays: &mut RayBatch) {
    let models = &tile.model[first..first + LANES];
    // nothing is the background's own: its number is that of no hit
    let own = [models, &tile.triangle[first..first + LANES]];
    let (eye, far) = (Lanes3::splat(stage.view.camera.eye), segment_ends(models));
    rays.push_lanes_to_samples(eye, stage.offsets(tile, first), far, own, wanted);
}

/// Where the segments to eight samples end.
fn segment_ends(models: &[u32]) -> Lanes {
    let background = Mask::equal(models, BACKGROUND);
    background.select(Lanes::splat(f32::INFINITY), Lanes::splat(SEGMENT_END))
}
