//! Meshes that a program has in memory.

mod build;
mod curves;
mod meshes;

pub use super::curves::{Basis as CurveBasis, CurveSet, CurveShape, Wrap as CurveWrap};
pub(in crate::scene) use build::models;
pub use meshes::{Given, GivenMesh, GivenModel, NAME};
