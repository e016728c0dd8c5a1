//! Writes whole files or none, removes leftovers of killed runs, and tests early whether a folder takes
//! files.
//!
//! A file is written under a hidden name of its own, `.NAME.RANDOM.part`, beside its final one (a rename is
//! atomic within one file system only), and locked as long as its writer lives. A killed run leaves such a
//! file unlocked; the next one that is to write `NAME` removes it ([`remove_leftovers`]).

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use tempfile::NamedTempFile;

/// Ending of the names of unfinished files.
const UNFINISHED: &str = ".part";

/// Number of random letters and digits in the name of an unfinished file: no word has as many by chance.
const RANDOM_LETTERS: usize = 12;

/// Maximum number of attempts to create a file that no other run removes before it is locked.
const MOST_TEMPORARIES: usize = 100;

/// Permissions of a new file before the user's mask applies, as for most programs.
const NEW_FILE_MODE: u32 = 0o666;

/// A file or folder that could not be written. Its text names it and says what to do.
#[derive(Debug)]
pub struct WriteError {
    /// The file or folder, under its final name.
    pub path: PathBuf,
    /// Answer of the operating system.
    pub source: io::Error,
}

impl WriteError {
    pub(super) fn new(path: &Path, source: io::Error) -> Self {
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
            ErrorKind::IsADirectory => "give a file's name",
            ErrorKind::InvalidFilename => "shorten the name",
            _ => "check the disk",
        };
        let path = self.path.display();
        write!(f, "cannot write {path}: {}; ", self.source)?;
        match self.source.kind() {
            ErrorKind::FileTooLarge => f.write_str("raise the limit on files (ulimit -f)"),
            _ => write!(f, "{advice}, or choose another folder"),
        }
    }
}

impl std::error::Error for WriteError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// Creates the folder of `file` and writes a small file in it.
///
/// # Errors
/// What a render would run into after its first frame: no permission, a read-only or full disk, a
/// file where a folder should be.
pub fn ensure_writable(file: &Path) -> Result<(), WriteError> {
    let folder = folder_of(file);
    let refused = |error| WriteError::new(folder, error);
    fs::create_dir_all(folder).map_err(refused)?;
    // it has no name, so it cannot meet another run's, and a killed run leaves none
    tempfile::tempfile_in(folder).and_then(|mut probe| probe.write_all(b"probe")).map_err(refused)
}

/// Lets `fill` write a file that gets the name `path` when its data is on the disk. After an error no file is
/// left.
pub fn write_whole<E: From<WriteError>>(path: &Path, fill: impl Fn(&File) -> Result<(), E>) -> Result<(), E> {
    let outcome = match write_once(path, &fill)? {
        // another run took it for a leftover, where locks are not seen by all machines
        Err(error) if error.kind() == ErrorKind::NotFound => write_once(path, &fill)?,
        outcome => outcome,
    };
    outcome.map_err(|error| WriteError::new(path, error).into())
}

/// Writes bytes by [`write_whole`].
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    write_whole(path, |mut file| file.write_all(bytes).map_err(|error| WriteError::new(path, error)))
}

/// Writes `bytes` to a new file. An existing file stays, and is an error.
pub fn write_new_bytes(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let write = || -> io::Result<()> {
        let staged = stage(path)?;
        staged.as_file().write_all(bytes)?;
        staged.as_file().sync_all()?;
        staged.persist_noclobber(path).map_err(|refused| refused.error)?;
        Ok(())
    };
    write().map_err(|error| WriteError::new(path, error))
}

/// Makes one attempt. The outer result is that of `fill`, the inner one that of the operating system.
fn write_once<E>(path: &Path, fill: &impl Fn(&File) -> Result<(), E>) -> Result<io::Result<()>, E> {
    let staged = match stage(path) {
        Ok(staged) => staged,
        Err(error) => return Ok(Err(error)),
    };
    fill(staged.as_file())?;
    Ok(publish(staged, path))
}

/// Creates an empty, locked file that is removed when it is dropped.
fn stage(path: &Path) -> io::Result<NamedTempFile> {
    for _ in 1..MOST_TEMPORARIES {
        let staged = create(path)?;
        // where locks do not exist, nobody gets one and removes the file; whoever has it now is about to remove it
        let locked = flock(staged.as_file(), FlockOperation::NonBlockingLockExclusive);
        if locked == Err(rustix::io::Errno::WOULDBLOCK) {
            continue;
        }
        // between its creation and its lock, another run may have taken it for a leftover
        if staged.as_file().metadata()?.nlink() > 0 {
            return Ok(staged);
        }
    }
    create(path)
}

fn create(path: &Path) -> io::Result<NamedTempFile> {
    let name = path.file_name().ok_or(ErrorKind::IsADirectory)?;
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    tempfile::Builder::new()
        .prefix(&prefix)
        .suffix(UNFINISHED)
        .rand_bytes(RANDOM_LETTERS)
        .permissions(Permissions::from_mode(NEW_FILE_MODE))
        .tempfile_in(folder_of(path))
}

/// Writes the data to the disk first, then the name, then the folder that holds the name: in this order only
/// a whole file is ever found under it, even after a power failure.
fn publish(staged: NamedTempFile, path: &Path) -> io::Result<()> {
    staged.as_file().sync_all()?;
    staged.persist(path).map_err(|refused| refused.error)?;
    // not every file system can, and the file is whole in any case
    let _ = File::open(folder_of(path)).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Removes leftovers of killed runs in `folder`, if `is_ours` accepts the names of their final files. Files
/// that must not be removed stay.
pub fn remove_leftovers(folder: &Path, is_ours: impl Fn(&str) -> bool) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.filter_map(Result::ok) {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().and_then(finished_name).is_some_and(&is_ours) {
            remove_unless_locked(&entry.path());
        }
    }
}

/// Final name of the unfinished file `name`: `a.exr` for `.a.exr.X.part`, where X is twelve letters and
/// digits now, and was `PID` or `PID-COUNT`.
fn finished_name(name: &str) -> Option<&str> {
    let (finished, tag) = name.strip_prefix('.')?.strip_suffix(UNFINISHED)?.rsplit_once('.')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_random = tag.len() == RANDOM_LETTERS && tag.bytes().all(|byte| byte.is_ascii_alphanumeric());
    let is_old =
        tag.split_once('-').map_or(is_number(tag), |(pid, count)| is_number(pid) && is_number(count));
    (is_random || is_old).then_some(finished)
}

fn remove_unless_locked(path: &Path) {
    let Ok(file) = OpenOptions::new().write(true).open(path) else { return };
    if flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
        drop(fs::remove_file(path)); // another run may have been faster
    }
}

/// Folder of `file`, which has a name.
pub(crate) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

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
    fn a_failed_file_leaves_nothing_but_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("folder");
        fs::create_dir(&target).unwrap();
        let text = write_bytes(&target, b"bytes").unwrap_err().to_string();
        assert!(text.contains("give a file"), "{text}");
        let file = folder.path().join("file");
        write_bytes(&file, b"old").unwrap();
        let half = |mut opened: &File| {
            opened.write_all(b"half").unwrap();
            Err(WriteError::new(&file, ErrorKind::StorageFull.into()))
        };
        write_whole(&file, half).unwrap_err();
        assert_eq!(fs::read(&file).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["file", "folder"]);
    }

    #[test]
    fn a_new_file_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        write_new_bytes(&path, b"first").unwrap();
        let error = write_new_bytes(&path, b"second").unwrap_err();
        assert_eq!(error.source.kind(), ErrorKind::AlreadyExists);
        assert_eq!((fs::read(&path).unwrap(), names(folder.path()).len()), (b"first".to_vec(), 1));
    }

    /// Runs in containers may share a folder and have one process id, as threads have.
    #[test]
    fn runs_of_one_process_id_do_not_meet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        std::thread::scope(|scope| {
            for writer in b'0'..b'8' {
                let path = &path;
                scope.spawn(move || {
                    for _ in 0..50 {
                        ensure_writable(path).unwrap();
                        write_bytes(path, &[writer; 5000]).unwrap();
                        remove_leftovers(path.parent().unwrap(), |_| true);
                    }
                });
            }
        });
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.len() == 5000 && bytes.iter().all(|byte| *byte == bytes[0]));
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn new_files_are_for_all_whom_the_mask_allows() {
        let folder = tempfile::tempdir().unwrap();
        let (staged, usual) = (folder.path().join("a"), folder.path().join("b"));
        write_bytes(&staged, b"").unwrap();
        fs::write(&usual, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&staged), mode(&usual));
    }

    #[test]
    fn what_killed_runs_left_goes_and_what_others_write_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.0001.exr");
        let live = stage(&path).unwrap();
        let live_name = live.path().file_name().unwrap().to_str().unwrap().to_owned();
        let leftovers = [".a.0001.exr.4711.part", ".a.0001.exr.4711-3.part", ".a.0001.exr.Xy12zQ34abCd.part"];
        let foreign = [
            ".a.0001.exr.part",
            ".a.0002.exr.4711.part",
            "a.0001.exr.4711.part",
            ".a.0001.exr.old.part",
            ".a.0001.exr.backup.part",
            ".a.0001.exr.my-copy.part",
        ];
        for name in leftovers.iter().chain(&foreign) {
            fs::write(folder.path().join(name), "half").unwrap();
        }
        remove_leftovers(folder.path(), |name| name == "a.0001.exr");
        let mut expected: Vec<&str> = foreign.into_iter().chain([live_name.as_str()]).collect();
        expected.sort_unstable();
        assert_eq!(names(folder.path()), expected);
        publish(live, &path).unwrap();
    }

    #[test]
    fn a_file_that_somebody_removes_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        let rounds = std::cell::Cell::new(0);
        let fill = |mut file: &File| {
            file.write_all(b"all").unwrap();
            if rounds.replace(rounds.get() + 1) == 0 {
                fs::read_dir(folder.path())
                    .unwrap()
                    .for_each(|e| fs::remove_file(e.unwrap().path()).unwrap());
            }
            Ok::<_, WriteError>(())
        };
        write_whole(&path, fill).unwrap();
        assert_eq!((fs::read(&path).unwrap(), rounds.get()), (b"all".to_vec(), 2));
    }
}
