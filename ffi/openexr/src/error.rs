//! Errors of a file, in sentences that say what to do.

use std::fmt;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Reason why a file was not written or read. Its text names the file and says what to do.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// The operating system refused.
    File {
        /// Name that the caller gives to the file.
        path: PathBuf,
        /// Failed operation, `write` or `read`.
        doing: &'static str,
        /// Answer of the operating system.
        source: io::Error,
    },
    /// The image given to the writer breaks a rule of the format or of this crate.
    Image {
        /// The file that would have been written.
        path: PathBuf,
        /// Broken rule, and its place.
        what: String,
    },
    /// OpenEXR refused.
    Library {
        /// The file.
        path: PathBuf,
        /// The step that failed.
        doing: &'static str,
        /// OpenEXR's own words.
        message: String,
    },
}

impl Error {
    pub(crate) fn image(path: &Path, what: impl Into<String>) -> Self {
        Self::Image { path: path.to_owned(), what: what.into() }
    }

    pub(crate) fn writing(path: &Path, source: io::Error) -> Self {
        Self::File { path: path.to_owned(), doing: "write", source }
    }

    pub(crate) fn reading(path: &Path, source: io::Error) -> Self {
        Self::File { path: path.to_owned(), doing: "read", source }
    }

    /// The file that the error is about.
    #[must_use]
    pub fn path(&self) -> &Path {
        match self {
            Self::File { path, .. } | Self::Image { path, .. } | Self::Library { path, .. } => path,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = self.path().display();
        match self {
            Self::File { path, doing, source } => {
                write!(f, "cannot {doing} {file}: {source}")?;
                advice(path, source.kind()).map_or(Ok(()), |advice| write!(f, "; {advice}"))
            }
            Self::Image { what, .. } => write!(f, "cannot write {file}: {what}"),
            Self::Library { doing, message, .. } => {
                write!(f, "{file}: OpenEXR failed to {doing}: {message}")
            }
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::File { source, .. } => Some(source),
            Self::Image { .. } | Self::Library { .. } => None,
        }
    }
}

fn advice(path: &Path, kind: ErrorKind) -> Option<String> {
    Some(match kind {
        ErrorKind::NotFound => String::from("check the name"),
        ErrorKind::PermissionDenied => String::from("allow reading it"),
        ErrorKind::FileTooLarge => String::from("raise the limit on files (ulimit -f)"),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new("."));
            format!("free space for {}, or choose another folder", folder.display())
        }
        _ => return None,
    })
}
