//! Cameras that the page moves: their initial poses, their tracks for the renderer, and their keys for a shot
//! file.

use std::fmt::Write;

use glam::DVec3;
use serde_json::{Value, json};

use crate::animation::Track;
use crate::geometry::Bounds;
use crate::pose::CameraPose;
use crate::scene::camera::{Aim, EyeTrack, Lens, Projection};
use crate::scene::turntable::text::number;
use crate::scene::{CameraTrack, RenderSpace, Shot};

/// Bounds of coordinates and heights, in the units of the files: those of shot files.
const FARTHEST: f64 = 1e18;
const LEAST: f64 = 1e-18;
/// Minimum field of view of shot files, degrees.
const LEAST_FOV: f64 = 1e-6;
/// Minimum distance of the target of a camera that is inside the models, or beside them: as a share of the
/// diagonal of all models.
const NEAREST_TARGET: f64 = 0.05;

/// Precision of places in keys, as a share of that which the distance to the target needs: a pixel moves by
/// less.
const FINER: f64 = 0.01;

/// A camera at one place, in the space of the shot's files.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeCamera {
    eye: DVec3,
    /// Point that it looks at, and orbits.
    target: DVec3,
    /// Roll in degrees, clockwise.
    roll: f64,
    /// Vertical field of view in degrees; for an orthographic camera the height of its view.
    lens: f64,
}

impl FreeCamera {
    /// Reads numbers between commas: eye, target, roll and lens.
    pub fn parse(text: &str) -> Option<Self> {
        let numbers =
            text.split(',').map(|number| number.parse().ok().filter(|number: &f64| number.is_finite()));
        let numbers: Vec<f64> = numbers.collect::<Option<_>>()?;
        let [ex, ey, ez, tx, ty, tz, roll, lens] = numbers[..] else { return None };
        let (eye, target) = (DVec3::new(ex, ey, ez), DVec3::new(tx, ty, tz));
        let is_near = eye.abs().max_element() <= FARTHEST && target.abs().max_element() <= FARTHEST;
        let is_apart = (target - eye).length() >= LEAST;
        (is_near && is_apart).then_some(Self { eye, target, roll, lens })
    }
}

/// The camera of a shot, and how its file writes keys.
#[derive(Debug)]
pub struct ShotCamera {
    /// World space.
    track: CameraTrack,
    space: RenderSpace,
    says_orbit: bool,
    /// Centre and diagonal of all models in the shot's first frame, world space.
    models: (DVec3, f64),
}

impl ShotCamera {
    /// Reads the camera of `shot`.
    pub fn new(shot: &Shot) -> Self {
        let track = shot.scene.camera.clone();
        // a camera with a target needs no other
        let models = match track.aim {
            Aim::Target { .. } => (DVec3::ZERO, 0.0),
            Aim::Rotation(_) => middle_of_models(shot),
        };
        Self { track, space: shot.scene.space, says_orbit: shot.says_orbit, models }
    }

    fn is_orthographic(&self) -> bool {
        self.track.projection() == Projection::Orthographic
    }

    /// Pose at `frame`.
    pub fn at(&self, frame: i32) -> FreeCamera {
        let (track, time) = (&self.track, f64::from(frame));
        let eye = track.eye.at(time);
        let (target, roll) = match &track.aim {
            Aim::Target { target, roll } => (target.at(time), roll.at(time)),
            Aim::Rotation(_) => self.ahead(eye, &CameraPose::new(track, time)),
        };
        let lens = match &track.lens.height {
            Some(height) => height.at(time) / self.space.scale(),
            None => track.fov.at(time),
        };
        let [eye, target] = [eye, target].map(|place| self.space.place_of_files(place));
        FreeCamera { eye, target, roll, lens }
    }

    /// Target on the view axis, as far away as the models are, and the roll of a camera that looks there.
    fn ahead(&self, eye: DVec3, pose: &CameraPose) -> (DVec3, f64) {
        let [right, forward] = [pose.right, pose.forward].map(|axis| axis.as_dvec3());
        let (middle, diagonal) = self.models;
        let depth = (middle - eye).dot(forward);
        let depth = if depth > NEAREST_TARGET * diagonal { depth } else { (0.5 * diagonal).max(LEAST) };
        let level = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let roll = (-right.dot(level.cross(forward))).atan2(right.dot(level)).to_degrees();
        (eye + depth * forward, roll)
    }

    /// Initial pose at `frame` for the page, as JSON.
    pub fn told(&self, frame: i32) -> Value {
        let FreeCamera { eye, target, roll, lens } = self.at(frame);
        json!({
            "eye": eye.to_array(), "target": target.to_array(), "roll": roll, "lens": lens,
            "orthographic": self.is_orthographic(),
        })
    }

    /// Track of `free` at `frame` for the renderer: in the space of the files, with the lens shift that the
    /// shot has there. `None` if there is no such lens.
    pub fn track(&self, free: &FreeCamera, frame: i32) -> Option<CameraTrack> {
        let is_lens = if self.is_orthographic() {
            (LEAST..=FARTHEST).contains(&free.lens)
        } else {
            (LEAST_FOV..180.0).contains(&free.lens)
        };
        let shift = self.track.lens.shift.each_ref().map(|shift| Track::constant(shift.at(f64::from(frame))));
        let height = self.is_orthographic().then(|| Track::constant(free.lens));
        is_lens.then(|| CameraTrack {
            eye: EyeTrack::constant(free.eye),
            aim: Aim::Target { target: Track::constant(free.target), roll: Track::constant(free.roll) },
            fov: Track::constant(free.lens),
            lens: Lens { height, shift, ..Lens::default() },
            cuts: Vec::new(),
        })
    }

    /// Key of `free` at `frame` for the shot file, in the words of the shot's other keys.
    pub fn key(&self, free: &FreeCamera, frame: i32) -> String {
        let FreeCamera { eye, target, roll, lens } = *free;
        let (way, time) = (target - eye, f64::from(frame));
        let distance = way.length();
        let place = |place: DVec3| list(&place.to_array(), FINER * distance);
        // a picture with a long lens shows little turns
        let degrees = |angle: f64| number(angle, if self.is_orthographic() { 1.0 } else { lens.min(1.0) });
        let mut text = format!("[[camera.key]]\nframe = {frame}\n");
        let mut line = |key: &str, value: String| {
            let _ = writeln!(text, "{key} = {value}");
        };
        // up and sideways, from -Z to the left
        let pitch = (way.y / distance).clamp(-1.0, 1.0).asin().to_degrees();
        let yaw = (-way.x).atan2(-way.z).to_degrees();
        match (&self.track.aim, self.says_orbit) {
            (Aim::Rotation(_), _) => {
                line("eye", place(eye));
                line("rotation", format!("[{}, {}, {}]", degrees(pitch), degrees(yaw), degrees(roll)));
            }
            (Aim::Target { .. }, true) => {
                let orbit = [degrees(yaw.rem_euclid(360.0)), degrees(-pitch), number(distance, distance)];
                line("orbit", format!("[{}]", orbit.join(", ")));
                line("target", place(target));
            }
            (Aim::Target { .. }, false) => {
                line("eye", place(eye));
                line("target", place(target));
            }
        }
        if matches!(self.track.aim, Aim::Target { .. }) && roll != 0.0 {
            line("roll", degrees(roll));
        }
        line(if self.is_orthographic() { "height" } else { "fov" }, number(lens, lens));
        let of_lens = &self.track.lens;
        let shift = of_lens.shift.each_ref().map(|shift| shift.at(time));
        if of_lens.shift.iter().any(|shift| shift.values().any(|shift| shift != 0.0)) {
            line("shift", list(&shift, 1.0));
        }
        let lengths = [
            ("aperture", &of_lens.aperture),
            ("focus", &of_lens.focus),
            ("near", &of_lens.near),
            ("far", &of_lens.far),
        ];
        for (key, track) in lengths {
            if let Some(track) = track {
                let length = track.at(time) / self.space.scale();
                line(key, number(length, length.max(LEAST)));
            }
        }
        text
    }
}

/// Numbers of things of this `size`.
fn list(numbers: &[f64], size: f64) -> String {
    let numbers: Vec<String> = numbers.iter().map(|value| number(*value, size)).collect();
    format!("[{}]", numbers.join(", "))
}

/// Without those that have no end.
fn middle_of_models(shot: &Shot) -> (DVec3, f64) {
    let first = f64::from(shot.frames.first());
    let finite = shot
        .scene
        .models
        .iter()
        .filter(|model| !model.mesh.as_curved().is_some_and(|curved| curved.is_endless()));
    let placed = finite.map(|model| Bounds::of(&model.mesh).placed(&model.track.at(first)));
    let all = placed.fold(Bounds::EMPTY, Bounds::union);
    if all.is_empty() {
        return (DVec3::ZERO, 1.0);
    }
    let [low, high] = [all.low, all.high].map(|corner| corner.as_dvec3());
    (0.5 * (low + high), (high - low).length())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::scene;

    /// The camera of a shot with this `[camera]`, whose only model is a sphere around the origin.
    fn camera(folder: &Path, keys: &str) -> ShotCamera {
        let path = folder.join("s.toml");
        let text = format!(
            "{keys}\n[[model]]\n[model.quadric]\ntype = \"sphere\"\nmaterial = \"m\"\n[[material]]\nname = \"m\"\n"
        );
        fs::write(&path, text).expect("written");
        ShotCamera::new(&scene::load(&path, true).expect("a shot"))
    }

    fn free(numbers: &str) -> FreeCamera {
        FreeCamera::parse(numbers).expect("a camera")
    }

    #[test]
    fn a_key_is_written_as_the_shot_writes_keys_and_means_the_same() {
        let folder = tempfile::tempdir().expect("a folder");
        for (table, key, moved) in [
            ("", "eye = [0, 0, 8]\ntarget = [0, 0, 0]\n", "3,4,5,1,0,-1,0,35"),
            ("", "eye = [0, 0, 8]\ntarget = [0, 0, 0]\nshift = [0.1, 0]\nroll = 9\n", "3,-4,5,1,0,-1,-30,35"),
            ("", "orbit = [30, 20, 8]\ntarget = [0, 1, 0]\n", "-6,2,4,0,1,0,0,20"),
            ("", "orbit = [30, 20, 8]\ntarget = [0, 1, 0]\naperture = 0.1\n", "6,-2,-4,0,1,0,5,20"),
            (
                "",
                "eye = [0, 0, 8]\nrotation = [5, 10, 20]\naperture = 0.1\nfocus = 3\n",
                "3,4,5,1,0,-1,15,35",
            ),
            (
                "[camera]\nprojection = \"orthographic\"\n",
                "eye = [0, 0, 8]\ntarget = [0, 0, 0]\nheight = 3\n",
                "0,9,1,0,0,0,0,2.5",
            ),
        ] {
            let written = |key: &str| camera(folder.path(), &format!("{table}{key}"));
            let shot = written(&format!("[[camera.key]]\nframe = 1\n{key}"));
            let moved = free(moved);
            let text = shot.key(&moved, 7);
            let again = written(&text);
            let words = |text: &str| -> Vec<String> {
                text.lines().filter_map(|line| Some(line.split_once(" = ")?.0.to_owned())).collect()
            };
            for word in words(key).iter().filter(|word| *word != "roll") {
                assert!(words(&text).contains(word), "{word}: {text}");
            }
            let track = shot.track(&moved, 7).expect("a lens");
            let [wanted, found] = [&track, &again.track].map(|track| CameraPose::new(track, 7.0));
            for (wanted, found) in [
                (wanted.eye, found.eye),
                (wanted.right, found.right),
                (wanted.up, found.up),
                (wanted.forward, found.forward),
            ] {
                assert!(wanted.distance(found) < 1e-3, "{wanted} {found}: {text}");
            }
            assert!(
                (wanted.half_height - found.half_height).abs() < 1e-4 && wanted.shift == found.shift,
                "{text}"
            );
            let lens = |camera: &ShotCamera| camera.track.lens.aperture.as_ref().map(|radius| radius.at(7.0));
            assert_eq!(lens(&again), lens(&shot));
        }
    }

    #[test]
    fn a_camera_that_is_let_go_is_where_the_shot_has_it() {
        let folder = tempfile::tempdir().expect("a folder");
        for key in
            ["eye = [1e7, 2, 8]\ntarget = [1e7, 1, 0]\nroll = 9", "eye = [3, 2, 8]\nrotation = [-10, 20, 30]"]
        {
            let shot = camera(folder.path(), &format!("[[camera.key]]\nframe = 1\n{key}\n"));
            let track = shot.space.camera(shot.track(&shot.at(1), 1).expect("a lens"));
            let [wanted, found] = [&shot.track, &track].map(|track| CameraPose::new(track, 1.0));
            assert!(
                wanted.eye == found.eye && wanted.up.distance(found.up) < 1e-6,
                "{key}: {wanted:?} {found:?}"
            );
            assert!(wanted.forward.distance(found.forward) < 1e-6, "{key}");
        }
        // around the sphere, and not around what is before the eye
        let shot =
            camera(folder.path(), "[[camera.key]]\nframe = 1\neye = [0, 0, 8]\nrotation = [0, 0, 0]\n");
        assert!(shot.at(1).target.length() < 1e-6, "{:?}", shot.at(1));
    }

    #[test]
    fn what_is_no_camera_is_refused() {
        for text in [
            "",
            "1,2,3,4,5,6,7",
            "1,2,3,4,5,6,7,8,9",
            "1,2,3,1,2,3,0,40",
            "NaN,2,3,4,5,6,0,40",
            "inf,2,3,4,5,6,0,40",
            "1e19,2,3,4,5,6,0,40",
            "1,2,3,4,5,6,0,x",
        ] {
            assert!(FreeCamera::parse(text).is_none(), "{text}");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let shot = camera(folder.path(), "[[camera.key]]\nframe = 1\neye = [0, 0, 8]\ntarget = [0, 0, 0]\n");
        for lens in ["0", "-40", "180"] {
            assert!(shot.track(&free(&format!("1,2,3,4,5,6,0,{lens}")), 1).is_none(), "{lens}");
        }
    }
}
