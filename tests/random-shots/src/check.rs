//! Tries a shot in every way that its claims can be tried.
//!
//! 1. It is refused with a reason, or rendered: never a panic, and no value that is not finite.
//! 2. The audit finds nothing in any frame: no sample that differs, no cell that shows another surface than its target sees.
//! 3. A second run that must give the same ([`Variation`]) gives the same pictures to the bit.
//! 4. Every frame is laid over the same one traced in full, which does not depend on how the audit asks ([`pictures`]):
//!    a sample that both have, in the same cell, of the same seed and at the same place, keeps the same light; surfaces have the
//!    same areas, and their light is as bright; and pixels of the same samples are the same to the bit.

use std::any::Any;
use std::cell::RefCell;
use std::fmt;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use afterimage::frame::{Finished, Renderer, Snapshot};
use afterimage::pilot;
use afterimage::scene::warnings::limits;
use afterimage::scene::{self, Shot};
use afterimage::schedule::steps::{StepError, Walk};
use afterimage::schedule::{self, Rule, Step};
use afterimage::settings::{Budget, Mode, Reuse, Settings};
use afterimage::stats::AuditCounts;
use rayon::ThreadPool;

use crate::fairness::relative_difference;
use crate::pictures::{self, Asked, Made, tells_how};
use crate::store::through_file;
use crate::trial::{Trial, Variation};

/// How a trial ended.
#[derive(Debug, Clone)]
pub enum Outcome {
    /// All held.
    Passed(Counts),
    /// The shot was refused, with a reason.
    Refused(String),
    /// Something did not.
    Failed(Failure),
}

/// What was looked at.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Frames with reuse; of two eyes, both.
    pub inferred: u64,
    /// Samples that the audit looked at.
    pub audited: u64,
    /// Those of them that held within a tolerance alone.
    pub on_edge: u64,
    /// Cells whose targets rounding decides.
    pub coverage_on_edge: u64,
    /// Surfaces in mirrors whose light was kept.
    pub mirrored: u64,
    /// Samples that a frame traced in full had as well.
    pub compared: u64,
    /// Cells that were laid over those of a frame in full.
    pub cells: u64,
    /// Those of them that showed another surface, where rounding decides.
    pub elsewhere: u64,
    /// Surfaces of frames whose light was compared with that in full.
    pub surfaces: u64,
    /// Pixels that had to be those of a frame in full to the bit.
    pub pixels: u64,
    /// Mean over the shot's frames of how much brighter they were than in full, relative to both; 0 where none was compared.
    pub brighter: f64,
}

impl Counts {
    /// Adds those of another shot, but for what is no count.
    pub fn add(&mut self, other: &Self) {
        let Self {
            inferred,
            audited,
            on_edge,
            coverage_on_edge,
            mirrored,
            compared,
            cells,
            elsewhere,
            surfaces,
            pixels,
            brighter: _,
        } = self;
        *inferred += other.inferred;
        *audited += other.audited;
        *on_edge += other.on_edge;
        *coverage_on_edge += other.coverage_on_edge;
        *mirrored += other.mirrored;
        *compared += other.compared;
        *cells += other.cells;
        *elsewhere += other.elsewhere;
        *surfaces += other.surfaces;
        *pixels += other.pixels;
    }
}

/// What did not hold.
#[derive(Debug, Clone)]
pub struct Failure {
    pub kind: Kind,
    /// Where, and how far.
    pub detail: String,
}

/// Which of the claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Panic,
    /// A renderer failed in a shot that was loaded.
    Render,
    /// Samples differ from what their rays see.
    Audit,
    /// Cells show another surface than their targets see.
    Coverage,
    NotFinite,
    Variation,
    /// A sample keeps other light than in full.
    Full,
    /// A surface has another area than in full.
    Area,
    /// It is brighter or darker than in full.
    Light,
    /// A pixel of the same samples is another one than in full.
    Pixels,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.kind, self.detail)
    }
}

impl Failure {
    /// What did not hold, and where.
    pub fn new(kind: Kind, detail: impl fmt::Display) -> Self {
        Self { kind, detail: detail.to_string() }
    }
}

/// Threads of the two runs.
#[derive(Debug)]
pub struct Pools {
    one: ThreadPool,
    three: ThreadPool,
}

impl Pools {
    /// # Panics
    /// If the system has no more threads.
    pub fn new() -> Self {
        let pool = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("the system has threads")
        };
        Self { one: pool(1), three: pool(3) }
    }
}

impl Default for Pools {
    fn default() -> Self {
        Self::new()
    }
}

thread_local! {
    /// What the last panic of this thread said, and where; none outside of a check.
    static SAID: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Panics of a check are results: they are told with its shot. Others are told as ever.
fn keep_panics_of_checks() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            let is_of_check =
                SAID.with_borrow_mut(|said| said.as_mut().map(|said| *said = info.to_string()).is_some());
            if !is_of_check {
                usual(info);
            }
        }));
    });
}

/// Tries a shot, whose files are written to `folder`.
pub fn check(trial: &Trial, folder: &Path, pools: &Pools) -> Outcome {
    keep_panics_of_checks();
    SAID.set(Some(String::new()));
    let outcome = panic::catch_unwind(AssertUnwindSafe(|| check_unguarded(trial, folder, pools)));
    let said = SAID.take().unwrap_or_default();
    outcome.unwrap_or_else(|panic| Outcome::Failed(Failure::new(Kind::Panic, panic_text(said, &*panic))))
}

/// What was `said`, or what the panic of another thread brings.
fn panic_text(said: String, panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| text.to_string()));
    if said.is_empty() { text.unwrap_or_default() } else { said }
}

fn check_unguarded(trial: &Trial, folder: &Path, pools: &Pools) -> Outcome {
    if let Err(error) = trial.write(folder) {
        return Outcome::Failed(Failure::new(Kind::Render, error));
    }
    // all copies that rest share their mesh: those of a shot as small would be put into world space otherwise
    let mut shot = match pools.one.install(|| scene::load_sharing(&folder.join("shot.toml"), false, 0)) {
        Ok(shot) => shot,
        Err(error) => return Outcome::Refused(error.to_string()),
    };
    if let Err(failure) = choose_counts(trial, &mut shot, pools) {
        return Outcome::Failed(failure);
    }
    let rule = Rule { full: false, shot_last: Some(shot.frames.last()), ..Rule::new(&shot, &shot.settings) };
    let steps = match schedule::schedule(shot.frames.runs(), &rule, None, |_| false) {
        Ok(steps) => steps,
        Err(error) => return Outcome::Refused(error.to_string()),
    };
    match try_all(trial, (&shot, &rule, &steps), folder, pools) {
        Ok(counts) => Outcome::Passed(counts),
        Err(failure) => Outcome::Failed(failure),
    }
}

/// Has the shot be of the counts that follow from its error, if it states one and if they are few enough to be tried. They do not depend on
/// threads.
fn choose_counts(trial: &Trial, shot: &mut Shot, pools: &Pools) -> Result<(), Failure> {
    const MOST: Counted = Counted { samples: 3, paths: 6 };
    let choose = |pool: &ThreadPool| {
        let choice = pool.install(|| pilot::choose(trial.backend, shot, &shot.settings));
        choice.map_err(|error| Failure::new(Kind::Render, error))
    };
    let choices = [choose(&pools.one)?, choose(&pools.three)?];
    let [Some(one), Some(three)] = choices else { return Ok(()) };
    if one != three {
        return Err(Failure::new(Kind::Variation, format!("counts by one thread: {one}; by three: {three}")));
    }
    if one.counts.samples <= MOST.samples && one.counts.paths <= MOST.paths {
        let mut settings = shot.settings.clone();
        one.apply(&mut shot.scene, &mut settings);
        shot.settings = settings;
    }
    Ok(())
}

/// Counts above which a shot takes too long.
struct Counted {
    samples: u32,
    paths: u32,
}

fn try_all(
    trial: &Trial,
    (shot, rule, steps): (&Shot, &Rule<'_>, &[Step]),
    folder: &Path,
    pools: &Pools,
) -> Result<Counts, Failure> {
    let audited = Settings { audit: true, ..shot.settings.clone() };
    let mut counts = Counts::default();
    let first = pools.three.install(|| {
        let mut brighter = vec![];
        let mut in_full =
            renderer(trial, shot, &Settings { mode: Mode::Full, audit: false, ..shot.settings.clone() })?;
        // where single floats are too coarse for what is shown, the program says so, and the audit is not asked
        let is_fine = limits::of_camera(&shot.scene, &shot.settings).is_empty();
        let asked = Asked { is_fine, is_defined: !trial.has_coinciding_models() };
        let mut renderer = renderer(trial, shot, &audited)?;
        let run = run(
            &mut renderer,
            steps,
            |_, _| Ok(()),
            |renderer, frames| {
                check_audit(is_fine, frames, &mut counts)?;
                compare_with_full(shot, asked, (renderer, frames), &mut in_full, (&mut counts, &mut brighter))
            },
        )?;
        counts.brighter = brighter.iter().sum::<f64>() / brighter.len().max(1) as f64;
        Ok(run)
    })?;
    if trial.has_coinciding_movers() {
        return Ok(counts);
    }
    let second = pools.one.install(|| vary(trial, (shot, rule, steps), folder))?;
    for frame in &second {
        let same = first.iter().find(|other| (other.number, other.eye) == (frame.number, frame.eye));
        let Some(same) = same else { continue };
        if let Some(plane) = first_difference(same, frame, trial.variation) {
            let detail = format!("{:?}: frame {}, {plane}", trial.variation, frame.number);
            return Err(Failure::new(Kind::Variation, detail));
        }
    }
    Ok(counts)
}

/// Whether the audit has found nothing in any of `frames`, and adds what it has looked at to `counts`.
fn check_audit(is_fine: bool, frames: &[Frame], counts: &mut Counts) -> Result<(), Failure> {
    for frame in frames {
        counts.inferred += u64::from(frame.is_inferred);
        let Some(audit) = frame.audit else { continue };
        let AuditCounts { checked, differing, on_edge, coverage, coverage_on_edge, mirrored, .. } = audit;
        counts.audited += checked;
        counts.on_edge += on_edge;
        counts.coverage_on_edge += coverage_on_edge;
        counts.mirrored += mirrored;
        if audit.wrong() > 0 && is_fine {
            let kind = if differing > 0 { Kind::Audit } else { Kind::Coverage };
            let detail = format!(
                "frame {}: of {checked} samples {differing} differ; {coverage} cells show another surface than their targets see, \
                 {coverage_on_edge} where rounding decides",
                frame.number
            );
            return Err(Failure::new(kind, detail));
        }
    }
    Ok(())
}

fn renderer<'s>(trial: &Trial, shot: &'s Shot, settings: &Settings) -> Result<Renderer<'s>, Failure> {
    let mut renderer = Renderer::with(trial.backend, &shot.scene, settings)
        .map_err(|error| Failure::new(Kind::Render, error))?;
    renderer.prove_ahead(trial.ahead);
    Ok(renderer)
}

/// A frame as one eye has seen it.
#[derive(Debug)]
pub struct Frame {
    pub number: i32,
    /// Number of the eye.
    pub eye: usize,
    pub is_inferred: bool,
    pub audit: Option<AuditCounts>,
    pub planes: Vec<Plane>,
}

/// A name, and the bits of the values of all pixels.
pub type Plane = (String, Vec<u32>);

impl Frame {
    /// # Errors
    /// If a value is not finite.
    fn new(frame: i32, eye: usize, finished: &Finished) -> Result<Self, Failure> {
        let pixels = (finished.film.width * finished.film.height) as usize;
        let mut planes = vec![];
        for plane in &finished.film.planes {
            let values: Vec<f32> = (0..pixels).map(|pixel| plane.values.get(pixel)).collect();
            if let Some(pixel) = values.iter().position(|value| !value.is_finite()) {
                let detail = format!("frame {frame}: {} is {} in pixel {pixel}", plane.name, values[pixel]);
                return Err(Failure::new(Kind::NotFinite, detail));
            }
            planes.push((plane.name.to_string(), values.into_iter().map(f32::to_bits).collect()));
        }
        let stats = &finished.stats;
        Ok(Self { number: frame, eye, is_inferred: stats.mode == "reproject", audit: stats.audit, planes })
    }

    /// Light of the whole picture.
    fn light(&self) -> f64 {
        let colors = self.planes.iter().filter(|(name, _)| ["R", "G", "B"].contains(&name.as_str()));
        colors.flat_map(|(_, bits)| bits).map(|bits| f64::from(f32::from_bits(*bits))).sum()
    }
}

/// Renders the frames of `steps`. `before` is called before each, with its number in the list; `after` after each, with what the eyes
/// have seen.
fn run(
    renderer: &mut Renderer<'_>,
    steps: &[Step],
    mut before: impl FnMut(&mut Renderer<'_>, usize) -> Result<(), Failure>,
    mut after: impl FnMut(&Renderer<'_>, &[Frame]) -> Result<(), Failure>,
) -> Result<Vec<Frame>, Failure> {
    let mut walk = Walk::default();
    let mut frames = vec![];
    for (number, step) in steps.iter().enumerate() {
        before(renderer, number)?;
        let first = frames.len();
        for eye in renderer.eyes() {
            let finished = walk.render(renderer, *eye, *step, |_| Ok::<(), StepError>(()));
            let finished = finished.map_err(|failure| Failure::new(Kind::Render, failure))?;
            frames.push(Frame::new(step.frame, *eye as usize, &finished)?);
        }
        after(renderer, &frames[first..])?;
    }
    Ok(frames)
}

/// Renders `steps`, and looks at nothing meanwhile.
fn run_through(
    renderer: &mut Renderer<'_>,
    steps: &[Step],
    before: impl FnMut(&mut Renderer<'_>, usize) -> Result<(), Failure>,
) -> Result<Vec<Frame>, Failure> {
    run(renderer, steps, before, |_, _| Ok(()))
}

/// The second run. It is not audited, so that it also tells whether the audit changes anything.
fn vary(
    trial: &Trial,
    (shot, rule, steps): (&Shot, &Rule<'_>, &[Step]),
    folder: &Path,
) -> Result<Vec<Frame>, Failure> {
    let mut settings = shot.settings.clone();
    let turn = trial.turn.min(steps.len().saturating_sub(1));
    match trial.variation {
        Variation::Threads => run_through(&mut renderer(trial, shot, &settings)?, steps, |_, _| Ok(())),
        Variation::NoTags => run_through(&mut renderer(trial, shot, &settings)?, steps, |renderer, _| {
            renderer.forget_tags();
            Ok(())
        }),
        Variation::NoTrees => {
            settings.tree_memory = 0;
            run_through(&mut renderer(trial, shot, &settings)?, steps, |_, _| Ok(()))
        }
        Variation::Store => {
            // what is kept for later lies in memory, and not in the file
            let turn = if steps[..turn].iter().any(|step| step.keep) { usize::MAX } else { turn };
            run_through(&mut renderer(trial, shot, &settings)?, steps, |renderer, number| {
                if number == turn {
                    let again = through_file(renderer, &shot.scene, folder);
                    let snapshot: Option<Snapshot> =
                        again.map_err(|error| Failure::new(Kind::Render, error))?;
                    if let Some(snapshot) = snapshot {
                        // what the renderer remembers is of another frame by then
                        render_all(renderer, steps.last().map_or(0, |step| step.frame))?;
                        renderer.restore(snapshot);
                    }
                }
                Ok(())
            })
        }
        Variation::Chunk => {
            let frames = shot.frames.list();
            let from = frames[turn.min(frames.len() - 1)];
            let finished = |frame| frame < from;
            let later = schedule::schedule(shot.frames.runs(), rule, None, finished);
            let later = later.map_err(|error| Failure::new(Kind::Render, error))?;
            run_through(&mut renderer(trial, shot, &settings)?, &later, |_, _| Ok(()))
        }
    }
}

/// The first plane that is not the same to the bit. What counts rays, or when something was asked, may be otherwise where the
/// variation says so.
fn first_difference(a: &Frame, b: &Frame, variation: Variation) -> Option<String> {
    let counts_alone = |name: &str| match variation {
        Variation::Threads => false,
        Variation::NoTags | Variation::NoTrees => tells_how(name) && name.starts_with("rays"),
        Variation::Store | Variation::Chunk => tells_how(name),
    };
    let differs = |((name, a), (other, b)): (&Plane, &Plane)| {
        let at = a.iter().zip(b).position(|(a, b)| a != b);
        let is_same = name == other && a.len() == b.len() && at.is_none();
        (!is_same && !counts_alone(name)).then(|| {
            let pixel = at.unwrap_or(0);
            let values =
                [a, b].map(|values| values.get(pixel).map_or(f32::NAN, |bits| f32::from_bits(*bits)));
            format!("{name}, pixel {pixel}: {} and {}", values[0], values[1])
        })
    };
    a.planes.iter().zip(&b.planes).find_map(differs)
}

/// Compares a frame that has just been rendered with the same one traced in full. `brighter` gets how much brighter it is.
fn compare_with_full(
    shot: &Shot,
    asked: Asked,
    (renderer, frames): (&Renderer<'_>, &[Frame]),
    in_full: &mut Renderer<'_>,
    (counts, brighter): (&mut Counts, &mut Vec<f64>),
) -> Result<(), Failure> {
    // an eye may be made of the samples of another one in base frames as well
    let is_base = !frames.iter().any(|frame| frame.is_inferred);
    if is_base && frames.len() == 1 {
        return Ok(());
    }
    let (Some((moment, samples)), Some(first)) = (renderer.samples(), frames.first()) else { return Ok(()) };
    if moment.frame != first.number {
        return Ok(());
    }
    let mut full = vec![];
    for frame in frames {
        let eye = in_full.eyes()[frame.eye];
        let finished = in_full.render_eye(eye, frame.number, false);
        let finished = finished.map_err(|error| Failure::new(Kind::Render, error))?;
        full.push(Frame::new(frame.number, frame.eye, &finished)?);
    }
    let Some((_, samples_in_full)) = in_full.samples() else { return Ok(()) };
    let inferred = Made { samples: &samples, frames };
    let full = Made { samples: &samples_in_full, frames: &full };
    let compared = pictures::compare(shot, asked, inferred, full)?;
    counts.compared += compared.samples;
    counts.cells += compared.cells;
    counts.elsewhere += compared.elsewhere;
    counts.surfaces += compared.surfaces;
    counts.pixels += compared.pixels;
    if asked.is_fine && shot.settings.reuse == Reuse::Target && shot.settings.budget == Budget::None {
        let both = frames.iter().zip(full.frames).map(|(frame, full)| [frame.light(), full.light()]);
        brighter.extend(both.filter_map(relative_difference));
    }
    Ok(())
}

/// Renders a frame in full, as each eye sees it.
fn render_all(renderer: &mut Renderer<'_>, frame: i32) -> Result<(), Failure> {
    for eye in renderer.eyes() {
        let rendered = renderer.render_eye(*eye, frame, false);
        rendered.map_err(|error| Failure::new(Kind::Render, error))?;
    }
    Ok(())
}
