//! Kinds of nodes that show pictures, and what they ask of readers.

use crate::scene::SceneError;
use crate::scene::import::pictures::PictureUse;
use crate::scene::texture::Mapping;

/// Kinds of nodes that show a picture.
pub const IMAGES: [&str; 5] = ["image", "tiledimage", "gltf_image", "gltf_colorimage", "gltf_normalmap"];

/// The kind of node that shows a picture in hexagonal tiles.
pub const HEXAGONS: &str = "hextiledimage";

/// A picture that a node asks for.
#[derive(Debug)]
pub(in crate::scene) struct PictureAsked {
    /// Name of the file.
    pub file: String,
    /// The same without the prefix that the document states: some write it into both.
    pub plain: String,
    /// Line of the node.
    pub line: usize,
    /// Places of texture coordinates on it.
    pub mapping: Mapping,
    /// What its values are.
    pub used: PictureUse,
    /// True if something is to be seen where it is missing; else the node's default counts.
    pub has_stand_in: bool,
}

/// Gives the number of a picture of the shot; `None` of one that is missing and has no stand-in.
pub(in crate::scene) type Pictures<'p> = &'p mut dyn FnMut(&PictureAsked) -> Result<Option<u32>, SceneError>;
