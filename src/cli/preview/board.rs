//! What the worker and the threads that answer the page tell one another.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::scene::frames::{Frames, Run};
use crate::visible::visible;

/// Bytes of finished pictures that are kept, at most.
const MOST_BYTES: usize = 256 << 20;

/// A frame of a version of the shot.
#[derive(Debug, Clone)]
pub struct Shown {
    /// The bytes of a PNG file.
    pub png: Arc<Vec<u8>>,
    /// Of rendering it.
    pub seconds: f64,
}

/// The state of the preview, and who waits for what.
pub struct Board {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Counts what was loaded, with success or without.
    version: u64,
    title: String,
    /// Of the shot; empty as long as it has never been loaded.
    runs: Vec<Run>,
    rate: f64,
    /// What is odd about the shot, and what was decided for the user.
    notes: Vec<String>,
    error: Option<String>,
    pictures: BTreeMap<i32, Shown>,
    bytes: usize,
    /// Frames that are waited for, oldest first.
    wanted: VecDeque<i32>,
}

impl Board {
    /// Of a shot that is yet to be loaded.
    pub fn new(shot: &Path) -> Self {
        let title = shot.display().to_string();
        Self { state: Mutex::new(State { title, ..State::default() }), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // a panic elsewhere leaves nothing half done here
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The shot was loaded anew: what was rendered of the old one goes.
    pub fn loaded(&self, title: &str, frames: &Frames, (above, below): (i32, u32), notes: Vec<String>) {
        let mut state = self.state();
        *state = State {
            version: state.version + 1,
            title: title.to_owned(),
            runs: frames.runs().to_vec(),
            rate: f64::from(above) / f64::from(below),
            notes,
            ..State::default()
        };
        self.changed.notify_all();
    }

    /// The shot could not be loaded, or a frame of it not rendered: the page keeps what it shows.
    pub fn failed(&self, error: &str) {
        let mut state = self.state();
        if state.error.as_deref() == Some(error) {
            return;
        }
        state.version += 1;
        state.error = Some(error.to_owned());
        state.pictures.clear();
        state.bytes = 0;
        state.wanted.clear();
        self.changed.notify_all();
    }

    /// A frame that somebody waits for; `None` if nobody wants any for so long.
    pub fn next_wanted(&self, patience: Duration) -> Option<i32> {
        let state = self.state();
        let idle = |state: &mut State| state.wanted.is_empty();
        let (state, _) =
            self.changed.wait_timeout_while(state, patience, idle).unwrap_or_else(PoisonError::into_inner);
        state.wanted.front().copied()
    }

    /// The worker has rendered `frame`.
    pub fn rendered(&self, frame: i32, shown: Shown) {
        let mut state = self.state();
        state.wanted.retain(|wanted| *wanted != frame);
        while state.bytes + shown.png.len() > MOST_BYTES {
            let Some((_, oldest)) = state.pictures.pop_first() else { break };
            state.bytes -= oldest.png.len();
        }
        state.bytes += shown.png.len();
        state.pictures.insert(frame, shown);
        self.changed.notify_all();
    }

    /// Waits for `frame` of `version`. `None` if there is another version by now, or it takes too long.
    pub fn picture(&self, version: u64, frame: i32, patience: Duration) -> Option<Shown> {
        let until = Instant::now() + patience;
        let mut state = self.state();
        loop {
            let is_frame = state.runs.iter().any(|run| (run.first..=run.last).contains(&frame));
            if state.version != version || state.error.is_some() || !is_frame {
                return None;
            }
            if let Some(shown) = state.pictures.get(&frame) {
                return Some(shown.clone());
            }
            if !state.wanted.contains(&frame) {
                state.wanted.push_back(frame);
                self.changed.notify_all();
            }
            let left = until.checked_duration_since(Instant::now())?;
            (state, _) = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// For the page. Texts come from files: nothing in them is obeyed by who shows them.
    pub fn told(&self) -> Value {
        let state = self.state();
        let runs: Vec<[i64; 3]> =
            state.runs.iter().map(|run| [run.first.into(), run.last.into(), run.step.into()]).collect();
        let notes: Vec<_> = state.notes.iter().map(|note| visible(note)).collect();
        json!({
            "version": state.version, "title": visible(&state.title), "runs": runs, "rate": state.rate,
            "notes": notes, "error": state.error.as_deref().map(visible),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board() -> Board {
        let board = Board::new(Path::new("a.toml"));
        board.loaded("a", &Frames::between(1, 9), (24, 1), Vec::new());
        board
    }

    fn shown(bytes: usize) -> Shown {
        Shown { png: Arc::new(vec![0; bytes]), seconds: 0.0 }
    }

    #[test]
    fn who_waits_for_a_frame_gets_it() {
        let board = board();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| board.picture(1, 4, Duration::from_secs(60)));
            assert_eq!(board.next_wanted(Duration::from_secs(60)), Some(4));
            board.rendered(4, shown(3));
            assert_eq!(waiting.join().expect("no panic").map(|shown| shown.png.len()), Some(3));
        });
        assert_eq!(board.next_wanted(Duration::ZERO), None);
    }

    #[test]
    fn a_change_ends_all_waiting() {
        let board = board();
        for change in [
            |board: &Board| board.failed("broken"),
            |board: &Board| {
                board.loaded("b", &Frames::between(1, 9), (24, 1), Vec::new());
            },
        ] {
            let version = board.told()["version"].as_u64().expect("a number");
            std::thread::scope(|scope| {
                let waiting = scope.spawn(|| board.picture(version, 4, Duration::from_secs(60)));
                while board.next_wanted(Duration::from_millis(1)).is_none() && !waiting.is_finished() {}
                change(&board);
                assert!(waiting.join().expect("no panic").is_none());
            });
        }
        assert!(board.told()["error"].is_null());
        assert!(board.picture(3, 10, Duration::ZERO).is_none(), "no frame of the shot");
    }

    #[test]
    fn memory_of_pictures_is_bounded() {
        let board = board();
        for frame in 1..=3 {
            board.rendered(frame, shown(MOST_BYTES / 2));
        }
        let frames: Vec<i32> = board.state().pictures.keys().copied().collect();
        assert_eq!(frames, [2, 3]);
    }
}
