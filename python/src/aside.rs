//! Work on a thread of its own, for which the thread that Python calls from waits.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::{error, fault_of_ours};
use crate::forked::Owner;

/// Time between two looks at signals and at progress.
pub const LOOK: Duration = Duration::from_millis(40);

/// The process that has the pool of threads that all such work shares.
static OWNER: Owner = Owner::nobody();

/// Does `work` on another thread, without the interpreter's lock.
///
/// # Errors
/// The message that `work` ends with, or that of its panic, as an `Error`; a process that was forked from one that did such work; an
/// exception that a signal raises, such as `KeyboardInterrupt`: then nobody waits for the work any more, and its result is dropped when it
/// is done.
pub fn aside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, String> + Send + 'static,
) -> PyResult<T> {
    OWNER.claim("a scene was loaded or made")?;
    let (send, receive) = sync_channel(1);
    let guarded = move || {
        let done = catch_unwind(AssertUnwindSafe(work));
        // nobody may want it any more
        let _ = send.send(done.unwrap_or_else(|panic| Err(fault_of_ours(&*panic))));
    };
    let thread = thread::Builder::new().name(String::from("afterimage")).spawn(guarded);
    thread.map_err(|cause| error(format!("cannot start a thread: {cause}")))?;
    let receive = Mutex::new(receive);
    loop {
        match wait(py, &receive) {
            Ok(done) => return done.map_err(error),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => return Err(error("a thread ended without a result")),
        }
    }
}

/// Waits for a message for the time of a [`LOOK`], without the interpreter's lock.
pub fn wait<T: Send>(py: Python<'_>, receive: &Mutex<Receiver<T>>) -> Result<T, RecvTimeoutError> {
    let receive = || receive.lock().map_err(|_| RecvTimeoutError::Disconnected)?.recv_timeout(LOOK);
    py.detach(receive)
}
