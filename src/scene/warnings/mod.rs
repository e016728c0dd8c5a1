//! Warnings of shots that will not look as they were meant: told before anything is rendered.

pub mod caustics;
pub(crate) mod darkness;
pub mod limits;
