//! Scenes of a program that has its meshes in memory: a shot file without a file.
//!
//! Camera, lights, materials, sky and settings are the tables of a shot file, as text: there is one reader and one set of words. Meshes
//! and their places come as plain data beside it. Materials are the text's `[[material]]` tables, which meshes name.

mod place;

use std::path::Path;
use std::sync::Arc;

use self::place::place_in;
pub use super::import::given::{
    CurveBasis, CurveSet, CurveShape, CurveWrap, Given, GivenMesh, GivenModel, NAME,
};
use super::keys::toml_text::TomlText;
use super::model::copies::MOST_ADDED;
use super::shot::{self, Beside, ReadBefore, Shot};
use super::{SceneError, Warning};
use crate::memory::{self, Need, Part};

/// Checks tables of a shot file as far as they can be checked without the rest of it: names and types of keys, and the values of
/// `[[material]]` and `[[light]]` tables.
///
/// # Errors
/// Those of a shot file, as in [`shot()`].
pub fn check(text: &str) -> Result<(), SceneError> {
    let toml = TomlText { path: Path::new(NAME), text };
    shot::check_tables(toml).map_err(|error| told(error, text))
}

/// Makes the shot of `given` models and of `text`, the other tables of a shot file: paths in it are relative to the working folder.
///
/// # Errors
/// Those of a shot file and of the pictures that it names; meshes that do not fit into memory; in a `strict` load also anything that a stand-in would replace. They name
/// the material or the light, and no line: nobody has seen the text.
///
/// # Panics
/// If a mesh does not pass its [check](GivenMesh::check), or a model names a mesh that is not there.
pub fn shot(text: &str, given: Given, strict: bool) -> Result<Shot, SceneError> {
    let path = Path::new(NAME);
    let bytes = given.meshes.iter().map(|mesh| mesh.bytes_while_made()).sum();
    let need = Need::new(Part::new("the meshes of the scene", bytes, "smaller meshes"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    // one empty table stands for all models
    let text = if given.models.is_empty() { String::from(text) } else { format!("{text}\n[[model]]\n") };
    let toml = TomlText { path, text: &text };
    let read = (!given.models.is_empty()).then(|| ReadBefore::Given(Arc::new(given)));
    let beside = Beside { read, ..Beside::default() };
    let shot = shot::from_text_with(toml, strict, beside, MOST_ADDED).map_err(|error| told(error, &text))?;
    let warnings = shot.warnings.into_iter().map(|Warning(error)| Warning(told(error, &text))).collect();
    let files = shot.files.into_iter().filter(|file| file != path).collect();
    Ok(Shot { warnings, files, ..shot })
}

/// Names the table of `text` instead of its line.
fn told(error: SceneError, text: &str) -> SceneError {
    match error.line.filter(|_| error.path == Path::new(NAME)) {
        Some(line) => SceneError::new(NAME, format!("{}{}", place_in(text, line), error.message)),
        None => error,
    }
}

#[cfg(test)]
mod tests;
