//! Afterimage: a ray tracer for animations that reuses the samples of the frame before, exactly.
#![forbid(unsafe_code)]

pub mod motion;
pub mod scene;
pub mod settings;
pub mod stats;
