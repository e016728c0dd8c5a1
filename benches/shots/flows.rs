//! Camera moves of chains: at constant speed for a leg, then back, and so on, so that chains of any length stay in
//! the scene.

use afterimage::animation::{Interpolation, Keyed, Track};
use afterimage::scene::CameraTrack;
use afterimage::scene::RenderSpace;
use afterimage::scene::camera::{Aim, Lens};
use clap::ValueEnum;
use glam::DVec3;

use super::kinds::FOV;
use super::places::Place;

/// Frames from one turning point to the next. Frames 24, 96 and 300 and their neighbours are on legs of the same
/// direction.
const LEG: i32 = 104;

/// Number of legs of a track.
const LEGS: i32 = 4;

/// Turn in degrees a frame, about the vertical axis or about the view axis.
const TURN: f64 = 0.3;

/// Share of the angle of view by which it shrinks in a frame.
const ZOOM: f64 = 0.01;

/// Movement of the camera on the first leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Flow {
    /// It travels along its view axis
    DollyIn,
    /// It travels backwards, from where `dolly-in` turns back
    DollyOut,
    /// It turns about the vertical axis, 0.3 degrees a frame; the place's view is in the middle of the leg
    Pan,
    /// It turns about its view axis, 0.3 degrees a frame
    Turn,
    /// Its angle of view narrows by 1 % a frame
    ZoomIn,
    /// Its angle of view widens, from where `zoom-in` turns back
    ZoomOut,
    /// It travels to the left
    Sideways,
}

impl Flow {
    /// Name on the command line and in tables.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// Camera at `place` from frame 1 on, in the space in which the scene is rendered.
    pub fn camera(self, place: &Place, space: &RenderSpace) -> CameraTrack {
        let leg = f64::from(LEG);
        let way = (place.target - place.eye).normalize();
        let near = place.eye + way * place.stride * leg;
        let left = place.eye - way.cross(DVec3::Y).normalize() * place.stride * leg;
        let angles = DVec3::new(way.y.asin(), (-way.x).atan2(-way.z), 0.0).map(f64::to_degrees);
        let half = DVec3::Y * TURN * leg / 2.0;
        let narrow = FOV * (1.0 - ZOOM).powf(leg);

        let mut eye = Track::constant(place.eye);
        let mut rotation = Track::constant(angles);
        let mut fov = Track::constant(FOV);
        match self {
            Self::DollyIn => eye = there_and_back(place.eye, near, DVec3::lerp),
            Self::DollyOut => eye = there_and_back(near, place.eye, DVec3::lerp),
            Self::Sideways => eye = there_and_back(place.eye, left, DVec3::lerp),
            Self::Pan => rotation = there_and_back(angles - half, angles + half, DVec3::lerp),
            Self::Turn => rotation = there_and_back(angles, angles + DVec3::Z * TURN * leg, DVec3::lerp),
            Self::ZoomIn => fov = there_and_back(FOV, narrow, by_ratio),
            Self::ZoomOut => fov = there_and_back(narrow, FOV, by_ratio),
        }
        let eye = eye.map(|eye| space.point(eye));
        CameraTrack {
            eye: eye.into(),
            aim: Aim::Rotation(rotation),
            fov,
            lens: Lens::default(),
            cuts: vec![],
        }
    }
}

/// Interpolates from `from` to `to`, each step by the same factor.
fn by_ratio(from: f64, to: f64, t: f64) -> f64 {
    from * (to / from).powf(t)
}

/// Creates a track that is at `from` in frame 1, at `to` a leg later, at `from` another leg later; a key a
/// frame, because `between` need not be linear.
fn there_and_back<T: Keyed>(from: T, to: T, between: fn(T, T, f64) -> T) -> Track<T> {
    let key = |step: i32| {
        let (leg, rest) = (step / LEG, step % LEG);
        let there = if leg % 2 == 0 { rest } else { LEG - rest };
        (f64::from(1 + step), between(from, to, f64::from(there) / f64::from(LEG)))
    };
    Track::through((0..=LEGS * LEG).map(key).collect(), Interpolation::Linear).expect("frames rise")
}
