//! Keyed values: tracks, and the transforms of models made of them.

pub mod track;
pub mod transform;
pub mod visibility;

pub use track::{Interpolation, Keyed, Track};
pub use transform::{Transform, TransformTrack};
pub use visibility::Visibility;
