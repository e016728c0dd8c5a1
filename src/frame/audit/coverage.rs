//! Check of which samples there are: every cell shows a sample of the surface that its target sees.
//!
//! What a surface is, is said here once more, without asking [`target`](crate::frame::reuse::target), which decides it for the
//! renderer: the same model and material, the same side, and the same layer. Whatever is wrong there is found here.

use glam::Vec3;

use super::tolerances::{COORDINATE_TOLERANCE, LAYER, TOLERANCE};
use super::{Sight, beside, offset, reach, rounding, sight_of_cell, trace_all};
use crate::frame::shot::frame_view::FrameView;
use crate::samples::{BACKGROUND, CELLS, EMPTY, Sample, Tile};
use crate::settings::Reuse;
use crate::shade::surface::corners_of;
use crate::trace::Hit;

/// Counts the cells of tile number `number` that show another surface than their targets see, and those where a displacement by rounding
/// decides what the target sees.
pub fn check_coverage(frame: &FrameView, number: usize, tile: &Tile) -> [u64; 2] {
    if frame.settings.reuse == Reuse::Paper {
        return [0; 2];
    }
    let sampled: Vec<usize> = (0..CELLS).filter(|cell| tile.model[*cell] != EMPTY).collect();
    let sight = |cell: usize| sight_of_cell(frame, number, cell);
    let met = trace_all(frame, sampled.iter().map(|cell| sight(*cell)));
    let (mut wrong, mut on_edge) = (0, 0);
    for (ray, cell) in sampled.into_iter().enumerate() {
        let (sample, sight) = (tile.sample(cell), sight(cell));
        if !is_covered(frame, &sample, sight, met.get(ray)) {
            let count =
                if is_on_edge(frame, &sample, sight, met.get(ray)) { &mut on_edge } else { &mut wrong };
            *count += 1;
        }
    }
    [wrong, on_edge]
}

/// Returns true if a ray along `sight`, with the hit `met`, met the surface that the sample shows.
fn is_covered(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    let Some(met) = met else { return sample.model == BACKGROUND };
    if met.model != sample.model {
        return false;
    }
    let mesh = &frame.scene.models[met.model as usize].mesh;
    let normal = normal_of(frame, met);
    let is_same_side = (normal.dot(sight.direction) > 0.0) == sample.record.is_from_behind();
    if met.triangle == sample.record.triangle {
        // a plane has one side towards the eye, and rounding alone may say otherwise
        return is_same_side || mesh.quadric.is_none();
    }
    let way = met.t * sight.direction;
    let spread = frame.view.spread();
    let layer = LAYER * (spread.by_distance * way.length() + spread.fixed);
    let from_eye = sight.origin - frame.view.camera.eye + way;
    let off = (offset(frame, sample) - from_eye).dot(normal).abs();
    is_same_side
        && frame.is_of(sample.record.material, mesh.material_of[met.triangle as usize])
        && off <= layer + reach(frame, sample) + rounding(frame, sample)
}

/// Normal of what a ray met: world space, unit length; zero where it has none.
fn normal_of(frame: &FrameView, met: Hit) -> Vec3 {
    let mesh = &frame.scene.models[met.model as usize].mesh;
    let in_object = match &mesh.quadric {
        Some(quadric) => quadric.normal(met.triangle, [met.u, met.v]),
        None => {
            let [a, b, c] = corners_of(mesh, met.triangle);
            (b - a).cross(c - a).normalize_or_zero().as_vec3()
        }
    };
    frame.place(met.model).geometric_normal(met.triangle, in_object).normalize_or_zero()
}

/// Returns true if the surface is met when the target is displaced by rounding, to some side.
fn is_on_edge(frame: &FrameView, sample: &Sample, sight: Sight, met: Option<Hit>) -> bool {
    let distance = met.map_or(1.0, |met| met.t) * sight.direction.length();
    let largest = frame.view.camera.eye.abs().max_element() + distance;
    let reach = distance * TOLERANCE + if met.is_some() { largest * COORDINATE_TOLERANCE } else { 0.0 };
    let beside = beside(frame, sight, met, (reach, distance));
    let met = trace_all(frame, beside.iter().copied());
    (0..).zip(beside).any(|(ray, sight)| is_covered(frame, sample, sight, met.get(ray)))
}
