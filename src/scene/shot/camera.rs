//! The camera of a shot: of its own keys, or one of a glTF file.

use std::ops::Range;
use std::path::PathBuf;

use glam::DVec3;

use super::readers::Readers;
use super::tracks::{any_number, each, frames_between, in_order, through};
use super::{lens, orbit};
use crate::animation::Track;
use crate::scene::camera::{Aim, Lens, Projection};
use crate::scene::import::gltf::CameraChoice;
use crate::scene::keys::camera::{CameraKey, CameraTable};
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::file_of_text;
use crate::scene::{CameraTrack, SceneError};

/// Endings of files that have cameras.
const ENDINGS: [&str; 2] = [".glb", ".gltf"];

/// Reads the camera. `marked`: frames at which the shot says that it cuts; `rate`: frames in a second.
///
/// # Errors With line and column: values that make no sense, or a camera that is not there. Those of a file that it names.
pub fn of_table(
    text: TomlText<'_>,
    table: &At<CameraTable>,
    marked: &[i32],
    (readers, rate): (&mut Readers, f64),
) -> Result<CameraTrack, SceneError> {
    let CameraTable { from, animation, projection, interpolation, key } = table.get_ref();
    let refuse = |span: Range<usize>, message: &str| Err(text.fault(span, message));
    let Some(from) = from else {
        return match animation {
            Some(animation) => refuse(
                animation.span(),
                "`animation` goes with `from`, the glTF file whose camera this is: take it out",
            ),
            None => of_keys(text, table, marked),
        };
    };
    if !key.is_empty() || projection.is_some() || interpolation.is_some() {
        let message =
            "`from` says all of the camera: take it out, or `projection`, `interpolation` and all keys";
        return refuse(from.span(), message);
    }
    let (path, camera) = file_and_name(text, from)?;
    let animation = animation.as_ref().map(|name| name.get_ref().as_str());
    let choice = CameraChoice { camera: camera.as_deref(), animation, rate };
    let own = readers.gltf.camera(&mut readers.import, &path, choice)?;
    let own = At::of(own.map_err(|what| text.bad("from", from, &what))?);
    // there is no text of it: faults are those of the file
    let of_file = |error: SceneError| SceneError::new(&path, error.message);
    of_keys(TomlText { path: &path, text: "" }, &own, marked).map_err(of_file)
}

/// Splits `shot.glb#Name`: the file, and the name of the camera, if there is one.
fn file_and_name(text: TomlText<'_>, from: &At<String>) -> Result<(PathBuf, Option<String>), SceneError> {
    let stated = from.get_ref();
    let lower = stated.to_ascii_lowercase();
    // names may hold the sign as well
    let ends = ENDINGS.iter().filter_map(|ending| Some(lower.find(&format!("{ending}#"))? + ending.len()));
    let (file, name) = match ends.min() {
        Some(end) => (&stated[..end], Some(stated[end + 1..].to_string())),
        None => (stated.as_str(), None),
    };
    if !ENDINGS.iter().any(|ending| file.to_ascii_lowercase().ends_with(ending)) {
        let message =
            "must be a glTF file, and the name of a camera in it if there are several: \"shot.glb#Name\"";
        return Err(text.bad("from", from, message));
    }
    Ok((file_of_text(text, "from", (file, from.span()))?, name))
}

/// Default vertical field of view if no key states one, degrees.
const DEFAULT_FOV: f64 = 40.0;
/// Bounds of the height of an orthographic camera's view, in the units of the files.
const LEAST_HEIGHT: f64 = 1e-18;
const GREATEST_HEIGHT: f64 = 1e18;
/// Maximum shift of a lens, in either direction, as a share of the picture's longer side.
const FARTHEST_SHIFT: f64 = 100.0;

/// Reads a camera of its own keys; `marked`: frames at which the shot says that it cuts.
fn of_keys(text: TomlText<'_>, table: &At<CameraTable>, marked: &[i32]) -> Result<CameraTrack, SceneError> {
    let keys = in_order(text, &table.get_ref().key, |key| &key.frame)?;
    let Some((_, first)) = keys.first() else {
        let message = "the camera has no keys: write one [[camera.key]] with frame, eye and target at least";
        return Err(text.fault(table.span(), message));
    };
    let by_target = first.get_ref().target.is_some();
    let interpolation = table.get_ref().interpolation.unwrap_or_default();
    let cuts = cuts(text, &keys, marked)?;
    let fov = fields_of_view(text, &keys)?;
    let is_orthographic = table.get_ref().projection == Some(Projection::Orthographic);
    let height = if is_orthographic { Some(heights(text, &keys)?) } else { None };
    let shift = shifts(text, &keys)?;
    refuse_other_lens(text, &keys, is_orthographic)?;
    let opening = lens::opening(text, &keys, is_orthographic)?;
    let [near, far] = lens::clip(text, &keys)?;
    let cut_frames: Vec<f64> = cuts.iter().map(|frame| f64::from(*frame)).collect();
    let aim = each(&keys, |key| aim_of(text, key, by_target))?;
    let roll = each(&keys, |key| key.roll.as_ref().map_or(Ok(0.0), |roll| any_number(text, "roll", roll)))?;
    if let Some(roll) = keys.iter().find_map(|(_, key)| key.get_ref().roll.as_ref()).filter(|_| !by_target) {
        return Err(text.bad(
            "roll",
            roll,
            "goes with `target`: with `rotation`, give it as the third number",
        ));
    }
    let aim = through(aim, interpolation).cut_at(&cut_frames);
    let eye = if keys.iter().any(|(_, key)| key.get_ref().orbit.is_some()) {
        let around = through(each(&keys, |key| orbit::of_key(text, key))?, interpolation).cut_at(&cut_frames);
        orbit::eye(text, &keys, (around, aim.clone()))?
    } else {
        let target = by_target.then_some(&aim);
        through(eyes(text, &keys, target)?, interpolation).cut_at(&cut_frames).into()
    };
    let track = CameraTrack {
        eye,
        aim: if by_target {
            Aim::Target { target: aim, roll: through(roll, interpolation).cut_at(&cut_frames) }
        } else {
            Aim::Rotation(aim)
        },
        fov: through(fov, interpolation).cut_at(&cut_frames),
        lens: Lens {
            height: height.map(|height| through(height, interpolation).cut_at(&cut_frames)),
            shift: shift.map(|shift| through(shift, interpolation).cut_at(&cut_frames)),
            aperture: opening.aperture.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            focus: opening.focus.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            near: near.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
            far: far.map(|keys| through(keys, interpolation).cut_at(&cut_frames)),
        },
        cuts,
    };
    let wide = |frame| !(track.fov.at(frame) > 0.0 && track.fov.at(frame) < 180.0);
    if let Some(frame) = frames_between(&keys).find(|frame| wide(*frame)) {
        let message = format!("the smooth curve of `fov` leaves 0..180 at frame {frame}: add a key there");
        return Err(text.fault(table.span(), message));
    }
    if let Some(frame) = frames_between(&keys).find(|frame| track.lens.sees_nothing(*frame)) {
        let message = format!(
            "the smooth curves of `near` and `far` leave nothing between them at frame {frame}: add a key there"
        );
        return Err(text.fault(table.span(), message));
    }
    let flat = |frame| track.lens.height.as_ref().is_some_and(|height| height.at(frame) < LEAST_HEIGHT);
    if let Some(frame) = frames_between(&keys).find(|frame| flat(*frame)) {
        let message =
            format!("the smooth curve of `height` falls to 0 or below at frame {frame}: add a key there");
        return Err(text.fault(table.span(), message));
    }
    Ok(track)
}

/// Reads the positions that keys give the eye, which looks at `target` if there is one.
fn eyes(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    target: Option<&Track<DVec3>>,
) -> Result<Vec<(f64, DVec3)>, SceneError> {
    let place = |(frame, key): &(f64, &At<CameraKey>)| {
        let missing =
            || text.fault(key.span(), "this camera key needs `eye`, or `orbit`: where the camera is");
        let stated = key.get_ref().eye.as_ref().ok_or_else(missing)?;
        let eye = text.vector("eye", stated)?;
        if target.is_some_and(|target| target.at(*frame) == eye) {
            return Err(text.bad("eye", stated, "and `target` are the same point: move one of them"));
        }
        Ok((*frame, eye))
    };
    keys.iter().map(place).collect()
}

/// Frames at which the shot cuts, in order: those that keys begin, and those that are `marked`.
fn cuts(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)], marked: &[i32]) -> Result<Vec<i32>, SceneError> {
    let mut cuts = marked.to_vec();
    for (frame, key) in keys.iter().filter(|(_, key)| key.get_ref().cut) {
        if frame.fract() != 0.0 {
            let message = format!("is {frame}: a cut falls on a whole frame");
            return Err(text.bad("frame", &key.get_ref().frame, &message));
        }
        cuts.push(*frame as i32);
    }
    cuts.sort_unstable();
    cuts.dedup();
    Ok(cuts)
}

/// Minimum field of view, degrees: below it, single floats cannot tell the directions of neighbouring samples
/// apart.
const LEAST_FOV: f64 = 1e-6;

/// Requirement for a field of view, for messages.
const FOV: &str = "from 1e-6 to below 180 degrees";

fn fields_of_view(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut last = DEFAULT_FOV;
    each(keys, |key| {
        if let Some(fov) = &key.fov {
            last = text.number("fov", fov, FOV, |fov| (LEAST_FOV..180.0).contains(&fov))?;
        }
        Ok(last)
    })
}

/// Reads the height of an orthographic camera's view at each key.
fn heights(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<Vec<(f64, f64)>, SceneError> {
    let mut last = None;
    each(keys, |key| {
        if let Some(height) = &key.height {
            let wanted = "from 1e-18 to 1e18, in the units of the models";
            last = Some(text.number("height", height, wanted, |height| {
                (LEAST_HEIGHT..=GREATEST_HEIGHT).contains(&height)
            })?);
        }
        last.ok_or_else(|| {
            let message = "this key of an orthographic camera needs `height`: how much of the world is seen from the top of \
                           the picture to its bottom";
            text.fault(key.frame.span(), message)
        })
    })
}

/// Reads the lens shift to the right and upwards, at each key.
fn shifts(text: TomlText<'_>, keys: &[(f64, &At<CameraKey>)]) -> Result<[Vec<(f64, f64)>; 2], SceneError> {
    let mut last = [0.0; 2];
    let both = each(keys, |key| {
        if let Some(shift) = &key.shift {
            last = shift.get_ref().0;
            if !last.iter().all(|shift| shift.abs() <= FARTHEST_SHIFT) {
                let message = "must be two numbers from -100 to 100: shares of the picture's longer side";
                return Err(text.bad("shift", shift, message));
            }
        }
        Ok(last)
    })?;
    Ok([0, 1].map(|axis| both.iter().map(|(frame, shift)| (*frame, shift[axis])).collect()))
}

/// Refuses keys that describe the other projection.
fn refuse_other_lens(
    text: TomlText<'_>,
    keys: &[(f64, &At<CameraKey>)],
    is_orthographic: bool,
) -> Result<(), SceneError> {
    for (_, key) in keys {
        let key = key.get_ref();
        if let Some(fov) = key.fov.as_ref().filter(|_| is_orthographic) {
            return Err(text.bad(
                "fov",
                fov,
                "goes with a perspective camera: an orthographic one has `height`",
            ));
        }
        if let Some(height) = key.height.as_ref().filter(|_| !is_orthographic) {
            let message =
                "goes with `projection = \"orthographic\"` in [camera]: a perspective camera has `fov`";
            return Err(text.bad("height", height, message));
        }
    }
    Ok(())
}

fn aim_of(text: TomlText<'_>, key: &CameraKey, by_target: bool) -> Result<DVec3, SceneError> {
    match (&key.target, &key.rotation) {
        (Some(target), None) if by_target => text.vector("target", target),
        (None, Some(rotation)) if !by_target => text.vector("rotation", rotation),
        (None, None) => {
            let message = "this camera key needs `target` (a point) or `rotation` (pitch, yaw, roll)";
            Err(text.fault(key.frame.span(), message))
        }
        (Some(_), Some(rotation)) => {
            Err(text.bad("rotation", rotation, "and `target` exclude each other: keep one of them"))
        }
        (Some(other), None) | (None, Some(other)) => {
            let message = "the keys of a camera have either all `target` or all `rotation`";
            Err(text.fault(other.span(), message))
        }
    }
}
