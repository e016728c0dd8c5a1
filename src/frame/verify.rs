//! Verification: is what was reprojected still seen? (the paper's "Verification Phase", for the eye)
//!
//! Segments run from the eye to the sample, so that the rays of a tile start in one point and stay
//! together; what the segment is tested against is the [plan](super::plan::Plan)'s to say.

use super::plan::SightCheck;
use super::stage::{Stage, Workbench, bit};
use crate::samples::{BACKGROUND, Hot, Status, Tile};
use crate::trace::{Blockers, Coherence, NO_HIT, Purpose};

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
    if [false, true].map(|moved| stage.plan.sight_check(moved)).iter().all(|needed| *needed != check) {
        return;
    }
    bench.begin_rays();
    for (cell, (hot, cold)) in tile.hot.iter().zip(&tile.cold).enumerate() {
        let asked = cold.status.is_reused() && stage.plan.sight_check(stage.moved(hot)) == check;
        if asked && (check != SightCheck::Moved || may_be_hidden_by_mover(stage, hot)) {
            push_segment(stage, hot, cold.triangle, bench);
            bench.owners.push(cell as u32);
            bench.cell_rays[cell].verification += 1;
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
            tile.cold[*cell as usize].status = Status::Obscured;
        }
    }
}

#[inline]
fn may_be_hidden_by_mover(stage: &Stage, hot: &Hot) -> bool {
    let far = if hot.model == BACKGROUND { f32::INFINITY } else { SEGMENT_END };
    stage.movers.may_meet(stage.view.camera.eye, stage.offset(hot), far)
}

#[inline]
fn push_segment(stage: &Stage, hot: &Hot, triangle: u32, bench: &mut Workbench) {
    let (eye, offset) = (stage.view.camera.eye, stage.offset(hot));
    if hot.model == BACKGROUND {
        bench.rays.push_to_sample(eye, offset, 0.0, f32::INFINITY, NO_HIT, NO_HIT);
    } else {
        bench.rays.push_to_sample(eye, offset, 0.0, SEGMENT_END, hot.model, triangle);
    }
}
