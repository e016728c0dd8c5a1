//! Lines of sight that the audit traces, and by how much rounding may move them and the samples on them.

use glam::Vec3;

use super::tolerances::{CELL_TOLERANCE, COORDINATE_TOLERANCE, DISPLACEMENTS, TOLERANCE};
use crate::exposure::Tick;
use crate::frame::grid::cells::is_traced;
use crate::frame::grid::place;
use crate::frame::grid::view::View;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::{F32x8, LANES};
use crate::samples::{BACKGROUND, Record, Sample, Tile};
use crate::scene::camera::Projection;
use crate::trace::{Coherence, Hit, HitBatch, RayBatch, SceneSubset, Search};

/// A line of sight, of any length.
#[derive(Debug, Clone, Copy)]
pub struct Sight {
    pub origin: Vec3,
    pub direction: Vec3,
    /// Tick of the exposure at which the eye sees along it.
    pub tick: Tick,
}

impl Sight {
    /// Vector from the eye to the point at `t` on it.
    pub fn offset_at(&self, frame: &FrameView, t: f32) -> Vec3 {
        self.origin - frame.view.eye(self.tick) + t * self.direction
    }
}

pub fn trace_all(frame: &FrameView, sights: impl Iterator<Item = Sight>) -> HitBatch {
    let (mut batch, mut hits, mut ticks) = (RayBatch::default(), HitBatch::default(), Vec::new());
    for sight in sights {
        batch.push(sight.origin, sight.direction, 0.0, f32::INFINITY);
        ticks.push(sight.tick);
    }
    if frame.pose.has_ticks() {
        batch.set_ticks(ticks.into_iter());
    }
    frame.tracer.closest(&batch, Search::from_eye(SceneSubset::All, Coherence::Coherent), &mut hits);
    hits
}

/// Line of sight on which the sample of `cell` is seen. A sample that was traced in this frame was seen on
/// the ray through the centre of its cell, and is checked on that ray: right before the eye, its point is
/// rounded by more than a cell.
pub fn sight(frame: &FrameView, number: usize, tile: &Tile, cell: usize) -> Sight {
    let sample = tile.sample(cell);
    if !is_traced(tile.status[cell]) && !is_of_its_cell(frame, &sample) {
        let tick = sample.record.traced.tick();
        let (offset, camera) = (offset(frame, &sample), frame.view.camera_at(tick));
        return Sight { origin: camera.origin(offset), direction: camera.sight(offset), tick };
    }
    sight_of_cell(frame, number, cell)
}

/// Line of sight through the centre of `cell`.
pub fn sight_of_cell(frame: &FrameView, number: usize, cell: usize) -> Sight {
    let (corner, place) = (frame.view.grid.tile_corner(number), place(cell));
    let centre = [0, 1].map(|axis| F32x8::splat((corner[axis] + place[axis] as i32) as f32 + 0.5));
    let tick = frame.view.tick_in_tile(number, cell);
    let cameras = frame.view.cameras_at(|| [tick; LANES]);
    let [origin, direction] = cameras.rays(centre[0], centre[1]).map(|all| all.lane(0));
    Sight { origin, direction, tick }
}

/// Returns true if the sample shows the background of an orthographic view, which has no place of its own: it
/// is seen at its cell.
pub fn is_of_its_cell(frame: &FrameView, sample: &Sample) -> bool {
    sample.model == BACKGROUND && frame.view.camera.is_orthographic()
}

/// Returns true if rounding of the sample's coordinates moves it by more than the tolerance of places in
/// cells.
pub fn is_uncertain(frame: &FrameView, sample: &Sample) -> bool {
    let View { camera, grid, .. } = frame.view;
    let cell = 2.0 * camera.half_height / grid.height as f32;
    let distance = if camera.is_orthographic() { 1.0 } else { offset(frame, sample).length() };
    rounding(frame, sample) >= CELL_TOLERANCE * cell * distance
}

/// Largest displacement of a sample by rounding, world units.
pub fn reach(frame: &FrameView, sample: &Sample) -> f32 {
    let (offset, eye) = (offset(frame, sample), frame.view.camera.eye);
    frame.view.camera.sight(offset).length() * TOLERANCE
        + eye.abs().max(offset.abs()).max_element() * COORDINATE_TOLERANCE
}

/// Largest distance, along the ray, by which rounding of coordinates may separate the sample from the point
/// in which the ray meets its triangle. The triangle's corners count here, and here alone: if they did for
/// displacements sideways, any model that hides a sample on a wide ground would be on an edge. Curved
/// primitives have no corners: for these the sample's own coordinates are rounded.
pub fn rounding(frame: &FrameView, sample: &Sample) -> f32 {
    let (offset, eye) = (offset(frame, sample), frame.view.camera.eye);
    let mut largest = eye.abs().max(offset.abs());
    if sample.model != BACKGROUND {
        let mesh = &frame.scene.models[sample.model as usize].mesh;
        let Some(triangles) = mesh.as_triangles() else {
            let of_object = frame.transform(sample.model).direction(sample.point).abs();
            return largest.max(of_object).max_element() * COORDINATE_TOLERANCE;
        };
        let place = frame.place(sample.model, sample.record.traced.tick());
        for corner in place.corners(triangles, sample.record.triangle) {
            largest = largest.max((corner - eye).abs());
        }
    }
    largest.max_element() * COORDINATE_TOLERANCE
}

/// Vector from the eye to a sample, at the sample's own tick.
pub fn offset(frame: &FrameView, sample: &Sample) -> Vec3 {
    frame.offset_of(sample, sample.record.traced.tick())
}

/// Normal of the sample's triangle at a `tick`, on the sample's side: world space, unit length.
pub fn geometric_normal(frame: &FrameView, sample: &Sample, tick: Tick) -> Vec3 {
    let Record { triangle, geometric_normal, .. } = sample.record;
    let place = frame.place(sample.model, tick);
    place.geometric_normal(triangle, geometric_normal.unfold()).normalize_or_zero()
}

/// Directions (any unit) at right angles to `axis`, all around it.
pub fn around(axis: Vec3) -> [Vec3; 8] {
    let (a, b) = axis.normalize_or(Vec3::X).any_orthonormal_pair();
    [a, -a, b, -b, a + b, a - b, b - a, -a - b]
}

/// Lines of sight to all sides of that of `sight`, which met `met`: `reach` away from it at `distance` from the eye, and nearer; and as far as
/// rounding may move the eye.
pub fn beside(
    frame: &FrameView,
    sight: Sight,
    met: Option<Hit>,
    (reach, distance): (f32, f32),
) -> Vec<Sight> {
    let Sight { origin, direction, .. } = sight;
    let aside = DISPLACEMENTS.iter().flat_map(|share| around(direction).map(|aside| aside * *share));
    let mut beside: Vec<Sight> = match frame.view.camera.projection {
        Projection::Perspective => {
            // as long relative to the sight as `reach` is to the distance, up to all but sideways: that may be rounded to zero
            let far = distance.max(f32::MIN_POSITIVE);
            let reach = (reach * direction.length() / far).min(1e3 * direction.length());
            aside.map(|aside| Sight { direction: direction + aside * reach, ..sight }).collect()
        }
        Projection::Orthographic => {
            aside.map(|aside| Sight { origin: origin + aside * reach, ..sight }).collect()
        }
    };
    beside.extend(around_eye(frame, sight, met));
    beside
}

/// Lines of sight that begin as far from that of `sight`, to all sides, as rounding may move the eye against
/// the model that it `met`. Where the eye is in a surface, rounding decides whether rays begin before it.
pub fn around_eye(frame: &FrameView, sight: Sight, met: Option<Hit>) -> Vec<Sight> {
    let Some(met) = met else { return Vec::new() };
    let (eye, origin) = (frame.view.camera.eye, frame.transform(met.model).point(Vec3::ZERO));
    let reach = eye.abs().max(origin.abs()).max_element() * COORDINATE_TOLERANCE;
    let aside = Vec3::AXES.into_iter().flat_map(|axis| [axis * reach, axis * -reach]);
    aside.map(|aside| Sight { origin: sight.origin + aside, ..sight }).collect()
}
