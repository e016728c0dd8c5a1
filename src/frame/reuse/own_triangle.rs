//! Targets that see the triangle on which the server lies. Where the ray through the target meets that triangle is a matter of
//! arithmetic; whether anything hides the place is one segment, which costs less than a search for the first hit.

use super::sight::SEGMENT_END;
use super::trace_missed::through_targets;
use crate::frame::grid::bits::set_bits;
use crate::frame::grid::cells::CellSet;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8, are_same};
use crate::samples::{CELLS, EMPTY, Tile};
use crate::trace::{self, Coherence, Occluders, Purpose, SceneSubset};

/// Least barycentric weight of a point that counts as within a triangle: nearer to an edge, rounding might decide which triangle is met.
const WITHIN: f32 = 1e-4;

/// Finds those of the cells in `asked` whose targets see the triangle on which their servers lie, as far as that is easily said.
/// Nothing but models `among` these can hide it.
pub fn confirmed(
    frame: &FrameView,
    number: usize,
    among: SceneSubset,
    (tile, asked): (&Tile, &CellSet),
    scratch: &mut TraceScratch,
) -> CellSet {
    let mut confirmed = CellSet::default();
    scratch.begin_rays();
    for first in (0..CELLS).step_by(LANES) {
        let asked = asked.eight(first);
        if asked != 0 {
            push_segments(frame, number, tile, (first, asked), scratch);
        }
    }
    if scratch.owners.is_empty() {
        return confirmed;
    }
    frame.set_ticks_of_targets(&mut scratch.rays, number, scratch.owners.iter().map(|cell| *cell as usize));
    scratch.tally.counts.primary += scratch.rays.count();
    scratch.begin_answers();
    let TraceScratch { rays, blocked, owners, .. } = scratch;
    let occluders: &[Occluders] = match among {
        SceneSubset::All => &[Occluders::Still, Occluders::Movable],
        SceneSubset::Still => &[Occluders::Still],
    };
    for by in occluders {
        frame.tracer.blocked(rays, *by, Purpose::Sight, Coherence::Coherent, blocked);
    }
    for (owners, blocked) in owners.chunks(trace::LANES).zip(blocked) {
        let seen = (0..owners.len()).filter(|lane| *blocked >> lane & 1 == 0);
        seen.for_each(|lane| confirmed.insert(owners[lane] as usize));
    }
    confirmed
}

/// Adds the segments from the eye to where the targets of eight cells see their servers' triangles, for those in `asked` that do.
#[inline(always)]
fn push_segments(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    (first, asked): (usize, u8),
    scratch: &mut TraceScratch,
) {
    let (models, triangles) = (&tile.model[first..first + LANES], tile.triangles(first));
    let asked = asked & !frame.displaced_bits(models);
    let of_lane = |lane: usize| {
        let model = models[lane];
        let mesh = (model < EMPTY).then(|| &*frame.scene.models[model as usize].mesh);
        mesh.filter(|mesh| mesh.cut.is_none())?.as_triangles()
    };
    let (mut corners, mut within) = ([Vec3x8::ZERO; 3], 0);
    if are_same(models) && are_same(&triangles) {
        let Some(all) = of_lane(0) else { return };
        (corners, within) = (all.positions_of(triangles[0]).map(Vec3x8::splat), asked);
    } else {
        for lane in set_bits(asked) {
            let Some(all) = of_lane(lane) else { continue };
            corners
                .iter_mut()
                .zip(all.positions_of(triangles[lane]))
                .for_each(|(corners, corner)| corners.set_lane(lane, corner));
            within |= 1 << lane;
        }
    }
    if within == 0 {
        return;
    }
    let grid = &frame.view.grid;
    let places = [F32x8::load(&grid.place_x, first), F32x8::load(&grid.place_y, first)];
    let [origins, directions] = through_targets(frame, number, places);
    // T. Möller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997
    let [a, b, c] = corners;
    let (ab, ac, to_origin) = (b - a, c - a, origins - a);
    let (across, aside) = (directions.cross(ac), to_origin.cross(ab));
    let size = ab.dot(across);
    let (u, v, t) = (to_origin.dot(across) / size, directions.dot(aside) / size, ac.dot(aside) / size);
    let least = F32x8::splat(WITHIN);
    // false for NaN as well
    let is_within: Mask =
        least.le(u) & least.le(v) & (u + v).le(F32x8::splat(1.0 - WITHIN)) & F32x8::ZERO.lt(t);
    within &= is_within.bits();
    if within == 0 {
        return;
    }
    let to_surface = directions * t;
    scratch.rays.push_lanes_to_samples(
        origins,
        to_surface,
        F32x8::splat(SEGMENT_END),
        [models, &triangles],
        within,
    );
    for cell in set_bits(within).map(|lane| first + lane) {
        scratch.owners.push(cell as u32);
        scratch.tally.cells.primary[cell] += 1;
    }
}
