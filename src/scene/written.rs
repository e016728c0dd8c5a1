//! Shots of files with a camera and lights of their own. They are rendered by what `afterimage init` writes: a text, and the tables that
//! their readers make of what the files say, which `init` alone writes as text.

use std::path::Path;

use glam::DAffine3;
use toml::Table;

use super::SceneError;
use super::import::cameras;
use super::keys::toml_text::{At, TomlText};
use super::keys::{Digits, FileTables};
use super::model::copies::MOST_ADDED;
use super::shot::{self, Beside, ReadBefore, Shot};

/// A shot file that shows another file.
pub struct Written {
    /// Text of the shot file.
    pub text: String,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
}

/// The shot of a file with a camera and lights of its own.
pub(crate) struct BareShot {
    /// Text of what stands in for what the file lacks, and of the model: before the file's camera, between that and its lights, and
    /// behind them.
    pub text: [String; 3],
    /// What the file says.
    pub tables: FileTables,
    /// Decisions that were made for the user, in whole sentences.
    pub notes: Vec<String>,
}

impl BareShot {
    /// Writes the shot.
    pub fn written(self) -> Written {
        let Self { text: [before, between, behind], tables, notes } = self;
        let (view, light) = (tables.text_of_view(), tables.text_of_light());
        Written { text: [before, view, between, light, behind].concat(), notes }
    }
}

/// Loads the shot of the file at `path`, which was `read`.
///
/// # Errors Those of the file and of what it names.
pub(crate) fn shot_of(
    path: &Path,
    bare: BareShot,
    read: ReadBefore,
    strict: bool,
) -> Result<Shot, SceneError> {
    let BareShot { text, tables, notes } = bare;
    let text = text.concat();
    // the column is one of our generated text, which nobody has seen
    let of_text = |error: &SceneError| error.path == path && error.column.is_some();
    let told = |error: SceneError| if of_text(&error) { SceneError::new(path, error.message) } else { error };
    let beside = Beside { read: Some(read), tables };
    let shot =
        shot::from_text_with(TomlText { path, text: &text }, strict, beside, MOST_ADDED).map_err(told)?;
    // it stands there twice: for the model, and for the text
    let mut files = shot.files;
    if let Some(last) = files.iter().rposition(|file| file == path) {
        files.remove(last);
    }
    Ok(Shot { notes, files, ..shot })
}

/// Keys of a camera, which looks along -Z, at these frames and places: tables of `[[camera.key]]`.
pub fn camera_keys(places: &[(f64, DAffine3)]) -> Vec<Table> {
    let keys = places.iter().map(|(frame, map)| cameras::key(*frame, *map));
    let keys = cameras::table(None, keys, &[]).key;
    keys.into_iter().map(At::into_inner).map(|key| key.to_table(Digits::default())).collect()
}
