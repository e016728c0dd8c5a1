//! Loads shots: a shot file (`.toml`), or a bare OBJ as a turntable.

use std::path::Path;

use super::shot::{self, Shot};
use super::toml_text::TomlText;
use super::{SceneError, turntable};

/// Loads the shot at `path`: a `.toml` file as a shot file, an `.obj` file as a turntable.
///
/// # Errors
/// With file, and where they are known line and column: what cannot be read or makes no sense. In a
/// `strict` load also everything that would otherwise be a warning about a stand-in: a missing texture,
/// a missing material.
pub fn load(path: &Path, strict: bool) -> Result<Shot, SceneError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "toml" => {
            let text = std::fs::read_to_string(path)
                .map_err(|error| SceneError::new(path, format!("the shot file cannot be read: {error}")))?;
            shot::from_text(TomlText { path, text: &text }, strict)
        }
        "obj" => load_turntable(path, strict, &turntable::Options::default()),
        _ => Err(SceneError::new(
            path,
            "not a file that can be rendered: give a shot (.toml) or a model (.obj)",
        )),
    }
}

/// The turntable of the OBJ file at `path`: see [`turntable`].
///
/// # Errors
/// Those of [`load`].
pub fn load_turntable(path: &Path, strict: bool, options: &turntable::Options) -> Result<Shot, SceneError> {
    turntable::shot(path, strict, options)
}
