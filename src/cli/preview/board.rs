//! State that the worker and the threads that answer the page share.

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::camera::ShotCamera;
use crate::scene::CameraTrack;
use crate::scene::frames::{Frames, Run};
use crate::visible::visible;

/// Bytes of finished pictures that are kept, at most.
const MOST_BYTES: usize = 256 << 20;

/// A frame of a version of the shot.
#[derive(Debug, Clone)]
pub struct ViewedPicture {
    /// The bytes of a PNG file.
    pub png: Arc<Vec<u8>>,
    /// Seconds that rendering it took.
    pub seconds: f64,
}

/// Quality of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// Small, and available at once.
    Coarse,
    /// Quality of the shot's frames.
    Full,
}

/// A frame seen by a free camera.
#[derive(Debug, Clone)]
pub struct View {
    pub frame: i32,
    /// The camera, in the space of the shot's files.
    pub camera: CameraTrack,
    pub detail: Detail,
}

/// Next task of the worker.
#[derive(Debug, Clone)]
pub enum Job {
    /// A frame of the shot.
    Frame(i32),
    /// The view with this number.
    View(u64, Arc<View>),
}

/// A shot that was loaded.
pub struct Loaded<'a> {
    pub title: &'a str,
    pub frames: &'a Frames,
    /// Frames per second: numerator and denominator.
    pub rate: (i32, u32),
    pub notes: Vec<String>,
    pub camera: ShotCamera,
    /// Size of its pictures, pixels.
    pub size: [u32; 2],
}

/// A requested view.
struct Wish {
    number: u64,
    /// Number of the page that waits: a page wants one view at a time.
    page: u64,
    view: Arc<View>,
    /// The picture, or the reason why there is none.
    shown: Option<Result<ViewedPicture, String>>,
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
    /// Frames of the shot; empty as long as it has never been loaded.
    runs: Vec<Run>,
    rate: f64,
    /// Warnings about the shot, and decisions made for the user.
    notes: Vec<String>,
    error: Option<String>,
    pictures: BTreeMap<i32, ViewedPicture>,
    bytes: usize,
    /// Requested frames, oldest first.
    wanted: VecDeque<i32>,
    /// Views that are requested, oldest first, or finished.
    wishes: Vec<Wish>,
    /// Number of views ever requested.
    numbers: u64,
    camera: Option<Arc<ShotCamera>>,
    size: [u32; 2],
}

impl State {
    /// Returns true if `frame` of `version` can be shown.
    fn has(&self, version: u64, frame: i32) -> bool {
        let is_frame = self.runs.iter().any(|run| (run.first..=run.last).contains(&frame));
        self.version == version && self.error.is_none() && is_frame
    }
}

impl Board {
    /// Creates a board for a shot that is yet to be loaded.
    pub fn new(shot: &Path) -> Self {
        let title = shot.display().to_string();
        Self { state: Mutex::new(State { title, ..State::default() }), changed: Condvar::new() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // a panic elsewhere leaves nothing half done here
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Replaces the shot by a newly loaded one, and drops the old one's pictures.
    pub fn loaded(&self, loaded: Loaded) {
        let (above, below) = loaded.rate;
        let mut state = self.state();
        *state = State {
            version: state.version + 1,
            title: loaded.title.to_owned(),
            runs: loaded.frames.runs().to_vec(),
            rate: f64::from(above) / f64::from(below),
            notes: loaded.notes,
            camera: Some(Arc::new(loaded.camera)),
            size: loaded.size,
            numbers: state.numbers,
            ..State::default()
        };
        self.changed.notify_all();
    }

    /// Records that the shot could not be loaded, or a frame of it not rendered. The page keeps what it
    /// shows.
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
        state.wishes.clear();
        self.changed.notify_all();
    }

    /// Waits for the next task; `None` if nothing is requested for `patience`. Coarse views come first: they
    /// delay other tasks only for a short time.
    pub fn next_job(&self, patience: Duration) -> Option<Job> {
        let waits = |wish: &&Wish| wish.shown.is_none();
        let idle =
            |state: &mut State| state.wanted.is_empty() && !state.wishes.iter().any(|wish| waits(&wish));
        let (state, _) = self
            .changed
            .wait_timeout_while(self.state(), patience, idle)
            .unwrap_or_else(PoisonError::into_inner);
        let coarse = |wish: &&Wish| waits(wish) && wish.view.detail == Detail::Coarse;
        let view = |wish: &Wish| Job::View(wish.number, Arc::clone(&wish.view));
        let coarse = state.wishes.iter().find(coarse).map(view);
        let frame = || state.wanted.front().map(|frame| Job::Frame(*frame));
        coarse.or_else(frame).or_else(|| state.wishes.iter().find(waits).map(view))
    }

    /// The worker has rendered `frame`.
    pub fn rendered(&self, frame: i32, shown: ViewedPicture) {
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
    pub fn picture(&self, version: u64, frame: i32, patience: Duration) -> Option<ViewedPicture> {
        let until = Instant::now() + patience;
        let mut state = self.state();
        loop {
            if !state.has(version, frame) {
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

    /// Returns true if the worker's current task is not needed any more: nobody waits for the full view with
    /// this number, or the frame delays a coarse view, which is to be shown soon.
    pub fn is_over(&self, job: &Job) -> bool {
        let state = self.state();
        match job {
            Job::View(_, view) if view.detail == Detail::Coarse => false,
            Job::View(number, _) => !state.wishes.iter().any(|wish| wish.number == *number),
            Job::Frame(_) => {
                let is_coarse = |wish: &Wish| wish.shown.is_none() && wish.view.detail == Detail::Coarse;
                state.wishes.iter().any(is_coarse)
            }
        }
    }

    /// Stores the rendered view with this number, or the reason why there is none. It may not be requested
    /// any more.
    pub fn viewed(&self, number: u64, shown: Result<ViewedPicture, String>) {
        if let Some(wish) = self.state().wishes.iter_mut().find(|wish| wish.number == number) {
            wish.shown = Some(shown);
            self.changed.notify_all();
        }
    }

    /// Waits for `view` of `version`, which `page` wants instead of any other. `None` if there is another version by now, the page
    /// wants another view, or it takes too long.
    pub fn view(
        &self,
        version: u64,
        page: u64,
        view: View,
        patience: Duration,
    ) -> Option<Result<ViewedPicture, String>> {
        let until = Instant::now() + patience;
        let mut state = self.state();
        if !state.has(version, view.frame) {
            return None;
        }
        state.numbers += 1;
        let number = state.numbers;
        state.wishes.retain(|wish| wish.page != page);
        state.wishes.push(Wish { number, page, view: Arc::new(view), shown: None });
        self.changed.notify_all();
        loop {
            let place = state.wishes.iter().position(|wish| wish.number == number)?;
            let left = until.checked_duration_since(Instant::now());
            if state.wishes[place].shown.is_some() || left.is_none() {
                return state.wishes.remove(place).shown;
            }
            let left = left.unwrap_or_default();
            (state, _) = self.changed.wait_timeout(state, left).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The camera of the shot, if `frame` of `version` is one that can be shown.
    pub fn camera(&self, version: u64, frame: i32) -> Option<Arc<ShotCamera>> {
        let state = self.state();
        state.camera.clone().filter(|_| state.has(version, frame))
    }

    /// State for the page, as JSON. Texts come from files: control sequences in them are made visible.
    pub fn told(&self) -> Value {
        let state = self.state();
        let runs: Vec<[i64; 3]> =
            state.runs.iter().map(|run| [run.first.into(), run.last.into(), run.step.into()]).collect();
        let notes: Vec<_> = state.notes.iter().map(|note| visible(note)).collect();
        json!({
            "version": state.version, "title": visible(&state.title), "runs": runs, "rate": state.rate,
            "notes": notes, "size": state.size, "error": state.error.as_deref().map(visible),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    fn board() -> Board {
        let board = Board::new(Path::new("a.toml"));
        load(&board, "a");
        board
    }

    fn load(board: &Board, title: &str) {
        let shot = scene::load(Path::new("scenes/city/city.toml"), false).expect("it is shipped");
        board.loaded(Loaded {
            title,
            frames: &Frames::between(1, 9),
            rate: (24, 1),
            notes: Vec::new(),
            camera: ShotCamera::new(&shot),
            size: [16, 9],
        });
    }

    fn view(board: &Board, detail: Detail) -> View {
        let camera = board.camera(1, 4).expect("it is loaded");
        View { frame: 4, camera: camera.track(&camera.at(4), 4).expect("a lens"), detail }
    }

    fn shown(bytes: usize) -> ViewedPicture {
        ViewedPicture { png: Arc::new(vec![0; bytes]), seconds: 0.0 }
    }

    #[test]
    fn what_nobody_waits_for_is_over() {
        let board = board();
        let patience = Duration::from_millis(1);
        let next = |detail| {
            // nobody renders it, and it is waited for as long as the page waits
            std::thread::scope(|scope| {
                let view = view(&board, detail);
                scope.spawn(|| board.view(1, 7, view, Duration::from_millis(300)));
                let job = board.next_job(Duration::from_secs(60)).expect("somebody waits");
                let is_over = [board.is_over(&job), board.is_over(&Job::Frame(3))];
                (job, is_over)
            })
        };
        let (full, is_over) = next(Detail::Full);
        assert_eq!(is_over, [false, false]);
        assert!(board.is_over(&full), "the page has gone");
        let (coarse, is_over) = next(Detail::Coarse);
        assert_eq!(is_over, [false, true], "frames wait for it");
        assert!(!board.is_over(&coarse) && !board.is_over(&Job::Frame(3)));
        assert!(board.next_job(patience).is_none());
    }

    #[test]
    fn who_waits_for_a_frame_gets_it() {
        let board = board();
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| board.picture(1, 4, Duration::from_secs(60)));
            assert!(matches!(board.next_job(Duration::from_secs(60)), Some(Job::Frame(4))));
            board.rendered(4, shown(3));
            assert_eq!(waiting.join().expect("no panic").map(|shown| shown.png.len()), Some(3));
        });
        assert!(board.next_job(Duration::ZERO).is_none());
    }

    #[test]
    fn a_page_has_one_view_and_coarse_ones_come_first() {
        let board = board();
        let [coarse, full] = [Detail::Coarse, Detail::Full].map(|detail| view(&board, detail));
        let wait = |page, view: &View| {
            let (board, view) = (&board, view.clone());
            move || {
                board
                    .view(1, page, view, Duration::from_secs(60))
                    .map(|shown| shown.expect("a picture").png.len())
            }
        };
        let waiting = || {
            let state = board.state();
            state.wishes.len() + state.wanted.len()
        };
        let has = |count| while waiting() < count {};
        std::thread::scope(|scope| {
            let given_up = scope.spawn(wait(7, &full));
            has(1);
            let newer = scope.spawn(wait(7, &full));
            assert_eq!(given_up.join().expect("no panic"), None, "the page wants another one");
            let frame = scope.spawn(|| board.picture(1, 2, Duration::from_secs(60)).is_some());
            has(2);
            let other = scope.spawn(wait(8, &coarse));
            has(3);
            let mut order = Vec::new();
            while let Some(job) = board.next_job(Duration::ZERO) {
                match job {
                    Job::Frame(frame) => {
                        order.push("frame");
                        board.rendered(frame, shown(1));
                    }
                    Job::View(number, view) => {
                        order.push(if view.detail == Detail::Coarse { "coarse" } else { "full" });
                        board.viewed(number, Ok(shown(order.len())));
                    }
                }
            }
            assert_eq!(order, ["coarse", "frame", "full"]);
            assert_eq!(
                (
                    other.join().expect("no panic"),
                    newer.join().expect("no panic"),
                    frame.join().expect("no panic")
                ),
                (Some(1), Some(3), true)
            );
        });
        assert!(board.state().wishes.is_empty());
    }

    #[test]
    fn a_change_ends_all_waiting() {
        let board = board();
        for change in [|board: &Board| board.failed("broken"), |board: &Board| load(board, "b")] {
            let version = board.told()["version"].as_u64().expect("a number");
            std::thread::scope(|scope| {
                let waiting = scope.spawn(|| board.picture(version, 4, Duration::from_secs(60)));
                while board.next_job(Duration::from_millis(1)).is_none() && !waiting.is_finished() {}
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
