//! Real scenes, which are no part of the project. `AFTERIMAGE_SCENES` names the folder that holds them, unpacked;
//! without it the tests that need them are ignored (see `build.rs`).

use std::path::PathBuf;

/// The folder `name` of the collection.
///
/// # Panics
/// Where it is not there: a test that saw nothing must not pass.
pub fn folder(name: &str) -> PathBuf {
    let all = std::env::var_os("AFTERIMAGE_SCENES").expect("AFTERIMAGE_SCENES names the scene collection");
    let folder = PathBuf::from(all).join(name);
    assert!(folder.is_dir(), "AFTERIMAGE_SCENES has no folder {}: unpack it", folder.display());
    folder
}
