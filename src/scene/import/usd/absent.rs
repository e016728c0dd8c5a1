//! Stands in for the reader of USD files in a program that was built without it.

use std::path::Path;
use std::sync::Arc;

use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::import::part_of_file::PartOfFile;
use crate::scene::import::usd::StageChoice;
use crate::scene::turntable::Options;
use crate::scene::written::{BareShot, Written};

/// A file that was read: there is none.
pub(crate) enum UsdFile {}

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
pub(crate) fn read(path: &Path, _: &Options) -> Result<(Arc<UsdFile>, BareShot), SceneError> {
    Err(refused(path))
}

/// Refuses the file at `path`.
///
/// # Errors Always.
pub fn text(path: &Path, _: &str, _: &Options) -> Result<Written, SceneError> {
    Err(refused(path))
}

impl UsdFiles {
    /// Adds a file that was read in advance: there is none.
    pub fn with(self, file: Arc<UsdFile>) -> Self {
        match *file {}
    }

    /// Refuses the file at `path`.
    ///
    /// # Errors Always.
    pub fn models(
        &mut self,
        _: &mut Import,
        path: &Path,
        _: &StageChoice,
    ) -> Result<Arc<Vec<PartOfFile>>, SceneError> {
        Err(refused(path))
    }
}
