//! Pure functions from surfaces and lights to colours. No ray is traced here.

pub mod area;
pub mod bsdf;
pub mod deformed;
pub mod emitter_parts;
pub mod emitters;
pub mod horizon;
pub mod light;
pub mod light_chances;
mod light_sample;
mod neighbours;
pub mod optics;
pub mod sampling;
pub mod sky;
mod sobol;
pub mod surface;
pub mod terminator;
pub mod within;

pub use surface::Surface;
