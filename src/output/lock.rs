//! Locks that several processes, on several machines, divide their work by.
//!
//! A lock is a file that the system locks for the process that has it open: when the process ends, however it ends, the lock is free.
//! The file itself is removed by the holder. One that a killed process left is no lock.

use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};

use super::WriteError;

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
    /// # Errors The file cannot be created, or the file system has no locks.
    pub fn take(path: &Path) -> Result<Option<Self>, WriteError> {
        let failed = |error| WriteError { path: path.to_owned(), source: error };
        for _ in 0..MOST_ATTEMPTS {
            let open = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
            let file = open.map_err(failed)?;
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
            if fs::metadata(path).is_ok_and(is_there) {
                // for people who wonder who has it
                let _ = file.set_len(0).and_then(|()| (&file).write_all(holder().as_bytes()));
                return Ok(Some(Self { path: path.to_owned(), _file: file }));
            }
        }
        Err(failed(ErrorKind::ResourceBusy.into()))
    }
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
