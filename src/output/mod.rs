//! What leaves the program as pictures: one EXR file a frame with all layers, and a PNG preview.
//!
//! A finished [`Film`](crate::film::Film) comes in; whole files come out, or none:
//! everything is written under a hidden temporary name in its folder and renamed when complete and on the disk.
//!
//! - [`path`]: `out/name.####.exr` and what it means for a frame number
//! - [`exr`]: layers and the header's metadata
//! - [`png`]: an 8-bit sRGB look at `R G B`
//! - [`look`]: how light becomes what screens show
//! - [`picture`]: finished frames, read back as a viewer shows them
//! - [`contact_sheet`]: many of them in one picture
//! - [`movie`]: all of them in one file, packed by FFmpeg
//! - [`fingerprint`]: what a frame was made from, so that a later run knows whether to keep it
//! - [`store_file`]: the samples of a frame, from which a later run goes on
//! - [`false_color`]: colours for how far two pictures are apart
//!
//! [`ensure_writable`] finds out before anything is rendered whether the folder takes files.

pub mod contact_sheet;
pub mod exr;
pub mod false_color;
pub mod fingerprint;
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
