//! Processes that are forked from one that has used the module: its threads are not carried over, and whoever waited for one of them
//! would wait for ever.

use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

use pyo3::PyResult;

use crate::errors::error;

/// The process that threads belong to: the first one that has started some.
pub struct Owner(AtomicU32);

impl Owner {
    /// That of threads which nobody has started yet.
    pub const fn nobody() -> Self {
        Self(AtomicU32::new(0))
    }

    /// That of threads which this process starts.
    pub fn this() -> Self {
        Self(AtomicU32::new(process::id()))
    }

    /// Returns true if this process is the owner.
    pub fn is_here(&self) -> bool {
        self.0.load(Ordering::Relaxed) == process::id()
    }

    /// Makes this process the owner if there is none yet.
    ///
    /// # Errors
    /// Another process is: this one was forked from it. `what` was done there.
    pub fn claim(&self, what: &str) -> PyResult<()> {
        let claimed = self.0.compare_exchange(0, process::id(), Ordering::Relaxed, Ordering::Relaxed);
        if claimed.is_ok() || self.is_here() { Ok(()) } else { Err(elsewhere(what)) }
    }
}

/// The error of a process in which threads are missing, because `what` was done before the fork.
pub fn elsewhere(what: &str) -> pyo3::PyErr {
    error(format!(
        "{what} in the process that this one was forked from, and its threads are not carried over: start processes anew, with the \
         method \"spawn\" or \"forkserver\" of multiprocessing"
    ))
}
