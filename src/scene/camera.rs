//! The camera of a shot: keyed eye, orientation and lens.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::animation::Track;
use crate::exposure::LensPose;

/// Greatest distance of a clipping plane that files may state, in their units.
pub const FARTHEST_PLANE: f64 = 1e18;

/// A camera whose place, direction and lens are keyed: a pinhole, or an orthographic one.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraTrack {
    /// Position of the eye, world space.
    pub eye: EyeTrack,
    /// Viewing direction.
    pub aim: Aim,
    /// Vertical field of view, degrees, in 0..180 (both excluded). Ignored by an orthographic camera.
    pub fov: Track<f64>,
    /// Projection beyond the field of view: orthographic height, shift, depth of field.
    pub lens: Lens,
    /// Frames at which the shot cuts, rising: nothing is reused across one.
    pub cuts: Vec<i32>,
}

/// Projection and depth of field of a camera, beside its field of view.
#[derive(Debug, Clone, PartialEq)]
pub struct Lens {
    /// Height of the visible part of the world, world units, above 0: the camera is orthographic. None: a
    /// pinhole camera.
    pub height: Option<Track<f64>>,
    /// Offset of the picture from the view axis, to the right and up, as shares of the picture's longer side.
    pub shift: [Track<f64>; 2],
    /// Radius of the aperture, world units. None, or 0: everything is in focus.
    pub aperture: Option<Track<f64>>,
    /// Distance of the plane in focus along the view axis, world units. None: the distance of the target.
    pub focus: Option<Track<f64>>,
    /// Distance along the view axis nearer than which nothing is seen, world units. None: all is seen.
    pub near: Option<Track<f64>>,
    /// Distance along the view axis farther than which nothing is seen, world units. None: all is seen.
    pub far: Option<Track<f64>>,
}

impl Lens {
    /// Returns true if the clipping planes leave nothing between them at `frame`.
    pub fn sees_nothing(&self, frame: f64) -> bool {
        let at = |plane: &Option<Track<f64>>, none| plane.as_ref().map_or(none, |plane| plane.at(frame));
        let (near, far) = (at(&self.near, 0.0), at(&self.far, f64::INFINITY));
        far <= 0.0 || near >= far
    }
}

impl Default for Lens {
    /// A pinhole, with the view axis in the middle of the picture.
    fn default() -> Self {
        let shift = [0.0; 2].map(Track::constant);
        Self { height: None, shift, aperture: None, focus: None, near: None, far: None }
    }
}

/// Arrangement of the lines of sight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Projection {
    /// All lines of sight start at one point.
    #[default]
    Perspective,
    /// All lines of sight are parallel.
    Orthographic,
}

impl CameraTrack {
    /// Projection of the camera, the same in all frames.
    pub fn projection(&self) -> Projection {
        if self.lens.height.is_some() { Projection::Orthographic } else { Projection::Perspective }
    }

    /// Half the height of the view at `frame`. Perspective: at distance 1, the tangent of half the vertical
    /// field of view. Orthographic: in world units.
    pub fn half_height(&self, frame: f64) -> f32 {
        match &self.lens.height {
            Some(height) => (height.at(frame) * 0.5) as f32,
            None => (self.fov.at(frame).to_radians() * 0.5).tan() as f32,
        }
    }

    /// Returns true if the camera is the same in all frames.
    pub fn is_constant(&self) -> bool {
        let Lens { height, shift, aperture, focus, near, far } = &self.lens;
        let is_aim_constant = match &self.aim {
            Aim::Target { target, roll } => target.is_constant() && roll.is_constant(),
            Aim::Rotation(rotation) => rotation.is_constant(),
        };
        let optional = [height, aperture, focus, near, far].into_iter().flatten();
        self.eye.is_constant()
            && is_aim_constant
            && self.fov.is_constant()
            && shift.iter().chain(optional).all(Track::is_constant)
    }

    /// Returns true if the aperture is open at any key, so that things may be out of focus.
    pub fn has_lens(&self) -> bool {
        self.lens.aperture.as_ref().is_some_and(|radius| radius.values().any(|radius| radius > 0.0))
    }

    /// The lens at `frame`, if it has one.
    pub fn lens_at(&self, frame: f64) -> Option<LensPose> {
        let radius = self.lens.aperture.as_ref()?.at(frame).max(0.0);
        let focus = match (&self.lens.focus, &self.aim) {
            (Some(focus), _) => focus.at(frame),
            (None, Aim::Target { target, .. }) => (target.at(frame) - self.eye.at(frame)).length(),
            // a loader demands `focus` here
            (None, Aim::Rotation(_)) => 1.0,
        };
        Some(LensPose { radius, focus })
    }
}

/// Place of the eye in each frame, world space.
#[derive(Debug, Clone, PartialEq)]
pub enum EyeTrack {
    /// Keyed places.
    Keyed(Track<DVec3>),
    /// An orbit: keyed angles and distances, around a point that may move itself.
    Orbit {
        /// Azimuth and elevation in degrees, and distance above 0. At azimuth 0 the eye is on the side of +Z, at 90 on that of +X.
        around: Track<DVec3>,
        /// Middle of the orbit, world space.
        target: Track<DVec3>,
    },
}

impl From<Track<DVec3>> for EyeTrack {
    fn from(places: Track<DVec3>) -> Self {
        Self::Keyed(places)
    }
}

/// Place of the eye at `orbit` (azimuth and elevation in degrees, distance) around `target`.
pub fn on_orbit(target: DVec3, orbit: DVec3) -> DVec3 {
    // whole turns go first: the last frame of a turn is the first one, to the bit
    let (sin, cos) = (orbit.x % 360.0).to_radians().sin_cos();
    let (up, out) = orbit.y.to_radians().sin_cos();
    target + orbit.z * DVec3::new(sin * out, up, cos * out)
}

impl EyeTrack {
    /// Creates the track of an eye that never moves.
    pub fn constant(place: DVec3) -> Self {
        Track::constant(place).into()
    }

    /// Place at `frame`.
    pub fn at(&self, frame: f64) -> DVec3 {
        match self {
            Self::Keyed(places) => places.at(frame),
            Self::Orbit { around, target } => on_orbit(target.at(frame), around.at(frame)),
        }
    }

    /// Frames of the keys.
    pub fn frames(&self) -> Vec<f64> {
        match self {
            Self::Keyed(places) => places.frames().collect(),
            Self::Orbit { around, target } => around.frames().chain(target.frames()).collect(),
        }
    }

    /// Places at the keys, and of an orbit also at all whole frames between them.
    pub fn places(&self) -> Vec<DVec3> {
        match self {
            Self::Keyed(places) => places.values().collect(),
            Self::Orbit { around, .. } => {
                let keys: Vec<f64> = around.frames().collect();
                let (first, last) = (keys[0], keys[keys.len() - 1]);
                let whole = (0..=(last - first).ceil() as u32).map(|i| first.ceil() + f64::from(i));
                whole.filter(|frame| *frame < last).chain(keys).map(|frame| self.at(frame)).collect()
            }
        }
    }

    /// Returns true if it is the same in all frames.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Keyed(places) => places.is_constant(),
            Self::Orbit { around, target } => around.is_constant() && target.is_constant(),
        }
    }

    /// Frame up to which, itself excluded, the place is certainly that at `frame`: see [`Track::rests_until`].
    pub fn rests_until(&self, frame: f64) -> f64 {
        match self {
            Self::Keyed(places) => places.rests_until(frame),
            Self::Orbit { around, target } => around.rests_until(frame).min(target.rests_until(frame)),
        }
    }

    /// Converts it to another space: `point` converts places, `scale` lengths.
    pub fn converted(self, point: impl Fn(DVec3) -> DVec3, scale: f64) -> Self {
        match self {
            Self::Keyed(places) => Self::Keyed(places.map(point)),
            Self::Orbit { around, target } => Self::Orbit {
                around: around.map(|orbit| DVec3::new(orbit.x, orbit.y, orbit.z * scale)),
                target: target.map(point),
            },
        }
    }
}

/// Two ways to key a direction.
#[derive(Debug, Clone, PartialEq)]
pub enum Aim {
    /// Looks at a point of world space; `roll` in degrees banks it clockwise.
    Target {
        /// Point that the camera looks at, world space.
        target: Track<DVec3>,
        /// Roll, degrees.
        roll: Track<f64>,
    },
    /// Pitch (up), yaw (left) and roll (clockwise) in degrees; zero looks along -Z with +Y up. Roll is applied
    /// first, then pitch, then yaw.
    Rotation(Track<DVec3>),
}
