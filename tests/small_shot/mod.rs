//! A shot of two triangles, to be loaded with whatever else a test writes into its file.
#![allow(dead_code, reason = "each test binary uses its share")]

use std::path::Path;

use afterimage::scene::{self, Shot};
use tempfile::TempDir;

pub const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n\
                   usemtl clear\nf 1 2 3\nusemtl wood\nf 2 4 3\n";
pub const MTL: &str = "newmtl wood\nKd 0.5 0.25 0.125\nnewmtl clear\nd 0.1\nnewmtl spare\n";
pub const REST: &str =
    "[[camera.key]]\nframe = 1\neye = [0, 0, 5]\ntarget = [0, 0, 0]\n[[model]]\nobj = \"m.obj\"\n";

pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.obj"), OBJ).unwrap();
    std::fs::write(folder.path().join("m.mtl"), MTL).unwrap();
    folder
}

pub fn load_in(folder: &Path, text: &str, strict: bool) -> Result<Shot, scene::SceneError> {
    let path = folder.join("s.toml");
    std::fs::write(&path, text).unwrap();
    scene::load(&path, strict)
}

/// The same where copies that stand still may add so many triangles before they share them.
pub fn load_sharing(text: &str, most_added: u64) -> Shot {
    let folder = folder();
    let path = folder.path().join("s.toml");
    std::fs::write(&path, text).unwrap();
    scene::load_sharing(&path, true, most_added).unwrap()
}

pub fn load(text: &str) -> Shot {
    load_in(folder().path(), text, true).unwrap()
}

/// Without the folder: `s.toml:1:2: …`.
pub fn error(text: &str) -> String {
    let folder = folder();
    let error = load_in(folder.path(), text, true).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}
