//! MaterialX files (`.mtlx`): surfaces and the graphs of their parameters.
//!
//! A material is a `surfacematerial` whose shader is an `open_pbr_surface`, a `standard_surface`, a `gltf_pbr` or a
//! `UsdPreviewSurface` ([`shaders`]); its parameters take values of the nodes of the file ([`walk`]): those of the standard library
//! that [`standard`] has, pictures, and the nodes of Blender that [`nodes`](crate::graph::nodes) has. What is not understood is told by
//! name, once, and its default counts.

#[cfg(feature = "usd")]
mod definitions;
mod document;
mod images;
mod noise;
mod picture_nodes;
mod shaders;
mod standard;
mod volumes;
mod walk;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[cfg(feature = "usd")]
pub(in crate::scene) use definitions::NodeKind;
pub(in crate::scene) use document::Document;
#[cfg(feature = "usd")]
pub(in crate::scene) use document::{Element, Stated};
use picture_nodes::Pictures;
#[cfg(feature = "usd")]
pub(in crate::scene) use picture_nodes::{IMAGES, PictureAsked};
pub(in crate::scene) use walk::Finding;

use crate::scene::SceneError;
use crate::scene::surface::Surface;

/// Files that were read.
#[derive(Default)]
pub(in crate::scene) struct MtlxFiles {
    documents: HashMap<PathBuf, Arc<Document>>,
}

impl MtlxFiles {
    /// The file at `path`, with true if it was not read before.
    ///
    /// # Errors
    /// One that cannot be read, or is no MaterialX.
    pub fn at(&mut self, path: &Path) -> Result<(Arc<Document>, bool), SceneError> {
        if let Some(known) = self.documents.get(path) {
            return Ok((Arc::clone(known), false));
        }
        let document = Arc::new(Document::read(path)?);
        self.documents.insert(path.to_path_buf(), Arc::clone(&document));
        Ok((document, true))
    }
}

/// The surface of the material `name` of a document, and what is left out of it.
///
/// # Errors
/// A material that the file does not have, or that makes no sense; those of pictures.
pub(in crate::scene) fn surface(
    document: &Document,
    name: &str,
    pictures: Pictures<'_>,
) -> Result<(Surface, Vec<Finding>), SceneError> {
    shaders::surface(document, name, pictures)
}
