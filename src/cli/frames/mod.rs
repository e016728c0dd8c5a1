//! Files of frames: where they go, how they are written, and which are there already.

pub mod frame_list;
pub mod paths;
pub mod resume;
pub mod store;
pub mod target;
pub mod writing;
