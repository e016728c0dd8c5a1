//! Axis-aligned boxes, at rest and swept: what is certainly not met needs no ray.

mod bounds;
mod swept_box;

pub use bounds::{Bounds, Bounds8, Segments};
pub use swept_box::SweptBox;
