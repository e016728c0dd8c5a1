//! Planes of a film: their list, the filters that weigh samples in them, and the windows through which tiles
//! write.

pub mod channels;
pub mod kernel;
pub mod mixing;
pub mod window;
