//! Loads shots: a shot file (`.toml`), a bare glTF or USD file, or a bare OBJ as a turntable.

use std::path::Path;

use memchr::memchr_iter;

use super::import::{gltf, usd};
use super::keys::toml_text::TomlText;
use super::model::copies::MOST_ADDED;
use super::shot::{self, ReadBefore, Shot};
use super::{SceneError, turntable, written};
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};

/// Memory for each byte of a shot file while it is read: measured with a hundred thousand camera keys.
const READING_BYTES: u64 = 64;

/// Loads the shot at `path`: a `.toml` file as a shot file, an `.obj` or `.ply` file as a turntable, a glTF or USD file with its own camera
/// and lights.
///
/// # Errors
/// With file, and where they are known line and column: what cannot be read or makes no sense. In a
/// `strict` load also everything that would otherwise be a warning about a stand-in: a missing texture,
/// a missing material.
pub fn load(path: &Path, strict: bool) -> Result<Shot, SceneError> {
    load_sharing(path, strict, MOST_ADDED)
}

/// Loads a shot like [`load`], with another limit for the triangles that copies of still models may add
/// before they share a mesh: tests let small shots share meshes.
///
/// # Errors Those of [`load`].
pub fn load_sharing(path: &Path, strict: bool, most_added: u64) -> Result<Shot, SceneError> {
    match ending(path).as_str() {
        "toml" => shot::from_text(TomlText { path, text: &read_text(path)? }, strict, most_added),
        "obj" | "ply" | "gltf" | "glb" | "usd" | "usda" | "usdc" | "usdz" => {
            load_turntable(path, strict, &turntable::Options::default())
        }
        _ => Err(SceneError::new(
            path,
            "not a file that can be rendered: give a shot (.toml) or a model (.obj, .ply, .gltf, .glb, .usda, .usdc, .usdz)",
        )),
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

fn read_text(path: &Path) -> Result<String, SceneError> {
    let unreadable =
        |error: InputError| SceneError::new(path, format!("the shot file cannot be read: {error}"));
    let input = input::open(path, Kind::Shot).map_err(unreadable)?;
    let need = Need::new(Part::new("reading the shot file", READING_BYTES * input.length, "fewer keys"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(unreadable)?;
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = memchr_iter(b'\n', before).count() + 1;
        SceneError::new(path, "the shot file is not UTF-8 from this line on: save it as UTF-8").at_line(line)
    })
}

/// Loads the model at `path`: an OBJ file as a turntable (see [`turntable`]), a glTF or USD file with its own camera and
/// lights, and as a turntable where it has none.
///
/// # Errors Those of [`load`].
pub fn load_turntable(path: &Path, strict: bool, options: &turntable::Options) -> Result<Shot, SceneError> {
    match ending(path).as_str() {
        "gltf" | "glb" => {
            let (document, shot) = gltf::read(path, options)?;
            written::shot_of(path, shot, ReadBefore::Gltf(document), strict)
        }
        "usd" | "usda" | "usdc" | "usdz" => {
            let (file, shot) = usd::read(path, options)?;
            written::shot_of(path, shot, ReadBefore::Usd(file), strict)
        }
        _ => turntable::shot(path, strict, options),
    }
}
