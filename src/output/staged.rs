//! Whole files or none, and an early look at whether the folder takes files.

use std::fmt;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// A file or folder that could not be written. Its text names it and says what to do.
#[derive(Debug)]
pub struct WriteError {
    /// The file or folder, under its final name.
    pub path: PathBuf,
    /// What the operating system answered.
    pub source: io::Error,
}

impl WriteError {
    fn new(path: &Path, source: io::Error) -> Self {
        Self { path: path.to_owned(), source }
    }
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let advice = match self.source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free space there",
            ErrorKind::PermissionDenied => "allow writing there",
            ErrorKind::NotFound => "create its folder",
            ErrorKind::NotADirectory | ErrorKind::AlreadyExists => "a file is in the way: remove it",
            _ => "check the disk",
        };
        let path = self.path.display();
        write!(f, "cannot write {path}: {}; {advice}, or choose another folder with -o", self.source)
    }
}

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// Creates the folder of `file` and writes and removes a small file in it.
///
/// # Errors
/// What a render would run into after its first frame: no permission, a read-only or full disk, a
/// file where a folder should be.
pub fn ensure_writable(file: &Path) -> Result<(), WriteError> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let refused = |error| WriteError::new(folder, error);
    fs::create_dir_all(folder).map_err(refused)?;
    let probe = folder.join(format!(".afterimage-{}.probe", std::process::id()));
    let written = fs::write(&probe, b"probe");
    let removed = fs::remove_file(&probe);
    written.and(removed).map_err(refused)
}

/// Writes all bytes under a hidden name beside `path`, then renames. On an error nothing is left.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let refused = |error| WriteError::new(path, error);
    let Some(name) = path.file_name() else {
        return Err(refused(ErrorKind::IsADirectory.into()));
    };
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".{}.part", std::process::id()));
    let temporary = path.with_file_name(hidden);
    let outcome = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    if outcome.is_err() {
        drop(fs::remove_file(&temporary)); // the first error is the one to tell
    }
    outcome.map_err(refused)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;

    #[test]
    fn folders_are_made_and_left_empty() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("new/deep/a.0001.exr");
        ensure_writable(&file).unwrap();
        assert_eq!(fs::read_dir(file.parent().unwrap()).unwrap().count(), 0);
    }

    #[test]
    fn a_file_in_the_way_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let text = ensure_writable(&file.join("a.0001.exr")).unwrap_err().to_string();
        assert!(text.contains("in the way") && text.contains("file"), "{text}");
    }

    #[test]
    fn a_failed_file_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("folder");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("inside"), "").unwrap();
        write_whole(&target, b"bytes").unwrap_err();
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
