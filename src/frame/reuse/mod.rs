//! Reuse, the subject of the paper: samples of the frame before are projected, serve cells, and are verified;
//! the other cells are traced.

pub mod beside;
pub mod bins;
pub mod candidates;
pub mod estimate;
pub mod invalidate_spares;
pub mod own_triangle;
pub mod project;
pub mod proofs;
pub mod reproject;
pub mod serve;
#[cfg(test)]
mod serve_tests;
pub mod sight;
pub mod target;
pub mod trace_missed;
pub mod verify;
