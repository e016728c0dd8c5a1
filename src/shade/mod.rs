//! Pure functions from surfaces and lights to colours. No ray is traced here.

pub mod emitters;
pub mod light;
pub mod optics;
pub mod phong;
pub mod sampling;
pub mod sky;
pub mod surface;

pub use surface::Surface;
