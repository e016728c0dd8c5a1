//! Tells when nobody needs the picture at work any more.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::board::{Board, Job};
use super::watch::Watch;

/// Events that make a picture needless.
pub struct Needless {
    board: Arc<Board>,
    /// Files that the shot is made of.
    files: Watch,
    /// Pause between two checks of the files.
    pause: Duration,
    now: Mutex<Now>,
}

struct Now {
    job: Option<Job>,
    /// Time of the last check of the files.
    looked: Instant,
}

impl Needless {
    /// While `files` are as they were; they are looked at once in each `pause`.
    pub fn new(board: Arc<Board>, files: Watch, pause: Duration) -> Self {
        let now = Mutex::new(Now { job: None, looked: Instant::now() });
        Self { board, files, pause, now }
    }

    /// The worker begins with `job`.
    pub fn begin(&self, job: &Job) {
        self.now.lock().unwrap_or_else(PoisonError::into_inner).job = Some(job.clone());
    }

    /// Returns true if the picture at work is needless: the camera was moved on, or a file has changed.
    pub fn is_at_work(&self) -> bool {
        let mut now = self.now.lock().unwrap_or_else(PoisonError::into_inner);
        if now.job.as_ref().is_some_and(|job| self.board.is_over(job)) {
            return true;
        }
        if now.looked.elapsed() < self.pause {
            return false;
        }
        now.looked = Instant::now();
        self.files.has_changed()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn a_picture_of_files_that_have_changed_is_needless() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.toml");
        std::fs::write(&file, "1").unwrap();
        let files = Watch::new([file.clone()], &Watch::default());
        let board = Arc::new(Board::new(&file));
        let needless = Needless::new(board, files, Duration::ZERO);
        needless.begin(&Job::Frame(1));
        assert!(!needless.is_at_work());
        std::fs::write(&file, "12").unwrap();
        assert!(needless.is_at_work());
    }
}
