//! The thread that renders the frames of one `Render`, one each time that it is asked.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Instant;

use afterimage::denoise::{self, Denoiser};
use afterimage::film::Plane;
use afterimage::frame::{self, BackendKind, Finished, Need, RenderError, Renderer};
use afterimage::memory;
use afterimage::scene::Shot;
use afterimage::schedule::steps::{StepError, Walk};
use afterimage::schedule::{Rule, Step, schedule};
use afterimage::settings::{DenoiseQuality, Settings};
use pyo3::PyResult;

use crate::errors::{error, fault_of_ours};
use crate::forked::Owner;
use crate::frame::Picture;

/// All that a render is made of.
pub struct Job {
    /// The shot.
    pub shot: Arc<Shot>,
    /// Settings, settled.
    pub settings: Settings,
    /// Quality of the denoised pictures; none if there are none.
    pub denoise: Option<DenoiseQuality>,
    /// Frames that are asked for.
    pub frames: afterimage::scene::Frames,
    /// Who answers the rays.
    pub backend: BackendKind,
    /// Number of threads; 0 for one a core.
    pub threads: usize,
}

/// State of a render that the asking and the rendering thread share.
#[derive(Default)]
pub struct Progress {
    /// True if nobody wants the frame any more.
    pub is_cancelled: AtomicBool,
    /// Number of the frame at work.
    pub frame: AtomicI32,
    /// Tiles of it that are done.
    pub done: AtomicUsize,
    /// All its tiles.
    pub tiles: AtomicUsize,
}

/// Why there is no frame.
pub enum Failure {
    /// It was cancelled.
    Cancelled,
    /// Description of what happened, and the remedy.
    Failed(String),
}

/// Answer to a request: a frame, or none if all are done.
pub type Answer = Result<Option<Vec<Picture>>, Failure>;

impl From<StepError> for Failure {
    fn from(error: StepError) -> Self {
        match error.error {
            RenderError::Stopped => Self::Cancelled,
            RenderError::Trace(_) | RenderError::Textures(_) => Self::Failed(error.to_string()),
        }
    }
}

/// What the thread of a render is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Request {
    /// The next frame is wanted.
    Frame,
    /// No more frames are wanted, though the iterator is still held.
    End,
}

/// The threads of all renders, each with the flag that cancels it and the way to wake it.
struct All {
    owner: Owner,
    threads: Vec<(Arc<Progress>, Sender<Request>, JoinHandle<()>)>,
    /// True once the interpreter ends: nobody would wait for a thread that is started now.
    is_over: bool,
}

static ALL: Mutex<All> = Mutex::new(All { owner: Owner::nobody(), threads: Vec::new(), is_over: false });

/// Only threads that hold the interpreter's lock come here: so no process is forked while it is locked.
fn all() -> MutexGuard<'static, All> {
    ALL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Cancels all renders, and returns what waits until their threads have ended. None are started any more.
pub fn end_all() -> impl FnOnce() + Send {
    let mut all = all();
    all.is_over = true;
    let mut threads = std::mem::take(&mut all.threads);
    if !all.owner.is_here() {
        // those of the process that this one was forked from: nothing of them is here
        threads.drain(..).for_each(std::mem::forget);
    }
    for (progress, requests, _) in &threads {
        progress.is_cancelled.store(true, Ordering::Relaxed);
        // one that rests between two frames waits for this
        let _ = requests.send(Request::End);
    }
    move || {
        for (.., thread) in threads {
            // its panics were caught
            let _ = thread.join();
        }
    }
}

/// Starts the thread. For each [`Request::Frame`] it answers with one frame; it ends with the last one, with an error, or when it is
/// told to, or the other ends are dropped. It waits for nobody to take its answers.
pub fn start(
    job: Job,
    progress: &Arc<Progress>,
    (requests, requested): (Sender<Request>, Receiver<Request>),
    answers: Sender<Answer>,
) -> PyResult<()> {
    let mut all = all();
    if all.is_over {
        return Err(error("Python is about to end: nothing is rendered any more"));
    }
    all.owner.claim("a render was begun")?;
    let shared = Arc::clone(progress);
    let work = move || {
        let run = AssertUnwindSafe(|| work(&job, &shared, requested, &answers));
        let ended = catch_unwind(run).unwrap_or_else(|panic| Err(Failure::Failed(fault_of_ours(&*panic))));
        // the scene goes first: whoever has the answer may count on its memory
        drop(job);
        let _ = answers.send(ended.map(|()| None));
    };
    let thread = thread::Builder::new().name(String::from("afterimage")).spawn(work);
    let thread = thread.map_err(|cause| error(no_threads(cause)))?;
    all.threads.retain(|(.., thread)| !thread.is_finished());
    all.threads.push((Arc::clone(progress), requests, thread));
    Ok(())
}

fn work(
    job: &Job,
    progress: &Arc<Progress>,
    requests: Receiver<Request>,
    answers: &Sender<Answer>,
) -> Result<(), Failure> {
    // nothing is built before a frame is asked for
    if requests.recv() != Ok(Request::Frame) {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .thread_name(|index| format!("afterimage-{index}"))
        .build()
        .map_err(|cause| failed(no_threads(cause)))?;
    pool.install(move || frames(job, progress, requests, answers))
}

fn no_threads(cause: impl std::fmt::Display) -> String {
    format!("cannot start threads: {cause}; try fewer `threads`")
}

fn failed(cause: impl std::fmt::Display) -> Failure {
    Failure::Failed(cause.to_string())
}

/// Renders the frames, one a request. The first one is asked for already.
fn frames(
    job: &Job,
    progress: &Arc<Progress>,
    requests: Receiver<Request>,
    answers: &Sender<Answer>,
) -> Result<(), Failure> {
    let rule = Rule::new(&job.shot, &job.settings);
    let steps = schedule(job.frames.runs(), &rule, None, |_| false).map_err(failed)?;
    let quality = job.denoise;
    let settings = if quality.is_some() { denoise::with_guides(&job.settings) } else { job.settings.clone() };
    need(job, &settings, &steps).check(&memory::left()).map_err(failed)?;
    let mut denoiser = quality
        .map(|quality| Denoiser::new(rayon::current_num_threads(), quality))
        .transpose()
        .map_err(failed)?
        .map(|new| new.filtering_guides(denoise::has_rough_guides(&job.shot.scene, &job.settings)));
    let mut renderer = Renderer::with(job.backend, &job.shot.scene, &settings).map_err(failed)?;
    watch(&mut renderer, progress);
    let mut walk = Walk::default();
    for step in &steps {
        progress.done.store(0, Ordering::Relaxed);
        progress.frame.store(step.frame, Ordering::Relaxed);
        let eyes = renderer.eyes().iter();
        let load = |_: &mut Renderer<'_>| Ok::<(), Failure>(());
        let all: Vec<Finished> =
            eyes.map(|eye| walk.render(&mut renderer, *eye, *step, load)).collect::<Result<_, _>>()?;
        if !step.write {
            continue;
        }
        let pictures = all.into_iter().map(|finished| picture(finished, job, denoiser.as_mut()));
        let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
        if answers.send(Ok(Some(pictures))).is_err() || requests.recv() != Ok(Request::Frame) {
            return Ok(());
        }
    }
    Ok(())
}

/// Has the renderer report its progress, and ask whether to go on.
fn watch(renderer: &mut Renderer<'_>, progress: &Arc<Progress>) {
    progress.tiles.store(renderer.tiles_a_frame(), Ordering::Relaxed);
    let shared = Arc::clone(progress);
    renderer.watch(Some(Arc::new(move |tiles| {
        shared.done.fetch_add(tiles, Ordering::Relaxed);
    })));
    let shared = Arc::clone(progress);
    renderer.stop_when(Some(Arc::new(move || shared.is_cancelled.load(Ordering::Relaxed))));
}

fn need(job: &Job, settings: &Settings, steps: &[Step]) -> Need {
    let threads = rayon::current_num_threads();
    let need = frame::need(&job.shot, settings, job.backend, steps.len(), threads);
    let need =
        if steps.iter().any(|step| step.keep) { frame::with_kept(need, &job.shot, settings) } else { need };
    // the arrays of a frame take about as much as a copy of it that is being written
    let need = frame::with_writing(need, &job.shot.scene, &job.settings);
    if job.denoise.is_some() { need.and(Need::new(denoise::need(settings))) } else { need }
}

/// Turns a finished frame into arrays, with the denoised picture if there is a denoiser.
fn picture(mut finished: Finished, job: &Job, denoiser: Option<&mut Denoiser>) -> Result<Picture, Failure> {
    let start = Instant::now();
    let denoised: Vec<Plane> = match denoiser {
        Some(denoiser) => {
            let number = finished.stats.frame;
            let cleaned = denoiser.denoise(&finished.film);
            let cleaned = cleaned.map_err(|cause| failed(format!("frame {number}: {cause}")))?;
            let seconds = start.elapsed().as_secs_f64();
            finished.stats.seconds.denoise += seconds;
            finished.stats.seconds.total += seconds;
            cleaned.into()
        }
        None => Vec::new(),
    };
    Picture::new(&finished, job.settings.layers, &denoised).map_err(failed)
}
