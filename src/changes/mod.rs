//! Expiry of results about segments: all motion of a shot is known before its first frame.
//!
//! The result of a ray (the surface that it met, or that nothing was in the way) can only change in a frame
//! in which something that moves touches the segment that the ray went along. [`Motion`] finds the first such
//! frame, and [`Until`] stores it in two bytes.
//!
//! | step | file | what |
//! |---|---|---|
//! | when | `frames.rs` | the frames in which a model or a light differs from the frame before |
//! | parts | `parts.rs` | boxes around parts of a mesh, in each of its shapes |
//! | where | `leaves.rs` | boxes around parts of the models at each of their places, with the frames of arriving and leaving |
//! | tree | `split.rs`, `tree.rs` | a hierarchy over space and frames with eight children a node |
//!
//! Frame g depends on the boxes of each model whose transform differs, exactly, from that of frame g - 1: at
//! its old place (leaving unblocks a ray) and at its new one (arriving blocks it). Models at rest change
//! nothing. The camera does not count. All of it is a function of the scene and of absolute frame numbers.
//!
//! For frames that are inferred backwards there is a second `Motion`, in which time runs the other way: frame
//! g comes after g + 1.

mod frames;
mod leaves;
mod motion;
mod parts;
mod split;
mod tree;
mod until;

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod world;

pub use frames::{Direction, anything_changes};
pub use motion::Motion;
pub use until::Until;
