//! The state of the shot in one frame, as all phases read it: poses, changes, bounds.

pub mod exposed;
pub mod frame_view;
mod linked;
pub mod links;
pub mod motion_vectors;
pub mod moved_bounds;
pub mod place;
pub mod plan;
pub mod prepared;
pub mod proofs;
pub mod reflection_maps;
pub mod tile_bounds;
