//! Places of camera, models and lights at one frame, in world space, ready for use.

use glam::{DMat3, DVec3, EulerRot, Mat4, Vec3, Vec4};

use crate::animation::{Track, Transform};
use crate::exposure::{Exposures, LensPose, TICKS, Tick};
use crate::scene::camera::{Aim, Lens, Projection};
use crate::scene::{CameraTrack, Light, LightKind, Panel, RenderSpace, Scene};
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
    /// Lights, one for each of [`Scene::lights`].
    pub lights: Vec<LightPose>,
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
        let middle = Self::at(scene, frame, clock.time(frame.into()), None);
        let sweeps = Sweeps::new(scene, clock, frame.into(), &middle.models);
        Self { camera, cameras, sweeps, ..middle }
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

    /// Returns true if rays must know at which tick they are: models move within the exposure, or clipping planes do.
    pub fn has_ticks(&self) -> bool {
        !self.sweeps.is_empty() || !self.cameras.is_empty() && self.camera.clip != Clip::NONE
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

/// Light at one frame, world space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LightPose {
    /// Part of the light that visibility depends on.
    pub shape: LightShape,
    /// Irradiance of a directional light and a sun; intensity of the others (of a rectangle and a disc along
    /// its axis). Linear RGB.
    pub strength: Vec3,
    /// Number of shadow rays that each sample sends to it: one to each of the points that stand for it, a
    /// grid of as many rows as columns.
    pub points: usize,
}

/// Part of a light that visibility depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightShape {
    /// Point that shines all around.
    Point {
        /// Position, world space.
        position: Vec3,
    },
    /// Light from infinitely far away.
    Directional {
        /// Direction from the scene to the light, unit length.
        to_light: Vec3,
    },
    /// Point that shines within a cone.
    Spot {
        /// Position, world space.
        position: Vec3,
        /// The cone.
        cone: Cone,
    },
    /// Light with an area.
    Area(AreaShape),
}

/// Directions within which a light shines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Direction in which the light travels, unit length.
    pub axis: Vec3,
    /// Cosine of the half angle at which the light ends.
    pub cos_outer: f32,
    /// Cosine of the half angle up to which it is full.
    pub cos_inner: f32,
    /// Numbers a and b of the curve between them, from 0 to 1: t²(a - bt).
    pub curve: [f32; 2],
}

/// How the radiance of a panel falls with the angle to its axis: by its tangent, to nothing at half of the spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Direction in which the light travels, unit length.
    pub axis: Vec3,
    /// 1 over the tangent of half of the spread.
    pub fall: f32,
}

/// Shape of a light with an area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AreaShape {
    /// Rectangle that shines to the side that its axis points to.
    Rectangle {
        /// Centre, world space.
        center: Vec3,
        /// Whole edge, horizontal where it can be.
        across: Vec3,
        /// Whole edge, at a right angle to the other.
        up: Vec3,
        /// Axis, unit length, at right angles to both.
        axis: Vec3,
        /// How it dims aside of its axis, if it does.
        spread: Option<Spread>,
    },
    /// Disc, or ellipse, that shines to the side that its axis points to.
    Disk {
        /// Centre, world space.
        center: Vec3,
        /// Vector from the centre to the rim.
        across: Vec3,
        /// Vector from the centre to the rim, at a right angle to the other.
        up: Vec3,
        /// Axis, unit length, at right angles to both.
        axis: Vec3,
        /// How it dims aside of its axis, if it does.
        spread: Option<Spread>,
    },
    /// Sphere that shines outwards.
    Sphere {
        /// Centre, world space.
        center: Vec3,
        /// Radius, world units.
        radius: f32,
        /// Directions to which alone it shines, if it is a spot.
        cone: Option<Cone>,
    },
    /// Light from infinitely far away, from a cone of directions.
    Sun {
        /// Direction from the scene to the middle of the light, unit length.
        to_light: Vec3,
        /// Axis across the light, unit length.
        across: Vec3,
        /// Other axis across the light, unit length; the three are at right angles.
        up: Vec3,
        /// Versine of the cone's half angle: 1 less its cosine.
        versine: f32,
    },
}

/// Origin of light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSource {
    /// A place, world space; the middle of it, where it has an area.
    Place(Vec3),
    /// Infinitely far away: the direction from the scene to the middle of it, unit length.
    Direction(Vec3),
}

impl LightShape {
    /// Returns true if the light has an area.
    pub fn is_area(&self) -> bool {
        matches!(self, Self::Area(_))
    }

    /// Origin of the light.
    #[inline(always)]
    pub fn source(&self) -> LightSource {
        match *self {
            Self::Point { position } | Self::Spot { position, .. } => LightSource::Place(position),
            Self::Directional { to_light } => LightSource::Direction(to_light),
            Self::Area(area) => area.source(),
        }
    }

    /// Upper bound of the distance of its points from its centre, world units, or for a sun from the middle
    /// of its directions; 0 for lights that have no area.
    pub fn reach(&self) -> f32 {
        match self {
            Self::Area(area) => area.reach(),
            Self::Point { .. } | Self::Directional { .. } | Self::Spot { .. } => 0.0,
        }
    }

    /// Half the size of the box around its points, or directions, with the [source](Self::source) in the middle.
    pub fn half_extent(&self) -> Vec3 {
        match self {
            Self::Area(area) => area.half_extent(),
            Self::Point { .. } | Self::Directional { .. } | Self::Spot { .. } => Vec3::ZERO,
        }
    }
}

impl AreaShape {
    #[inline(always)]
    fn source(&self) -> LightSource {
        match *self {
            Self::Rectangle { center, .. } | Self::Disk { center, .. } | Self::Sphere { center, .. } => {
                LightSource::Place(center)
            }
            Self::Sun { to_light, .. } => LightSource::Direction(to_light),
        }
    }

    fn reach(&self) -> f32 {
        match self {
            Self::Rectangle { across, up, .. } => 0.5 * (across.length() + up.length()),
            Self::Disk { across, up, .. } => across.length().max(up.length()),
            Self::Sphere { radius, .. } => *radius,
            Self::Sun { versine, .. } => (2.0 * versine).sqrt(),
        }
    }

    fn half_extent(&self) -> Vec3 {
        match self {
            Self::Rectangle { across, up, .. } => 0.5 * (across.abs() + up.abs()),
            Self::Disk { across, up, .. } => across.abs() + up.abs(),
            Self::Sphere { .. } | Self::Sun { .. } => Vec3::splat(self.reach()),
        }
    }
}

impl LightPose {
    /// Returns true if it sends no light, for want of power or colour: no ray to it is worth casting.
    pub fn is_dark(&self) -> bool {
        self.strength == Vec3::ZERO
    }

    /// Light at `frame`.
    pub fn new(light: &Light, frame: f64) -> Self {
        let strength = light.color.at(frame) * light.power.at(frame) as f32;
        let shape = match &light.kind {
            LightKind::Point { position } => LightShape::Point { position: position.at(frame).as_vec3() },
            LightKind::Directional { direction } => LightShape::Directional {
                to_light: -direction.at(frame).try_normalize().unwrap_or(DVec3::NEG_Y).as_vec3(),
            },
            LightKind::Spot { position, target, cone, soft, fall, radius } => {
                let (position, target) = (position.at(frame), target.at(frame));
                let half = (cone.at(frame) * 0.5).to_radians();
                let cone = Cone {
                    axis: (target - position).try_normalize().unwrap_or(DVec3::NEG_Y).as_vec3(),
                    cos_outer: half.cos() as f32,
                    cos_inner: (half * (1.0 - soft.at(frame))).cos() as f32,
                    curve: fall.curve(),
                };
                let (position, radius) = (position.as_vec3(), radius.at(frame) as f32);
                match radius > 0.0 {
                    true => {
                        LightShape::Area(AreaShape::Sphere { center: position, radius, cone: Some(cone) })
                    }
                    false => LightShape::Spot { position, cone },
                }
            }
            LightKind::Rectangle(panel) => {
                let (center, [across, up, axis], spread) = placed(panel, panel.size.at(frame), frame);
                LightShape::Area(AreaShape::Rectangle { center, across, up, axis, spread })
            }
            LightKind::Disk(panel) => {
                let radii = panel.size.at(frame).map(|diameter| 0.5 * diameter);
                let (center, [across, up, axis], spread) = placed(panel, radii, frame);
                LightShape::Area(AreaShape::Disk { center, across, up, axis, spread })
            }
            LightKind::Sphere { position, radius } => LightShape::Area(AreaShape::Sphere {
                center: position.at(frame).as_vec3(),
                radius: radius.at(frame) as f32,
                cone: None,
            }),
            LightKind::Sun { direction, angle } => {
                let axes = looking_at(-direction.at(frame), 0.0);
                let half_sine = (angle.at(frame) * 0.25).to_radians().sin();
                LightShape::Area(AreaShape::Sun {
                    to_light: -axes.z_axis.as_vec3(),
                    across: axes.x_axis.as_vec3(),
                    up: axes.y_axis.as_vec3(),
                    versine: (2.0 * half_sine * half_sine) as f32,
                })
            }
        };
        Self { shape, strength, points: light.points() }
    }
}

/// Centre of a panel, its axes (those across it have these lengths, that along which it shines has 1), and its spread.
fn placed(panel: &Panel, [width, height]: [f64; 2], frame: f64) -> (Vec3, [Vec3; 3], Option<Spread>) {
    let center = panel.position.at(frame);
    let axes = upright(panel.target.at(frame) - center, panel.up.at(frame));
    let axis = -axes.z_axis.as_vec3();
    let spread = panel.spread.at(frame);
    let spread = (spread < Panel::ALL_OF_ITS_SIDE)
        .then(|| Spread { axis, fall: (0.5 * spread).to_radians().tan().recip() as f32 });
    let edges = [(axes.x_axis * width).as_vec3(), (axes.y_axis * height).as_vec3(), axis];
    (center.as_vec3(), edges, spread)
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
