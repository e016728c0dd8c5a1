//! The readers of all formats of models, and what they share.

use std::sync::Arc;

use crate::scene::import::Import;
use crate::scene::import::given::Given;
use crate::scene::import::gltf::{Document, GltfFiles};
use crate::scene::import::meshes::MeshFiles;
use crate::scene::import::meshes::read_model::ReadModel;
use crate::scene::import::usd::{UsdFile, UsdFiles};
use crate::scene::keys::FileTables;
use crate::scene::keys::material::KdBesideMap;

/// File that was read before the shot that shows it.
pub(crate) enum ReadBefore {
    /// The text's only model: the text need not name its path.
    Obj(Box<ReadModel>),
    /// Models that a program hands over: the text has one table for all of them, which names nothing.
    Given(Arc<Given>),
    /// A glTF file, which the text names.
    Gltf(Arc<Document>),
    /// A USD file, which the text names.
    Usd(Arc<UsdFile>),
}

/// What a shot has beside its text.
#[derive(Default)]
pub(crate) struct Beside {
    /// A file of it that was read already.
    pub read: Option<ReadBefore>,
    /// Tables of that file.
    pub tables: FileTables,
}

/// The readers of a shot.
#[derive(Default)]
pub struct Readers {
    pub import: Import,
    /// OBJ and PLY files.
    pub meshes: MeshFiles,
    pub gltf: GltfFiles,
    pub usd: UsdFiles,
    /// Models that a program has handed over, until they are asked for.
    pub given: Option<Arc<Given>>,
}

impl Readers {
    /// Creates readers that have read nothing, and add to `import`.
    pub fn new(import: Import, kd_beside_map: KdBesideMap) -> Self {
        Self { import, meshes: MeshFiles::new(kd_beside_map), ..Self::default() }
    }

    /// Adds a file that was read before, so that it is not read again.
    pub fn with(self, file: ReadBefore) -> Self {
        match file {
            ReadBefore::Obj(model) => Self { meshes: self.meshes.with(*model), ..self },
            ReadBefore::Given(given) => Self { given: Some(given), ..self },
            ReadBefore::Gltf(document) => Self { gltf: self.gltf.with(document), ..self },
            ReadBefore::Usd(file) => Self { usd: self.usd.with(file), ..self },
        }
    }
}
