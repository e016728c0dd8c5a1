//! Pure functions from surfaces and lights to colours. No ray is traced here.

pub mod area;
pub mod coat;
pub mod deformed;
pub mod emitter_parts;
pub mod emitters;
pub mod fresnel;
pub mod ggx;
pub mod horizon;
pub mod light;
pub mod light_chances;
mod light_sample;
pub mod mis;
pub mod optics;
pub mod phong;
pub mod sampling;
pub mod sky;
mod sobol;
pub mod surface;
pub mod terminator;

pub use surface::Surface;
