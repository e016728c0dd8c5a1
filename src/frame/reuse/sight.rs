//! Segments from the eye (of an orthographic camera, from the plane of the eye) to samples, which
//! verification traces; the side and the distance from which surfaces are seen.

use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::CameraChange;
use crate::frame::surface::footprints::cell_widths;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, Flags, Octahedral, Tile};
use crate::trace::RayBatch;

/// End of a verification segment, as a share of the distance from the eye to the sample.
///
/// Short of 1 by the distance that rounding may put between a sample and its neighbours on the same surface.
/// The sample's own triangle never counts, so that the rest can be this tight: an occluder nearer to the
/// sample than this is taken for the sample's own surface, and a hit on a neighbouring triangle costs one ray
/// and no error. The [audit](crate::frame::audit) tolerates no more.
pub const SEGMENT_END: f32 = 1.0 - 1e-5;

/// Lines of sight to eight samples of a tile: origins, and vectors from there to the samples.
#[inline(always)]
pub fn sights(frame: &FrameView, tile: &Tile, first: usize) -> [Vec3x8; 2] {
    let offsets = frame.offsets(tile, first);
    [frame.view.origins(offsets), frame.view.sights(offsets)]
}

/// Adds the segments from the eye to those of eight samples whose bit is set.
pub fn segments(frame: &FrameView, tile: &Tile, first: usize, wanted: u8, rays: &mut RayBatch) {
    let models = &tile.model[first..first + LANES];
    // the background has no triangle of its own: its number is that of no hit
    let triangles = tile.triangles(first);
    let own = [models, &triangles[..]];
    let [origins, sights] = sights(frame, tile, first);
    rays.push_lanes_to_samples(origins, sights, segment_ends(models), own, wanted);
}

/// Ends of the segments to eight samples, as ray parameters.
pub fn segment_ends(models: &[u32]) -> F32x8 {
    let background = Mask::equal(models, BACKGROUND);
    background.select(F32x8::splat(f32::INFINITY), F32x8::splat(SEGMENT_END))
}

/// Bit mask of those of eight cells whose samples do not hold as they are seen now: from the other side, since they were shaded for
/// the side that the eye was on; or from so near or so far that their textures were filtered over [another
/// place](crate::samples::Footprint).
#[inline]
pub fn outdated_bits(frame: &FrameView, tile: &Tile, first: usize, flags: Flags) -> u8 {
    let models = &tile.model[first..first + LANES];
    let surfaces = surface_bits(models);
    let is_doubtful = frame.plan.camera == CameraChange::Moved || flags.has(Flags::UNSEEN);
    let moved = if is_doubtful { u8::MAX } else { frame.moved_bits(models) };
    let may_have_turned = moved & surfaces;
    let is_resized =
        frame.palette.has_textures && (may_have_turned != 0 || frame.plan.camera != CameraChange::None);
    if may_have_turned == 0 && !is_resized {
        return 0;
    }
    // the side needs no unit length
    let mut geometric_normals = Octahedral::directions(tile.geometric_normals(first));
    frame.each_displaced(models, |place, of_model| {
        place.geometric_normals(of_model, |lane| tile.record[first + lane].triangle, &mut geometric_normals);
    });
    let sights = frame.view.sights(frame.offsets(tile, first));
    let before = geometric_normals.dot(sights).lt(F32x8::ZERO);
    let turned = may_have_turned & !before.bits();
    if is_resized {
        turned | resized_bits(frame, tile, first, surfaces, [sights, geometric_normals])
    } else {
        turned
    }
}

/// Bit mask of those of eight samples, among `surfaces`, whose footprints do not serve along these `sights`. Normals: world space.
fn resized_bits(
    frame: &FrameView,
    tile: &Tile,
    first: usize,
    surfaces: u8,
    [sights, normals]: [Vec3x8; 2],
) -> u8 {
    let widths = cell_widths(frame.view, sights, normals);
    let is_resized = |lane: &usize| {
        let (footprint, model) = (tile.record[first + lane].footprint, tile.model[first + lane]);
        footprint.is_some() && !footprint.serves(widths.lane(*lane) * frame.scale_to_object(model))
    };
    set_bits(surfaces).filter(is_resized).fold(0, |bits, lane| bits | 1 << lane)
}
