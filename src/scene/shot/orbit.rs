//! Cameras that go around their target: keyed by angles and a distance instead of a place.

use glam::DVec3;

use crate::animation::{Interpolation, Track};
use crate::scene::SceneError;
use crate::scene::keys::camera::CameraKey;
use crate::scene::keys::toml_text::{At, TomlText};

/// Maximum number of frames of an orbit: one key of the eye is made for each.
const MOST_FRAMES: f64 = 1e6;

/// Position of the eye that `orbit` (azimuth and elevation in degrees, distance) puts beside `target`. At
/// azimuth 0 it is on the side of +Z, at 90 on that of +X.
pub fn eye(target: DVec3, orbit: DVec3) -> DVec3 {
    // whole turns go first: the last frame of a turn is the first one, to the bit
    let (sin, cos) = (orbit.x % 360.0).to_radians().sin_cos();
    let (up, out) = orbit.y.to_radians().sin_cos();
    target + orbit.z * DVec3::new(sin * out, up, cos * out)
}

/// Reads the `orbit` of a key.
pub fn of_key(text: TomlText<'_>, key: &CameraKey) -> Result<DVec3, SceneError> {
    let Some(stated) = &key.orbit else {
        return Err(text.fault(key.frame.span(), "the keys of a camera have either all `eye` or all `orbit`"));
    };
    if let Some(eye) = &key.eye {
        return Err(text.bad("eye", eye, "and `orbit` exclude each other: keep one of them"));
    }
    if key.target.is_none() {
        return Err(text.fault(stated.span(), "`orbit` goes around the key's `target`: give it one"));
    }
    let orbit = text.vector("orbit", stated)?;
    if orbit.y.abs() > 90.0 || orbit.z <= 0.0 {
        let message = "is azimuth, elevation (-90 to 90) and a distance above 0";
        return Err(text.bad("orbit", stated, message));
    }
    Ok(orbit)
}

/// Positions of the eye at each whole frame, on its way around `target`. Angles and distances are
/// interpolated each on its own.
pub fn eyes(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    (orbit, target): (&Track<DVec3>, &Track<DVec3>),
    cuts: &[f64],
) -> Result<Track<DVec3>, SceneError> {
    let (first, last) = (keys[0].0, keys[keys.len() - 1].0);
    if last - first > MOST_FRAMES {
        let message = format!("is more than {MOST_FRAMES} frames after the first: an orbit has no more");
        return Err(text.bad("frame", &keys[keys.len() - 1].1.get_ref().frame, &message));
    }
    let whole = (0..=(last - first).ceil() as u32).map(|i| first.ceil() + f64::from(i));
    let mut frames: Vec<f64> =
        whole.filter(|frame| *frame < last).chain(keys.iter().map(|(frame, _)| *frame)).collect();
    frames.sort_by(f64::total_cmp);
    frames.dedup();
    let key = |frame| (frame, eye(target.at(frame), orbit.at(frame)));
    let track = Track::through(frames.into_iter().map(key).collect(), Interpolation::Linear);
    Ok(track.expect("frames are finite, in order, and each is there once").cut_at(cuts))
}
