//! The space in which a shot is rendered: that of its files, or one beside the shot and of its size.
//!
//! Single floats keep 6e-8 of a coordinate, and some distances of the renderer are absolute. A shot far from the
//! origin, a tiny one or a huge one is therefore moved to the origin and scaled by a power of two when it is loaded:
//! tracks and meshes are converted in double floats. Pictures keep the units of the files: `P`, `Z` and the matrices
//! in a frame's header are converted back. Most shots need nothing of this and stay as they are, to the bit.
//!
//! Everywhere else *world space* is the space in which the shot is rendered.

use glam::{DVec3, Vec3};

use super::camera::{Aim, Lens};
use super::{CameraTrack, Light};
use crate::animation::TransformTrack;

/// A shot is moved if its middle is farther from the origin than this many times its own size.
const FAR: f64 = 8.0;

/// Shots whose largest coordinate is within this range are not scaled. Far above it products of coordinates overflow;
/// below it the least distance at which a ray leaves a surface is too large.
const USUAL: std::ops::RangeInclusive<f64> = 1.0 / 16.0..=1_099_511_627_776.0;

/// Transform from the space of the files to the space in which they are rendered: `(point - origin) * scale`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSpace {
    origin: DVec3,
    /// Factor, a power of two.
    scale: f64,
}

/// The smallest box around points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extent {
    low: DVec3,
    high: DVec3,
}

impl Extent {
    /// The extent of nothing.
    pub const NONE: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    /// Extends it by `point`.
    pub fn with(self, point: DVec3) -> Self {
        Self { low: self.low.min(point), high: self.high.max(point) }
    }

    /// Largest distance from the origin along any axis.
    pub fn reach(&self) -> f64 {
        self.low.abs().max(self.high.abs()).max_element()
    }

    /// Lengths of its edges.
    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }

    /// Length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }

    /// Centre of the box.
    pub fn center(&self) -> DVec3 {
        (self.low + self.high) * 0.5
    }

    /// Extends it by a model at all key frames of its track. `bounds`: of its mesh, object space.
    pub fn with_model(self, bounds: (DVec3, DVec3), track: &TransformTrack) -> Self {
        let frames = track.key_frames().into_iter();
        frames.fold(self, |extent, frame| extent.with_model_at(bounds, track, frame))
    }

    /// Extends it by a model as it stands at a frame.
    pub fn with_model_at(self, (low, high): (DVec3, DVec3), track: &TransformTrack, frame: f64) -> Self {
        let map = track.map_at(frame);
        let corner = |i: u8| {
            DVec3::new(
                [low.x, high.x][usize::from(i & 1)],
                [low.y, high.y][usize::from(i >> 1 & 1)],
                [low.z, high.z][usize::from(i >> 2)],
            )
        };
        (0..8).fold(self, |extent, i| extent.with(map.transform_point3(corner(i))))
    }

    /// Extends it by all positions of the eye.
    pub fn with_camera(self, camera: &CameraTrack) -> Self {
        camera.eye.places().into_iter().fold(self, Self::with)
    }
}

impl RenderSpace {
    /// The space of the files.
    pub const OF_FILES: Self = Self { origin: DVec3::ZERO, scale: 1.0 };

    /// Chooses the space for everything within `extent`.
    pub(crate) fn fit_for(extent: Extent) -> Self {
        let (center, half) = ((extent.low + extent.high) * 0.5, (extent.high - extent.low) * 0.5);
        let size = half.max_element();
        let is_far = center.abs().max_element() > FAR * size;
        let origin = if is_far { center } else { DVec3::ZERO };
        let largest = (center - origin).abs().max_element() + size;
        let scale = if USUAL.contains(&largest) || !largest.is_normal() {
            1.0
        } else if largest > *USUAL.end() {
            // no smaller than it must be: small things near the camera come closer to the limit of tiny shots
            (USUAL.end().log2() - largest.log2().ceil()).exp2()
        } else {
            (-largest.log2().round()).exp2()
        };
        Self { origin, scale }
    }

    /// Minimum length that shadows need, in the units of the files. None unless the shot was scaled down.
    pub fn least_length(&self) -> Option<f64> {
        (self.scale < 1.0).then(|| USUAL.start() / self.scale)
    }

    /// Returns true if the shot is rendered in the space of its files.
    pub fn is_of_files(&self) -> bool {
        *self == Self::OF_FILES
    }

    /// Factor from the units of the files to those of the render space.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Converts a point from the space of the files.
    pub fn point(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.scale
    }

    /// Converts a point back to the space of the files.
    pub fn point_of_files(&self, point: Vec3) -> DVec3 {
        point.as_dvec3() / self.scale + self.origin
    }

    /// Converts a point of a track back to the space of the files.
    pub fn place_of_files(&self, place: DVec3) -> DVec3 {
        place / self.scale + self.origin
    }

    /// Converts a length from the space of the files.
    pub fn length(&self, length: f64) -> f32 {
        (length * self.scale) as f32
    }

    /// Converts a length back to the space of the files.
    pub fn length_of_files(&self, length: f32) -> f32 {
        (f64::from(length) / self.scale) as f32
    }

    /// Converts a model's motion.
    pub(crate) fn track(&self, track: TransformTrack) -> TransformTrack {
        TransformTrack {
            translate: track.translate.map(|place| self.point(place)),
            scale: track.scale.map(|factors| factors * self.scale),
            ..track
        }
    }

    /// Converts the camera's motion.
    pub(crate) fn camera(&self, camera: CameraTrack) -> CameraTrack {
        let aim = match camera.aim {
            Aim::Target { target, roll } => Aim::Target { target: target.map(|at| self.point(at)), roll },
            rotation => rotation,
        };
        let height = camera.lens.height.map(|track| track.map(|height| height * self.scale));
        let Lens { aperture, focus, near, far, .. } = camera.lens;
        let [aperture, focus, near, far] = [aperture, focus, near, far]
            .map(|track| track.map(|track| track.map(|length| length * self.scale)));
        let lens = Lens { height, aperture, focus, near, far, shift: camera.lens.shift };
        CameraTrack { eye: camera.eye.converted(|eye| self.point(eye), self.scale), aim, lens, ..camera }
    }

    /// Converts a light's motion and its power.
    pub(crate) fn light(&self, light: Light) -> Light {
        let (kind, strength) = light.kind.converted(|at| self.point(at), self.scale);
        Light { kind, power: light.power.map(|power| power * strength), ..light }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3};

    use super::*;
    use crate::animation::Track;
    use crate::scene::LightKind;

    fn fit(low: [f64; 3], high: [f64; 3]) -> RenderSpace {
        RenderSpace::fit_for(Extent::NONE.with(low.into()).with(high.into()))
    }

    #[test]
    fn usual_shots_stay_as_they_are() {
        for (low, high) in [([-1.0; 3], [1.0; 3]), ([0.0, 0.0, 50.0], [9.0; 3]), ([-1e6; 3], [1e7; 3])] {
            assert!(fit(low, high).is_of_files());
        }
    }

    #[test]
    fn far_tiny_and_huge_shots_come_to_the_origin() {
        for (low, high) in [([1e5; 3], [1.001e5; 3]), ([-1e-7; 3], [2e-7; 3]), ([-1e15; 3], [1e15, 1.0, 1.0])]
        {
            let space = fit(low, high);
            let largest = [low, high].map(|at| space.point(at.into()).abs().max_element());
            assert!(!space.is_of_files());
            assert!(
                largest.iter().all(|at| *at < 2e12) && largest.iter().any(|at| *at > 0.25),
                "{largest:?}"
            );
            let there = space.point(DVec3::from(high)).as_vec3();
            assert!(space.point_of_files(there).abs_diff_eq(high.into(), high[0] * 1e-6));
        }
    }

    #[test]
    fn what_is_far_away_shrinks_the_rest_no_more_than_it_must() {
        let space = fit([-5.0; 3], [4.5e12, 5.0, 5.0]);
        assert_eq!(space.point(DVec3::ONE), DVec3::splat(0.125));
        assert_eq!(
            (space.least_length(), fit([-5.0; 3], [1e12, 5.0, 5.0]).least_length()),
            (Some(0.5), None)
        );
    }

    #[test]
    fn a_scaled_point_light_is_as_bright() {
        let space = fit([-1e-7; 3], [1e-7; 3]);
        let light = Light {
            name: String::new(),
            kind: LightKind::Point { position: Track::constant(DVec3::new(0.0, 3e-7, 0.0)) },
            color: Track::constant(Vec3::ONE),
            power: Track::constant(2e-14),
            samples: 1,
            group: None,
            links: Default::default(),
        };
        let light = space.light(light);
        let LightKind::Point { position } = light.kind else { panic!("still a point light") };
        let distance = position.at(1.0).distance(space.point(DVec3::ZERO));
        let expected = 2e-14 / (3e-7f64 * 3e-7);
        assert!((light.power.at(1.0) / (distance * distance) / expected - 1.0).abs() < 1e-5);
    }

    #[test]
    fn motion_is_converted_with_the_places_that_it_leads_to() {
        let space = fit([1e5; 3], [1.001e5; 3]);
        let track = TransformTrack {
            translate: Track::constant(DVec3::splat(1e5)),
            rotate: Track::constant(DVec3::new(10.0, 20.0, 30.0)),
            scale: Track::constant(DVec3::new(1.0, 2.0, 3.0)),
            matrix: Some(Track::constant(DAffine3::from_mat3_translation(
                DMat3::from_cols(DVec3::X, DVec3::new(0.5, -1.0, 0.0), DVec3::new(0.0, 2.0, 1.0)),
                DVec3::new(7.0, 8.0, 9.0),
            ))),
            ..TransformTrack::identity()
        };
        let (before, after) = (track.map_at(1.0), space.track(track).map_at(1.0));
        let point = DVec3::new(3.0, -4.0, 5.0);
        let wanted = space.point(before.transform_point3(point));
        assert!(after.transform_point3(point).abs_diff_eq(wanted, 1e-9));
    }
}
