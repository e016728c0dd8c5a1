//! Angles at which surfaces are seen, for what graphs compute of them.

use glam::Vec3;

use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::lanes::LANES;
use crate::samples::Tile;
use crate::shade::surface;

/// Cosine of the angle at which a `point` (object space, at rest) of a triangle of a model is seen `along` a way from what sees it (world
/// space, any length): that of the curved surface for which the triangle stands, without what bends its normals, as Blender's nodes have
/// it. Below 0 if its back is seen. `geometric_normal`: world space, of unit length, on the side from which it is seen.
pub fn facing(
    frame: &FrameView,
    of: (u32, u32),
    (point, from_behind, tick): (Vec3, bool, Tick),
    geometric_normal: Vec3,
    along: Vec3,
) -> f32 {
    let curved = frame.horizon(of, point, from_behind, tick);
    let normal = curved.map_or(geometric_normal, |horizon| horizon.normal);
    let outside = if from_behind { -geometric_normal } else { geometric_normal };
    surface::facing([normal, outside], along)
}

/// [`facing`] of the sample in a cell, as the eye sees it in this frame.
pub fn facing_of_sample(frame: &FrameView, tile: &Tile, cell: usize) -> f32 {
    let (first, lane) = (cell / LANES * LANES, cell % LANES);
    let record = &tile.record[cell];
    let [_, sights] = frame.sights(tile, first);
    let normals = frame.geometric_normals((tile, first), || tile.ticks(first));
    let seen = (tile.point(cell), record.is_from_behind(), record.traced.tick());
    let normal = normals.lane(lane).normalize_or_zero();
    facing(frame, (tile.model[cell], record.triangle), seen, normal, sights.lane(lane))
}
