//! Readers of the files that a shot shows: a folder a format, and what they share.
//!
//! A reader takes an [`Import`], adds to its parts, and returns meshes and their places as plain data. What it keeps for itself (files that
//! were read, parts by number) is its own: no reader knows another one, but for what its format refers to (MTL is written in lines as OBJ
//! is, USD files hold networks of MaterialX), and the import knows MaterialX alone, whose materials a shot's tables may name.

pub(in crate::scene) mod arrange;
mod bytes;
pub(in crate::scene) mod cameras;
pub mod curves;
pub(in crate::scene) mod deformed;
pub(in crate::scene) mod faces;
pub(in crate::scene) mod given;
pub mod gltf;
mod inputs;
pub(in crate::scene) mod lights;
pub(in crate::scene) mod meshes;
pub(in crate::scene) mod mtl;
mod mtlx;
pub(in crate::scene) mod npy;
pub mod obj;
pub(in crate::scene) mod part_of_file;
pub(in crate::scene) mod pictures;
pub mod ply;
pub(in crate::scene) mod surfaces;
pub mod usd;
pub(in crate::scene) mod vdb;

use std::path::{Path, PathBuf};

use arrange::Arranger;
pub(in crate::scene) use inputs::Inputs;
pub(in crate::scene) use surfaces::Surfaces;

use self::mtl::statements::maps::MapStatement;
use self::pictures::{PictureUse, Pictures};
use self::surfaces::material_table::Override;
use super::error::Findings;
use super::{Material, SceneError, Texture};
use crate::digest::Digest;

/// Things that all readers of a shot add to.
#[derive(Default)]
pub(in crate::scene) struct Import {
    /// Files that were read, without pictures.
    pub inputs: Inputs,
    /// Materials, and the tables that override them.
    pub surfaces: Surfaces,
    /// Pictures of the materials.
    pub pictures: Pictures,
    /// Defects of the files.
    pub findings: Findings,
}

/// Shared materials and textures of the models, and the files that they come from.
pub(in crate::scene) struct Imported {
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub findings: Findings,
    /// All files that were read.
    pub files: Vec<PathBuf>,
    /// Digest of the files' contents.
    pub inputs: Digest,
}

impl Import {
    /// Creates an import of nothing. `strict`: stand-ins are errors.
    pub fn new(strict: bool, overrides: Vec<Override>) -> Self {
        let findings = Findings { strict, ..Findings::default() };
        Self { findings, surfaces: Surfaces { overrides, ..Surfaces::default() }, ..Self::default() }
    }

    /// Arranges meshes of the materials that are there by now.
    pub fn arranger(&self) -> Arranger<'_> {
        Arranger { materials: &self.surfaces.materials, textures: &self.pictures.textures }
    }

    /// Index of the picture of `map`, a statement of the file `asking`.
    ///
    /// # Errors Those of [`Pictures::index_at`].
    pub fn picture(
        &mut self,
        map: &MapStatement,
        asking: &Path,
        used: PictureUse,
    ) -> Result<u32, SceneError> {
        self.pictures.index_at(&map.named_by(asking), map.mapping(), &mut self.findings, used)
    }

    /// Returns what all readers have added.
    pub fn finish(self) -> Imported {
        let Self { inputs, mut surfaces, pictures, findings } = self;
        surfaces.fill_media();
        Imported {
            materials: surfaces.materials,
            findings,
            files: inputs.files(pictures.files().cloned()),
            inputs: inputs.digest(pictures.digest()),
            textures: pictures.textures,
        }
    }
}
