//! What the targets of a tile see while the camera rests. Each sees the surface that its cell shows, as it did when it was
//! [asked](crate::frame::reuse::trace_missed); so nothing but what has moved since can be seen there instead.
//!
//! A sample that was traced for its cell lies on the ray through the target, and is seen at the target's tick: whether it is still seen says all. Others lie
//! beside, or are seen at other ticks.

use crate::frame::grid::bits::{set_bits, status_bits};
use crate::frame::grid::cells::CellSet;
use crate::frame::reuse::trace_missed::through_targets;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::tile_bounds::TileBounds;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::geometry::Bounds;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, CELLS, EMPTY, Status, Tile};
use crate::trace::{Coherence, HitBatch, NO_HIT, Occluders, Purpose, RayBatch, SceneSubset, Search};

/// Largest distance of a sample from the ray through its cell's target at which it counts as the target itself, as a share of the
/// distance from the eye: what the points of hits are rounded by, and those of models when they are placed.
const ON_RAY: f32 = 1e-5;

/// Rays through the targets of eight cells of tile number `number`, from cell `first` on; and a bit mask of those of their samples that lie
/// beside these rays, or are seen on them at other ticks.
fn beside_targets(frame: &FrameView, number: usize, tile: &Tile, first: usize) -> ([Vec3x8; 2], u8) {
    let grid = &frame.view.grid;
    let places = [F32x8::load(&grid.place_x, first), F32x8::load(&grid.place_y, first)];
    let [origins, directions] = through_targets(frame, number, places);
    let models = &tile.model[first..first + LANES];
    let [from, sights] = frame.sights(tile, first);
    let aside = (from + sights - origins).cross(directions);
    let most = sights.dot(sights) * directions.dot(directions) * F32x8::splat(ON_RAY * ON_RAY);
    let mut is_on = aside.dot(aside).le(most);
    if frame.pose.has_ticks() {
        // the target may see what moves at another time than the eye that sees the sample, on the same ray
        is_on = is_on
            & Mask::new(|lane| {
                tile.record[first + lane].traced.tick() == frame.view.tick_in_tile(number, first + lane)
            });
    }
    let is_sample = !Mask::equal(models, EMPTY);
    // what is seen of the background in an orthographic view has no place beside which it could lie
    let has_place = !Mask::equal(models, BACKGROUND);
    let may_be_beside = if frame.view.camera.is_orthographic() { is_sample & has_place } else { is_sample };
    ([origins, directions], (may_be_beside & !is_on).bits())
}

/// Bounds of what those targets of tile number `number` see of the models at rest beside which the samples lie; and the cells for which this
/// took a ray.
pub fn behind(frame: &FrameView, number: usize, tile: &Tile) -> (TileBounds, CellSet) {
    let (mut rays, mut hits, mut asked) = (RayBatch::default(), HitBatch::default(), CellSet::default());
    for first in (0..CELLS).step_by(LANES) {
        let ([origins, directions], beside) = beside_targets(frame, number, tile, first);
        rays.push_lanes(origins, directions, F32x8::splat(f32::INFINITY), beside);
        asked.insert_eight(first, beside);
    }
    if rays.is_empty() {
        return (TileBounds::NONE, asked);
    }
    frame.set_ticks_of_targets(&mut rays, number, asked.numbers());
    frame.tracer.closest(&rays, Search::from_eye(SceneSubset::Still, Coherence::Coherent), &mut hits);
    let (mut surfaces, mut sky) = (Bounds::EMPTY, Bounds::EMPTY);
    for ((packet, lanes), hits) in rays.packets().zip(&hits.packets) {
        for lane in set_bits(lanes) {
            let [origin, direction] = [&packet.origin, &packet.direction]
                .map(|all| glam::Vec3::from_array(all.map(|axis| axis[lane])));
            if hits.model[lane] == NO_HIT {
                sky = sky.with(direction);
            } else {
                surfaces = surfaces.with(origin + hits.t[lane] * direction);
            }
        }
    }
    (TileBounds::seen(surfaces, sky), asked)
}

/// Cells of tile number `number` whose targets may see something that moved, where their samples do not say so.
pub fn in_doubt(frame: &FrameView, number: usize, tile: &Tile, scratch: &mut TraceScratch) -> CellSet {
    let mut in_doubt = CellSet::default();
    scratch.begin_rays();
    let far = F32x8::splat(f32::INFINITY);
    for first in (0..CELLS).step_by(LANES) {
        let reused = status_bits(&tile.status[first..first + LANES], Status::is_reused);
        if reused == 0 {
            continue;
        }
        let ([origins, directions], beside) = beside_targets(frame, number, tile, first);
        let asked = reused & beside & frame.moved_bounds.may_meet(origins, directions, far);
        scratch.rays.push_lanes_to_samples(origins, directions, far, [&[NO_HIT; LANES]; 2], asked);
        for cell in set_bits(asked).map(|lane| first + lane) {
            scratch.owners.push(cell as u32);
            scratch.tally.cells.verification[cell] += 1;
        }
    }
    if scratch.owners.is_empty() {
        return in_doubt;
    }
    frame.set_ticks_of_targets(&mut scratch.rays, number, scratch.owners.iter().map(|cell| *cell as usize));
    scratch.tally.counts.verification += scratch.rays.count();
    scratch.begin_answers();
    let TraceScratch { rays, blocked, owners, .. } = scratch;
    frame.tracer.blocked(rays, Occluders::Moved, Purpose::Sight, Coherence::Coherent, blocked);
    for (owners, blocked) in owners.chunks(crate::trace::LANES).zip(blocked) {
        set_bits(*blocked).for_each(|lane| in_doubt.insert(owners[lane] as usize));
    }
    in_doubt
}
