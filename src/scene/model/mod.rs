//! Models once their files are read: put into world space, trimmed, or left to share their mesh.

pub mod bake;
pub mod copies;
pub mod trim;
