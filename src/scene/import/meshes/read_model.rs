//! Model files as they were read: OBJ and PLY files, before their materials are looked up.

use std::path::{Path, PathBuf};

use crate::digest::Digest;
use crate::scene::SceneError;
use crate::scene::import::faces::TriangleSoup;
use crate::scene::import::obj;
use crate::scene::import::ply::{self, PlyFile};

/// Returns true if a file is a PLY file, by its ending.
pub(crate) fn is_ply(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ply"))
}

/// An OBJ or PLY file that was read.
pub(crate) struct ReadModel {
    pub path: PathBuf,
    pub obj: TriangleSoup,
    /// Digest of the file's content.
    pub digest: Digest,
    /// Parts of the file that have no effect, in whole sentences.
    pub unused: Vec<String>,
}

impl ReadModel {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// Those of [`obj::read`], and of PLY files.
    pub fn at(path: &Path) -> Result<Self, SceneError> {
        let path_kept = path.to_path_buf();
        if is_ply(path) {
            let PlyFile { surface, digest, unused } = ply::read(path)?;
            return Ok(Self { path: path_kept, obj: surface, digest, unused });
        }
        let (obj, digest) = obj::read_with_digest(path)?;
        Ok(Self { path: path_kept, obj, digest, unused: Vec::new() })
    }
}

/// Names the material of a PLY file that has no name by the file's stem if `is_stated` says that a `[[material]]` of this name is there.
pub(super) fn name_material(file: &mut TriangleSoup, path: &Path, is_stated: impl Fn(&str) -> bool) {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    if let Some(material) =
        file.materials.first_mut().filter(|material| material.name.is_empty() && is_stated(&stem))
    {
        material.name = stem.into_owned();
    }
}
