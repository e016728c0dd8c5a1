//! The thread that renders the frames of a `Render`, one each time that it is asked, and goes on with those of the next one where it can: a
//! program that renders frame by frame has each made of the samples of the one before.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use afterimage::denoise::{self, Denoiser};
use afterimage::film::Plane;
use afterimage::frame::{self, BackendKind, Finished, Need, RenderError, Renderer};
use afterimage::memory;
use afterimage::pilot;
use afterimage::scene::{Frames, Shot};
use afterimage::schedule::steps::{StepError, Walk};
use afterimage::schedule::{Origin, Rule, Step, schedule};
use afterimage::settings::{BasePlace, DenoiseQuality, Mode, Settings};
use pyo3::PyResult;

use crate::errors::{error, fault_of_ours};
use crate::forked::Owner;
use crate::frame::Picture;

/// All that a renderer is made of.
#[derive(Clone)]
pub struct Job {
    /// The shot.
    pub shot: Arc<Shot>,
    /// Settings, settled.
    pub settings: Settings,
    /// Quality of the denoised pictures; none if there are none.
    pub denoise: Option<DenoiseQuality>,
    /// Who answers the rays.
    pub backend: BackendKind,
    /// Number of threads; 0 for one a core.
    pub threads: usize,
}

impl Job {
    /// Returns true if a renderer of `other` is one of this job, too. A scene that was edited has another shot.
    fn is_same(&self, other: &Self) -> bool {
        let Self { shot, settings, denoise, backend, threads } = self;
        Arc::ptr_eq(shot, &other.shot)
            && *settings == other.settings
            && (*denoise, *backend, *threads) == (other.denoise, other.backend, other.threads)
    }

    /// Returns true if later frames may go on with the samples that are there when others are done.
    fn goes_on(&self) -> bool {
        self.settings.mode != Mode::Full && self.settings.base_place == BasePlace::First
    }
}

/// Frames that a `Render` asks for, and the way back to it.
pub struct Order {
    /// The frames.
    pub frames: Frames,
    /// State that both sides share.
    pub progress: Arc<Progress>,
    /// Requests for the next of them.
    pub requested: Receiver<Request>,
    /// Where they go. The renderer waits for nobody to take them.
    pub answers: Sender<Answer>,
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
    /// True if no frame is asked for any more.
    pub is_over: AtomicBool,
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
            RenderError::Trace(_) | RenderError::Textures(_) | RenderError::LightGroup(_) => {
                Self::Failed(error.to_string())
            }
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

/// Time for which a renderer whose frames are done is kept for others.
const LONGEST_REST: Duration = Duration::from_secs(60);

/// What is known of all renders, and of the threads that make them.
struct All {
    owner: Owner,
    /// The renders: the flag that cancels each, and the way to wake its thread.
    renders: Vec<(Weak<Progress>, Sender<Request>)>,
    threads: Vec<JoinHandle<()>>,
    /// The thread whose renderer may go on with other frames: one, or memory would fill with samples.
    kept: Option<Kept>,
    /// True once the interpreter ends: nobody would wait for a thread that is started now.
    is_over: bool,
}

/// A thread that takes orders. It ends when this is dropped and its frames are done.
struct Kept {
    job: Job,
    desk: Desk,
    /// The render for which it works, or has worked last.
    progress: Arc<Progress>,
    /// Disconnected when the thread has freed its memory.
    gone: Receiver<()>,
}

/// Where a thread takes orders: nothing, once it has ended. It is not locked while a process is forked that goes on to ask it: that process
/// is no owner.
type Desk = Arc<Mutex<Option<Sender<Order>>>>;

static ALL: Mutex<All> = Mutex::new(All {
    owner: Owner::nobody(),
    renders: Vec::new(),
    threads: Vec::new(),
    kept: None,
    is_over: false,
});

/// Only threads that hold the interpreter's lock come here: so no process is forked while it is locked.
fn all() -> MutexGuard<'static, All> {
    locked(&ALL)
}

/// Cancels all renders, and returns what waits until their threads have ended. None are started any more.
pub fn end_all() -> impl FnOnce() + Send {
    let mut all = all();
    all.is_over = true;
    let (mut threads, kept) = (std::mem::take(&mut all.threads), all.kept.take());
    let renders = std::mem::take(&mut all.renders);
    if all.owner.is_here() {
        drop(kept);
        for (progress, requests) in renders {
            if let Some(progress) = progress.upgrade() {
                progress.is_cancelled.store(true, Ordering::Relaxed);
            }
            // one that rests between two frames waits for this
            let _ = requests.send(Request::End);
        }
    } else {
        // those of the process that this one was forked from: nothing of them is here
        threads.drain(..).for_each(std::mem::forget);
        std::mem::forget((kept, renders));
    }
    move || {
        for thread in threads {
            // its panics were caught
            let _ = thread.join();
        }
    }
}

/// Lets go of what is kept of a shot that nobody can render any more.
pub fn let_go(shot: &Arc<Shot>) {
    let mut all = all();
    if all.owner.is_here() {
        drop(all.kept.take_if(|kept| Arc::ptr_eq(&kept.job.shot, shot)));
    }
}

/// Has `order` be made: by the thread that has made frames of this job before, if it has nothing else to do, or by a new one. It answers with
/// one frame for each [`Request::Frame`], and then with none.
pub fn start(job: Job, order: Order, requests: Sender<Request>) -> PyResult<()> {
    let mut all = all();
    if all.is_over {
        return Err(error("Python is about to end: nothing is rendered any more"));
    }
    all.owner.claim("a render was begun")?;
    all.renders.retain(|(progress, _)| progress.strong_count() > 0);
    all.renders.push((Arc::downgrade(&order.progress), requests));
    let kept = all.kept.take();
    let rests = kept.filter(|kept| kept.progress.is_over.load(Ordering::Relaxed));
    let (order, before) = match rests {
        Some(kept) if kept.job.is_same(&job) => {
            let progress = Arc::clone(&order.progress);
            match kept.ask(order) {
                None => {
                    all.kept = Some(Kept { progress, ..kept });
                    return Ok(());
                }
                Some(order) => (order, None),
            }
        }
        // its memory is waited for
        Some(Kept { gone, .. }) => (order, Some(gone)),
        None => (order, None),
    };
    let (sender, orders) = channel();
    let desk = Arc::new(Mutex::new(Some(sender)));
    let (here, gone) = channel();
    all.kept = job.goes_on().then(|| Kept {
        job: job.clone(),
        desk: Arc::clone(&desk),
        progress: Arc::clone(&order.progress),
        gone,
    });
    let open = Arc::downgrade(&desk);
    drop(desk);
    let work = move || {
        if let Some(before) = before {
            let _ = before.recv();
        }
        serve(job, order, orders, &open);
        drop(here);
    };
    let thread = thread::Builder::new().name(String::from("afterimage")).spawn(work);
    let thread = thread.map_err(|cause| error(no_threads(cause)))?;
    all.threads.retain(|thread| !thread.is_finished());
    all.threads.push(thread);
    Ok(())
}

impl Kept {
    /// Gives an order to the thread; gives it back if it has ended.
    fn ask(&self, order: Order) -> Option<Order> {
        match &*locked(&self.desk) {
            Some(orders) => orders.send(order).err().map(|back| back.0),
            None => Some(order),
        }
    }
}

/// Makes what is ordered, until nothing is for a while, or something fails.
fn serve(job: Job, first: Order, orders: Receiver<Order>, open: &Weak<Mutex<Option<Sender<Order>>>>) {
    let (orders, answers) = (Mutex::new(orders), Mutex::new(first.answers.clone()));
    let (mut next, mut job) = (Some(first), Some(job));
    while let (Some(order), Some(of)) = (next.take(), &job) {
        *locked(&answers) = order.answers.clone();
        let run = AssertUnwindSafe(|| work(of, order, &orders, &answers));
        let ended = catch_unwind(run).unwrap_or_else(|panic| Err(Failure::Failed(fault_of_ours(&*panic))));
        if let Some(desk) = open.upgrade() {
            locked(&desk).take();
        }
        // what was ordered just before the desk closed is made as well
        next = locked(&orders).try_recv().ok();
        if next.is_none() {
            // the scene goes first: whoever has the answer may count on its memory
            job = None;
        }
        // nobody may want it any more
        let _ = locked(&answers).send(ended.map(|()| None));
    }
}

/// Nothing that is locked so is left half changed.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn no_threads(cause: impl std::fmt::Display) -> String {
    format!("cannot start threads: {cause}; try fewer `threads`")
}

fn failed(cause: impl std::fmt::Display) -> Failure {
    Failure::Failed(cause.to_string())
}

/// Makes orders, one after the other, with one renderer.
fn work(
    job: &Job,
    first: Order,
    orders: &Mutex<Receiver<Order>>,
    answers: &Mutex<Sender<Answer>>,
) -> Result<(), Failure> {
    // nothing is built before a frame is asked for
    if first.requested.recv() != Ok(Request::Frame) {
        return Ok(());
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .thread_name(|index| format!("afterimage-{index}"))
        .build()
        .map_err(|cause| failed(no_threads(cause)))?;
    pool.install(move || {
        let settled = settled(job)?;
        all_orders(settled.as_ref().unwrap_or(job), first, orders, answers)
    })
}

/// The job with the counts that follow from the error that its frames may have, if that is stated.
fn settled(job: &Job) -> Result<Option<Job>, Failure> {
    let choice = pilot::choose(job.backend, &job.shot, &job.settings).map_err(failed)?;
    Ok(choice.map(|choice| {
        let (mut shot, mut settings) = (Shot::clone(&job.shot), job.settings.clone());
        choice.apply(&mut shot.scene, &mut settings);
        Job { shot: Arc::new(shot), settings, ..job.clone() }
    }))
}

/// Makes orders. The first frame of the first one is asked for already.
fn all_orders(
    job: &Job,
    first: Order,
    orders: &Mutex<Receiver<Order>>,
    answers: &Mutex<Sender<Answer>>,
) -> Result<(), Failure> {
    let rule = Rule::new(&job.shot, &job.settings);
    let steps_of = |order: &Order| schedule(order.frames.runs(), &rule, None, |_| false).map_err(failed);
    let mut steps = steps_of(&first)?;
    let quality = job.denoise;
    let settings = if quality.is_some() { denoise::with_guides(&job.settings) } else { job.settings.clone() };
    need(job, &settings, &steps).check(&memory::left()).map_err(failed)?;
    let denoiser = quality
        .map(|quality| Denoiser::new(rayon::current_num_threads(), quality))
        .transpose()
        .map_err(failed)?
        .map(|new| new.filtering_guides(denoise::has_rough_guides(&job.shot.scene, &job.settings)));
    let renderer = Renderer::with(job.backend, &job.shot.scene, &settings).map_err(failed)?;
    let mut line = Line { job, renderer, denoiser, walk: Walk::default(), done: Vec::new() };
    let mut order = first;
    loop {
        let rendered = line.render(&order, &steps);
        match &rendered {
            Ok(()) => {}
            // the renderer has forgotten what it had, and does for the next one
            Err(Failure::Cancelled) => line.done.clear(),
            Err(Failure::Failed(_)) => return rendered,
        }
        if !job.goes_on() {
            return rendered;
        }
        line.renderer.watch(None);
        line.renderer.stop_when(None);
        let _ = order.answers.send(rendered.map(|()| None));
        loop {
            let Ok(next) = locked(orders).recv_timeout(LONGEST_REST) else { return Ok(()) };
            *locked(answers) = next.answers.clone();
            order = next;
            if order.requested.recv() == Ok(Request::Frame) {
                break;
            }
        }
        steps = steps_of(&order)?;
    }
}

/// A renderer, and the frames that it has made.
struct Line<'a> {
    job: &'a Job,
    renderer: Renderer<'a>,
    denoiser: Option<Denoiser>,
    walk: Walk,
    /// Steps since the last base frame, of which the last has left its samples.
    done: Vec<Step>,
}

impl Line<'_> {
    /// Renders the frames of an order, one a request. The first one is asked for already.
    fn render(&mut self, order: &Order, steps: &[Step]) -> Result<(), Failure> {
        let Order { progress, requested, answers, .. } = order;
        watch(&mut self.renderer, progress);
        for step in &steps[self.count_done(steps)..] {
            progress.done.store(0, Ordering::Relaxed);
            progress.frame.store(step.frame, Ordering::Relaxed);
            let eyes = self.renderer.eyes();
            let load = |_: &mut Renderer<'_>| Ok::<(), Failure>(());
            let all: Vec<Finished> = eyes
                .iter()
                .map(|eye| self.walk.render(&mut self.renderer, *eye, *step, load))
                .collect::<Result<_, _>>()?;
            if step.origin == Origin::Nothing {
                self.done.clear();
            }
            self.done.push(*step);
            if !step.write {
                continue;
            }
            let pictures =
                all.into_iter().map(|finished| picture(finished, self.job, self.denoiser.as_mut()));
            let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
            if answers.send(Ok(Some(pictures))).is_err() || requested.recv() != Ok(Request::Frame) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Number of the first of these steps that are done: a run-up to frames that go on with the samples of the last one. What is done and
    /// asked for again is rendered again, from the base frame.
    fn count_done(&self, steps: &[Step]) -> usize {
        let is_done =
            |(done, step): (&Step, &Step)| !step.write && Step { write: done.write, ..*step } == *done;
        let fits = self.done.len() < steps.len() && self.done.iter().zip(steps).all(is_done);
        if fits { self.done.len() } else { 0 }
    }
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
