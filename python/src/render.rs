//! The function `render`, and the iterator that it returns.

use std::num::NonZeroUsize;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError, TryLockError};

use afterimage::frame::BackendKind;
use afterimage::scene::Frames;
use afterimage::settings::{Build, PixelRect, Settings, limits};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use pyo3::{PyTraverseError, PyVisit};

use crate::aside::wait;
use crate::convert;
use crate::errors::{Cancelled, error, guarded};
use crate::forked::{self, Owner};
use crate::frame::Frame;
use crate::keys;
use crate::scene::Scene;
use crate::worker::{self, Answer, Failure, Job, Order, Progress, Request};

/// Settings of a render that no shot file has.
struct Own {
    crop: Option<PixelRect>,
    audit: bool,
    threads: usize,
    backend: BackendKind,
    build: Option<Build>,
}

/// Renders frames of a scene, one each time that the iterator is asked for the next one.
#[pyfunction]
#[pyo3(signature = (scene, frames = None, mode = None, progress = None, **settings))]
pub fn render(
    scene: &Bound<'_, Scene>,
    frames: Option<Bound<'_, PyAny>>,
    mode: Option<Bound<'_, PyAny>>,
    progress: Option<Py<PyAny>>,
    settings: Option<Bound<'_, PyDict>>,
) -> PyResult<Render> {
    let py = scene.py();
    let settings = settings.unwrap_or_else(|| PyDict::new(py));
    let own = take_own(&settings)?;
    let frames = frames.map(|frames| convert::frames(&frames)).transpose()?;
    if let Some(mode) = mode {
        settings.set_item("mode", mode)?;
    }
    let tables = keys::tables_of_settings(&settings)?.to_string();
    let shot = scene.get().shot(py)?;
    let (settings, denoise) = guarded(|| shot.settings_with(&tables).map_err(|cause| cause.message))?;
    let chosen = Settings { crop: own.crop, audit: own.audit, ..settings };
    let word = |key: &str| format!("`{key}`");
    limits::check_window(&chosen, &word).map_err(error)?;
    limits::check_samples(&chosen, &word, &word("samples")).map_err(error)?;
    let build = own.build.unwrap_or_else(|| shot.build_that_pays(&chosen));
    let settings = Settings { build, ..chosen };
    let frames = frames.unwrap_or_else(|| shot.frames.clone());
    let job = Job { shot, settings, denoise, backend: own.backend, threads: own.threads };
    Render::start(job, frames, progress)
}

/// Takes the settings that no shot file has out of `settings`.
fn take_own(settings: &Bound<'_, PyDict>) -> PyResult<Own> {
    let take = |key: &str| -> PyResult<Option<Bound<'_, PyAny>>> {
        let value = settings.get_item(key)?;
        if value.is_some() {
            settings.del_item(key)?;
        }
        Ok(value.filter(|value| !value.is_none()))
    };
    let wanted = |key: &str, wanted: &str| error(format!("`{key}` must be {wanted}"));
    let crop = take("crop")?.map(|crop| {
        let stated = crop.extract::<String>().ok().and_then(|text| PixelRect::parse(&text));
        let four = crop.extract::<(i32, i32, u32, u32)>().ok();
        let four = four.map(|(x, y, width, height)| PixelRect { x, y, width, height });
        stated.or(four).ok_or_else(|| {
            wanted("crop", "(x, y, width, height) in pixels, from the picture's first to the right and down")
        })
    });
    let threads = take("threads")?.map(|threads| {
        let count = threads.extract::<NonZeroUsize>().ok().filter(|count| count.get() <= 4096);
        count.map(NonZeroUsize::get).ok_or_else(|| wanted("threads", "a whole number from 1 to 4096"))
    });
    let backend = take("backend")?.map(|backend| match backend.extract::<String>().as_deref() {
        Ok("embree") => Ok(BackendKind::Embree),
        Ok("rust") => Ok(BackendKind::Rust),
        _ => Err(wanted("backend", "\"embree\" or \"rust\"")),
    });
    let build = take("build")?.map(|build| match build.extract::<String>().as_deref() {
        Ok("auto") => Ok(None),
        Ok("best") => Ok(Some(Build::Best)),
        Ok("quick") => Ok(Some(Build::Quick)),
        _ => Err(wanted("build", "\"auto\", \"best\" or \"quick\"")),
    });
    let audit =
        take("audit")?.map(|audit| audit.extract::<bool>().map_err(|_| wanted("audit", "True or False")));
    Ok(Own {
        crop: crop.transpose()?,
        audit: audit.transpose()?.unwrap_or_default(),
        threads: threads.transpose()?.unwrap_or_default(),
        backend: backend.transpose()?.unwrap_or_default(),
        build: build.transpose()?.flatten(),
    })
}

/// The frames of a render, one after the other.
#[pyclass(frozen, module = "afterimage")]
pub struct Render {
    progress: Arc<Progress>,
    /// Progress function; none any more if the garbage collector has cleared it.
    callback: Mutex<Option<Py<PyAny>>>,
    requests: Sender<Request>,
    /// The way back from the thread that renders; none once all is over.
    answers: Mutex<Option<Answers>>,
    /// The process that has that thread.
    owner: Owner,
}

type Answers = Mutex<Receiver<Answer>>;

impl Render {
    fn start(job: Job, frames: Frames, callback: Option<Py<PyAny>>) -> PyResult<Self> {
        let progress = Arc::new(Progress::default());
        let (requests, requested) = channel();
        // nobody may take an answer any more: the thread must not wait for that
        let (answer, answers) = channel();
        let order = Order { frames, progress: Arc::clone(&progress), requested, answers: answer };
        worker::start(job, order, requests.clone())?;
        Ok(Self {
            progress,
            callback: Mutex::new(callback),
            requests,
            answers: Mutex::new(Some(Mutex::new(answers))),
            owner: Owner::this(),
        })
    }

    /// Lets the thread go on with other frames.
    fn end(&self) {
        self.progress.is_over.store(true, Ordering::Relaxed);
        if self.owner.is_here() {
            // one that rests between two frames waits for this
            let _ = self.requests.send(Request::End);
        }
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled.load(Ordering::Relaxed)
    }

    /// Waits for the answer to a request.
    fn answer(&self, py: Python<'_>, answers: &Answers) -> PyResult<Option<Frame>> {
        let mut told = None;
        loop {
            let answer = wait(py, answers);
            if self.is_cancelled() {
                return Err(raised(Failure::Cancelled));
            }
            match answer {
                Ok(Ok(Some(pictures))) => {
                    let frame = Frame::new(py, pictures)?;
                    self.tell(py, (frame.number, 1.0), &mut told)?;
                    return Ok(Some(frame));
                }
                Ok(Ok(None)) => return Ok(None),
                Ok(Err(failure)) => return Err(raised(failure)),
                Err(RecvTimeoutError::Timeout) => {
                    py.check_signals().inspect_err(|_| self.cancel())?;
                    let Progress { frame, done, tiles, .. } = &*self.progress;
                    let share =
                        done.load(Ordering::Relaxed) as f64 / tiles.load(Ordering::Relaxed).max(1) as f64;
                    self.tell(py, (frame.load(Ordering::Relaxed), share.min(1.0)), &mut told)?;
                }
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(error("the rendering thread ended without an answer"));
                }
            }
        }
    }

    /// The progress function, if there is one. It is not called under the lock: it may do anything with this render.
    fn callback(&self, py: Python<'_>) -> Option<Py<PyAny>> {
        let callback = self.callback.lock().unwrap_or_else(PoisonError::into_inner);
        callback.as_ref().map(|callback| callback.clone_ref(py))
    }

    /// Calls the callback if there is something new to tell.
    fn tell(&self, py: Python<'_>, now: (i32, f64), told: &mut Option<(i32, f64)>) -> PyResult<()> {
        let Some(callback) = self.callback(py) else { return Ok(()) };
        if self.progress.tiles.load(Ordering::Relaxed) == 0 || *told == Some(now) {
            return Ok(());
        }
        *told = Some(now);
        let said = callback.call1(py, now).inspect_err(|_| self.cancel())?;
        if said.bind(py).cast::<PyBool>().is_ok_and(|said| !said.is_true()) {
            self.cancel();
            return Err(raised(Failure::Cancelled));
        }
        Ok(())
    }
}

fn raised(failure: Failure) -> PyErr {
    match failure {
        Failure::Cancelled => Cancelled::new_err("the render was cancelled"),
        Failure::Failed(message) => error(message),
    }
}

#[pymethods]
impl Render {
    fn __iter__(render: Py<Self>) -> Py<Self> {
        render
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<Frame>> {
        if !self.owner.is_here() {
            return Err(forked::elsewhere("this render was begun"));
        }
        let mut answers = match self.answers.try_lock() {
            Ok(answers) => answers,
            Err(TryLockError::WouldBlock) => {
                return Err(error("another thread waits for a frame of this render: frames come one by one"));
            }
            Err(TryLockError::Poisoned(answers)) => answers.into_inner(),
        };
        if self.is_cancelled() {
            *answers = None;
            return Err(raised(Failure::Cancelled));
        }
        let Some(open) = &*answers else { return Ok(None) };
        // if nobody is there to hear it, the answer says so
        let _ = self.requests.send(Request::Frame);
        let answer = self.answer(py, open);
        if !matches!(answer, Ok(Some(_))) {
            *answers = None;
            self.end();
        }
        answer
    }

    /// What the garbage collector must know: a progress function may hold the render that it belongs to.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        // whoever has the lock holds the function, too
        let Ok(callback) = self.callback.try_lock() else { return Ok(()) };
        visit.call(callback.as_ref())
    }

    fn __clear__(&self) {
        let callback = self.callback.try_lock().ok().and_then(|mut callback| callback.take());
        // it may be the last one that holds this render: the lock is not held meanwhile
        drop(callback);
    }

    /// Cancels the render, from any thread: whoever waits for a frame gets `Cancelled` within a second.
    fn cancel(&self) {
        self.progress.is_cancelled.store(true, Ordering::Relaxed);
        self.end();
    }
}

impl Drop for Render {
    fn drop(&mut self) {
        // the thread ends by itself and frees the scene, or goes on with it
        self.cancel();
        if !self.owner.is_here() {
            // at the moment of the fork that thread may have had the lock of the channel, which nobody gives back here
            let answers = self.answers.get_mut().unwrap_or_else(PoisonError::into_inner);
            std::mem::forget(answers.take());
        }
    }
}
