//! Files of frames: their places, their writing, and those that exist already.

pub mod checkpoint;
pub mod frame_list;
pub mod handoff;
pub mod paths;
pub mod resume;
pub mod store;
pub mod target;
pub mod writing;
