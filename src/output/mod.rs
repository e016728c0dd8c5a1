//! Pictures as files: one EXR file a frame with all layers, and a PNG preview.
//!
//! A finished [`Film`](crate::film::Film) comes in; whole files come out, or none:
//! everything is written under a hidden temporary name in its folder and renamed when complete and on the disk.
//!
//! - [`path`]: `out/name.####.exr`, and the file name of each frame
//! - [`exr`]: layers and the header's metadata
//! - [`png`]: an 8-bit sRGB preview of `R G B`
//! - [`look`]: conversion of light to a screen's values
//! - [`picture`]: finished frames, read back as a viewer shows them
//! - [`contact_sheet`]: many of them in one picture
//! - [`movie`]: all of them in one file, packed by FFmpeg
//! - [`fingerprint`]: digests of a frame's inputs, so that a later run knows whether to keep it
//! - [`lock`]: locks by which several processes divide their work
//! - [`store_file`]: the samples of a frame, from which a later run continues
//! - [`false_color`]: colours for differences between two pictures
//!
//! [`ensure_writable`] finds out before anything is rendered whether the folder takes files.

pub mod contact_sheet;
pub mod exr;
pub mod false_color;
pub mod fingerprint;
pub mod lock;
pub mod look;
mod metadata;
pub mod movie;
pub mod path;
pub mod picture;
pub mod png;
mod staged;
pub mod store_file;

pub use exr::write_exr;
pub use fingerprint::Fingerprint;
pub use metadata::FrameMeta;
pub use path::{OutputPattern, PatternError};
pub use png::write_png;
pub(crate) use staged::folder_of;
pub use staged::{WriteError, ensure_writable, remove_leftovers, write_bytes, write_new_bytes};
