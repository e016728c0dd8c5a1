//! Axis-aligned boxes, at rest and swept, which show without a ray that certain models are not met; trees of them; [curved
//! geometry](Curved), which is not made of flat triangles: quadrics, curves; angles, and normals of vertices.

pub mod angle;
mod bounds;
pub mod curved;
pub mod curves;
pub mod quadric;
mod swept_box;
pub mod tree;
pub mod vertex_normal;

pub use bounds::{Bounds, Bounds8, Segments};
pub use curved::Curved;
pub use curves::Curves;
pub use quadric::Quadric;
pub use swept_box::SweptBox;
