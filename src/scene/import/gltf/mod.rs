//! Reads glTF 2.0 files, text (`.gltf`) and binary (`.glb`): meshes, materials, the tree of nodes and its animation.
//!
//! The JSON is read into plain structures (`json`), and each reference in it is checked where it is followed (`Document::get`).
//! Buffers and pictures are opened like all input, and must lie beside the file.

mod accessor;
mod animation;
mod bake;
mod cameras;
mod chosen_camera;
mod document;
mod framing;
mod geometry;
mod gloss;
mod json;
mod lights;
mod materials;
mod nodes;
mod parts;
mod pictures;
mod reading;
mod skin;
mod stated_gloss;
mod surrounded;
mod tints;
mod upper;
mod uri;
mod whole;

pub(crate) use chosen_camera::CameraChoice;
pub(crate) use document::Document;
pub(in crate::scene) use parts::GltfFiles;
pub(crate) use whole::read;
pub use whole::text;
