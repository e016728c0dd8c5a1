//! The camera of a shot: of its own keys, or one of a glTF file.

use std::ops::Range;
use std::path::PathBuf;

use super::tracks;
use crate::scene::gltf::CameraChoice;
use crate::scene::keys::ShotFile;
use crate::scene::keys::camera::CameraTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::file_of_text;
use crate::scene::model::assemble::Assembly;
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
    (assembly, rate): (&mut Assembly, f64),
) -> Result<CameraTrack, SceneError> {
    let CameraTable { from, animation, projection, interpolation, key } = table.get_ref();
    let refuse = |span: Range<usize>, message: &str| Err(text.fault(span, message));
    let Some(from) = from else {
        return match animation {
            Some(animation) => refuse(
                animation.span(),
                "`animation` goes with `from`, the glTF file whose camera this is: take it out",
            ),
            None => tracks::camera(text, table, marked),
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
    let written = assembly.gltf_camera(&path, choice)?;
    let written = written.map_err(|what| text.bad("from", from, &what))?;
    // nobody has seen this text: faults are those of the file
    let of_file = |error: SceneError| SceneError::new(&path, error.message);
    let own = TomlText { path: &path, text: &written };
    let file: ShotFile = own.read().map_err(of_file)?;
    let own_table = file.camera.as_ref().ok_or_else(|| SceneError::new(&path, "its camera has no keys"))?;
    tracks::camera(own, own_table, marked).map_err(of_file)
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
