//! Samples to pixels: the paper's "Filtering", and all values of a pixel beside colour.

pub mod areas;
pub mod develop;
pub mod filter;
pub mod mattes;
pub mod mean;
pub mod pixels;
pub mod reach;
pub mod rims;
pub mod spread;
pub mod variance;
