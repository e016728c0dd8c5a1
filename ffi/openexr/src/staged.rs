//! A file under a temporary name that becomes visible when it is whole.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::fd::IntoRawFd;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

/// A file that is being written beside its final place. Dropping it removes it.
pub(crate) struct StagedFile {
    final_path: PathBuf,
    temporary: PathBuf,
    file: Option<File>,
    first_failure: Mutex<Option<io::Error>>,
}

impl StagedFile {
    /// Creates `.NAME.PID-COUNT.part` in the folder of `path`.
    ///
    /// The same folder, because a rename is atomic within one file system only; hidden, so that a
    /// viewer that watches the folder leaves it alone; numbered, so that no two writers share it.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
            return Err(io::ErrorKind::IsADirectory.into());
        };
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{count}.part", std::process::id()));
        let temporary = path.with_file_name(hidden);
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&temporary)?;
        Ok(Self { final_path: path.to_owned(), temporary, file: Some(file), first_failure: Mutex::new(None) })
    }

    /// The name it has while it is written.
    pub(crate) fn temporary(&self) -> &Path {
        &self.temporary
    }

    /// Writes all bytes at that place; keeps the first error for [`Self::take_failure`].
    pub(crate) fn write_at(&self, bytes: &[u8], offset: u64) -> bool {
        let outcome = match &self.file {
            Some(file) => file.write_all_at(bytes, offset),
            None => Err(io::ErrorKind::NotConnected.into()),
        };
        match outcome {
            Ok(()) => true,
            Err(error) => {
                // A second failure says less than the first.
                self.lock_failure().get_or_insert(error);
                false
            }
        }
    }

    /// The first error of [`Self::write_at`].
    pub(crate) fn take_failure(&self) -> Option<io::Error> {
        self.lock_failure().take()
    }

    fn lock_failure(&self) -> std::sync::MutexGuard<'_, Option<io::Error>> {
        // An `Option` is whole even if a thread died while it held the lock.
        self.first_failure.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Closes the file and gives it its final name, replacing what was there.
    pub(crate) fn publish(mut self) -> io::Result<()> {
        if let Some(error) = self.take_failure() {
            return Err(error);
        }
        if let Some(file) = self.file.take() {
            close(file)?;
        }
        fs::rename(&self.temporary, &self.final_path)
    }
}

impl Drop for StagedFile {
    fn drop(&mut self) {
        drop(self.file.take());
        // After a rename there is nothing to remove; after an error there is nobody left to tell.
        drop(fs::remove_file(&self.temporary));
    }
}

/// Closes the file and says so if that fails: on network file systems a full disk shows only here.
fn close(file: File) -> io::Result<()> {
    let descriptor = file.into_raw_fd();
    // SAFETY: the descriptor is open, and `into_raw_fd` has just made us its only owner.
    match unsafe { libc::close(descriptor) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}
