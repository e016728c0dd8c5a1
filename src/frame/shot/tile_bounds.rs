//! Boxes around a tile's samples, and tests of what may lie between them and the eye or a light.

use glam::Vec3;

use super::frame_view::FrameView;
use super::moved_bounds::MovedBounds;
use crate::geometry::{Bounds, SweptBox};
use crate::lanes::{LANES, Mask, Vec3x8};
use crate::pose::{LightPose, LightSource, Pose};
use crate::samples::{BACKGROUND, CELLS, EMPTY, Tile};
use crate::scene::camera::Projection;
use crate::shade::surface::around_origins;

/// Bounds of the samples of a tile.
#[derive(Debug, Clone, PartialEq)]
pub struct TileBounds {
    /// Box around the surfaces, world space.
    surfaces: Bounds,
    /// Box around the directions to the background.
    sky: Bounds,
    /// Upper bound of the way from the surfaces to those that their triangles stand for, on which shadow rays may start.
    lift: f32,
}

impl TileBounds {
    /// Bounds of nothing.
    pub const NONE: Self = Self { surfaces: Bounds::EMPTY, sky: Bounds::EMPTY, lift: 0.0 };

    /// Bounds of what the eye sees: surfaces, world space, and directions to the background.
    pub fn seen(surfaces: Bounds, sky: Bounds) -> Self {
        Self { surfaces, sky, lift: 0.0 }
    }

    /// Bounds of the samples of both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            surfaces: self.surfaces.union(other.surfaces),
            sky: self.sky.union(other.sky),
            lift: self.lift.max(other.lift),
        }
    }

    /// Computes the bounds of the samples of `tile`.
    pub fn samples(frame: &FrameView, tile: &Tile) -> Self {
        let [surfaces, sky] = bounds_of_samples(frame, tile);
        Self { surfaces, sky, lift: frame.most_lift(&tile.model) }
    }

    /// Creates bounds of surfaces alone, world space, with the [longest way](FrameView::most_lift) to where shadow rays start.
    pub fn surfaces(surfaces: Bounds, lift: f32) -> Self {
        Self { surfaces, sky: Bounds::EMPTY, lift }
    }

    /// Returns true if anything that moved may lie between the eye and any sample. The samples are those of
    /// tile number `number`. A `false` is certain.
    pub fn may_be_hidden(&self, frame: &FrameView, number: usize) -> bool {
        let Self { surfaces, sky, .. } = self;
        let eyes = frame.view.cameras().fold(Bounds::EMPTY, |all, camera| all.with(camera.eye));
        let hides = |bounds: &Bounds, sweep: SweptBox| {
            !bounds.is_empty() && frame.moved_bounds.may_meet_sweep(&sweep)
        };
        match frame.view.camera.projection {
            Projection::Perspective => {
                hides(surfaces, SweptBox::between(&eyes, surfaces)) || hides(sky, SweptBox::fans(&eyes, sky))
            }
            // includes the part behind the camera, which does no harm
            Projection::Orthographic => {
                let backwards =
                    frame.view.cameras().fold(Bounds::EMPTY, |all, camera| all.with(-camera.forward));
                hides(surfaces, SweptBox::fans(surfaces, &backwards))
                    || hides(sky, frame.view.sights_of_tile(number))
            }
        }
    }

    /// Returns true if anything in `moved` may lie between light number `light` and any surface. A `false` is certain.
    pub fn may_be_in_shadow(&self, moved: &MovedBounds, pose: &Pose, light: usize) -> bool {
        pose.all_of_light(light).any(|light| self.may_be_in_shadow_of(moved, light))
    }

    fn may_be_in_shadow_of(&self, moved: &MovedBounds, light: &LightPose) -> bool {
        // boxes of tiny models are smaller than the distance from a surface at which rays begin
        let Bounds { low, high } = self.surfaces;
        let surfaces = &around_origins(&Bounds { low: low - self.lift, high: high + self.lift });
        let half = light.shape.half_extent();
        let around = |middle: Vec3| Bounds { low: middle - half, high: middle + half };
        let sweep = match light.shape.source() {
            LightSource::Place(center) => SweptBox::between(&around(center), surfaces),
            LightSource::Direction(to_light) if half == Vec3::ZERO => SweptBox::along(surfaces, to_light),
            LightSource::Direction(to_light) => SweptBox::fans(surfaces, &around(to_light)),
        };
        !self.surfaces.is_empty() && moved.may_meet_sweep(&sweep)
    }
}

/// Boxes around the samples of `tile`: surfaces, world space, and directions to the background.
fn bounds_of_samples(frame: &FrameView, tile: &Tile) -> [Bounds; 2] {
    let nothing = [Vec3x8::splat(Vec3::INFINITY), Vec3x8::splat(Vec3::NEG_INFINITY)];
    let (mut surfaces, mut sky) = (nothing, nothing);
    let widen = |[low, high]: &mut [Vec3x8; 2], wanted: Mask, offsets: Vec3x8| {
        *low = low.min(wanted.select3(offsets, *low));
        *high = high.max(wanted.select3(offsets, *high));
    };
    let eye = Vec3x8::splat(frame.view.camera.eye);
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let offsets = frame.offsets_from(eye, (tile, first), || tile.ticks(first));
        widen(&mut surfaces, Mask::less(models, EMPTY), offsets);
        let is_sky = Mask::equal(models, BACKGROUND);
        if is_sky.any() {
            widen(&mut sky, is_sky, offsets);
        }
    }
    let around = |[low, high]: [Vec3x8; 2], eye: Vec3| {
        (0..LANES).fold(Bounds::EMPTY, |all, lane| {
            all.union(Bounds { low: low.lane(lane) + eye, high: high.lane(lane) + eye })
        })
    };
    [around(surfaces, frame.view.camera.eye), around(sky, Vec3::ZERO)]
}
