//! Real scenes, which are no part of the project: used where they are at hand.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder `name` of the collection, which the environment names or which lies packed beside the
/// checkout; otherwise `None`, with the reason printed.
pub fn folder(name: &str) -> Option<PathBuf> {
    let found = unpacked(name).map(|all| all.join(name)).filter(|folder| folder.is_dir());
    if found.is_none() {
        println!("skipped: neither AFTERIMAGE_SCENES nor ../shared/scenes has the folder `{name}`");
    }
    found
}

fn unpacked(name: &str) -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("AFTERIMAGE_SCENES") {
        return Some(folder.into());
    }
    let tool = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes/unpack");
    let output = Command::new(tool).arg(name).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().into())
}
