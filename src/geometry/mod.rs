//! Axis-aligned boxes, at rest and swept: what is certainly not met needs no ray. And quadrics, which no list of corners
//! describes.

mod bounds;
pub mod quadric;
mod swept_box;

pub use bounds::{Bounds, Bounds8, Segments};
pub use quadric::Quadric;
pub use swept_box::SweptBox;
