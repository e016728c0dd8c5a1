//! Reads the exposure of the camera: the keys of a lens with an aperture, the shutter, and two eyes.

use crate::exposure::{Curve, LensPose, Shutter};
use crate::scene::camera::{FARTHEST_PLANE, Projection};
use crate::scene::keys::camera::{CameraKey, ShutterTable, StereoTable};
use crate::scene::keys::toml_text::{At, List, TomlText};
use crate::scene::{CameraTrack, SceneError};
use crate::stereo::Stereo;

/// Radii and distances, in the units of the files: single floats lose those beyond these limits.
const LEAST_FOCUS: f64 = 1e-18;
const GREATEST: f64 = 1e18;

/// Keys of a lens's aperture; empty if no key states one.
pub struct Opening {
    /// Aperture radius at each key.
    pub aperture: Option<Vec<(f64, f64)>>,
    /// Focus distance at each key. None: that of the target.
    pub focus: Option<Vec<(f64, f64)>>,
}

/// Reads the aperture at each of `keys`.
pub fn opening(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    is_orthographic: bool,
) -> Result<Opening, SceneError> {
    let stated = keys.iter().find_map(|(_, key)| key.get_ref().aperture.as_ref());
    if let Some(aperture) = stated.filter(|_| is_orthographic) {
        return Err(text.bad("aperture", aperture, LensPose::ORTHOGRAPHIC));
    }
    let focused = keys.iter().find_map(|(_, key)| key.get_ref().focus.as_ref());
    let Some(stated) = stated else {
        let Some(focus) = focused else { return Ok(Opening { aperture: None, focus: None }) };
        let message = "goes with `aperture`, the radius of the lens: without one everything is sharp";
        return Err(text.bad("focus", focus, message));
    };
    let (mut radius, mut last_focus) = (0.0, None);
    let (mut radii, mut distances) = (Vec::new(), Vec::new());
    for (frame, key) in keys {
        let key = key.get_ref();
        if let Some(aperture) = &key.aperture {
            let wanted = "the radius of a lens: from 0 to 1e18, in the units of the models";
            radius =
                text.number("aperture", aperture, wanted, |radius| (0.0..=GREATEST).contains(&radius))?;
        }
        if let Some(focus) = &key.focus {
            let wanted = "a distance from 1e-18 to 1e18, in the units of the models";
            let fits = |focus: f64| (LEAST_FOCUS..=GREATEST).contains(&focus);
            last_focus = Some(text.number("focus", focus, wanted, fits)?);
        }
        let distance = last_focus.or_else(|| distance_of_target(key)).ok_or_else(|| {
            let message = "this camera key needs `focus`, the distance of what is sharp: with `rotation` there is no target";
            text.fault(key.frame.span(), message)
        })?;
        if radius > distance * LensPose::WIDEST {
            let message = format!(
                "is {radius}, and what is sharp is {distance} away: the radius of the lens may be {} times the distance at most",
                LensPose::WIDEST
            );
            return Err(text.bad("aperture", key.aperture.as_ref().unwrap_or(stated), &message));
        }
        radii.push((*frame, radius));
        distances.push((*frame, distance));
    }
    Ok(Opening { aperture: Some(radii), focus: focused.map(|_| distances) })
}

/// Keys of the distance of a clipping plane. None: there is no such plane.
type Plane = Option<Vec<(f64, f64)>>;

/// Reads the distances of the near and the far clipping plane at each of `keys`.
pub fn clip(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<[Plane; 2], SceneError> {
    let near =
        plane(text, keys, "near", |key| key.near.as_ref(), |depth| (0.0..=FARTHEST_PLANE).contains(&depth))?;
    let far =
        plane(text, keys, "far", |key| key.far.as_ref(), |depth| depth > 0.0 && depth <= FARTHEST_PLANE)?;
    if let (Some(near), Some(far)) = (&near, &far) {
        let crossed = keys.iter().zip(near.iter().zip(far)).find(|(_, ((_, near), (_, far)))| near >= far);
        if let Some(((_, key), ((_, near), (_, far)))) = crossed {
            let message = format!("`near` ({near}) must be below `far` ({far}): nothing would be seen");
            return Err(text.fault(key.get_ref().frame.span(), message));
        }
    }
    Ok([near, far])
}

/// Reads the distance of a clipping plane at each of `keys`: the last that was stated, or the first.
fn plane<'k>(
    text: TomlText<'_>,
    keys: &[(f64, &'k At<CameraKey>)],
    name: &str,
    of: impl Fn(&'k CameraKey) -> Option<&'k At<f64>>,
    fits: impl Fn(f64) -> bool,
) -> Result<Plane, SceneError> {
    let wanted = "a distance of up to 1e18, in the units of the models";
    let stated = |key: &'k At<CameraKey>| {
        of(key.get_ref()).map(|depth| text.number(name, depth, wanted, &fits)).transpose()
    };
    let all: Vec<Option<f64>> = keys.iter().map(|(_, key)| stated(key)).collect::<Result<_, _>>()?;
    let Some(mut last) = all.iter().find_map(|depth| *depth) else { return Ok(None) };
    let depths = keys.iter().zip(all).map(|((frame, _), depth)| {
        last = depth.unwrap_or(last);
        (*frame, last)
    });
    Ok(Some(depths.collect()))
}

/// Distance from the key's eye to its target.
fn distance_of_target(key: &CameraKey) -> Option<f64> {
    let target = key.target.as_ref()?.get_ref().0;
    if let Some(orbit) = &key.orbit {
        return Some(orbit.get_ref().0[2]);
    }
    let eye = key.eye.as_ref()?.get_ref().0;
    let squares = eye.iter().zip(target).map(|(eye, target)| (eye - target).powi(2));
    Some(squares.sum::<f64>().sqrt())
}

/// Reads the two eyes beside `camera`.
pub fn stereo(
    text: TomlText<'_>,
    table: &At<StereoTable>,
    camera: &CameraTrack,
) -> Result<Stereo, SceneError> {
    if camera.projection() == Projection::Orthographic {
        return Err(text.fault(table.span(), Stereo::ORTHOGRAPHIC));
    }
    let StereoTable { separation, convergence } = table.get_ref();
    let separation = separation.as_ref().ok_or_else(|| {
        let message = "[stereo] needs `separation`: the distance between the eyes, in the units of the models, such as 0.065 \
                       for metres; leave the table out for one eye";
        text.fault(table.span(), message)
    })?;
    let number = |value: &At<f64>| *value.get_ref();
    let stereo = Stereo { separation: number(separation), convergence: convergence.as_ref().map(number) };
    match stereo.fault() {
        Some(fault) => Err(text.fault(table.span(), format!("[stereo]: {fault}"))),
        None => Ok(stereo),
    }
}

/// Reads when the shutter is open, and how far.
pub fn shutter(text: TomlText<'_>, table: &At<ShutterTable>) -> Result<Shutter, SceneError> {
    let ShutterTable { open, close, curve } = table.get_ref();
    let usual = Shutter::default();
    let number = |value: &Option<At<f64>>, usual| value.as_ref().map_or(usual, |value| *value.get_ref());
    let stated = curve.as_ref().map(|points| {
        let curve = Curve::through(points.get_ref().iter().map(|List(point)| *point).collect());
        curve.map_err(|fault| text.fault(points.span(), format!("[shutter]: the `curve` {fault}")))
    });
    let curve = stated.transpose()?.unwrap_or(usual.curve);
    let shutter = Shutter { open: number(open, usual.open), close: number(close, usual.close), curve };
    match shutter.fault() {
        Some(fault) => Err(text.fault(table.span(), format!("[shutter]: {fault}"))),
        None => Ok(shutter),
    }
}
