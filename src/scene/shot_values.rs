//! Values of a shot file that several of its tables have.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::SceneError;
use super::paths::find_beside;
use super::toml_text::{At, Three, TomlText};

/// Texels along an edge of a reflection map.
pub(crate) const LEAST_MAP: u32 = 8;
pub(crate) const LARGEST_MAP: u32 = 1024;

/// The file that the key `key` names.
pub(super) fn file_of(text: TomlText<'_>, key: &str, name: &At<String>) -> Result<PathBuf, SceneError> {
    let folder = text.path.parent().unwrap_or(Path::new(""));
    find_beside(folder, name.get_ref()).ok_or_else(|| {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        let (file, folder) = (name.get_ref(), folder.display());
        let message = format!("there is no file `{file}` in `{folder}`: paths are relative to the shot file");
        text.fault(name.span(), format!("`{key}`: {message}"))
    })
}

/// The colour that the key `key` gives, if it is there.
pub(super) fn optional_color(
    text: TomlText<'_>,
    key: &str,
    value: &Option<Three>,
) -> Result<Option<Vec3>, SceneError> {
    value.as_ref().map(|value| text.color(key, value)).transpose()
}
