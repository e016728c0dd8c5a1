//! Random small shots that try whether reuse is exact.
//!
//! Every sample of an inferred frame is to be what tracing it now would give. Tests ask this of scenes that somebody thought of; this
//! asks it of scenes that nobody did. [`generate`] makes a shot of a number, out of everything that a shot file can say. [`check`] renders
//! it, audits it, lays it over what is traced in full ([`pictures`]), and renders it once more in another way that must not matter. [`shrink`] cuts what fails down to a few lines.
//! [`run`] does so many times and counts which [`features`] met.
//!
//! The same number makes the same shot on every machine.
#![allow(missing_docs, reason = "a tool of this workspace alone")]

pub mod check;
pub mod dice;
pub mod fairness;
pub mod features;
pub mod files;
pub mod generate;
pub mod glb;
pub mod mtlx;
pub mod pictures;
pub mod run;
pub mod shrink;
mod store;
pub mod trial;
mod vdb;
