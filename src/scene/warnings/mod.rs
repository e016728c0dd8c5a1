//! Warnings before rendering about shots that will not look as intended.

pub mod caustics;
pub(crate) mod darkness;
pub mod kinds;
pub mod limits;
pub(crate) mod media;
