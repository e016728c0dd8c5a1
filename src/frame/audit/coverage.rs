//! Check of which samples there are: every cell shows a sample of the surface that its target sees
//! ([`target`](crate::frame::reuse::target)).

use super::tolerances::{COORDINATE_TOLERANCE, TOLERANCE};
use super::{Sight, beside, reach, rounding, sight_of_cell, trace_all};
use crate::frame::reuse::target::Seen;
use crate::frame::shot::frame_view::FrameView;
use crate::samples::{BACKGROUND, CELLS, EMPTY, Sample, Tile};
use crate::settings::Reuse;
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
fn is_covered(
    frame: &FrameView,
    sample: &Sample,
    Sight { origin, direction }: Sight,
    met: Option<Hit>,
) -> bool {
    let slack = if sample.model == BACKGROUND { 0.0 } else { reach(frame, sample) + rounding(frame, sample) };
    Seen::new(frame, origin, direction, met).is_shown_by(frame, sample, slack)
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
