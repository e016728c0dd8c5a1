//! A safe wrapper of [Open Image Denoise 2](https://www.openimagedenoise.org): one picture, its albedo and its normals in,
//! the picture without noise out.
//!
//! The library is loaded when a [`Denoiser`] is made. A program that has it starts without the library, too, and can say
//! what is missing. So there are no headers to make bindings from: `functions.rs` declares the few functions by hand, as
//! version 2.0 has them and later ones of that series keep them.
//!
//! ```no_run
//! use oidn::{Denoiser, Guides, Quality};
//!
//! let mut denoiser = Denoiser::load("libOpenImageDenoise.so.2".as_ref(), 4, Quality::High)?;
//! let (color, albedo, normal) = ([[0.5; 3]; 64], [[1.0; 3]; 64], [[0.0, 0.0, 1.0]; 64]);
//! let mut output = [[0.0; 3]; 64];
//! denoiser.denoise([8, 8], &color, Guides { albedo: &albedo, normal: &normal }, &mut output)?;
//! # Ok::<(), oidn::Error>(())
//! ```

mod denoiser;
mod error;
mod functions;

pub use denoiser::{Denoiser, Guide, Guides, MOST_MEGABYTES, Quality};
pub use error::{Error, Kind};
