//! From a frame's number to where everything is.

pub mod pose;
pub mod track;
pub mod transform;

pub use pose::{CameraPose, LightPose, Pose};
pub use track::{Interpolation, Keyed, Track};
pub use transform::{Transform, TransformTrack};
