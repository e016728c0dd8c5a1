//! Camera moves: one way for a hundred frames, then back, and so on, so that chains can be long.

use afterimage::animation::{Interpolation, Keyed, Track};
use afterimage::scene::CameraTrack;
use afterimage::scene::camera::{Aim, Lens};
use clap::ValueEnum;
use glam::DVec3;

/// Frames from one turning point to the next. Frames 24, 96 and 300 are on legs of the same direction.
pub const LEG: i32 = 100;

/// Number of legs of a track.
const LEGS: i32 = 20;

/// Movement of the camera on the first leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Flow {
    /// It does not move.
    Rest,
    /// It travels along its view axis.
    In,
    /// It travels backwards.
    Out,
    /// It travels to the right.
    Sideways,
    /// It turns left about its vertical axis.
    Turn,
}

/// Initial pose of a camera, and its speeds. World space.
#[derive(Debug, Clone, Copy)]
pub struct Stand {
    pub eye: DVec3,
    pub target: DVec3,
    /// Vertical field of view, degrees.
    pub fov: f64,
    /// World units a frame, for `In` and `Out`.
    pub stride: f64,
    /// World units a frame, for `Sideways`.
    pub aside: f64,
    /// Degrees a frame, for `Turn`.
    pub turn: f64,
}

impl Flow {
    /// Name on the command line and in tables.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Camera that starts at `stand`; `Out` starts where `In` turns.
    pub fn camera(self, stand: &Stand) -> CameraTrack {
        let way = (stand.target - stand.eye).normalize();
        let leg = f64::from(LEG);
        let (near, right) = (stand.eye + way * stand.stride * leg, way.cross(DVec3::Y).normalize());
        let angles = DVec3::new(way.y.asin(), (-way.x).atan2(-way.z), 0.0).map(f64::to_degrees);
        let (mut eye, mut rotation) = (Track::constant(stand.eye), Track::constant(angles));
        match self {
            Self::Rest => {}
            Self::In => eye = there_and_back(stand.eye, near),
            Self::Out => eye = there_and_back(near, stand.eye),
            Self::Sideways => eye = there_and_back(stand.eye, stand.eye + right * stand.aside * leg),
            Self::Turn => rotation = there_and_back(angles, angles + DVec3::Y * stand.turn * leg),
        }
        CameraTrack {
            eye: eye.into(),
            aim: Aim::Rotation(rotation),
            fov: Track::constant(stand.fov),
            lens: Lens::default(),
            cuts: vec![],
        }
    }
}

/// Creates a track that is at `from` in frame 1, at `to` a leg later, and so on, with constant speed.
pub fn there_and_back<T: Keyed>(from: T, to: T) -> Track<T> {
    let key = |leg: i32| (f64::from(1 + LEG * leg), if leg % 2 == 0 { from } else { to });
    Track::through((0..=LEGS).map(key).collect(), Interpolation::Linear).expect("frames rise")
}
