//! Keyed values: tracks, and the transforms and shapes of models made of them.

pub mod keys;
pub mod shape;
pub mod track;
pub mod transform;
pub mod visibility;

pub use keys::Keys;
pub use shape::{Chord, Shape, ShapeTrack};
pub use track::{Interpolation, Keyed, Track};
pub use transform::{Transform, TransformTrack};
pub use visibility::Visibility;
