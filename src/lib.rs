//! Afterimage: a ray tracer for animations that reuses the samples of the frame before, exactly.
#![forbid(unsafe_code)]

pub mod cli;
pub mod film;
pub mod frame;
pub mod motion;
pub mod output;
pub mod report;
pub mod samples;
pub mod scene;
pub mod settings;
pub mod shade;
pub mod stats;
pub mod trace;
