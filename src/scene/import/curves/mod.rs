//! Curves of files, of any basis, to chains of points that a [`Curves`](crate::geometry::Curves) geometry has.

mod basis;
mod set;
mod text;

pub use basis::Basis;
#[cfg(feature = "usd")]
pub use basis::Wrap;
pub use set::CurveSet;
pub(in crate::scene) use set::mesh_of;
pub(in crate::scene) use text::read;
