//! Values that several tables of a shot file have.

use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::OutputTable;
use super::toml_text::{At, Three, TomlText};
use crate::scene::SceneError;
use crate::scene::paths::find_beside;
use crate::settings::Look;

/// Path of the file that the key `key` names.
pub fn file_of(text: TomlText<'_>, key: &str, name: &At<String>) -> Result<PathBuf, SceneError> {
    file_of_text(text, key, (name.get_ref(), name.span()))
}

/// Path of the file that a part of the value of the key `key` names; the value is at `span`.
pub fn file_of_text(
    text: TomlText<'_>,
    key: &str,
    (file, span): (&str, Range<usize>),
) -> Result<PathBuf, SceneError> {
    let folder = text.path.parent().unwrap_or(Path::new(""));
    find_beside(folder, file).ok_or_else(|| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let folder = folder.display();
        let message = format!("there is no file `{file}` in `{folder}`: paths are relative to the shot file");
        text.fault(span, format!("`{key}`: {message}"))
    })
}

/// Colour of the key `key`, if it is there.
pub fn optional_color(
    text: TomlText<'_>,
    key: &str,
    value: &Option<Three>,
) -> Result<Option<Vec3>, SceneError> {
    value.as_ref().map(|value| text.color(key, value)).transpose()
}

/// Reads the exposure and the view transform of pictures for screens; `before`: those that are not stated.
pub fn look(text: TomlText<'_>, table: &OutputTable, before: Look) -> Result<Look, SceneError> {
    let most = Look::MOST_EXPOSURE;
    let fits = |stops: f64| stops.abs() <= f64::from(most);
    let wanted = format!("from -{most} to {most} stops");
    let read = |exposure| text.number("exposure", exposure, &wanted, fits);
    let exposure = table.exposure.as_ref().map(read).transpose()?;
    Ok(Look {
        exposure: exposure.map_or(before.exposure, |stops| stops as f32),
        view: table.view.unwrap_or(before.view),
    })
}
