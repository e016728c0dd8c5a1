//! Meshes that a program has in memory.

mod build;
mod meshes;

pub(in crate::scene) use build::models;
pub use meshes::{Given, GivenMesh, GivenModel, NAME};
