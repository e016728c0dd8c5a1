//! Stands in for the reader of USD files in a program that was built without it.

use std::path::Path;
use std::sync::Arc;

use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::import::part_of_file::PartOfFile;
use crate::scene::shot::Shot;
use crate::scene::turntable::Options;
use crate::scene::written::Written;

/// Nothing: no USD file is read.
#[derive(Default)]
pub(in crate::scene) struct UsdFiles;

fn refused(path: &Path) -> SceneError {
    let message = "this program was built without USD: build it with `cargo build --release --features usd` (Rust 1.95 or later), or \
                   export glTF";
    SceneError::new(path, message)
}

/// Refuses the file at `path`.
///
/// # Errors Always.
pub(crate) fn shot(path: &Path, _: bool, _: &Options) -> Result<Shot, SceneError> {
    Err(refused(path))
}

/// Refuses the file at `path`.
///
/// # Errors Always.
pub fn text(path: &Path, _: &str, _: &Options) -> Result<Written, SceneError> {
    Err(refused(path))
}

impl UsdFiles {
    /// Refuses the file at `path`.
    ///
    /// # Errors Always.
    pub fn models(&mut self, _: &mut Import, path: &Path) -> Result<Arc<Vec<PartOfFile>>, SceneError> {
        Err(refused(path))
    }
}
