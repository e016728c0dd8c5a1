//! Afterimage
#![forbid(unsafe_code)]
