//! Opens every file that is read: regular files alone, none of them larger than its kind may be.
//!
//! Opening a FIFO waits for a writer that may never come, and reading from a device may never end. So only
//! regular files are read, after all links are followed. (EXR files are opened by OpenEXR's wrapper, in the
//! same way. Files in `/proc`, in which the system describes itself, are not input.)

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;
use std::{fmt, thread};

use rustix::fs::OFlags;

use crate::memory::Bytes;

/// Largest number of attempts to open a file that another program is about to release, and the time between
/// two of them.
const MOST_LOOKS: u32 = 100;
const PAUSE: Duration = Duration::from_millis(20);

/// Kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A shot, as text.
    Shot,
    /// Materials (MTL).
    Materials,
    /// A model (OBJ), or a shape of one.
    Model,
    /// A texture, an environment map, or a preview.
    Picture,
    /// Shapes of a model.
    PointCache,
    /// Numbers of many models, such as their places.
    Array,
    /// Names of many models.
    Names,
    /// Samples of an earlier run.
    Store,
}

impl Kind {
    /// Largest size in bytes; `None` where memory alone is the limit.
    fn most_bytes(self) -> Option<u64> {
        match self {
            // some hundred thousand keys
            Self::Shot => Some(16 << 20),
            // a million materials
            Self::Materials | Self::Names => Some(256 << 20),
            // more than the largest picture that is accepted, uncompressed, with floats for colours
            Self::Picture => Some(16 << 30),
            Self::Model | Self::PointCache | Self::Array | Self::Store => None,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Shot => "a shot file",
            Self::Materials => "an MTL file",
            Self::Model => "an OBJ file",
            Self::Picture => "a picture",
            Self::PointCache => "a point cache",
            Self::Array => "an array",
            Self::Names => "a list of names",
            Self::Store => "a sample store",
        }
    }
}

/// Reason why a file is not read. The text, the end of a sentence, says what to do.
#[derive(Debug)]
pub(crate) enum InputError {
    /// Error of the system.
    System(io::Error),
    /// Something else than a regular file, by this name.
    NoFile(&'static str),
    /// Size in bytes, above the limit of this kind.
    TooLarge(u64, Kind),
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::System(error) => error.fmt(f),
            Self::NoFile(what) => write!(f, "it is {what}, and not a regular file: give a file"),
            Self::TooLarge(bytes, kind) => {
                let (bytes, most) = (Bytes(*bytes), Bytes(kind.most_bytes().unwrap_or(u64::MAX)));
                let name = kind.name();
                write!(
                    f,
                    "it has {bytes}, and {name} may have {most}: check that it is one, or make it smaller"
                )
            }
        }
    }
}

impl From<io::Error> for InputError {
    fn from(error: io::Error) -> Self {
        Self::System(error)
    }
}

impl From<InputError> for io::Error {
    fn from(error: InputError) -> Self {
        match error {
            InputError::System(error) => error,
            other => Self::other(other.to_string()),
        }
    }
}

/// Regular file that is open.
#[derive(Debug)]
pub(crate) struct Input {
    /// File, at its beginning.
    pub file: File,
    /// Length in bytes, when it was opened.
    pub length: u64,
    kind: Kind,
}

/// Opens the file at `path`, to which links may lead. Never waits for one.
pub(crate) fn open(path: &Path, kind: Kind) -> Result<Input, InputError> {
    // opening a device may do something already
    check(&path.metadata()?, kind)?;
    let file = open_at_once(path)?;
    // the file may be another one by now
    let found = file.metadata()?;
    check(&found, kind)?;
    Ok(Input { file, length: found.len(), kind })
}

impl Input {
    /// Reads all bytes; of a file that has become longer, no more than its kind may have.
    pub fn read_all(self) -> Result<Vec<u8>, InputError> {
        let Self { file, length, kind } = self;
        let mut bytes = Vec::new();
        let room = usize::try_from(length).ok().and_then(|length| bytes.try_reserve_exact(length).ok());
        room.ok_or(io::Error::from(ErrorKind::OutOfMemory))?;
        file.take(kind.most_bytes().map_or(length, |most| most + 1)).read_to_end(&mut bytes)?;
        check_length(bytes.len() as u64, kind)?;
        Ok(bytes)
    }
}

fn check(found: &Metadata, kind: Kind) -> Result<(), InputError> {
    let what = match found.file_type() {
        file if file.is_file() => return check_length(found.len(), kind),
        file if file.is_dir() => "a folder",
        file if file.is_fifo() => "a FIFO",
        file if file.is_socket() => "a socket",
        _ => "a device",
    };
    Err(InputError::NoFile(what))
}

fn check_length(bytes: u64, kind: Kind) -> Result<(), InputError> {
    match kind.most_bytes() {
        Some(most) if bytes > most => Err(InputError::TooLarge(bytes, kind)),
        _ => Ok(()),
    }
}

/// Opens a file, without waiting for another end.
fn open_at_once(path: &Path) -> io::Result<File> {
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let open = || OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(path);
    for _ in 1..MOST_LOOKS {
        match open() {
            // a file server has lent the file to a client, and asks for it now (a lease: see fcntl)
            Err(error) if error.kind() == ErrorKind::WouldBlock => thread::sleep(PAUSE),
            outcome => return outcome,
        }
    }
    open()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::os::unix::fs::symlink;
    use std::path::PathBuf;

    use rustix::fs::{CWD, FileType, Mode, mknodat};
    use tempfile::TempDir;

    use super::*;

    fn folder(name: &str) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        (folder, path)
    }

    fn read(path: &Path, kind: Kind) -> Result<Vec<u8>, InputError> {
        open(path, kind)?.read_all()
    }

    fn refused(path: &Path, kind: Kind) -> String {
        read(path, kind).unwrap_err().to_string()
    }

    #[test]
    fn files_are_read_also_through_links() {
        let (folder, path) = folder("a");
        std::fs::write(&path, "text").unwrap();
        let link = folder.path().join("link");
        symlink("a", &link).unwrap();
        for path in [&path, &link] {
            assert_eq!(read(path, Kind::Shot).unwrap(), b"text");
            assert_eq!(read(path, Kind::Model).unwrap(), b"text");
            assert_eq!(open(path, Kind::Model).unwrap().length, 4);
        }
    }

    #[test]
    fn what_is_no_file_is_told_and_not_waited_for() {
        let (folder, fifo) = folder("fifo");
        mknodat(CWD, &fifo, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let link = folder.path().join("link");
        symlink("/dev/zero", &link).unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        for (path, what) in
            [(&*fifo, "a FIFO"), (&link, "a device"), (folder.path(), "a folder"), (&socket, "a socket")]
        {
            let text = refused(path, Kind::Model);
            assert!(text.contains(what) && text.contains("regular file"), "{text}");
        }
        // a FIFO that takes the place of a file which has been checked
        open_at_once(&fifo).unwrap();
        assert!(refused(&folder.path().join("gone"), Kind::Shot).contains("No such file"));
    }

    #[test]
    fn files_that_are_too_large_are_not_read() {
        let (_folder, path) = folder("sparse");
        let file = File::create(&path).unwrap();
        file.set_len(500 << 20).unwrap();
        let text = refused(&path, Kind::Shot);
        assert!(text.contains("500 MiB") && text.contains("a shot file may have 16 MiB"), "{text}");
        assert!(refused(&path, Kind::Materials).contains("256 MiB"));
        assert!(open(&path, Kind::Picture).is_ok() && open(&path, Kind::Model).is_ok());
    }

    #[test]
    fn what_grows_while_it_is_read_is_read_to_its_limit() {
        let (_folder, path) = folder("growing");
        let file = File::create(&path).unwrap();
        let [shot, model] = [Kind::Shot, Kind::Model].map(|kind| open(&path, kind).unwrap());
        file.set_len(17 << 20).unwrap();
        assert!(matches!(shot.read_all(), Err(InputError::TooLarge(..))));
        assert_eq!(model.read_all().unwrap(), b"");
    }
}
