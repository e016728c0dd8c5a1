//! Writes reports to the paths that the user names: files are replaced whole or not at all; anything else is
//! written into.

use std::fs::{self, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::output::{self, WriteError, folder_of};

/// Maximum number of symbolic links that lead from one to the next: as many as Linux follows.
const MOST_LINKS: usize = 40;

/// Destination of a report.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Destination {
    /// A regular file, or none yet: replaced whole. Links to it are followed, and stay.
    File(PathBuf),
    /// A device or a FIFO: written into.
    Stream(PathBuf),
    /// Destination of stdout, even if that is a file: the report follows the printed output.
    Stdout,
    /// Destination of stderr, even if that is a file.
    Stderr,
}

impl Destination {
    /// Finds the present destination at `path`. Opens nothing.
    ///
    /// # Errors A folder, a socket, links in a circle, a folder of the path that is none.
    pub fn new(path: &Path) -> Result<Self, WriteError> {
        Self::found(path).map_err(|error| WriteError { path: path.to_owned(), source: error })
    }

    fn found(path: &Path) -> io::Result<Self> {
        let found = match fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => {
                let file = end_of_links(path);
                let is_name = file.file_name().is_some();
                return if is_name { Ok(Self::File(file)) } else { Err(ErrorKind::IsADirectory.into()) };
            }
            found => found?,
        };
        if is_same(&found, io::stdout()) {
            return Ok(Self::Stdout);
        }
        if is_same(&found, io::stderr()) {
            return Ok(Self::Stderr);
        }
        match found.file_type() {
            kind if kind.is_file() => path.canonicalize().map(Self::File),
            kind if kind.is_dir() => Err(ErrorKind::IsADirectory.into()),
            kind if kind.is_socket() => Err(io::Error::other("it is a socket")),
            _ => Ok(Self::Stream(path.to_owned())),
        }
    }
}

/// Target of the links that begin with `path`; `path` itself if it is no link.
fn end_of_links(path: &Path) -> PathBuf {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(target) = fs::read_link(&at) else { break };
        at = folder_of(&at).join(target);
    }
    at
}

fn is_same(found: &Metadata, stream: impl AsFd) -> bool {
    rustix::fs::fstat(stream).is_ok_and(|stat| (stat.st_dev, stat.st_ino) == (found.dev(), found.ino()))
}

/// Finds out before the work whether a report can be written to `path`, and removes what killed runs left of it.
/// (Streams are not tried: to open a FIFO is to wait for its reader.)
pub fn prepare(path: &Path) -> Result<(), WriteError> {
    if let Destination::File(file) = Destination::new(path)? {
        output::ensure_writable(&file)?;
        output::remove_leftovers(folder_of(&file), |name| file.file_name().is_some_and(|own| own == name));
    }
    Ok(())
}

/// Writes `value` as JSON that people can read.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), WriteError> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| WriteError { path: path.to_owned(), source: error.into() })?;
    write_text(path, &format!("{text}\n"))
}

/// Writes `text`. Waits for the reader of a FIFO; one that leaves early is no error.
pub fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    let written = match Destination::new(path)? {
        Destination::File(file) => return output::write_bytes(&file, text.as_bytes()),
        Destination::Stream(stream) => {
            OpenOptions::new().write(true).open(stream).and_then(|stream| write_into(stream, text))
        }
        Destination::Stdout => write_into(io::stdout().lock(), text),
        Destination::Stderr => write_into(io::stderr().lock(), text),
    };
    written.map_err(|error| WriteError { path: path.to_owned(), source: error })
}

fn write_into(mut stream: impl Write, text: &str) -> io::Result<()> {
    match stream.write_all(text.as_bytes()).and_then(|()| stream.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn replaces_whole_files_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        write_text(&path, "old, and longer than the new").unwrap();
        write_json(&path, &[1, 2]).unwrap();
        assert_eq!(serde_json::from_str::<Vec<i32>>(&fs::read_to_string(&path).unwrap()).unwrap(), [1, 2]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn names_the_file_that_it_cannot_write() {
        let folder = tempfile::tempdir().unwrap();
        for path in [folder.path().join("no/such.json"), folder.path().to_owned()] {
            let error = write_text(&path, "x").unwrap_err().to_string();
            assert!(error.contains(&path.display().to_string()), "{error}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn links_are_followed_to_their_end() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().canonicalize().unwrap().join(name);
        fs::create_dir(at("deep")).unwrap();
        symlink("deep/second", at("first")).unwrap();
        symlink("../end", at("deep/second")).unwrap();
        symlink("circle", at("circle")).unwrap();
        assert_eq!(
            Destination::new(&at("first")).unwrap(),
            Destination::File(at("deep/../end")),
            "no file yet"
        );
        fs::write(at("end"), "").unwrap();
        assert_eq!(Destination::new(&at("first")).unwrap(), Destination::File(at("end")));
        Destination::new(&at("circle")).unwrap_err();
        Destination::new(Path::new("")).unwrap_err();
    }
}
