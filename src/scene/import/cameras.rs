//! Cameras of files, as the table that a shot file has for them, and the settings of the pictures that they take.

use glam::{DAffine3, DVec3};

use super::lights::three;
use crate::scene::camera::Projection;
use crate::scene::keys::camera::{CameraKey, CameraTable};
use crate::scene::keys::samples::SamplesValue;
use crate::scene::keys::toml_text::{At, List};
use crate::scene::keys::{Rate, RenderTable};

/// Height of a picture whose width follows from the camera, pixels.
const HEIGHT: f64 = 720.0;

/// Ratios of width to height that are taken from a camera.
const RATIOS: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// Samples along an edge of a pixel.
const SAMPLES: i64 = 2;

/// Roll below which a camera is level, degrees: files keep rotations as single floats.
const LEAST_ROLL: f64 = 1e-4;

/// Size of a picture that is `ratio` times as wide as high, pixels. `None` if no picture is.
pub fn size_of_ratio(ratio: f64) -> Option<[u32; 2]> {
    RATIOS.contains(&ratio).then(|| [(ratio * HEIGHT).round() as u32, HEIGHT as u32])
}

/// Settings of pictures of this size.
pub fn settings(size: [u32; 2], frames: String, rate: Rate) -> RenderTable {
    RenderTable {
        size: Some(List(size.map(|side| At::of(i64::from(side))))),
        samples: Some(At::of(SamplesValue::Fixed(SAMPLES))),
        frames: Some(At::of(frames)),
        rate: Some(At::of(rate)),
        ..RenderTable::default()
    }
}

/// A camera with these keys, which jumps at `cuts`.
pub fn table(
    projection: Option<Projection>,
    keys: impl Iterator<Item = CameraKey>,
    cuts: &[f64],
) -> CameraTable {
    let mut turned = 0.0;
    let key = keys.enumerate().map(|(i, key)| {
        let (frame, roll) = (*key.frame.get_ref(), key.roll.map_or(0.0, At::into_inner));
        // the shorter way from key to key
        turned += (roll - turned + 180.0).rem_euclid(360.0) - 180.0;
        let roll = (f64::abs(turned) > LEAST_ROLL).then(|| At::of(turned));
        let cut = i > 0 && frame.fract() == 0.0 && cuts.contains(&frame);
        At::of(CameraKey { roll, cut, ..key })
    });
    CameraTable { key: key.collect(), from: None, animation: None, projection, interpolation: None }
}

/// Place of a camera at a frame, which looks along -Z of its node: all of its lens is left to the key before.
pub fn key(frame: f64, map: DAffine3) -> CameraKey {
    let View { eye, target, roll } = View::of(map);
    CameraKey {
        frame: At::of(frame),
        eye: Some(three(eye)),
        orbit: None,
        target: Some(three(target)),
        rotation: None,
        roll: Some(At::of(roll)),
        fov: None,
        height: None,
        shift: None,
        aperture: None,
        focus: None,
        near: None,
        far: None,
        cut: false,
    }
}

/// Place and direction of a camera.
struct View {
    eye: DVec3,
    target: DVec3,
    /// Degrees, clockwise.
    roll: f64,
}

impl View {
    /// View of a camera that looks along -Z of its node. The target is the point nearest to the origin, if it is before the camera.
    fn of(map: DAffine3) -> Self {
        let axis = |axis: DVec3| axis.normalize_or_zero();
        let (eye, forward) = (map.translation, axis(-map.matrix3.z_axis));
        let right = forward.cross(axis(map.matrix3.y_axis));
        let level = forward.cross(DVec3::Y).try_normalize().unwrap_or(DVec3::X);
        let roll = f64::atan2(-right.dot(level.cross(forward)), right.dot(level)).to_degrees();
        let ahead = -eye.dot(forward);
        let distance = if ahead > 1e-3 * eye.length() { ahead } else { 1.0 };
        Self { eye, target: eye + forward * distance, roll }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_roll_the_shorter_way_and_jump_at_cuts() {
        let turns = [(1.0, 0.0), (2.0, 170.0), (2.5, 190.0), (3.0, 0.00001)];
        let keys = turns.map(|(frame, turn): (f64, f64)| {
            // clockwise for the camera
            let map = DAffine3::from_rotation_z(-turn.to_radians());
            key(frame, DAffine3::from_translation(DVec3::Z) * map)
        });
        let table = table(None, keys.into_iter(), &[1.0, 2.5, 3.0]);
        let key = |i: usize| table.key[i].get_ref();
        let roll = |i: usize| key(i).roll.as_ref().map(|roll| roll.get_ref().abs().round());
        assert_eq!([0, 1, 2, 3].map(roll), [None, Some(170.0), Some(190.0), Some(360.0)]);
        assert_eq!([0, 1, 2, 3].map(|i| key(i).cut), [false, false, false, true], "on whole frames alone");
    }
}
