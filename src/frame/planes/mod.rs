//! The planes of a film: which there are, how a filter weighs samples in them, and where tiles write.

pub mod channels;
pub mod kernel;
pub mod mixing;
pub mod window;
