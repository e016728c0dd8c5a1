//! The proof of exactness: every sample of a finished frame is traced and shaded again, from nothing.
//!
//! For each sample the ray from the frame's camera through the sample's own position is traced, and:
//! 1. it must meet the sample's triangle, in the sample's point, first ([`check_sight`]);
//! 2. the stored surface must be that of the mesh there ([`check_surface`]);
//! 3. all shadow rays, cast anew without tags against everything, must agree with the tags
//!    ([`check_shadows`]), and the light summed anew must be the light that was stored;
//! 4. all paths by which it gathers light, traced anew, must bring the stored light ([`check_gathered`]);
//! 5. all paths by which its layer reflects, traced anew, must bring the stored light, and must still serve the
//!    eye ([`check_reflected`]);
//! 6. of its rays of ambient occlusion, all cast anew, as many must get away as is stored
//!    ([`check_openness`]);
//! 7. what flat mirrors show of what was kept must be seen there, and lit anew have the stored light ([`check_mirrored`]).
//!
//! And for each cell the ray through its target is traced: it must meet the surface that the cell shows ([`coverage`]). That is
//! counted by itself, and the paper's rule for serving, which does not promise it, is not asked.
//!
//! Highlights, reflections and refractions are not kept with samples. Where the film of the frame before
//! shows them still they are not made anew; that this is right, as is all else in the film, is checked by
//! making the film again ([`film`]).
//!
//! **Tolerances** all stand in [`tolerances`]. A sample holds *on an edge*, and is counted as such, where a
//! displacement by [`TOLERANCE`] of the distance (and [`COORDINATE_TOLERANCE`](tolerances::COORDINATE_TOLERANCE)) decides: the ray meets a
//! neighbouring or coinciding surface at the same place, or slips past a silhouette; the eye is in a surface;
//! the shadow ray grazes an edge. Stored colours, normals and positions may differ from fresh ones by the
//! rounding that the store does ([`COLOR_TOLERANCE`], [`NORMAL_COSINE`], [`CELL_TOLERANCE`]).

mod coverage;
pub mod film;
mod kept_light;
mod mirrored;
mod sights;
pub mod tolerances;
mod verdict;

use glam::{Vec2, Vec3};
use rayon::prelude::*;
use wide::u32x8;

use coverage::check_coverage;
use kept_light::{check_gathered, check_openness, check_reflected};
use mirrored::check_mirrored;
use sights::{
    Sight, around, beside, geometric_normal, is_of_its_cell, is_uncertain, offset, reach, rounding, sight,
    sight_of_cell, trace_all,
};
use tolerances::{
    CELL_TOLERANCE, COLOR_TOLERANCE, DARKEST, EDGE_ON_COSINE, NORMAL_COSINE, TOLERANCE, WIDTH_TOLERANCES,
};
use verdict::Verdict;

use crate::exposure::Tick;
use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::grid::cells::is_traced;
use crate::frame::grid::place;
use crate::frame::light::direct::sum_light;
use crate::frame::light::lighting::sample_of_light;
use crate::frame::light::shadow::ShadowQueue;
use crate::frame::reuse::candidates::REACH;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::frame::surface::facing::facing_of_sample;
use crate::frame::surface::footprints::{cell_widths, has_textures};
use crate::frame::surface::placed::{Placed, lift};
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::samples::{
    BACKGROUND, CELLS, EMPTY, Footprint, Record, Sample, SampleStore, Tag, Tile, full_color,
};
use crate::scene::on_mesh::OnMesh;
use crate::shade::light::{StratifiedPattern, light_samples};
use crate::shade::surface::SurfacePoint;
use crate::shade::terminator::ToLight;
use crate::stats::AuditCounts;
use crate::trace::{Coherence, Hit, SceneSubset};

/// Audits every sample of a finished frame. `differs` flags the pixels in which the film differs from the
/// samples; empty if it is known that none does.
pub fn audit_tiles(frame: &FrameView, store: &SampleStore, differs: &[bool]) -> AuditCounts {
    let tiles = store.tiles.par_iter().enumerate();
    let audit = tiles.map(|(number, tile)| audit(frame, number, tile, differs));
    audit.reduce(AuditCounts::default, |mut a, b| {
        a += b;
        a
    })
}

/// Checks all samples of tile number `number`. Samples of pixels that `differs` flags fail: see [`film`].
fn audit(frame: &FrameView, number: usize, tile: &Tile, differs: &[bool]) -> AuditCounts {
    let ticks = frame.ticks_of(tile);
    let frame = &FrameView { ticks: ticks.as_ref(), ..*frame };
    let sampled = || (0..CELLS).filter(|cell| tile.model[*cell] != EMPTY);
    let mut verdicts = vec![Verdict::Holds; CELLS];
    let mut raise = |cell: usize, verdict: Verdict| verdicts[cell] = verdicts[cell].max(verdict);

    let differing = film::differing_cells(&frame.view.grid, number, differs);
    for cell in differing.into_iter().filter(|cell| tile.model[*cell] != EMPTY) {
        raise(cell, Verdict::Differs);
    }
    let sight = |cell: usize| sight(frame, number, tile, cell);
    let met = trace_all(frame, sampled().map(sight));
    for (ray, cell) in sampled().enumerate() {
        let (sample, sight) = (tile.sample(cell), sight(cell));
        // where rounding decides the direction of a sample that stays because the camera rests, the ray
        // through its cell's centre counts as well
        let of_cell = sight_of_cell(frame, number, cell);
        let is_of_cell = is_of_its_cell(frame, &sample)
            || (is_traced(tile.status[cell]) || is_uncertain(frame, &sample))
                && is_on(frame, &sample, of_cell);
        let by_cell = || check_sight(frame, &sample, of_cell, trace_all(frame, [of_cell].into_iter()).get(0));
        raise(cell, check_sight(frame, &sample, sight, met.get(ray)).or_if(is_of_cell, by_cell));
        if !is_of_cell {
            raise(cell, check_position(frame, number, cell, &sample));
        }
        if sample.model != BACKGROUND {
            raise(
                cell,
                check_surface(frame, &sample, sight.direction, || facing_of_sample(frame, tile, cell)),
            );
        }
    }
    for first in (0..CELLS).step_by(LANES) {
        let surfaces = surface_bits(&tile.model[first..first + LANES]);
        if surfaces != 0 {
            let placed = Placed::of(frame, tile, first);
            check_light(frame, tile, first, &placed, surfaces, &mut raise);
        }
    }
    check_gathered(frame, tile, &mut raise);
    check_reflected(frame, tile, &mut raise);
    check_openness(frame, tile, &mut raise);
    let mirrored = check_mirrored(frame, number, tile, &mut raise);
    for (light, pose) in frame.pose.lights.iter().enumerate() {
        let points = 0..pose.points;
        points.for_each(|point| check_shadows(frame, tile, LightPoint { light, point }, &mut raise));
    }
    let [targets, coverage, coverage_on_edge] = check_coverage(frame, number, tile, &mut raise);
    let count = |wanted| verdicts.iter().filter(|verdict| **verdict == wanted).count() as u64;
    AuditCounts {
        checked: sampled().count() as u64,
        differing: count(Verdict::Differs),
        on_edge: count(Verdict::OnEdge),
        targets,
        coverage,
        coverage_on_edge,
        mirrored,
    }
}

/// Checks that the camera meets the sample first, on the line of `sight`.
fn check_sight(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> Verdict {
    Verdict::new(meets(frame, sample, sight, met)).or_on_edge(|| {
        let beside = beside(frame, sight, met, (reach(frame, sample), offset(frame, sample).length()));
        let met = trace_all(frame, beside.iter().copied());
        let holds = |sight, met| meets(frame, sample, sight, met) || coincides(frame, sample, sight, met);
        (0..).zip(&beside).any(|(ray, sight)| holds(*sight, met.get(ray)))
    })
}

/// Returns true if a ray along `sight`, with the hit `met`, met the sample.
fn meets(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    match met {
        None => sample.model == BACKGROUND,
        Some(hit) => {
            (hit.model, hit.triangle) == (sample.model, sample.record.triangle)
                && coincides(frame, sample, sight, met)
        }
    }
}

/// Returns true if the hit `met` of a ray along `sight` lies in the sample's plane: on a neighbouring
/// triangle, or on another surface in the same place, either of which may be met first.
fn coincides(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    let Some(met) = met.filter(|_| sample.model != BACKGROUND) else { return false };
    let tolerance = reach(frame, sample) + rounding(frame, sample);
    let from_eye = sight.offset_at(frame, met.t);
    (from_eye - frame.offset_of(sample, sight.tick)).dot(geometric_normal(frame, sample, sight.tick)).abs()
        <= tolerance
}

/// Checks that the sample is as near to the centre of its cell as a server must be.
fn check_position(frame: &FrameView, number: usize, cell: usize, sample: &Sample) -> Verdict {
    let (corner, place) = (frame.view.grid.tile_corner(number), place(cell));
    let Some(seen) = frame.view.project_one(offset(frame, sample), sample.record.traced.tick()) else {
        return Verdict::Differs;
    };
    let aside = |axis: usize, at: f32| at - (corner[axis] + place[axis] as i32) as f32 - 0.5;
    let off = Vec2::new(aside(0, seen.x), aside(1, seen.y));
    Verdict::new(off.length() <= REACH + CELL_TOLERANCE)
}

/// Returns true if the sample is off the ray along `sight` by no more than rounding of its coordinates.
fn is_on(frame: &FrameView, sample: &Sample, sight: Sight) -> bool {
    let from_origin = frame.offset_of(sample, sight.tick) - sight.offset_at(frame, 0.0);
    from_origin.cross(sight.direction).length() <= rounding(frame, sample) * sight.direction.length()
}

/// Checks that the stored surface, its reflectance included, is that of the mesh at the sample.
/// `sight`: from the eye, any length; `facing`: see [`facing_of_sample`].
fn check_surface(frame: &FrameView, sample: &Sample, sight: Vec3, facing: impl FnOnce() -> f32) -> Verdict {
    let kept = full_color(sample.record.reflectance);
    let model = &frame.scene.models[sample.model as usize];
    let Record { triangle, footprint, .. } = sample.record;
    let there = SurfacePoint::at(frame.scene, (model, triangle), sample.point, footprint.width());
    // in a model that is flattened or sheared, a small rounding in the world may be a large one in object
    // space; a triangle much larger than its distance is met beside its edge
    let in_object = |reach: Vec3| frame.transform(sample.model).length_in_object(reach);
    let distance = in_object(offset(frame, sample)).max(sample.point.length());
    let reach = f64::from(TOLERANCE * distance + in_object(Vec3::splat(rounding(frame, sample))));

    let tick = sample.record.traced.tick();
    // cosine up to which the eye may be on the other side
    let edge_on = EDGE_ON_COSINE + rounding(frame, sample) / offset(frame, sample).length();
    let side = if sample.record.is_from_behind() { -1.0 } else { 1.0 };
    let place = OnMesh::on(model, triangle, there.weights).with_width(footprint.width());
    let number = place.material();
    let material = &frame.scene.materials[usize::from(number)];
    let place = if material.is_of_eye() { place.seen_at(facing()) } else { place };
    let (fresh, varied) = place.appearance(frame.scene, material);
    Verdict::new(
        sample.record.material == number
            && sample.varied == varied
            && check_footprint(frame, sample)
            && there.distance <= reach
            && sample.record.normal.unfold().dot(there.normal * side) >= NORMAL_COSINE
            && sample.record.geometric_normal.unfold().dot(there.geometric_normal * side) >= NORMAL_COSINE
            && (fresh - kept).abs().max_element() <= COLOR_TOLERANCE * kept.max_element().max(1.0)
            && geometric_normal(frame, sample, tick).dot(sight.normalize_or_zero()) < edge_on,
    )
}

/// Returns true if the sample's footprint is that of a sample that is traced there now.
fn check_footprint(frame: &FrameView, sample: &Sample) -> bool {
    let Record { footprint, material, .. } = sample.record;
    if !footprint.is_some() {
        return !has_textures(frame.scene, material);
    }
    let normal = geometric_normal(frame, sample, sample.record.traced.tick());
    let sights =
        Vec3x8::splat(frame.view.camera_at(sample.record.traced.tick()).sight(offset(frame, sample)));
    let widths = cell_widths(frame.view, sights, Vec3x8::splat(normal));
    let width = widths.lane(0) * frame.scale_to_object(sample.model);
    WIDTH_TOLERANCES.iter().any(|factor| footprint == Footprint::new(width * factor, sample.point))
}

/// Checks that the stored light of eight samples is that which the tags and lights give.
fn check_light(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    placed: &Placed,
    surfaces: u8,
    raise: &mut impl FnMut(usize, Verdict),
) {
    let (kept, fresh) = (tile.kept_light(first), sum_light(frame, tile, first, placed));
    for lane in set_bits(surfaces) {
        let (kept, fresh) = (kept.lane(lane), fresh.lane(lane));
        let slack = COLOR_TOLERANCE * fresh.abs().max_element().max(DARKEST);
        let holds = (kept - fresh.min(Vec3::splat(65504.0))).abs().max_element() <= slack;
        raise(first + lane, Verdict::new(holds));
    }
}

/// A point of a light, by number.
#[derive(Clone, Copy)]
struct LightPoint {
    light: usize,
    point: usize,
}

/// Checks that the tags for one point of a light agree with fresh shadow rays.
fn check_shadows(frame: &FrameView, tile: &Tile, source: LightPoint, raise: &mut impl FnMut(usize, Verdict)) {
    let tag = |cell: usize| tile.tags.get(frame.slots[source.light], source.point, cell);
    let is_lit = |cell: usize| tag(cell).is_lit();
    // tags of a light without power may be unknown; those that are known must be right, or they would be
    // wrong when the light returns
    let is_dark = frame.pose.is_dark(source.light);
    let is_known = |cell: usize| !is_dark || tag(cell) != Tag::Unknown;
    let mut queue = ShadowQueue::default();
    let purpose = frame.shadows_of_light(source.light);
    queue.begin(purpose);
    for first in (0..CELLS).step_by(LANES) {
        let surfaces = surface_bits(&tile.model[first..first + LANES]);
        let surfaces =
            set_bits(surfaces).filter(|lane| is_known(first + lane)).fold(0, |bits, lane| bits | 1 << lane);
        if surfaces == 0 {
            continue;
        }
        let placed = Placed::of(frame, tile, first);
        let seeds = tile.gathered.seeds(first);
        let lift = |lane: usize| lift(frame, tile, first + lane);
        let ticks = tile.ticks(first);
        // lights that do not light a model send no ray to it
        let lit = frame.lit_bits(source.light, &tile.model[first..first + LANES]);
        let faces =
            ask(frame, source, (&placed, seeds, ticks), lift, surfaces & lit, first as u32, &mut queue);
        let faces = faces & lit;
        for lane in set_bits(surfaces & !faces) {
            raise(first + lane, Verdict::new(!is_lit(first + lane)));
        }
    }
    let mut doubtful = Vec::new();
    queue.set_ticks(frame, |cell| cell);
    answer(frame, &mut queue, |cell, tag| {
        if tag.is_lit() != is_lit(cell as usize) {
            doubtful.push(cell as usize);
        }
    });
    for cell in doubtful {
        let lane = cell % LANES;
        let seed = tile.gathered.seeds(cell - lane).as_array_ref()[lane];
        let (lit, seeds) = (is_lit(cell), u32x8::splat(seed));
        let (placed, lane) = (Placed::of(frame, tile, cell / LANES * LANES), cell % LANES);
        let reach = reach(frame, &tile.sample(cell));
        // the same surface eight times, displaced in eight directions
        let one = |all: Vec3x8| Vec3x8::splat(all.lane(lane));
        let mut beside = Placed {
            point: one(placed.point),
            normal: one(placed.normal),
            geometric_normal: one(placed.geometric_normal),
            smooth: placed.smooth.map(one),
            fibres: if placed.fibres >> lane & 1 != 0 { u8::MAX } else { 0 },
        };
        for (aside_lane, aside) in around(placed.geometric_normal.lane(lane)).into_iter().enumerate() {
            beside.point.set_lane(aside_lane, placed.point.lane(lane) + aside * reach);
        }
        queue.begin(purpose);
        let ticks = [tile.record[cell].traced.tick(); LANES];
        ask(frame, source, (&beside, seeds, ticks), |_| lift(frame, tile, cell), u8::MAX, 0, &mut queue);
        queue.set_ticks(frame, |_| cell as u32);
        let mut grazes = false;
        answer(frame, &mut queue, |_, tag| grazes |= tag.is_lit() == lit);
        raise(cell, Verdict::Differs.or_on_edge(|| grazes));
    }
}

/// Queues shadow rays to `source` from those of eight samples whose bit is set. Returns the bit mask of
/// samples that face it. `seeds`: for the points of the light that they ask; `ticks`: at which they see it; `lift`: the ways from them to
/// the curved surfaces that their triangles stand for.
fn ask(
    frame: &FrameView,
    source: LightPoint,
    (placed, seeds, ticks): (&Placed, u32x8, [Tick; LANES]),
    lift: impl Fn(usize) -> Vec3,
    wanted: u8,
    owner: u32,
    queue: &mut ShadowQueue,
) -> u8 {
    let number = (source.light, source.point);
    let light_sample = sample_of_light(frame, number, || ticks, (placed.point, seeds));
    let mut rays = placed.receivers().to_light(&light_sample, wanted, &lift);
    if frame.pose.lights[source.light].points > 1 {
        // all rays to its points start in one
        for lane in set_bits(wanted) {
            let light = &frame.pose.lights_at(ticks[lane])[source.light];
            let pattern = StratifiedPattern::of_seeds(light, seeds);
            let light_samples = light_samples(light, &pattern, lane, placed.point.lane(lane));
            let sixteen = placed.receivers().to_sixteen(lane, &light_samples, || lift(lane));
            let (half, point) = (source.point / LANES, source.point % LANES);
            rays.faces &= !(1 << lane);
            rays.faces |= ((sixteen.faces >> source.point & 1) as u8) << lane;
            rays.origins.set_lane(lane, sixteen.origin);
            rays.to_light.set_lane(lane, sixteen.light_samples[half].to_light.lane(point));
        }
    }
    let ToLight { faces, origins, to_light } = rays;
    queue.push(origins, to_light, F32x8::splat(light_sample.far), wanted & faces, owner);
    faces
}

fn answer(frame: &FrameView, queue: &mut ShadowQueue, say: impl FnMut(u32, Tag)) {
    queue.answer(ShadowCheck::StillThenMovable, SceneSubset::All, Coherence::Coherent, frame.tracer, say);
}
