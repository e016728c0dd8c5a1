//! The camera of a shot: keyed eye, orientation and lens.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::animation::Track;
use crate::exposure::LensPose;

/// A camera whose place, direction and lens are keyed: a pinhole, or an orthographic one.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraTrack {
    /// Position of the eye, world space.
    pub eye: Track<DVec3>,
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
}

impl Default for Lens {
    /// A pinhole, with the view axis in the middle of the picture.
    fn default() -> Self {
        Self { height: None, shift: [0.0; 2].map(Track::constant), aperture: None, focus: None }
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
        let Lens { height, shift, aperture, focus } = &self.lens;
        let is_aim_constant = match &self.aim {
            Aim::Target { target, roll } => target.is_constant() && roll.is_constant(),
            Aim::Rotation(rotation) => rotation.is_constant(),
        };
        let optional = [height, aperture, focus].into_iter().flatten();
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
