//! Files for fuzz targets: readers take paths, as users give them.
//!
//! A [`Folder`] lies in memory where the system has such a place (`/dev/shm`). A target makes one, writes the file that libFuzzer made
//! into it, and has it read as the program does.
#![forbid(unsafe_code)]

use std::fs;
use std::path::{Path, PathBuf};

use afterimage::scene::{self, Shot};
use tempfile::TempDir;

/// OBJ file of two triangles with two materials.
pub const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\n\
                       usemtl wood\nf 1/1 2/2 3/3\nusemtl clear\nf 1/1 3/3 4/2\n";

/// Its materials.
pub const MTL: &str = "newmtl wood\nKd 0.5 0.25 0.125\nnewmtl clear\nd 0.1\n";

/// Start of a shot file: small pictures, a camera.
pub const SHOT: &str = "[render]\nsize = [16, 9]\nsamples = 1\nframes = \"1-2\"\n[[camera.key]]\nframe = 1\neye = [0, 0, 5]\n\
                        target = [0, 0, 0]\n";

/// Folder with an OBJ file and its materials, `m.obj` and `m.mtl`.
#[derive(Debug)]
pub struct Folder(TempDir);

impl Folder {
    /// Creates the folder.
    ///
    /// # Panics
    /// If the system gives no folder.
    pub fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let made = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        let folder = Self(made.expect("a temporary folder is needed"));
        folder.write("m.obj", OBJ);
        folder.write("m.mtl", MTL);
        folder
    }

    /// Creates the folder with a shot file of a model, `s.toml`: `key` is the line that names the model's file. Without a light, loading
    /// takes a hundredth of the time of a bare model, which stands under a sky.
    pub fn of_model(key: &str) -> Self {
        let folder = Self::new();
        folder.write("s.toml", format!("{SHOT}[[model]]\n{key}\n"));
        folder
    }

    /// Path of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file of it.
    ///
    /// # Panics
    /// If it cannot be written.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("a folder for tests can be written to");
        path
    }

    /// Loads a shot or a model of it, if it can be loaded.
    pub fn load(&self, name: &str) -> Option<Shot> {
        match scene::load(&self.path(name), false) {
            Ok(shot) => Some(shot),
            Err(error) => {
                // texts of errors are made by code, too
                let _ = error.to_string();
                None
            }
        }
    }
}

impl Default for Folder {
    fn default() -> Self {
        Self::new()
    }
}
