//! Axis-aligned boxes, at rest and swept, which show without a ray that certain models are not met; trees of them; and
//! quadrics, surfaces that are not lists of corners; angles, and normals of vertices.

pub mod angle;
mod bounds;
pub mod quadric;
mod swept_box;
pub mod tree;
pub mod vertex_normal;

pub use bounds::{Bounds, Bounds8, Segments};
pub use quadric::Quadric;
pub use swept_box::SweptBox;
