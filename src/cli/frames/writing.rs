//! Writes frames in the background: while one is packed and written, the next one is rendered.
//!
//! One thread writes the frame's files; the costly work of packing is done by the threads that render. It has
//! a copy of the film, because the renderer goes on with its own. No more than one frame is on its way, and
//! frames come in order.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::cli::failure::Failure;
use crate::film::{Film, Plane};
use crate::frame::Finished;
use crate::layers::Layers;

/// Pause of a thread that finds no work for the others, before it looks again.
const PAUSE: Duration = Duration::from_millis(1);

/// Picture of a frame as seen by one eye.
pub struct Seen {
    /// The rendering, with a film that holds all layers to write.
    pub finished: Finished,
    /// The denoised picture, if there is one.
    pub denoised: Option<[Plane; 3]>,
}

impl From<Finished> for Seen {
    fn from(finished: Finished) -> Self {
        Self { finished, denoised: None }
    }
}

/// A finished frame on its way to the writer.
pub struct Frame {
    /// Pictures of one eye, or of the left and the right one.
    pub seen: Vec<Seen>,
    /// True if it is written; otherwise it is only reported.
    pub write: bool,
    /// Seconds that copying its film took.
    pub copying: f64,
    /// Receives a message when the frame is packed, and only the disk is waited for.
    pub packed: Option<Sender<()>>,
}

/// Start of the current wait of the renderer for a frame to be written, if it waits.
#[derive(Default)]
pub struct Waiting(Mutex<Option<Instant>>);

impl Waiting {
    /// Seconds of the current wait that lie after `start`.
    pub fn seconds(&self, start: Instant) -> f64 {
        let since = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        since.map_or(0.0, |since| since.max(start).elapsed().as_secs_f64())
    }

    fn set(&self, since: Option<Instant>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = since;
    }
}

/// Accepts frames for writing, one after the other.
pub struct Behind<'w> {
    waiting: &'w Waiting,
    frames: Sender<Frame>,
    back: Receiver<Result<Vec<Film>, Failure>>,
    layers: Layers,
    /// Second films, one for each eye once there was a frame. `None` while they are with the writer.
    films: Option<Vec<Film>>,
}

/// Runs `work`, which gives frames to a [`Behind`], while `write` writes them on a thread of its own;
/// `layers` of them are kept for that. The first failure ends both. If both fail, that of the earlier frame
/// is returned.
pub fn behind(
    layers: Layers,
    write: impl FnMut(&mut Frame, &Waiting) -> Result<(), Failure> + Send,
    work: impl FnOnce(&mut Behind<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let waiting = Waiting::default();
    let ((frames, taken), (give_back, back)) = (mpsc::channel(), mpsc::channel());
    thread::scope(|scope| {
        let thread = thread::Builder::new().name("afterimage-write".to_owned());
        thread.spawn_scoped(scope, || write_all(taken, give_back, &waiting, write)).map_err(|error| {
            Failure::Failed(format!("cannot start a thread: {error}; try fewer --threads"))
        })?;
        let mut behind = Behind { waiting: &waiting, frames, back, layers, films: Some(Vec::new()) };
        let outcome = work(&mut behind);
        behind.wait().and(outcome)
    })
}

fn write_all(
    frames: Receiver<Frame>,
    back: Sender<Result<Vec<Film>, Failure>>,
    waiting: &Waiting,
    mut write: impl FnMut(&mut Frame, &Waiting) -> Result<(), Failure>,
) {
    for mut frame in frames {
        let outcome = write(&mut frame, waiting);
        let film = |seen: Seen| Arc::into_inner(seen.finished.film).unwrap_or_else(Film::empty);
        let films = frame.seen.into_iter().map(film).collect();
        let failed = outcome.is_err();
        // nobody waits for it if the run has ended otherwise
        if back.send(outcome.map(|()| films)).is_err() || failed {
            return;
        }
    }
}

impl Behind<'_> {
    /// Waits until the frame before is written, and takes this one.
    pub fn take(&mut self, seen: Vec<Seen>, write: bool) -> Result<(), Failure> {
        self.send(seen, write, None)
    }

    /// Takes a frame like [`take`](Self::take), and waits until it is packed. For callers that measure what
    /// comes next: it then shares the processors with nothing while the disk is waited for.
    pub fn take_and_pack(&mut self, seen: Vec<Seen>, write: bool) -> Result<(), Failure> {
        let (done, packed) = mpsc::channel();
        self.send(seen, write, Some(done))?;
        // of a frame that is not packed at all, because it failed or is not to be written, the other end is dropped
        let _ = wait_for(&packed);
        Ok(())
    }

    fn send(&mut self, mut seen: Vec<Seen>, write: bool, packed: Option<Sender<()>>) -> Result<(), Failure> {
        self.wait()?;
        let start = Instant::now();
        let mut films = self.films.take().unwrap_or_default();
        for Seen { finished, .. } in &mut seen {
            let mut film = films.pop().unwrap_or_else(Film::empty);
            if write {
                film.copy_from(&finished.film, |name| self.layers.has_plane(name));
            }
            // the renderer's own goes back to it
            finished.film = Arc::new(film);
        }
        let copying = start.elapsed().as_secs_f64();
        self.frames.send(Frame { seen, write, copying, packed }).map_err(|_| ended())
    }

    /// Waits until all frames that were taken are written.
    pub fn wait(&mut self) -> Result<(), Failure> {
        if self.films.is_none() {
            // whatever comes, it is not waited for again
            let films = self.films.insert(Vec::new());
            self.waiting.set(Some(Instant::now()));
            let written = wait_for(&self.back);
            self.waiting.set(None);
            *films = written.ok_or_else(ended)??;
        }
        Ok(())
    }
}

/// A panic in `work` must not end in a wait for the thread, which may wait for this one: see [`wait_for`].
impl Drop for Behind<'_> {
    fn drop(&mut self) {
        let _ = self.wait();
    }
}

fn ended() -> Failure {
    Failure::Failed(String::from("the thread that writes frames has ended"))
}

/// Receives the next value. This thread is one of those that pack frames, and may be the only one: it does
/// their work while it waits.
fn wait_for<T>(channel: &Receiver<T>) -> Option<T> {
    loop {
        let pause = if rayon::yield_now() == Some(rayon::Yield::Executed) { Duration::ZERO } else { PAUSE };
        match channel.recv_timeout(pause) {
            Ok(value) => return Some(value),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return None,
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::film::PlaneKind;
    use crate::pose::CameraPose;
    use crate::scene::camera::Projection;
    use crate::stats::FrameStats;
    use crate::trace::BackendKind;

    pub fn finished(frame: i32) -> Finished {
        let plane = |name| Plane::new(name, PlaneKind::Half, &[frame as f32; 6]);
        let planes = ["R", "G", "B", "Z", "P.X"].map(plane).to_vec();
        Finished {
            film: Arc::new(Film { width: 3, height: 2, planes }),
            stats: FrameStats { frame, ..FrameStats::default() },
            camera: CameraPose {
                eye: glam::Vec3::ZERO,
                right: glam::Vec3::X,
                up: glam::Vec3::Y,
                forward: glam::Vec3::NEG_Z,
                projection: Projection::Perspective,
                half_height: 1.0,
                shift: [0.0; 2],
                clip: crate::pose::Clip::NONE,
            },
            backend: BackendKind::Embree,
            about_layers: Vec::new().into(),
        }
    }

    /// Frames that were written: number, number of planes, and a value of the film.
    type Written = Vec<(i32, usize, f32)>;

    /// Renders frames 1 to 5, of which `bad` cannot be written and 2 is not to be. Returns the written frames
    /// and the outcome.
    fn run(bad: i32, threads: usize) -> (Written, Result<(), Failure>) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut written = Written::new();
        let write = |frame: &mut Frame, _: &Waiting| {
            let number = frame.seen[0].finished.stats.frame;
            // as packing does, which has one thread alone
            pool.install(|| rayon::join(|| (), || ()));
            if number == bad {
                return Err(Failure::Failed(format!("frame {number}")));
            }
            if frame.write {
                let film = &frame.seen[0].finished.film;
                written.push((number, film.planes.len(), film.planes[0].values.get(5)));
            }
            Ok(())
        };
        let outcome = pool.install(|| {
            behind(Layers::Z, write, |behind| {
                (1..=5).try_for_each(|frame| behind.take(vec![finished(frame).into()], frame != 2))
            })
        });
        (written, outcome)
    }

    #[test]
    fn frames_are_written_in_order_with_their_layers_alone() {
        for threads in [1, 3] {
            let (written, outcome) = run(0, threads);
            assert_eq!(outcome, Ok(()));
            assert_eq!(written, [1, 3, 4, 5].map(|frame| (frame, 4, frame as f32)));
        }
    }

    #[test]
    fn both_eyes_of_a_frame_come_together() {
        let mut written = Vec::new();
        let write = |frame: &mut Frame, _: &Waiting| {
            let value = |seen: &Seen| seen.finished.film.planes[0].values.get(0);
            written.push(frame.seen.iter().map(value).collect::<Vec<f32>>());
            Ok(())
        };
        let outcome = behind(Layers::NONE, write, |behind| {
            (1..=3).try_for_each(|frame| {
                behind.take([frame, frame + 10].map(finished).map(Seen::from).into(), true)
            })
        });
        assert_eq!((outcome, written), (Ok(()), vec![vec![1.0, 11.0], vec![2.0, 12.0], vec![3.0, 13.0]]));
    }

    #[test]
    fn a_failure_ends_the_run_and_what_was_written_stays() {
        for bad in [1, 3, 5] {
            let (written, outcome) = run(bad, 2);
            assert_eq!(outcome, Err(Failure::Failed(format!("frame {bad}"))));
            assert!(written.iter().all(|(frame, ..)| *frame < bad), "{written:?}");
        }
    }

    #[test]
    fn a_frame_that_is_on_its_way_is_written_before_a_later_failure_is_told() {
        let mut written = 0;
        let slow = |_: &mut Frame, _: &Waiting| {
            thread::sleep(Duration::from_millis(30));
            written += 1;
            Ok(())
        };
        let outcome = behind(Layers::NONE, slow, |behind| {
            behind.take(vec![finished(1).into()], true)?;
            Err(Failure::Failed("frame 2".into()))
        });
        assert_eq!((outcome, written), (Err(Failure::Failed("frame 2".into())), 1));
    }

    #[test]
    fn what_comes_after_packing_waits_for_no_disk() {
        let [is_packed, is_written] = [const { AtomicBool::new(false) }; 2];
        let write = |frame: &mut Frame, _: &Waiting| {
            thread::sleep(Duration::from_millis(20));
            is_packed.store(true, Ordering::SeqCst);
            frame.packed.take().unwrap().send(()).unwrap();
            thread::sleep(Duration::from_millis(300));
            is_written.store(true, Ordering::SeqCst);
            Ok(())
        };
        behind(Layers::NONE, write, |behind| {
            behind.take_and_pack(vec![finished(1).into()], true)?;
            assert!(is_packed.load(Ordering::SeqCst) && !is_written.load(Ordering::SeqCst));
            Ok(())
        })
        .unwrap();
        assert!(is_written.into_inner());
    }

    #[test]
    fn a_frame_that_is_never_packed_is_not_waited_for() {
        for (write, outcome) in [(false, Ok(())), (true, Err(Failure::Failed("full".into())))] {
            let fails = |frame: &mut Frame, _: &Waiting| {
                if frame.write { Err(Failure::Failed("full".into())) } else { Ok(()) }
            };
            let ended =
                behind(Layers::NONE, fails, |behind| behind.take_and_pack(vec![finished(1).into()], write));
            assert_eq!(ended, outcome);
        }
    }

    #[test]
    fn only_what_rendering_waits_for_counts() {
        let mut waited = Vec::new();
        let slow = |_: &mut Frame, waiting: &Waiting| {
            let start = Instant::now();
            thread::sleep(Duration::from_millis(60));
            waited.push(waiting.seconds(start));
            Ok(())
        };
        behind(Layers::NONE, slow, |behind| {
            behind.take(vec![finished(1).into()], true)?;
            thread::sleep(Duration::from_millis(200));
            behind.take(vec![finished(2).into()], true)
        })
        .unwrap();
        // the first one was done long before it was asked for, and nothing else was done beside the last one
        assert_eq!(waited[0], 0.0);
        assert!(waited[1] > 0.03, "{waited:?}");
    }
}
