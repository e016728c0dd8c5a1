//! The thread that renders the frames of one `Render`, one each time that it is asked.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};
use std::sync::{Arc, Mutex, PoisonError};
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

use crate::errors::fault_of_ours;
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

/// Threads of all renders, with the flag that ends each.
static ALL: Mutex<Vec<(Arc<Progress>, JoinHandle<()>)>> = Mutex::new(Vec::new());

/// Cancels all renders and waits until their threads have ended.
pub fn end_all() {
    let all = std::mem::take(&mut *ALL.lock().unwrap_or_else(PoisonError::into_inner));
    all.iter().for_each(|(progress, _)| progress.is_cancelled.store(true, Ordering::Relaxed));
    for (_, thread) in all {
        // its panics were caught
        let _ = thread.join();
    }
}

/// Starts the thread. For each message that `requests` brings it answers with one frame; it ends with the last one, with an error, or
/// when the other ends are dropped.
pub fn start(
    job: Job,
    progress: &Arc<Progress>,
    requests: Receiver<()>,
    answers: SyncSender<Answer>,
) -> Result<(), Failure> {
    let shared = Arc::clone(progress);
    let work = move || {
        let run = AssertUnwindSafe(|| work(&job, &shared, requests, &answers));
        let ended = catch_unwind(run).unwrap_or_else(|panic| Err(Failure::Failed(fault_of_ours(&*panic))));
        // the scene goes first: whoever has the answer may count on its memory
        drop(job);
        let _ = answers.send(ended.map(|()| None));
    };
    let thread = thread::Builder::new().name(String::from("afterimage")).spawn(work);
    let thread = thread.map_err(cannot_start)?;
    let mut all = ALL.lock().unwrap_or_else(PoisonError::into_inner);
    all.retain(|(_, thread)| !thread.is_finished());
    all.push((Arc::clone(progress), thread));
    Ok(())
}

fn work(
    job: &Job,
    progress: &Arc<Progress>,
    requests: Receiver<()>,
    answers: &SyncSender<Answer>,
) -> Result<(), Failure> {
    // nothing is built before a frame is asked for
    if requests.recv().is_err() {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .thread_name(|index| format!("afterimage-{index}"))
        .build()
        .map_err(cannot_start)?;
    pool.install(move || frames(job, progress, requests, answers))
}

fn cannot_start(cause: impl std::fmt::Display) -> Failure {
    Failure::Failed(format!("cannot start threads: {cause}; try fewer `threads`"))
}

fn failed(cause: impl std::fmt::Display) -> Failure {
    Failure::Failed(cause.to_string())
}

/// Renders the frames, one a request. The first one is asked for already.
fn frames(
    job: &Job,
    progress: &Arc<Progress>,
    requests: Receiver<()>,
    answers: &SyncSender<Answer>,
) -> Result<(), Failure> {
    let rule = Rule::new(&job.shot, &job.settings);
    let steps = schedule(job.frames.runs(), &rule, None, |_| false).map_err(failed)?;
    let quality = job.denoise;
    let settings = if quality.is_some() { denoise::with_guides(&job.settings) } else { job.settings.clone() };
    need(job, &settings, &steps).check(&memory::left()).map_err(failed)?;
    let mut denoiser = quality
        .map(|quality| Denoiser::new(rayon::current_num_threads(), quality))
        .transpose()
        .map_err(failed)?;
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
        if answers.send(Ok(Some(pictures))).is_err() || requests.recv().is_err() {
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
