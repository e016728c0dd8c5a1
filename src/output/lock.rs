//! Locks that several processes, on several machines, divide their work by.
//!
//! A lock is a file that the system locks for the process that has it open: when the process ends, however it ends, the lock is free.
//! The file itself is removed by the holder. One that a killed process left is no lock.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, OFlags, flock};

use super::{WriteError, folder_of};

/// Maximum number of attempts to lock a file that its holder does not remove meanwhile.
const MOST_ATTEMPTS: usize = 100;

/// A lock that this process holds until it is dropped.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    /// Open as long as the lock is held.
    _file: File,
}

impl Lock {
    /// Takes the lock at `path`: `None` if another process, or another part of this one, has it.
    ///
    /// Nothing is ever written into a file that is there already, whatever it is: a leftover is removed, and a symbolic link is not
    /// followed.
    ///
    /// # Errors The file cannot be created, the file system has no locks, or something else than a file has its name
    /// ([`ErrorKind::AlreadyExists`]).
    pub fn take(path: &Path) -> Result<Option<Self>, WriteError> {
        let failed = |error| WriteError { path: path.to_owned(), source: error };
        for _ in 0..MOST_ATTEMPTS {
            let (file, is_new) = match open(path) {
                // its holder has removed it meanwhile
                Err(error) if error.kind() == ErrorKind::NotFound && folder_of(path).is_dir() => continue,
                opened => opened.map_err(failed)?,
            };
            match flock(&file, FlockOperation::NonBlockingLockExclusive) {
                Ok(()) => {}
                Err(rustix::io::Errno::WOULDBLOCK) => return Ok(None),
                // a file server says so of a file that its holder on another machine has removed
                Err(rustix::io::Errno::STALE) => continue,
                Err(error) => return Err(failed(error.into())),
            }
            // between its opening and its lock, the holder may have removed it, and somebody else made another
            let own = file.metadata().map_err(failed)?;
            let is_there = |found: fs::Metadata| (found.dev(), found.ino()) == (own.dev(), own.ino());
            if !fs::symlink_metadata(path).is_ok_and(is_there) {
                continue;
            }
            if is_new {
                // for people who wonder who has it
                let _ = (&file).write_all(holder().as_bytes());
                return Ok(Some(Self { path: path.to_owned(), _file: file }));
            }
            fs::remove_file(path).map_err(failed)?;
        }
        Err(failed(ErrorKind::ResourceBusy.into()))
    }
}

/// Opens the file of a lock, and tells whether it was not there before.
fn open(path: &Path) -> io::Result<(File, bool)> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        made => return made.map(|file| (file, true)),
    }
    let in_the_way =
        |what: &str| io::Error::new(ErrorKind::AlreadyExists, format!("{what} has the lock's name"));
    let opened = options.custom_flags(OFlags::NOFOLLOW.bits() as i32).open(path);
    let file = opened.map_err(|error| match rustix::io::Errno::from_io_error(&error) {
        Some(rustix::io::Errno::LOOP) => in_the_way("a symbolic link"),
        _ => error,
    })?;
    if file.metadata()?.is_file() { Ok((file, false)) } else { Err(in_the_way("something that is no file")) }
}

impl Drop for Lock {
    /// Removes the file while the lock is still held.
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Name of this machine, and number of this process.
fn holder() -> String {
    let machine = rustix::system::uname().nodename().to_string_lossy().into_owned();
    format!("{machine} {}\n", std::process::id())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn one_at_a_time_has_it_and_a_leftover_is_no_lock() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(".a.lock");
        fs::write(&path, "of a process that was killed").unwrap();
        let held = Lock::take(&path).unwrap().unwrap();
        assert!(fs::read_to_string(&path).unwrap().ends_with(&format!(" {}\n", std::process::id())));
        assert!(Lock::take(&path).unwrap().is_none());
        drop(held);
        assert!(!path.exists());
        assert!(Lock::take(&path).unwrap().is_some());
        assert!(Lock::take(&folder.path().join("no/such")).unwrap_err().to_string().contains("no/such"));
    }

    #[test]
    fn what_a_link_with_the_name_of_a_lock_points_to_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let (path, victim) = (folder.path().join(".a.lock"), folder.path().join("victim"));
        fs::write(&victim, "of somebody else").unwrap();
        let kept = || fs::read_to_string(&victim).unwrap() == "of somebody else";
        std::os::unix::fs::symlink("victim", &path).unwrap();
        let told = Lock::take(&path).unwrap_err();
        assert_eq!(told.source.kind(), ErrorKind::AlreadyExists);
        assert!(told.to_string().contains("a symbolic link has the lock's name"), "{told}");
        assert!(kept() && path.is_symlink());
        fs::remove_file(&path).unwrap();
        fs::hard_link(&victim, &path).unwrap();
        let held = Lock::take(&path).unwrap().unwrap();
        assert!(kept(), "a second name of the same file");
        drop(held);
        assert!(kept() && !path.exists());
        fs::create_dir(&path).unwrap();
        Lock::take(&path).unwrap_err();
    }

    #[test]
    fn many_that_take_and_remove_it_never_have_it_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(".a.lock");
        let (inside, taken) = (AtomicUsize::new(0), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..6 {
                scope.spawn(|| {
                    for _ in 0..300 {
                        let Some(_lock) = Lock::take(&path).unwrap() else { continue };
                        assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
                        taken.fetch_add(1, Ordering::SeqCst);
                        inside.fetch_sub(1, Ordering::SeqCst);
                    }
                });
            }
        });
        assert!(taken.into_inner() > 0);
    }
}
