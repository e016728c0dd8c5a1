//! Check of which samples there are: every cell shows a sample of the surface that its target sees.
//!
//! What a surface is, is said here once more, without asking [`target`](crate::frame::reuse::target), which decides it for the
//! renderer: the same model and material, the same side, the same layer, by the planes of both, and planes that are about parallel. Whatever is wrong there is found here.
//!
//! Which of two surfaces in one place a ray meets is not defined, so a cell may show either of them ([`is_in_one_place`]). Its sample
//! counts as one that holds within the tolerance.

use glam::{DVec3, Vec3};

use super::sights::{Sight, beside, geometric_normal, reach, rounding, sight_of_cell, trace_all};
use super::tolerances::{ABOUT_PARALLEL, COORDINATE_TOLERANCE, LAYER, TOLERANCE};
use super::verdict::Verdict;
use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::samples::{BACKGROUND, CELLS, EMPTY, Sample, Tile};
use crate::scene::Geometry;
use crate::settings::Reuse;
use crate::shade::surface::geometric_normal_of;
use crate::trace::Hit;

/// Counts the cells of tile number `number` whose targets are asked, those of them that show another surface than their targets see, and those where a displacement by rounding
/// decides what the target sees.
pub fn check_coverage(
    frame: &FrameView,
    number: usize,
    tile: &Tile,
    raise: &mut impl FnMut(usize, Verdict),
) -> [u64; 3] {
    if frame.settings.reuse == Reuse::Paper {
        return [0; 3];
    }
    let sampled: Vec<usize> = (0..CELLS).filter(|cell| tile.model[*cell] != EMPTY).collect();
    let asked = sampled.len() as u64;
    let sight = |cell: usize| sight_of_cell(frame, number, cell);
    let met = trace_all(frame, sampled.iter().map(|cell| sight(*cell)));
    let (mut wrong, mut on_edge) = (0, 0);
    for (ray, cell) in sampled.into_iter().enumerate() {
        let (sample, sight) = (tile.sample(cell), sight(cell));
        let met = met.get(ray);
        if is_covered(frame, &sample, sight, met) {
            continue;
        }
        if is_shown(frame, &sample, sight, met) {
            raise(cell, Verdict::OnEdge);
        } else if is_on_edge(frame, &sample, sight, met) {
            on_edge += 1;
        } else {
            wrong += 1;
        }
    }
    [asked, wrong, on_edge]
}

/// Returns true if a ray along `sight`, with the hit `met`, met the surface that the sample shows, or one in the same place.
fn is_shown(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    is_covered(frame, sample, sight, met) || met.is_some_and(|met| is_in_one_place(frame, sample, sight, met))
}

/// Returns true if the model of the sample has the surface that the sample shows in the place where a ray along `sight` met another one.
fn is_in_one_place(frame: &FrameView, sample: &Sample, sight: Sight, met: Hit) -> bool {
    let is_same = met.model == sample.model && met.triangle == sample.record.triangle;
    if is_same || sample.model == BACKGROUND {
        return false;
    }
    let way = met.t * sight.direction;
    let spread = frame.view.spread();
    let layer = LAYER * (spread.by_distance * way.length() + spread.fixed);
    let from_eye = sight.offset_at(frame, met.t);
    let tolerance = reach(frame, sample) + rounding(frame, sample);
    let mesh = &frame.scene.models[sample.model as usize].mesh;
    let place = frame.place(sample.model, sight.tick);
    let there = sight.origin + way;
    let as_met = |triangle: u32, [u, v]: [f32; 2]| Hit { t: met.t, u, v, model: sample.model, triangle };
    let triangles = match &mesh.geometry {
        Geometry::Triangles(triangles) => triangles,
        Geometry::Curved(curved) => {
            let transform = frame.pose.transform(sample.model as usize, sight.tick);
            let (point, tolerance) = (
                transform.to_object.transform_point3(there),
                transform.length_in_object(Vec3::splat(tolerance)),
            );
            let mut is_there = false;
            curved.near(point, tolerance, &mut |one| {
                let is_on = !is_there && curved.distance(one, point) <= f64::from(tolerance);
                let met = is_on.then(|| as_met(one, curved.weights(one, point)));
                is_there |= met.is_some() && is_covered(frame, sample, sight, met);
            });
            return is_there;
        }
    };
    // mostly it is elsewhere, which the sample's own plane says; otherwise all triangles of its model are looked at
    let off = (from_eye - frame.offset_of(sample, sight.tick))
        .dot(geometric_normal(frame, sample, sight.tick))
        .abs();
    if off > layer + tolerance {
        return false;
    }
    (0..triangles.corners.len() as u32).any(|triangle| {
        let corners = place.corners(triangles, triangle);
        is_on_triangle(corners, there, tolerance)
            && is_covered(frame, sample, sight, Some(as_met(triangle, [0.0; 2])))
    })
}

/// Returns true if a point is on a triangle, or off it by no more than `tolerance`.
fn is_on_triangle(corners: [Vec3; 3], point: Vec3, tolerance: f32) -> bool {
    let [a, b, c] = corners.map(|corner| (corner - point).as_dvec3());
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
    let is_inside = |from: DVec3, to: DVec3| {
        let inwards = normal.cross(to - from).normalize_or_zero();
        -from.dot(inwards) >= -f64::from(tolerance)
    };
    a.dot(normal).abs() <= f64::from(tolerance) && is_inside(a, b) && is_inside(b, c) && is_inside(c, a)
}

/// Returns true if a ray along `sight`, with the hit `met`, met the surface that the sample shows.
fn is_covered(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    let Some(met) = met else { return sample.model == BACKGROUND };
    if met.model != sample.model {
        return false;
    }
    let mesh = &frame.scene.models[met.model as usize].mesh;
    let normal = normal_of(frame, met, sight.tick);
    let is_same_side = (normal.dot(sight.direction) > 0.0) == sample.record.is_from_behind();
    if met.triangle == sample.record.triangle {
        // a plane has one side towards the eye, and rounding alone may say otherwise
        return is_same_side || !mesh.is_curved();
    }
    let way = met.t * sight.direction;
    let spread = frame.view.spread();
    let layer = LAYER * (spread.by_distance * way.length() + spread.fixed);
    let apart = frame.offset_of(sample, sight.tick) - sight.offset_at(frame, met.t);
    let of_sample = geometric_normal(frame, sample, sight.tick);
    let off = apart.dot(normal).abs().max(apart.dot(of_sample).abs());
    // the normals of samples are on their side
    let on_side = if sample.record.is_from_behind() { -normal } else { normal };
    is_same_side
        && on_side.dot(of_sample) >= ABOUT_PARALLEL
        && sample.record.material == mesh.material_of[met.triangle as usize]
        && off <= layer + reach(frame, sample) + rounding(frame, sample)
}

/// Normal of what a ray met at a `tick`: world space, unit length; zero where it has none.
fn normal_of(frame: &FrameView, met: Hit, tick: Tick) -> Vec3 {
    let mesh = &frame.scene.models[met.model as usize].mesh;
    let in_object = geometric_normal_of(mesh, met.triangle, [met.u, met.v]);
    frame.place(met.model, tick).geometric_normal(met.triangle, in_object).normalize_or_zero()
}

/// Returns true if the surface is met when the target is displaced by rounding, to some side.
fn is_on_edge(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    let distance = met.map_or(1.0, |met| met.t) * sight.direction.length();
    let largest = frame.view.camera.eye.abs().max_element() + distance;
    let reach = distance * TOLERANCE + if met.is_some() { largest * COORDINATE_TOLERANCE } else { 0.0 };
    let beside = beside(frame, sight, met, (reach, distance));
    let met = trace_all(frame, beside.iter().copied());
    (0..).zip(beside).any(|(ray, sight)| is_shown(frame, sample, sight, met.get(ray)))
}
