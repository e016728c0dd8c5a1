//! Tries a shot in every way that its claims can be tried.
//!
//! 1. It is refused with a reason, or rendered: never a panic, and no value that is not finite.
//! 2. The audit finds nothing in any frame.
//! 3. A second run that must give the same ([`Variation`]) gives the same pictures to the bit.
//! 4. Where a sample of the last frame is one that a frame traced in full has as well, in the same cell, of the same seed and at
//!    the same place, both keep the same light. That does not depend on how the audit asks.

use std::any::Any;
use std::cell::RefCell;
use std::fmt;
use std::panic::{self, AssertUnwindSafe};
use std::path::Path;
use std::sync::Once;

use afterimage::frame::{Renderer, Snapshot};
use afterimage::lanes::LANES;
use afterimage::samples::{EMPTY, SampleStore, Tile};
use afterimage::scene::warnings::limits;
use afterimage::scene::{self, Shot};
use afterimage::schedule::steps::{StepError, Walk};
use afterimage::schedule::{self, Rule, Step};
use afterimage::settings::{Budget, Mode, Settings};
use rayon::ThreadPool;

use crate::store::through_file;
use crate::trial::{Trial, Variation};

/// Of a colour's largest part: how far kept light may be from that of a frame traced in full. Both are rounded to half floats.
const COLOR_TOLERANCE: f32 = 2e-3;

/// Light below this is black.
const DARKEST: f32 = 1e-3;

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
    /// Samples that a frame traced in full had as well.
    pub compared: u64,
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
    Audit,
    NotFinite,
    Variation,
    Full,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}: {}", self.kind, self.detail)
    }
}

impl Failure {
    fn new(kind: Kind, detail: impl fmt::Display) -> Self {
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
    let shot = match pools.one.install(|| scene::load_sharing(&folder.join("shot.toml"), false, 0)) {
        Ok(shot) => shot,
        Err(error) => return Outcome::Refused(error.to_string()),
    };
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

fn try_all(
    trial: &Trial,
    (shot, rule, steps): (&Shot, &Rule<'_>, &[Step]),
    folder: &Path,
    pools: &Pools,
) -> Result<Counts, Failure> {
    let audited = Settings { audit: true, ..shot.settings.clone() };
    let mut counts = Counts::default();
    let first = pools.three.install(|| {
        let mut renderer = renderer(trial, shot, &audited)?;
        let run = run(&mut renderer, steps, |_, _| Ok(()))?;
        check_audit(shot, &run, &mut counts)?;
        counts.compared = compare_with_full(trial, shot, &renderer)?;
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
fn check_audit(shot: &Shot, frames: &[Frame], counts: &mut Counts) -> Result<(), Failure> {
    // where single floats are too coarse for what is shown, the program says so, and the audit is not asked
    let is_coarse = !limits::of_camera(&shot.scene, &shot.settings).is_empty();
    for frame in frames {
        counts.inferred += u64::from(frame.is_inferred);
        let Some(audit) = frame.audit else { continue };
        counts.audited += audit.checked;
        counts.on_edge += audit.on_edge;
        if audit.differing > 0 && !is_coarse {
            let detail = format!("frame {}: {} of {} samples", frame.number, audit.differing, audit.checked);
            return Err(Failure::new(Kind::Audit, detail));
        }
    }
    Ok(())
}

fn renderer<'s>(trial: &Trial, shot: &'s Shot, settings: &Settings) -> Result<Renderer<'s>, Failure> {
    Renderer::with(trial.backend, &shot.scene, settings).map_err(|error| Failure::new(Kind::Render, error))
}

/// A frame as one eye has seen it.
struct Frame {
    number: i32,
    eye: usize,
    is_inferred: bool,
    audit: Option<afterimage::stats::AuditCounts>,
    planes: Vec<Plane>,
}

/// A name, and the bits of the values of all pixels.
type Plane = (String, Vec<u32>);

/// Renders the frames of `steps`. `before` is called before each, with its number in the list.
fn run(
    renderer: &mut Renderer<'_>,
    steps: &[Step],
    mut before: impl FnMut(&mut Renderer<'_>, usize) -> Result<(), Failure>,
) -> Result<Vec<Frame>, Failure> {
    let mut walk = Walk::default();
    let mut frames = vec![];
    for (number, step) in steps.iter().enumerate() {
        before(renderer, number)?;
        for eye in renderer.eyes() {
            let finished = walk.render(renderer, *eye, *step, |_| Ok::<(), StepError>(()));
            let finished = finished.map_err(|failure| Failure::new(Kind::Render, failure))?;
            let pixels = (finished.film.width * finished.film.height) as usize;
            let mut planes = vec![];
            for plane in &finished.film.planes {
                let values: Vec<f32> = (0..pixels).map(|pixel| plane.values.get(pixel)).collect();
                if let Some(pixel) = values.iter().position(|value| !value.is_finite()) {
                    let detail =
                        format!("frame {}: {} is {} in pixel {pixel}", step.frame, plane.name, values[pixel]);
                    return Err(Failure::new(Kind::NotFinite, detail));
                }
                planes.push((plane.name.to_string(), values.into_iter().map(f32::to_bits).collect()));
            }
            frames.push(Frame {
                number: step.frame,
                eye: *eye as usize,
                is_inferred: finished.stats.mode == "reproject",
                audit: finished.stats.audit,
                planes,
            });
        }
    }
    Ok(frames)
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
        Variation::Threads => run(&mut renderer(trial, shot, &settings)?, steps, |_, _| Ok(())),
        Variation::NoTags => run(&mut renderer(trial, shot, &settings)?, steps, |renderer, _| {
            renderer.forget_tags();
            Ok(())
        }),
        Variation::NoTrees => {
            settings.tree_memory = 0;
            run(&mut renderer(trial, shot, &settings)?, steps, |_, _| Ok(()))
        }
        Variation::Store => {
            // what is kept for later lies in memory, and not in the file
            let turn = if steps[..turn].iter().any(|step| step.keep) { usize::MAX } else { turn };
            run(&mut renderer(trial, shot, &settings)?, steps, |renderer, number| {
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
            run(&mut renderer(trial, shot, &settings)?, &later, |_, _| Ok(()))
        }
    }
}

/// The first plane that is not the same to the bit. What counts rays, or when something was asked, may be otherwise where the
/// variation says so.
fn first_difference(a: &Frame, b: &Frame, variation: Variation) -> Option<String> {
    let counts_alone = |name: &str| {
        let counts_rays = name.starts_with("rays");
        let counts_reuse = name.starts_with("status");
        match variation {
            Variation::Threads => false,
            Variation::NoTags | Variation::NoTrees => counts_rays,
            Variation::Store | Variation::Chunk => counts_rays || counts_reuse,
        }
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

/// Compares the samples of the last frame with those of the same frame traced in full: how many could be compared.
fn compare_with_full(trial: &Trial, shot: &Shot, inferred: &Renderer<'_>) -> Result<u64, Failure> {
    let Some((moment, pictures)) = inferred.samples() else { return Ok(0) };
    // with a budget samples have as many paths as they have had time for
    if shot.settings.budget != Budget::None {
        return Ok(0);
    }
    let settings = Settings { mode: Mode::Full, audit: false, ..shot.settings.clone() };
    let mut full = renderer(trial, shot, &settings)?;
    render_all(&mut full, moment.frame)?;
    let Some((_, in_full)) = full.samples() else { return Ok(0) };
    let mut compared = 0;
    let mut differing = 0;
    for picture in &pictures {
        let Some(same) = in_full.iter().find(|other| other.picture == picture.picture) else { continue };
        for (level, other) in picture.levels.iter().zip(&same.levels) {
            let stores: [&SampleStore; 2] = [level.store, other.store];
            for (tile, other) in stores[0].tiles.iter().zip(&stores[1].tiles) {
                for cell in 0..tile.model.len() {
                    if is_same_sample(tile, other, cell) {
                        compared += 1;
                        differing += u64::from(!keeps_same_light(tile, other, cell));
                    }
                }
            }
        }
    }
    if differing > 0 {
        let detail = format!("frame {}: {differing} of {compared} samples", moment.frame);
        return Err(Failure::new(Kind::Full, detail));
    }
    Ok(compared)
}

/// Renders a frame in full, as each eye sees it.
fn render_all(renderer: &mut Renderer<'_>, frame: i32) -> Result<(), Failure> {
    for eye in renderer.eyes() {
        let rendered = renderer.render_eye(*eye, frame, false);
        rendered.map_err(|error| Failure::new(Kind::Render, error))?;
    }
    Ok(())
}

/// Whether both tiles have one and the same sample in `cell`.
fn is_same_sample(tile: &Tile, other: &Tile, cell: usize) -> bool {
    let place = |tile: &Tile| [tile.x[cell], tile.y[cell], tile.z[cell]].map(f32::to_bits);
    let what =
        |tile: &Tile| (tile.model[cell], tile.record[cell].triangle, tile.record[cell].is_from_behind());
    tile.model[cell] < EMPTY
        && what(tile) == what(other)
        && place(tile) == place(other)
        && seed(tile, cell) == seed(other, cell)
}

/// Of its random numbers.
fn seed(tile: &Tile, cell: usize) -> u32 {
    tile.gathered.seeds(cell / LANES * LANES).to_array()[cell % LANES]
}

fn keeps_same_light(tile: &Tile, other: &Tile, cell: usize) -> bool {
    let [a, b] = [tile, other].map(|tile| tile.record[cell].direct_diffuse.map(|part| part.to_f32()));
    let largest = b.into_iter().fold(DARKEST, f32::max);
    a.into_iter().zip(b).all(|(a, b)| (a - b).abs() <= COLOR_TOLERANCE * largest)
}
