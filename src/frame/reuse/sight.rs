//! Segments from the eye (of an orthographic camera, from the plane of the eye) to samples, which
//! verification traces; the side and the distance from which surfaces are seen.

use crate::frame::grid::bits::{set_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::CameraChange;
use crate::frame::surface::facing::facing_of_sample;
use crate::frame::surface::footprints::cell_widths;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{BACKGROUND, Flags, Footprint, Tile, half_colors};
use crate::scene::on_mesh::OnMesh;
use crate::shade::surface::SurfacePoint;
use crate::trace::RayBatch;

/// End of a verification segment, as a share of the distance from the eye to the sample.
///
/// Short of 1 by the distance that rounding may put between a sample and its neighbours on the same surface.
/// The sample's own triangle never counts, so that the rest can be this tight: an occluder nearer to the
/// sample than this is taken for the sample's own surface, and a hit on a neighbouring triangle costs one ray
/// and no error. The [audit](crate::frame::audit) tolerates no more.
pub const SEGMENT_END: f32 = 1.0 - 1e-5;

/// Adds the segments from the eye to those of eight samples whose bit is set.
pub fn segments(frame: &FrameView, tile: &Tile, first: usize, wanted: u8, rays: &mut RayBatch) {
    let models = &tile.model[first..first + LANES];
    // the background has no triangle of its own: its number is that of no hit
    let triangles = tile.triangles(first);
    let own = [models, &triangles[..]];
    let [origins, sights] = frame.sights(tile, first);
    rays.push_lanes_to_samples(origins, sights, segment_ends(models), own, wanted);
}

/// Ends of the segments to eight samples, as ray parameters.
pub fn segment_ends(models: &[u32]) -> F32x8 {
    let background = Mask::equal(models, BACKGROUND);
    background.select(F32x8::splat(f32::INFINITY), F32x8::splat(SEGMENT_END))
}

/// Samples of eight cells that do not hold as they are seen now.
#[derive(Debug, Clone, Copy)]
pub struct Outdated {
    /// Bits of those that end: they are seen from the other side than that for which they were shaded; or the picture that bends
    /// their normals is to be filtered over another place, so that all of their light is another one.
    pub ended: u8,
    /// Bits of those whose look is another one: they are seen from so near or so far that their colours are to be filtered over another
    /// place, or what graphs compute of them depends on the angle at which they are seen.
    pub restyled: u8,
    /// Places over which these are filtered.
    pub footprints: [Footprint; LANES],
}

impl Outdated {
    /// None of the samples.
    const NONE: Self = Self { ended: 0, restyled: 0, footprints: [Footprint::NONE; LANES] };

    /// Finds them among the samples from cell `first` on; `flags`: those that any sample of the tile has.
    #[inline]
    pub fn find(frame: &FrameView, tile: &Tile, first: usize, flags: Flags) -> Self {
        let models = &tile.model[first..first + LANES];
        let surfaces = surface_bits(models);
        let is_doubtful = frame.plan.camera == CameraChange::Moved || flags.has(Flags::UNSEEN);
        let moved = if is_doubtful { u8::MAX } else { frame.moved_bits(models) };
        let may_have_turned = moved & surfaces;
        let may_be_resized =
            frame.palette.has_textures && (may_have_turned != 0 || frame.plan.camera != CameraChange::None);
        if may_have_turned == 0 && !may_be_resized {
            return Self::NONE;
        }
        // the side needs no unit length
        let geometric_normals = frame.geometric_normals((tile, first), || tile.ticks(first));
        let [_, sights] = frame.sights(tile, first);
        let before = geometric_normals.dot(sights).lt(F32x8::ZERO);
        let turned = may_have_turned & !before.bits();
        let resized = if may_be_resized {
            Self::resized(frame, tile, first, surfaces, [sights, geometric_normals])
        } else {
            Self::NONE
        };
        let seen_anew = match frame.palette.is_of_eye {
            true => Self::of_eye(frame, tile, first, may_have_turned, resized),
            false => resized,
        };
        Self { ended: turned | seen_anew.ended, restyled: seen_anew.restyled & !turned, ..seen_anew }
    }

    /// Adds those among `moved` whose look depends on the angle at which they are seen.
    #[inline(never)]
    fn of_eye(frame: &FrameView, tile: &Tile, first: usize, moved: u8, mut resized: Self) -> Self {
        for lane in set_bits(moved & !resized.ended & !resized.restyled) {
            let record = &tile.record[first + lane];
            if frame.scene.materials[usize::from(record.material)].is_of_eye() {
                resized.restyled |= 1 << lane;
                resized.footprints[lane] = record.footprint;
            }
        }
        resized
    }

    /// Finds those among `surfaces` with other places along these `sights` than their own. Normals: world space.
    fn resized(
        frame: &FrameView,
        tile: &Tile,
        first: usize,
        surfaces: u8,
        [sights, normals]: [Vec3x8; 2],
    ) -> Self {
        let records = &tile.record[first..first + LANES];
        let textured = surfaces & Mask::new(|lane| records[lane].footprint.is_some()).bits();
        if textured == 0 {
            return Self::NONE;
        }
        let mut widths = cell_widths(frame.view, sights, normals);
        if frame.displaced_bits(&tile.model[first..first + LANES]) != 0 {
            for lane in set_bits(textured) {
                let scale = frame.scale_to_object(tile.model[first + lane]);
                widths.set_lane(lane, widths.lane(lane) * scale);
            }
        }
        let footprints = Footprint::eight(widths, tile.points(first));
        let is_other = Mask::new(|lane| records[lane].footprint != footprints[lane]);
        let resized = textured & is_other.bits();
        let is_bent = |lane: &usize| frame.is_bent(tile.model[first + lane], records[*lane].triangle);
        let ended = match frame.palette.bends_normals {
            true => set_bits(resized).filter(is_bent).fold(0, |bits, lane| bits | 1 << lane),
            false => 0,
        };
        Self { ended, restyled: resized & !ended, footprints }
    }
}

/// Looks the colour of the sample in `cell` up anew, over the place `footprint`: of the point that is kept, as when it was traced, so
/// that it is what would be traced there now. No ray is cast; the light of the sample is summed anew from what is kept. Where the look has
/// changed, what follows from it is forgotten: reflected paths, and the paths of what goes below the surface.
pub fn look_up(frame: &FrameView, tile: &mut Tile, cell: usize, footprint: Footprint) {
    tile.record[cell].footprint = footprint;
    let is_other = restyle(frame, tile, cell);
    let flags = &mut tile.record[cell].flags;
    *flags = flags.with(Flags::STALE.when(is_other));
    if is_other {
        // whether a layer draws paths, how many and where to, may follow from its colour and its parameters
        tile.gathered.reflected.forget_one(cell);
    }
    if is_other && frame.palette.scattering(tile.look(cell)).is_some() {
        // the medium below a surface follows from its colour
        tile.gathered.forget_paths(cell);
    }
}

/// Sets the look of the sample in `cell` to that which it has as it is seen now. Returns true if it was another one.
pub fn restyle(frame: &FrameView, tile: &mut Tile, cell: usize) -> bool {
    let (record, model, point) = (tile.record[cell], tile.model[cell], tile.point(cell));
    let model = &frame.scene.models[model as usize];
    let weights = SurfacePoint::weights(&model.mesh, record.triangle, point);
    let material = &frame.scene.materials[usize::from(record.material)];
    let mut place = OnMesh::on(model, record.triangle, weights).with_width(record.footprint.width());
    if material.is_of_eye() {
        place = place.seen_at(facing_of_sample(frame, tile, cell));
    }
    let (color, varied) = place.appearance(frame.scene, material);
    let reflectance = half_colors(Vec3x8::splat(color))[0];
    let is_other = reflectance != record.reflectance || varied != tile.look(cell).varied;
    tile.record[cell].reflectance = reflectance;
    tile.varied.set(cell, varied);
    is_other
}
