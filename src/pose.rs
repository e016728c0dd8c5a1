//! Places of camera, models and lights at one frame, in world space, ready for use.

mod light;

use glam::{DMat3, DVec3, EulerRot, Mat4, Vec3, Vec4};

pub use light::{AreaShape, Cone, LightPose, LightShape, LightSource, Spread};

use crate::animation::{Track, Transform};
use crate::exposure::{Exposures, LensPose, TICKS, Tick};
use crate::lanes::LANES;
use crate::scene::camera::{Aim, Lens, Projection};
use crate::scene::{CameraTrack, RenderSpace, Scene};
use crate::stereo::EyePlace;
use crate::sweep::Sweeps;

/// Everything that moves, at one frame. Two poses compare exactly: equal parts did not move.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Number of the frame.
    pub frame: i32,
    /// Number of the [moment](crate::exposure::Clock) on the clock of its exposure: the frame's.
    pub moment: i64,
    /// Camera of the frame; of an exposure, that in its middle.
    pub camera: CameraPose,
    /// The cameras at the exposure's [`TICKS`]; empty where all are `camera`.
    pub cameras: Vec<CameraPose>,
    /// Transforms from object to world space, one for each of [`Scene::models`]; of an exposure, those in its middle.
    pub models: Vec<Transform>,
    /// Transforms of the models that move within the exposure.
    pub sweeps: Sweeps,
    /// Lights, one for each of [`Scene::lights`]; of an exposure, those in its middle.
    pub lights: Vec<LightPose>,
    /// The lights at the exposure's [`TICKS`]; empty where all are `lights`.
    pub lights_at_ticks: Vec<Vec<LightPose>>,
}

impl Pose {
    /// Pose of `scene` at `frame`: a function of the frame's number alone.
    pub fn new(scene: &Scene, frame: i32) -> Self {
        Self::seen_from(scene, frame, None)
    }

    /// Pose of `scene` at `frame`, with the camera in one eye's place, if it is given.
    pub fn seen_from(scene: &Scene, frame: i32, eye: Option<&EyePlace>) -> Self {
        Self::at(scene, frame, f64::from(frame), eye)
    }

    /// Pose of exposure number `index` of the frame, in a picture of `size` pixels of `cells` x `cells`
    /// cells.
    pub fn exposed(
        scene: &Scene,
        frame: i32,
        (exposures, index): (&Exposures, usize),
        eye: Option<&EyePlace>,
        picture: ([u32; 2], u32),
    ) -> Self {
        let (camera, cameras) = CameraPose::exposed(&scene.camera, frame, (exposures, index), eye, picture);
        let clock = exposures.clock(index);
        let mut middle = Self::at(scene, frame, clock.time(frame.into()), None);
        let sweeps = Sweeps::new(scene, clock, frame.into(), &mut middle.models);
        let lights_at_ticks = LightPose::at_ticks(&scene.lights, clock, frame.into(), &middle.lights);
        Self { camera, cameras, sweeps, lights_at_ticks, ..middle }
    }

    /// Transform of a model at one of the exposure's ticks.
    #[inline(always)]
    pub fn transform(&self, model: usize, tick: Tick) -> &Transform {
        self.sweeps.at(model, tick).unwrap_or(&self.models[model])
    }

    /// All transforms of a model within the exposure, some maybe twice.
    pub fn transforms(&self, model: usize) -> impl Iterator<Item = &Transform> {
        self.sweeps.of(model).unwrap_or_default().iter().chain([&self.models[model]])
    }

    /// The camera at one of the exposure's ticks.
    pub fn camera_at(&self, tick: Tick) -> &CameraPose {
        self.cameras.get(usize::from(tick)).unwrap_or(&self.camera)
    }

    /// Returns true if rays must know at which tick they are: models move within the exposure, lights change, or clipping planes move.
    pub fn has_ticks(&self) -> bool {
        !self.sweeps.is_empty()
            || !self.lights_at_ticks.is_empty()
            || !self.cameras.is_empty() && self.camera.clip != Clip::NONE
    }

    /// All lights at one of the exposure's ticks.
    #[inline(always)]
    pub fn lights_at(&self, tick: Tick) -> &[LightPose] {
        self.lights_at_ticks.get(usize::from(tick)).unwrap_or(&self.lights)
    }

    /// A light at all times of the exposure: once, where it does not change.
    pub fn all_of_light(&self, light: usize) -> impl Iterator<Item = &LightPose> {
        let middle = &self.lights[light];
        let at_ticks = self.lights_at_ticks.iter().map(move |lights| &lights[light]);
        std::iter::once(middle).chain(at_ticks.filter(move |pose| *pose != middle))
    }

    /// Returns true if a light sends no light as long as the exposure lasts: no ray to it is worth casting.
    pub fn is_dark(&self, light: usize) -> bool {
        self.all_of_light(light).all(LightPose::is_dark)
    }

    /// Calls `each` for a light as eight surfaces see it at their `ticks`, with the bit mask of those that see this: once, where it does
    /// not change.
    #[inline(always)]
    pub fn each_of_light(
        &self,
        light: usize,
        ticks: impl FnOnce() -> [Tick; LANES],
        mut each: impl FnMut(&LightPose, u8),
    ) {
        let changes = !self.lights_at_ticks.is_empty();
        let ticks = if changes { ticks() } else { [0; LANES] };
        let mut left = u8::MAX;
        while left != 0 {
            let (mut pose, mut bits) = (&self.lights[light], left);
            if changes {
                let at = |lane: usize| &self.lights_at(ticks[lane])[light];
                pose = at(left.trailing_zeros() as usize);
                let sees = |lane: &usize| left >> lane & 1 != 0 && at(*lane) == pose;
                bits = (0..LANES).filter(sees).fold(0, |bits, lane| bits | 1 << lane);
            }
            each(pose, bits);
            left &= !bits;
        }
    }

    /// The cameras at all ticks: one, where all are the same.
    pub fn all_cameras(&self) -> &[CameraPose] {
        if self.cameras.is_empty() { std::slice::from_ref(&self.camera) } else { &self.cameras }
    }

    fn at(scene: &Scene, frame: i32, at: f64, eye: Option<&EyePlace>) -> Self {
        Self {
            frame,
            moment: frame.into(),
            camera: CameraPose::seen_from(&scene.camera, at, eye),
            cameras: Vec::new(),
            models: scene.models.iter().map(|model| model.track.at(at)).collect(),
            sweeps: Sweeps::default(),
            lights: scene.lights.iter().map(|light| LightPose::new(light, at)).collect(),
            lights_at_ticks: Vec::new(),
        }
    }
}

/// Camera at one frame. Its axes have unit length and stand at right angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Position of the eye, world space.
    pub eye: Vec3,
    /// Axis to the right of the picture.
    pub right: Vec3,
    /// Axis to the top of the picture.
    pub up: Vec3,
    /// Axis into the picture.
    pub forward: Vec3,
    /// Projection: the course of lines of sight.
    pub projection: Projection,
    /// Half the height of the picture: at distance 1 (the tangent of half the vertical field of view), or of
    /// an orthographic camera in world units.
    pub half_height: f32,
    /// Offset of the picture from the view axis, to the right and up, as shares of its longer side.
    pub shift: [f32; 2],
    /// Distances along the view axis between which the eye sees anything.
    pub clip: Clip,
}

/// Distances of clipping planes from the eye along the view axis, world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clip {
    /// Nothing nearer is seen; 0 or above.
    pub near: f32,
    /// Nothing farther is seen.
    pub far: f32,
}

impl Clip {
    /// No planes: everything before the eye is seen.
    pub const NONE: Self = Self { near: 0.0, far: f32::INFINITY };
}

impl CameraPose {
    /// Camera at `frame`.
    pub fn new(track: &CameraTrack, frame: f64) -> Self {
        Self::seen_from(track, frame, None)
    }

    /// Camera of exposure number `index` of a frame: see [`Pose::camera`] and [`Pose::cameras`].
    pub fn exposed(
        track: &CameraTrack,
        frame: i32,
        (exposures, index): (&Exposures, usize),
        eye: Option<&EyePlace>,
        picture: ([u32; 2], u32),
    ) -> (Self, Vec<Self>) {
        let at = |tick| Self::exposed_at(track, (frame, tick), (exposures, index), eye, picture);
        let middle = at(None);
        if track.is_constant() && !track.has_lens() {
            return (middle, Vec::new());
        }
        let mut ticks: Vec<Self> = (0..TICKS as Tick).map(|tick| at(Some(tick))).collect();
        if ticks.iter().all(|tick| *tick == middle) {
            ticks.clear();
        }
        (middle, ticks)
    }

    /// Camera of exposure number `index` of a frame at one of its ticks, or else in its middle.
    pub fn exposed_at(
        track: &CameraTrack,
        (frame, tick): (i32, Option<Tick>),
        (exposures, index): (&Exposures, usize),
        eye: Option<&EyePlace>,
        picture: ([u32; 2], u32),
    ) -> Self {
        let time = exposures.time(frame, index, tick);
        let (lens, shift) = (exposures.lens(index, tick), exposures.all[index].shift);
        let place = LensPose::place(track.lens_at(time), (lens, shift), picture);
        Self::seen_from(track, time, Some(&place.in_eye(eye)))
    }

    /// Camera at `frame` in one eye's place beside it, if that is given: it looks along the same axis,
    /// through a window of its own.
    pub fn seen_from(track: &CameraTrack, frame: f64, place: Option<&EyePlace>) -> Self {
        let mut eye = track.eye.at(frame);
        let axes = match &track.aim {
            Aim::Target { target, roll } => looking_at(target.at(frame) - eye, roll.at(frame)),
            Aim::Rotation(angles) => rotated(angles.at(frame)),
        };
        let half_height = track.half_height(frame);
        let mut shift = track.lens.shift.each_ref().map(|shift| shift.at(frame));
        let plane = |plane: &Option<Track<f64>>| plane.as_ref().map(|depth| depth.at(frame) as f32);
        let Lens { near, far, .. } = &track.lens;
        let clip =
            Clip { near: plane(near).unwrap_or(Clip::NONE.near), far: plane(far).unwrap_or(Clip::NONE.far) };
        if let Some(place) = place {
            eye += axes.x_axis * place.aside[0] + axes.y_axis * place.aside[1];
            let more = place.shift(f64::from(half_height));
            shift = [shift[0] + more[0], shift[1] + more[1]];
        }
        Self {
            eye: eye.as_vec3(),
            right: axes.x_axis.as_vec3(),
            up: axes.y_axis.as_vec3(),
            forward: -axes.z_axis.as_vec3(),
            projection: track.projection(),
            half_height,
            shift: shift.map(|shift| shift as f32),
            clip,
        }
    }

    /// Returns true if lines of sight are parallel.
    #[inline(always)]
    pub fn is_orthographic(&self) -> bool {
        self.projection == Projection::Orthographic
    }

    /// Half the width and height of a picture of this `aspect`, width over height, and the place of its
    /// centre, to the right of the view axis and above it. Units as for [`half_height`](Self::half_height).
    pub fn frustum(&self, aspect: f32) -> [[f32; 2]; 2] {
        let half = [self.half_height * aspect, self.half_height];
        let longer = 2.0 * half[0].max(half[1]);
        [half, self.shift.map(|shift| shift * longer)]
    }

    /// Vector from the origin of a line of sight to a point at `offset` from the eye.
    pub fn sight(&self, offset: Vec3) -> Vec3 {
        if self.is_orthographic() { self.forward * offset.dot(self.forward) } else { offset }
    }

    /// Origin of the line of sight on which a point at `offset` from the eye is seen. With an orthographic
    /// camera it lies in the plane through the eye at a right angle to the view axis.
    pub fn origin(&self, offset: Vec3) -> Vec3 {
        if self.is_orthographic() { self.eye + (offset - self.sight(offset)) } else { self.eye }
    }

    /// Matrix from world to camera space, column vectors; the camera looks along -Z.
    pub fn world_to_camera(&self) -> Mat4 {
        let rows = [self.right, self.up, -self.forward];
        Mat4::from_cols(
            Vec4::new(rows[0].x, rows[1].x, rows[2].x, 0.0),
            Vec4::new(rows[0].y, rows[1].y, rows[2].y, 0.0),
            Vec4::new(rows[0].z, rows[1].z, rows[2].z, 0.0),
            Vec4::new(-rows[0].dot(self.eye), -rows[1].dot(self.eye), -rows[2].dot(self.eye), 1.0),
        )
    }

    /// Matrix from world space to normalised device coordinates (x, y in -1..1 over the picture, y upwards).
    /// `aspect` is width over height.
    pub fn world_to_ndc(&self, aspect: f32) -> Mat4 {
        // near and far planes only scale z: the picture has none, but compositors expect them
        let (near, far) = (0.1, 10_000.0);
        let [[half_x, half_y], [x, y]] = self.frustum(aspect);
        let [right, up] = [x / half_x, y / half_y];
        let projection = match self.projection {
            Projection::Perspective => Mat4::from_cols(
                Vec4::new(1.0 / half_x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, 1.0 / half_y, 0.0, 0.0),
                Vec4::new(right, up, (near + far) / (near - far), -1.0),
                Vec4::new(0.0, 0.0, 2.0 * near * far / (near - far), 0.0),
            ),
            Projection::Orthographic => Mat4::from_cols(
                Vec4::new(1.0 / half_x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, 1.0 / half_y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, 2.0 / (near - far), 0.0),
                Vec4::new(-right, -up, (near + far) / (near - far), 1.0),
            ),
        };
        projection * self.world_to_camera()
    }
}

impl RenderSpace {
    /// Converts a camera to the space of the shot's files.
    pub fn camera_of_files(&self, camera: &CameraPose) -> CameraPose {
        let half_height = match camera.projection {
            Projection::Perspective => camera.half_height,
            Projection::Orthographic => self.length_of_files(camera.half_height),
        };
        let Clip { near, far } = camera.clip;
        let clip = Clip { near: self.length_of_files(near), far: self.length_of_files(far) };
        CameraPose { eye: self.point_of_files(camera.eye).as_vec3(), half_height, clip, ..*camera }
    }
}

/// Camera axes as columns (right, up, back) for a view along `way`, banked by `roll` degrees.
fn looking_at(direction: DVec3, roll: f64) -> DMat3 {
    upright(direction, DVec3::Y) * DMat3::from_rotation_z(-roll.to_radians())
}

/// Axes as columns that face along `direction`, the second of which leans towards `up`.
fn upright(direction: DVec3, up: DVec3) -> DMat3 {
    let forward = direction.try_normalize().unwrap_or(DVec3::NEG_Z);
    // straight up or down has no horizon: take -Z (or +Z) for the top of the picture
    let aside = || if up == DVec3::Y { DVec3::X } else { forward.any_orthonormal_vector() };
    let right = forward.cross(up).try_normalize().unwrap_or_else(aside);
    DMat3::from_cols(right, right.cross(forward), -forward)
}

/// Camera axes as columns for pitch, yaw and roll in degrees; roll banks clockwise here, too.
fn rotated(angles: DVec3) -> DMat3 {
    let [pitch, yaw, roll] = angles.to_array().map(f64::to_radians);
    DMat3::from_euler(EulerRot::YXZ, yaw, pitch, -roll)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_rotation_looks_along_minus_z() {
        let axes = rotated(DVec3::ZERO);
        assert_eq!(axes, DMat3::IDENTITY);
        assert!(looking_at(DVec3::NEG_Z, 0.0).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    }

    #[test]
    fn yaw_turns_left_pitch_turns_up_and_roll_banks_clockwise() {
        let forward = |angles| -rotated(angles).z_axis;
        assert!(forward(DVec3::new(0.0, 90.0, 0.0)).abs_diff_eq(DVec3::NEG_X, 1e-12));
        assert!(forward(DVec3::new(90.0, 0.0, 0.0)).abs_diff_eq(DVec3::Y, 1e-12));
        let banked = looking_at(DVec3::NEG_Z, 90.0);
        assert!(banked.y_axis.abs_diff_eq(DVec3::X, 1e-12), "{banked}");
        assert!(rotated(DVec3::new(0.0, 0.0, 90.0)).abs_diff_eq(banked, 1e-12));
    }

    #[test]
    fn rectangles_turn_about_their_axis_with_up() {
        let facing = |up| upright(DVec3::new(0.0, 0.0, -2.0), up);
        assert!(facing(DVec3::new(3.0, 0.0, 1.0)).y_axis.abs_diff_eq(DVec3::X, 1e-12));
        assert!(facing(DVec3::new(0.0, 0.5, 0.0)).abs_diff_eq(DMat3::IDENTITY, 1e-12));
        for (direction, up) in [(DVec3::NEG_Y, DVec3::Y), (DVec3::X, DVec3::X)] {
            let axes = upright(direction, up);
            assert!((axes.determinant() - 1.0).abs() < 1e-12, "{direction} {up}: {axes}");
        }
    }

    #[test]
    fn matrices_agree_with_the_axes() {
        let axes = looking_at(DVec3::new(1.0, -0.5, -2.0), 10.0);
        let camera = CameraPose {
            eye: Vec3::new(3.0, 2.0, 1.0),
            right: axes.x_axis.as_vec3(),
            up: axes.y_axis.as_vec3(),
            forward: -axes.z_axis.as_vec3(),
            projection: Projection::Perspective,
            half_height: 0.5,
            shift: [0.0; 2],
            clip: Clip::NONE,
        };
        let point = camera.eye + camera.forward * 4.0 + camera.up * 2.0 + camera.right;
        let seen = camera.world_to_camera().transform_point3(point);
        assert!(seen.abs_diff_eq(Vec3::new(1.0, 2.0, -4.0), 1e-5), "{seen}");
        let ndc = camera.world_to_ndc(2.0).project_point3(point);
        assert!((ndc.x - 0.25).abs() < 1e-5 && (ndc.y - 1.0).abs() < 1e-5, "{ndc}");
        // the picture is twice as wide as high: a quarter of its width is half of its height
        let shifted = CameraPose { shift: [0.25, -0.25], ..camera }.world_to_ndc(2.0).project_point3(point);
        assert!((shifted.x + 0.25).abs() < 1e-5 && (shifted.y - 2.0).abs() < 1e-5, "{shifted}");
        let side_by_side = CameraPose { projection: Projection::Orthographic, half_height: 4.0, ..camera };
        let ndc = side_by_side.world_to_ndc(2.0).project_point3(point);
        assert!((ndc.x - 0.125).abs() < 1e-5 && (ndc.y - 0.5).abs() < 1e-5 && ndc.z.abs() < 1.0, "{ndc}");
        let shifted =
            CameraPose { shift: [0.25, -0.25], ..side_by_side }.world_to_ndc(2.0).project_point3(point);
        assert!((shifted.x + 0.375).abs() < 1e-5 && (shifted.y - 1.5).abs() < 1e-5, "{shifted}");
    }

    #[test]
    fn lines_of_sight_lead_to_what_is_seen() {
        let axes = looking_at(DVec3::new(1.0, -0.5, -2.0), 10.0);
        let perspective = CameraPose {
            eye: Vec3::new(3.0, 2.0, 1.0),
            right: axes.x_axis.as_vec3(),
            up: axes.y_axis.as_vec3(),
            forward: -axes.z_axis.as_vec3(),
            projection: Projection::Perspective,
            half_height: 0.5,
            shift: [0.0; 2],
            clip: Clip::NONE,
        };
        let offset = perspective.forward * 4.0 + perspective.up * 2.0 + perspective.right;
        for camera in [perspective, CameraPose { projection: Projection::Orthographic, ..perspective }] {
            let (origin, sight) = (camera.origin(offset), camera.sight(offset));
            assert!((origin + sight).abs_diff_eq(camera.eye + offset, 1e-5));
            assert!((origin - camera.eye).dot(camera.forward).abs() < 1e-5);
        }
    }
}
