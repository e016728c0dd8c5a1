//! Output file of OpenEXR's library, and the first error in writing it.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::sync::{Mutex, PoisonError};

/// Destination of the library's bytes.
pub(crate) struct Sink<'a> {
    file: &'a File,
    first_failure: Mutex<Option<io::Error>>,
}

impl<'a> Sink<'a> {
    pub(crate) fn new(file: &'a File) -> Self {
        Self { file, first_failure: Mutex::new(None) }
    }

    /// Writes all bytes at that place; keeps the first error for [`Self::take_failure`].
    pub(crate) fn write_at(&self, bytes: &[u8], offset: u64) -> bool {
        match self.file.write_all_at(bytes, offset) {
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
}
