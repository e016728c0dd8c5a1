//! Curves of files, of any basis, to chains of points that a [`Curves`](crate::geometry::Curves) geometry has.

mod basis;
mod mesh;
mod ribbons;
mod set;
mod text;

pub use basis::{Basis, Wrap};
pub(in crate::scene) use mesh::mesh_of;
pub use set::{CurveSet, CurveShape};
pub(in crate::scene) use text::read;
