//! Kinds of shots, and the shot file that has all of them.
//!
//! One shot serves all kinds, each in frames of its own, so that a scene is read once and built as rarely
//! as can be. What moves in the frames of one kind rests in those of the others.

use std::fmt::{self, Write};
use std::str::FromStr;

use afterimage::scene::Light;
use clap::ValueEnum;
use glam::{DQuat, DVec3};

use super::places::Place;

/// Moving things of a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// The camera rests, one object moves
    Object,
    /// The camera turns where it stands, sideways and up
    Pan,
    /// The angle of view narrows
    Zoom,
    /// The camera travels
    Dolly,
    /// The camera rests, one light moves
    Light,
    /// The camera is elsewhere in each frame: next to nothing is seen again
    Cut,
    /// Camera, all models and all lights move
    All,
}

/// Frames that the dolly would need to its end: a second of film.
pub const DOLLY_FRAMES: f64 = 24.0;

/// Turn of the camera, radians a frame: a quarter turn in four seconds, about.
const PAN: [f64; 2] = [0.016, 0.004];

/// Share of the angle of view by which it shrinks in a frame.
const ZOOM: f64 = 0.01;

/// Turn in radians about the vertical axis from cut to cut: no two of a few in a row show the same side.
const CUT: f64 = 2.4;

/// Vertical field of view, degrees.
pub const FOV: f64 = 40.0;

/// Number of point lights of a shot file; a measurement takes as many of them as it wants. After them comes
/// one panel, in the place of the first: the soft light.
pub const MOST_LIGHTS: usize = 32;

/// Lights that a measurement takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lights {
    /// This number of point lights, with hard shadows.
    Points(usize),
    /// The panel.
    Soft,
}

/// Set-up with which a shot is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    pub lights: Lights,
    /// Samples along a pixel's edge.
    pub samples: u32,
    /// Number of mirrors and panes that a ray may meet.
    pub depth: u32,
}

impl Setup {
    pub const fn of(lights: Lights, samples: u32, depth: u32) -> Self {
        Self { lights, samples, depth }
    }
}

impl Lights {
    /// Selects from `all`, the lights of a shot file.
    pub fn of(self, all: &[Light]) -> &[Light] {
        match self {
            Self::Points(count) => &all[..count],
            Self::Soft => &all[MOST_LIGHTS..],
        }
    }
}

impl fmt::Display for Lights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Points(count) => write!(f, "{count}"),
            Self::Soft => f.write_str("soft"),
        }
    }
}

impl FromStr for Lights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("soft", _) => Ok(Self::Soft),
            (_, Ok(count @ 1..=MOST_LIGHTS)) => Ok(Self::Points(count)),
            _ => Err(format!("write `soft`, or a number from 1 to {MOST_LIGHTS}")),
        }
    }
}

struct Camera {
    eye: DVec3,
    target: DVec3,
    fov: f64,
}

impl Kind {
    /// Name on the command line and in the table.
    pub fn name(self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }

    /// First frame of the kind, traced in full; the others follow.
    pub fn first_frame(self) -> i32 {
        1 + 1000 * self as i32
    }

    /// Returns true if all models move. The kind is the last one, so that models have moved in no other
    /// frame.
    pub fn moves_all(self) -> bool {
        self == Self::All
    }

    fn moves_object(self) -> bool {
        matches!(self, Self::Object | Self::All)
    }

    fn moves_light(self, light: usize) -> bool {
        self == Self::All || self == Self::Light && light == 0
    }

    fn camera(self, place: &Place, step: u32) -> Camera {
        let (t, way) = (f64::from(step), place.target - place.eye);
        let mut camera = Camera { eye: place.eye, target: place.target, fov: FOV };
        match self {
            Self::Object | Self::Light => {}
            Self::Pan => {
                let turned = DQuat::from_rotation_y(-PAN[0] * t) * way;
                camera.target = place.eye + turned + DVec3::Y * way.length() * PAN[1] * t;
            }
            Self::Zoom => camera.fov = FOV * (1.0 - ZOOM).powi(step as i32),
            Self::Dolly | Self::All => {
                camera.eye = place.eye.lerp(place.dolly[0], t / DOLLY_FRAMES);
                camera.target = place.target.lerp(place.dolly[1], t / DOLLY_FRAMES);
            }
            Self::Cut if place.cut_turns => {
                // a step aside, too: a camera that only turned would be verified against nothing
                camera.eye += DVec3::new(t.sin(), 0.0, t.cos()) * 0.02 * way.length();
                camera.target = camera.eye + DQuat::from_rotation_y(CUT * t) * way;
            }
            Self::Cut => camera.eye = place.target - DQuat::from_rotation_y(CUT * t) * way,
        }
        camera
    }
}

/// Writes the shot file of all kinds at `place`, `frames` frames each, `samples` along a pixel's edge.
/// `object` is the OBJ of the thing that moves alone: a sphere of radius 1.
pub fn shot_file(place: &Place, object: &str, frames: u32) -> String {
    let mut text = String::from(HEAD);
    camera_keys(&mut text, place, frames);
    models(&mut text, place, object, frames);
    lights(&mut text, place, frames);
    text
}

/// Writes the shot file without the object, with nothing that moves.
pub fn still_file(place: &Place) -> String {
    let mut text = String::from(HEAD);
    camera_keys(&mut text, place, 1);
    writeln!(text, "[[model]]\nobj = {:?}", place.obj).expect(TAKES_ALL);
    lights(&mut text, place, 0);
    text
}

/// Head of a shot file, up to the camera's keys.
const HEAD: &str = "[render]\nfilter = \"box\"\n[background]\ncolor = [0.2, 0.25, 0.3]\n\
                    [ambient]\ncolor = [0.25, 0.25, 0.25]\n[camera]\n";

/// Frames of all kinds, each with the number of steps from its kind's first.
fn all_frames(frames: u32) -> impl Iterator<Item = (Kind, i32, u32)> {
    let kinds = Kind::value_variants().iter();
    kinds.flat_map(move |kind| (0..frames).map(move |step| (*kind, kind.first_frame() + step as i32, step)))
}

/// Message of a failure that cannot happen: writing to a string.
const TAKES_ALL: &str = "a string grows";

fn camera_keys(text: &mut String, place: &Place, frames: u32) {
    for (kind, frame, step) in all_frames(frames) {
        let Camera { eye, target, fov } = kind.camera(place, step);
        let (eye, target) = (list(eye), list(target));
        writeln!(text, "[[camera.key]]\nframe = {frame}\neye = {eye}\ntarget = {target}\nfov = {fov:?}")
            .expect(TAKES_ALL);
    }
}

/// Writes the scene, and the object that moves before it.
fn models(text: &mut String, place: &Place, object: &str, frames: u32) {
    let distance = place.eye.distance(place.target);
    writeln!(text, "[[model]]\nobj = {:?}", place.obj).expect(TAKES_ALL);
    for (_, frame, step) in all_frames(frames).filter(|(kind, ..)| kind.moves_all()) {
        let (t, shift) = (f64::from(step), 0.002 * distance * f64::from(step));
        writeln!(
            text,
            "[[model.key]]\nframe = {frame}\ntranslate = [{shift:?}, 0, 0]\nrotate = [0, {:?}, 0]",
            0.1 * t
        )
        .expect(TAKES_ALL);
    }
    writeln!(text, "[[model]]\nobj = {object:?}\nscale = {:?}", 0.06 * distance).expect(TAKES_ALL);
    let from = place.eye.lerp(place.target, 0.6);
    let mut steps = 0.0;
    for (_, frame, step) in all_frames(frames).filter(|(kind, ..)| kind.moves_object()) {
        // goes on in a kind where it was left by the one before
        steps += if step == 0 { 0.0 } else { 1.0 };
        let at = list(from + DVec3::new(0.01, 0.004, 0.0) * distance * steps);
        writeln!(text, "[[model.key]]\nframe = {frame}\ntranslate = {at}").expect(TAKES_ALL);
    }
}

/// Writes all point lights, and the panel.
fn lights(text: &mut String, place: &Place, frames: u32) {
    for light in 0..MOST_LIGHTS {
        light_keys(text, place, light, frames, None);
    }
    light_keys(text, place, 0, frames, Some(place.panel));
}

/// Writes a point light, or, with a width and a height, a panel that faces the camera's target.
fn light_keys(text: &mut String, place: &Place, light: usize, frames: u32, panel: Option<[f64; 2]>) {
    let place_of_light = place.light + place.light_spread * on_spiral(light);
    let shape = match panel {
        None => String::from("type = \"point\""),
        Some(size) => {
            format!("type = \"rectangle\"\nsize = {size:?}\ntarget = {}", list(place.panel_target))
        }
    };
    writeln!(text, "[[light]]\n{shape}\npower = {:?}", place.power).expect(TAKES_ALL);
    writeln!(text, "position = {}", list(place_of_light)).expect(TAKES_ALL);
    let mut steps = 0.0;
    for (_, frame, step) in all_frames(frames).filter(|(kind, ..)| kind.moves_light(light)) {
        steps += if step == 0 { 0.0 } else { 1.0 };
        let at = list(place_of_light + place.light_spread * 0.02 * steps);
        writeln!(text, "[[light.key]]\nframe = {frame}\nposition = {at}").expect(TAKES_ALL);
    }
}

/// Points that fill a flat ball of radius 1, the first of them its centre.
fn on_spiral(number: usize) -> DVec3 {
    const GOLDEN_ANGLE: f64 = 2.399963;
    let t = number as f64;
    let radius = (t / MOST_LIGHTS as f64).sqrt();
    let (sin, cos) = (t * GOLDEN_ANGLE).sin_cos();
    DVec3::new(cos * radius, (t * 0.7).sin() * radius, sin * radius)
}

fn list(v: DVec3) -> String {
    format!("{:?}", v.to_array())
}
