//! The camera of a shot: keyed eye, orientation and field of view.

use glam::DVec3;

use crate::animation::Track;

/// A pinhole camera whose place, direction and lens are keyed.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraTrack {
    /// World space.
    pub eye: Track<DVec3>,
    /// Where it looks.
    pub aim: Aim,
    /// Vertical field of view, degrees, in 0..180 (both excluded).
    pub fov: Track<f64>,
    /// Frames at which the shot cuts: nothing is reused across one.
    pub cuts: Vec<i32>,
}

impl CameraTrack {
    /// Tangent of half the vertical field of view at `frame`.
    pub fn tan_half_fov(&self, frame: f64) -> f32 {
        (self.fov.at(frame).to_radians() * 0.5).tan() as f32
    }
}

/// Two ways to key a direction.
#[derive(Debug, Clone, PartialEq)]
pub enum Aim {
    /// Looks at a point of world space; `roll` in degrees banks it clockwise.
    Target {
        /// World space.
        target: Track<DVec3>,
        /// Degrees.
        roll: Track<f64>,
    },
    /// Pitch (up), yaw (left) and roll (clockwise) in degrees; zero looks along -Z with +Y up. Roll is applied
    /// first, then pitch, then yaw.
    Rotation(Track<DVec3>),
}
