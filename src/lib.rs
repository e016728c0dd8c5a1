//! Afterimage
#![forbid(unsafe_code)]

pub mod film;
pub mod output;
