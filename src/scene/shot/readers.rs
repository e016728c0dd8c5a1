//! The readers of all formats of models, and what they share.

use std::sync::Arc;

use crate::scene::given::meshes::Given;
use crate::scene::gltf::GltfFiles;
use crate::scene::import::Import;
use crate::scene::keys::material::KdBesideMap;
use crate::scene::model::meshes::MeshFiles;
use crate::scene::model::read_model::ReadBefore;
use crate::scene::usd::UsdFiles;

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
            #[cfg(feature = "usd")]
            ReadBefore::Usd(file) => Self { usd: self.usd.with(file), ..self },
        }
    }
}
