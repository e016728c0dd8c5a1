//! Keyed values: tracks, and the transforms of models made of them.

pub mod track;
pub mod transform;

pub use track::{Interpolation, Keyed, Track};
pub use transform::{Transform, TransformTrack};
