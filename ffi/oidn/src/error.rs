//! Errors of the wrapper.

use std::fmt;
use std::path::PathBuf;

/// Reason why there is no picture.
#[derive(Debug)]
pub enum Error {
    /// The library cannot be loaded, or lacks a function: it is of another series.
    Load {
        /// Path of the library as given.
        path: PathBuf,
        /// Message of the system's loader.
        why: String,
    },
    /// The library refuses something.
    Library {
        /// Kind of the error.
        kind: Kind,
        /// Message of the library, or nothing.
        why: String,
    },
    /// A list has another length than the picture has pixels.
    Size {
        /// Name of the list.
        what: &'static str,
        /// Length of the list.
        length: usize,
        /// Number of pixels.
        pixels: usize,
    },
}

/// `OIDNError`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs, reason = "the library's own names")]
pub enum Kind {
    Unknown,
    InvalidArgument,
    InvalidOperation,
    OutOfMemory,
    UnsupportedHardware,
    Cancelled,
}

impl Kind {
    /// Converts the library's number; `None`: no error.
    pub(crate) fn of(code: i32) -> Option<Self> {
        match code {
            0 => None,
            2 => Some(Self::InvalidArgument),
            3 => Some(Self::InvalidOperation),
            4 => Some(Self::OutOfMemory),
            5 => Some(Self::UnsupportedHardware),
            6 => Some(Self::Cancelled),
            _ => Some(Self::Unknown),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Unknown => "unknown error",
            Self::InvalidArgument => "invalid argument",
            Self::InvalidOperation => "invalid operation",
            Self::OutOfMemory => "out of memory",
            Self::UnsupportedHardware => "unsupported hardware",
            Self::Cancelled => "cancelled",
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Load { path, why } => write!(f, "{} cannot be loaded: {why}", path.display()),
            Self::Library { kind, why } if why.is_empty() => {
                write!(f, "Open Image Denoise: {}", kind.words())
            }
            Self::Library { kind, why } => write!(f, "Open Image Denoise: {}: {why}", kind.words()),
            Self::Size { what, length, pixels } => {
                write!(f, "{what} has {length} pixels, and the picture {pixels}")
            }
        }
    }
}

impl std::error::Error for Error {}
