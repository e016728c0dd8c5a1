//! Requests to stop: SIGINT (Ctrl-C) and SIGTERM (a farm, a shutdown) end a render between two bands of tiles.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::failure::Failure;

/// Signals that ask the program to stop. A second one ends it at once.
#[derive(Debug, Clone, Default)]
pub struct StopRequest {
    /// Number of the signal that came; 0: none.
    signal: Arc<AtomicUsize>,
}

impl StopRequest {
    /// Begins to listen. Before, signals end the program as usual.
    pub fn listen() -> Self {
        let request = Self::default();
        let was_asked = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // in this order: the flag is not yet set when the first one comes. Where a signal cannot be registered it ends the program
            let _ = flag::register_conditional_default(signal, Arc::clone(&was_asked));
            let _ = flag::register(signal, Arc::clone(&was_asked));
            let _ = flag::register_usize(signal, Arc::clone(&request.signal), signal.unsigned_abs() as usize);
        }
        request
    }

    /// Number of the signal that came, if one did.
    pub fn signal(&self) -> Option<u8> {
        u8::try_from(self.signal.load(Ordering::Relaxed)).ok().filter(|signal| *signal != 0)
    }

    /// Fails if a signal came. `remedy` says how to go on.
    pub fn check(&self, remedy: &str) -> Result<(), Failure> {
        match self.signal() {
            None => Ok(()),
            Some(signal) => {
                let name = match i32::from(signal) {
                    SIGINT => "SIGINT",
                    _ => "SIGTERM",
                };
                Err(Failure::Stopped(
                    signal,
                    format!(
                        "stopped by {name}: the frame at work is dropped, all before it are whole; {remedy}"
                    ),
                ))
            }
        }
    }
}
