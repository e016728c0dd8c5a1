//! Cameras that go around their target: keyed by angles and a distance instead of a place.

use glam::DVec3;

use crate::animation::Track;
use crate::scene::SceneError;
use crate::scene::camera::EyeTrack;
use crate::scene::keys::camera::CameraKey;
use crate::scene::keys::toml_text::{At, TomlText};

/// Maximum number of frames of an orbit: the extent of the shot looks at each.
const MOST_FRAMES: f64 = 1e6;

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

/// Way of an eye `around` a `target`. Angles and distances are interpolated each on its own, at any time.
pub fn eye(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    (around, target): (Track<DVec3>, Track<DVec3>),
) -> Result<EyeTrack, SceneError> {
    let (first, last) = (keys[0].0, keys[keys.len() - 1].0);
    if last - first > MOST_FRAMES {
        let message = format!("is more than {MOST_FRAMES} frames after the first: an orbit has no more");
        return Err(text.bad("frame", &keys[keys.len() - 1].1.get_ref().frame, &message));
    }
    Ok(EyeTrack::Orbit { around, target })
}
