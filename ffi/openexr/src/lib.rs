//! Writes multi-layer EXR files, and reads them back.
//!
//! [`write()`] makes one scanline part, [`write_parts()`] one for each layer. Their chunks are packed and compressed on all threads of rayon's
//! pool; OpenEXR's C library makes the header and the file's structure. The caller opens the file, and
//! gives it its name when it is complete. [`read()`] takes every scanline file's first part,
//! [`scan()`] goes through it line by line, [`scan_part()`] through any part. Chunks of B44 and DWA are unpacked in Rust.
//!
//! Planes are `f32` or halves, row-major, top row first, `width * height` long. No NaN and no infinity goes into
//! a file.

mod attributes;
mod c_text;
mod check;
mod compress;
mod error;
mod header;
mod library;
mod lossy;
mod pack;
mod parts;
mod piz;
mod read;
mod sink;
mod source;
mod views;
mod write;

pub use error::Error;
pub use library::version;
pub use read::{ReadChannel, ReadImage, part_count, read, read_header, read_header_of, scan, scan_part};
pub use views::write_views;
pub use write::{write, write_at_level, write_parts};

/// Storage of a channel's samples in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    /// 16-bit float. Finite values beyond 65504 are stored as 65504, with their sign.
    Half,
    /// 32-bit float: stored as it is.
    Float,
    /// 32-bit unsigned integer: rounded to the nearest, clamped to 0 and the largest.
    Uint,
}

/// One plane to write.
#[derive(Clone, Copy, Debug)]
pub struct Channel<'a> {
    /// Name: `R`, or `layer.R`; at most 31 bytes and one dot.
    pub name: &'a str,
    /// The type in the file.
    pub stored: SampleType,
    /// Values: `width * height` finite ones, row-major, top row first.
    pub data: Data<'a>,
}

/// The values of a plane in memory.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs, reason = "the names say it")]
pub enum Data<'a> {
    Floats(&'a [f32]),
    /// Made for channels that are stored as [`SampleType::Half`]; others are converted.
    Halves(&'a [half::f16]),
}

impl Data<'_> {
    /// Number of values.
    fn len(&self) -> usize {
        match self {
            Self::Floats(values) => values.len(),
            Self::Halves(values) => values.len(),
        }
    }
}

/// A value of the header.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// UTF-8 text without a zero byte.
    Text(String),
    /// A number.
    Float(f32),
    /// A whole number.
    Int(i32),
    /// A fraction, such as 24000/1001 frames per second.
    #[allow(missing_docs, reason = "the names say it")]
    Rational { numerator: i32, denominator: u32 },
    /// Several texts without a zero byte.
    Texts(Vec<String>),
    /// A matrix, rows one after the other, for row vectors (`p' = p * M`): the translation stands in
    /// elements 12, 13 and 14, as in Imath.
    M44f([f32; 16]),
    /// Two floats.
    V2f([f32; 2]),
    /// Two whole numbers.
    V2i([i32; 2]),
    /// Three floats.
    V3f([f32; 3]),
    /// CIE x and y of red, green, blue and white.
    Chromaticities([f32; 8]),
    /// SMPTE 12M time code as OpenEXR packs it: binary-coded digits and flags, and user data.
    #[allow(missing_docs, reason = "the names are the file format's")]
    TimeCode { time_and_flags: u32, user_data: u32 },
    /// An attribute in a file whose type is not listed above; its type's name. It cannot be written.
    Other(String),
}

/// Compression of chunks. All methods are lossless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compression {
    /// No compression.
    None,
    /// Deflate, one scanline a chunk: compositors read single lines, and read it fastest.
    #[default]
    Zips,
    /// Deflate, 16 scanlines a chunk: a little smaller.
    Zip,
    /// Wavelet, 32 scanlines a chunk: smaller for grainy pictures.
    Piz,
}

/// Position of a file's pixels in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Column and row of the data window's first pixel, counted from the picture's first; negative before it.
    pub first: [i32; 2],
    /// Pixels across and down the picture: the display window begins with its first.
    pub picture: [u32; 2],
}

/// One of several views of the same scene, which go into one file: the pictures of a left and a right eye.
#[derive(Clone, Debug)]
pub struct View<'a> {
    /// Name: `left` and `right` of two eyes. No dots, no spaces.
    pub name: &'a str,
    /// Picture, with channels as in a file of its own. All views have one size, place and compression.
    pub image: Image<'a>,
}

/// Everything that goes into one file.
#[derive(Clone, Debug)]
pub struct Image<'a> {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
    /// Position of the pixels, if they are not the whole picture: its display window has another size or
    /// place than the data window.
    pub placed: Option<Placed>,
    /// Channels in any order: the file has them sorted by name.
    pub channels: Vec<Channel<'a>>,
    /// Attributes. Names are at most 31 bytes; later ones replace earlier ones of the same name.
    pub attributes: Vec<(String, Attribute)>,
    /// Compression of all channels.
    pub compression: Compression,
}
