//! `afterimage render`: frames of a shot into EXR files.

pub mod extras;
pub mod parts;
mod record;
mod writer;

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, Parser, ValueEnum};
use rayon::ThreadPool;

use self::extras::{Extras, ExtrasArgs};
use self::parts::{Part, Parts, Shared};
use self::record::Record;
use self::writer::Writer;
use crate::cli::args::{self, Job, ShotArgs};
use crate::cli::bare_model::{is_model, turn_note};
use crate::cli::coarse::{self, CoarseArg};
use crate::cli::denoising::Denoising;
use crate::cli::failure::Failure;
use crate::cli::frames::checkpoint::Checkpoints;
use crate::cli::frames::handoff::Handoffs;
use crate::cli::frames::paths::{self, Report};
use crate::cli::frames::resume::{Fingerprints, Review};
use crate::cli::frames::store::{Loaded, StoreArgs};
use crate::cli::frames::target::Target;
use crate::cli::frames::writing::{self, Behind, Frame, Seen, Waiting};
use crate::cli::say::table;
use crate::cli::say::terminal::Terminal;
use crate::cli::stop::StopRequest;
use crate::denoise;
use crate::frame::{self, Finished, Renderer};
use crate::memory::{self, Need};
use crate::report::file::write_json;
use crate::scene::warnings::{caustics, kinds, limits};
use crate::schedule::steps::Walk;
use crate::schedule::{self, Origin, Rule, Saved, Step};
use crate::settings::{DenoiseQuality, Mode, Settings};
use crate::stats::{AuditCounts, Eyes, Memory, RunSettings, RunStats, Totals};

/// Examples, printed below the options in `--help`.
pub const EXAMPLES: &str = "\
Examples:
  afterimage render city.toml
      renders the shot's frames to the files that it names, or to out/city/
  afterimage render statue.obj --frames 1-48 --size 960x540 -o turn/statue.####.exr
      a model on a turntable, with PNG previews
  afterimage render statue.obj --contact-sheet --movie statue.mp4
      a whole turn, all frames in one picture, and a movie (by FFmpeg)
  afterimage render city.toml --frames 101-200 --resume -o city.%04d.exr --stats city.json
      a chunk of a farm: complete frames of the same shot are kept; pictures do not depend on the chunk

Table: seconds of rendering, seconds of waiting for files, which are written while the next frame is
rendered (in --stats, `total` is both); samples reused, percent;
rays cast, millions by kind; rays saved, percent, against full tracing (estimated: one primary ray a sample,
shadow rays as in the last base frame, reflection and refraction rays as cast; `afterimage compare` measures
it).

Files are written under a hidden temporary name (.NAME….part) and renamed when complete. The next run of the
same frames removes what a killed run left. Exit code: 0 if every requested frame exists and is complete, 1 if
something failed, 2 if the command line is invalid.";

/// Advice on shorter run-ups.
const FEWER_STEPS: &str = "--mode full needs no run-up, --base-every makes it shorter";

/// Advice after a signal, to a run with `--resume` and to one without.
const GO_ON: &str = "the same command goes on";
const GO_ON_LATER: &str = "the same command with --resume goes on";

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct RenderArgs {
    #[command(flatten)]
    shot: ShotArgs,

    /// File names, with #### or %04d for the frame number [default: the shot's, or
    /// out/NAME/NAME.####.exr]
    #[allow(rustdoc::broken_intra_doc_links, reason = "a default in brackets is no link")]
    #[arg(short, long, value_name = "DIR/name.####.exr")]
    output: Option<String>,

    /// When samples are reused [default: the shot's]
    #[arg(long, value_enum)]
    mode: Option<ModeArg>,

    /// Also write a denoised picture, as the layer `denoised`, made by Intel's Open Image Denoise; R G B stays as it is.
    /// Previews show the denoised picture
    #[arg(long)]
    denoise: bool,

    /// Quality of the denoised picture; implies --denoise [default: the shot's]
    #[arg(long, value_enum, value_name = "QUALITY")]
    denoise_quality: Option<QualityArg>,

    /// Write statistics of each frame
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,

    /// Write a coarse picture of the first frame before that is rendered: NAME.coarse.png beside the frames
    #[arg(long, value_enum, default_value_t, value_name = "WHEN")]
    coarse: CoarseArg,

    #[command(flatten)]
    extras: ExtrasArgs,

    #[command(flatten)]
    store: StoreArgs,

    /// Keep frames that are complete and made from the same shot, inputs, settings and version
    #[arg(long)]
    resume: bool,

    /// Write a checkpoint beside the frames every N of them, from which --resume goes on if the run is killed: the samples
    /// of the last frame. It is removed when the run is complete
    #[arg(long, value_name = "N")]
    checkpoint: Option<NonZeroU32>,

    /// Divide the frames with other processes that render the same shot to the same folder, on this machine or others; implies
    /// --resume. Each takes segments that are free, and those of a process that was killed
    #[arg(long, conflicts_with_all = ["save_store", "load_store"])]
    shared: bool,

    /// Go on from samples that a run of neighbouring frames has left beside them, instead of rendering from the last base frame
    /// on, and leave those of the last frame where frames of other runs follow; implies --resume
    #[arg(long, conflicts_with_all = ["save_store", "load_store", "shared"])]
    handoff: bool,
}

/// Modes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModeArg {
    /// Reuse where this is estimated to be faster than full tracing
    Auto,
    /// Reuse in every frame that has a previous frame
    Reproject,
    /// Trace every frame in full
    Full,
}

/// Qualities by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum QualityArg {
    /// For final frames
    High,
    /// Less than half the time
    Balanced,
    /// A fifth of the time: for previews
    Fast,
}

impl From<QualityArg> for DenoiseQuality {
    fn from(quality: QualityArg) -> Self {
        match quality {
            QualityArg::High => Self::High,
            QualityArg::Balanced => Self::Balanced,
            QualityArg::Fast => Self::Fast,
        }
    }
}

/// Validated arguments.
#[derive(Debug)]
struct Options {
    job: Job,
    target: Target,
    stats: Option<PathBuf>,
    coarse: CoarseArg,
    extras: Extras,
    store: StoreArgs,
    resume: bool,
    checkpoint: Option<NonZeroU32>,
    shared: bool,
    handoff: bool,
    threads: Option<NonZeroUsize>,
}

/// Options of `render` as another command takes them, after `--`.
#[derive(Debug, Parser)]
#[command(name = "afterimage render", no_binary_name = true, disable_help_flag = true)]
struct Words {
    #[command(flatten)]
    render: RenderArgs,
}

/// The job of `render SHOT WORDS`, and where its frames go. Nothing is written.
pub fn job_and_target(shot: &Path, words: &[String]) -> Result<(Job, Target), Failure> {
    let all = [shot.as_os_str().to_owned()].into_iter().chain(words.iter().map(Into::into));
    let words = Words::try_parse_from(all).map_err(|error| {
        let text = error.to_string();
        let first = text.lines().next().unwrap_or_default();
        Failure::Usage(format!("options of render: {}", first.trim_start_matches("error: ")))
    })?;
    let options = words.render.settle()?;
    Ok((options.job, options.target))
}

impl RenderArgs {
    /// Output streams for these arguments.
    pub fn terminal(&self) -> Terminal {
        Terminal::new(self.shot.progress, self.shot.quiet)
    }

    /// Renders.
    pub fn execute(self, terminal: &mut Terminal) -> Result<(), Failure> {
        let pool = args::pool(self.shot.threads)?;
        pool.install(|| render(&self.settle()?, &pool, terminal))
    }

    fn settle(self) -> Result<Options, Failure> {
        let mut job = self.shot.load(self.mode.map(Mode::from))?;
        if self.denoise {
            job.denoise = Some(job.shot.denoise_quality);
        }
        job.denoise = self.denoise_quality.map(DenoiseQuality::from).or(job.denoise);
        let png = self.shot.png || is_model(&job.path);
        let target = job.target(self.output.as_deref(), png)?;
        let extras = self.extras.settle(&target)?;
        let (stats, store, coarse) = (self.stats, self.store, self.coarse);
        store.check(&job)?;
        let in_vain = [(self.checkpoint.is_some(), "--checkpoint"), (self.handoff, "--handoff")];
        let in_vain = in_vain.into_iter().find(|(is_given, _)| *is_given && job.settings.mode == Mode::Full);
        if let Some((_, option)) = in_vain {
            return Err(Failure::Usage(format!(
                "{option}: in `full` mode no frame is made of the samples of another, and --resume needs none; leave it out",
            )));
        }
        let (resume, shared, handoff) =
            (self.resume || self.shared || self.handoff, self.shared, self.handoff);
        let (checkpoint, threads) = (self.checkpoint, self.shot.threads);
        let options = Options {
            job,
            target,
            stats,
            coarse,
            extras,
            store,
            resume,
            checkpoint,
            shared,
            handoff,
            threads,
        };
        let files: Vec<Report<'_>> = reports(&options).into_iter().chain(options.store.input()).collect();
        paths::check(&options.job, Some(&options.target), &files)?;
        Ok(options)
    }
}

impl From<ModeArg> for Mode {
    fn from(mode: ModeArg) -> Self {
        match mode {
            ModeArg::Auto => Self::Auto,
            ModeArg::Reproject => Self::Reproject,
            ModeArg::Full => Self::Full,
        }
    }
}

/// Rule that decides the base frames of a job.
pub fn rule(job: &Job, full: bool) -> Rule<'_> {
    Rule { full, ..Rule::new(&job.shot, &job.settings) }
}

/// Schedule of a job's frames; `saved`: the frame of which there is a store.
pub fn plan(
    job: &Job,
    full: bool,
    saved: Option<Saved>,
    finished: impl Fn(i32) -> bool,
) -> Result<Vec<Step>, Failure> {
    let steps = schedule::schedule(job.frames.runs(), &rule(job, full), saved, finished);
    steps.map_err(|error| Failure::Usage(error.to_string()))
}

/// Prints the loader's warnings.
pub fn warn_about(job: &Job, terminal: &Terminal) {
    for warning in kinds::told(&job.shot.warnings) {
        terminal.warn(&warning);
    }
    let turned =
        (is_model(&job.path) && job.shot.says_orbit).then(|| turn_note(&job.frames.list())).flatten();
    for note in job.shot.notes.iter().chain(&turned) {
        terminal.note(note);
    }
    match &job.choice {
        Some(choice) if choice.is_reached() => terminal.note(&choice.to_string()),
        Some(choice) => terminal.warn(&choice.to_string()),
        None => {}
    }
    let (scene, settings) = (&job.shot.scene, &job.settings);
    for warning in limits::of_camera(scene, settings).into_iter().chain(caustics::warning(scene, settings)) {
        terminal.warn(&warning);
    }
}

fn reports(options: &Options) -> Vec<Report<'_>> {
    let stats = options.stats.as_deref().map(|path| ("--stats", path));
    stats.into_iter().chain(options.extras.reports()).chain(options.store.report()).collect()
}

/// Renders the frames. `pool` is the thread pool of the calling thread.
fn render(options: &Options, pool: &ThreadPool, terminal: &mut Terminal) -> Result<(), Failure> {
    let Options { job, target, .. } = options;
    warn_about(job, terminal);
    target.check()?;
    let settings = if job.denoise.is_some() { &denoise::with_guides(&job.settings) } else { &job.settings };
    let full = job.settings.mode == Mode::Full;
    let fingerprints = Fingerprints::new(job, &rule(job, full))?;
    let review = Review::new(target, &fingerprints);
    let ends = (job.frames.first(), job.frames.last());
    // in a shared run each segment has its own
    let checkpoints = options.checkpoint.filter(|_| !options.shared);
    let checkpoints = checkpoints.map(|every| Checkpoints::new(target, ends, every));
    let checkpoint = checkpoints.as_ref().filter(|_| options.resume).and_then(|checkpoints| {
        checkpoints.open(job, &rule(job, full)).unwrap_or_else(|failure| {
            terminal.note(&format!("--checkpoint: nothing is taken from an earlier run: {failure}"));
            None
        })
    });
    let goes_on = checkpoint.is_some();
    let mut loaded = match checkpoint {
        None => options.store.open(job, &rule(job, full))?,
        checkpoint => checkpoint,
    };
    let saved = loaded.as_ref().map(Loaded::saved);
    let to_save = to_save(options, &fingerprints, saved)?;
    let mut steps =
        plan(job, full, saved, |frame| options.resume && Some(frame) != to_save && review.keeps(frame))?;
    if let Some(note) = review.note() {
        terminal.note(&note);
    }
    let is_taken = steps.is_empty() || steps.iter().any(|step| step.origin == Origin::Saved);
    if let Some(loaded) = loaded.as_ref().filter(|_| !is_taken && !goes_on) {
        terminal.note(&loaded.unused_note());
    }
    if !steps.is_empty() {
        need(job, settings, &steps).check(&memory::left()).map_err(Failure::of)?;
    }
    options.extras.prepare()?;
    target.prepare()?;
    paths::prepare(&reports(options))?;
    let kept = job.frames.list().len() - steps.iter().filter(|step| step.write).count();
    if kept > 0 {
        terminal.note(&format!("resume: {kept} frames are there and whole"));
    }
    let mut handoffs = options.handoff.then(|| Handoffs::new(job, rule(job, full), target, &fingerprints));
    if steps.is_empty() {
        // neither build a scene that nothing needs nor replace the statistics of the run that made them
        let extras = options.extras.write(target, job.denoise.is_some(), terminal);
        checkpoints.as_ref().map_or(Ok(()), Checkpoints::remove)?;
        handoffs.iter().for_each(Handoffs::tidy);
        return target.check_all_there().and(extras);
    }
    if let Some(loaded) = loaded.as_ref().filter(|_| goes_on && is_taken) {
        terminal.note(&format!("--checkpoint: goes on from frame {}", loaded.saved().frame));
    }

    // before anything is rendered that it is to denoise
    let mut denoising = Denoising::new(job).map_err(Failure::of)?;
    let mut renderer =
        Renderer::with(job.backend.unwrap_or_default(), &job.shot.scene, settings).map_err(Failure::of)?;
    if let Some(settings) = coarse_settings(options, terminal) {
        coarse::write(&mut renderer, job, &settings, target, terminal);
    }
    if let Some(handoffs) = handoffs.as_ref().filter(|_| !is_taken)
        && let Some(fewer) = handoffs.take(&steps, &mut renderer, terminal)?
    {
        // the renderer has the samples already
        (steps, loaded) = (fewer, None);
    }
    if let Some(note) = schedule::run_up_note(&steps, FEWER_STEPS) {
        terminal.note(&note);
    }
    let mut record = Record::default();
    renderer.watch(terminal.watcher());
    let stop = StopRequest::listen();
    let asked = stop.clone();
    renderer.stop_when(Some(Arc::new(move || asked.signal().is_some())));
    let check = || stop.check(if options.resume { GO_ON } else { GO_ON_LATER });
    terminal.begin(steps.len(), renderer.tiles_a_frame());
    let mut parts = if options.shared {
        let files = (target, &fingerprints);
        Parts::Shared(Shared::new(job, rule(job, full), files, options.checkpoint, &steps)?)
    } else {
        Parts::One(Some(Part::new(steps, loaded, checkpoints)))
    };
    terminal.result(&table::header(settings.stereo.is_some()));
    let writer = Writer { target, fingerprints: &fingerprints, pool };
    let write = |frame: &mut Frame, waiting: &Waiting| writer.write(frame, waiting, &mut record, terminal);
    let outcome = writing::behind(job.settings.layers, write, |behind| {
        while let Some(part) = parts.next(check)? {
            let part = render_part(
                part,
                (job, &fingerprints, handoffs.as_mut()),
                &mut renderer,
                |step, seen, behind| denoise_step(step, seen, &mut denoising, behind),
                (behind, &check),
            )?;
            // others look at its frames once the lock is free
            behind.wait()?;
            part.finish()?;
        }
        Ok(())
    });
    // the reason, and not what became of the frame
    let outcome = outcome.or_else(|failure| check().and(Err(failure)));
    terminal.end();

    // what was finished is reported even if a later frame failed
    let memory = renderer.memory().with_peak();
    terminal.result(&record.summary(
        memory,
        (job.settings.build, renderer.build_seconds()),
        terminal.elapsed(),
    ));
    terminal.result(&format!("{:<9}{}", "files", target.text()));
    if let Some(handoffs) = &handoffs {
        handoffs.notes().iter().for_each(|note| terminal.note(note));
        if outcome.is_ok() {
            handoffs.tidy();
        }
    }
    let outcome = outcome.and_then(|()| options.store.save(job, &fingerprints, &renderer, terminal));
    let stats = write_stats(options, &record, memory);
    outcome?;
    let extras = options.extras.write(target, job.denoise.is_some(), terminal);
    target.check_all_there().and(extras).and(stats).and_then(|()| audit_verdict(record.totals().audit))
}

/// Renders the frames of a part, gives each to `take`, and writes checkpoints. `check` fails if the run is to stop.
fn render_part(
    mut part: Part,
    (job, fingerprints, mut handoffs): (&Job, &Fingerprints, Option<&mut Handoffs<'_>>),
    renderer: &mut Renderer<'_>,
    mut take: impl FnMut(Step, Vec<Finished>, &mut Behind<'_>) -> Result<(), Failure>,
    (behind, check): (&mut Behind<'_>, impl Fn() -> Result<(), Failure>),
) -> Result<Part, Failure> {
    let mut walk = Walk::default();
    for (number, step) in part.steps.iter().enumerate() {
        check()?;
        let load = |renderer: &mut Renderer<'_>| {
            part.loaded.as_ref().map_or(Ok(()), |loaded| loaded.give(job, renderer))
        };
        let eyes = renderer.eyes().iter();
        let seen = eyes.map(|eye| walk.render(renderer, *eye, *step, load)).collect::<Result<_, _>>()?;
        take(*step, seen, behind)?;
        if let Some(handoffs) = &mut handoffs {
            handoffs.leave(*step, renderer);
        }
        let Some(checkpoints) = &mut part.checkpoints else { continue };
        if checkpoints.is_due(*step, part.steps.get(number + 1), fingerprints) {
            behind.wait()?;
            checkpoints.write(job, fingerprints, renderer)?;
        }
    }
    Ok(part)
}

/// Settings of the coarse picture before the first frame, if there is to be one.
fn coarse_settings(options: &Options, terminal: &Terminal) -> Option<Settings> {
    let Options { job, target, store, coarse, resume, .. } = options;
    let run = coarse::CoarseRun {
        is_watched: terminal.has_bar(),
        writes_png: target.has_previews(),
        goes_on: *resume || store.loads(),
    };
    coarse.plan(run, &job.shot, &job.settings, rayon::current_num_threads())
}

/// The last frame, if it must be rendered even though it exists, because its samples are to be saved and are
/// not.
fn to_save(
    options: &Options,
    fingerprints: &Fingerprints,
    saved: Option<Saved>,
) -> Result<Option<i32>, Failure> {
    if !options.resume || !options.store.saves() {
        return Ok(None);
    }
    let last = plan(&options.job, false, saved, |_| false)?.last().map(|step| step.frame);
    Ok(last.filter(|last| !options.store.has(&options.job, fingerprints, *last)))
}

/// Memory that the frames of `steps` need beside the scene, on the threads of this pool.
pub fn need(job: &Job, settings: &Settings, steps: &[Step]) -> Need {
    let kind = job.backend.unwrap_or_default();
    let need = frame::need(&job.shot, settings, kind, steps.len(), rayon::current_num_threads());
    let need =
        if steps.iter().any(|step| step.keep) { frame::with_kept(need, &job.shot, settings) } else { need };
    let need = frame::with_writing(need, &job.shot.scene, &job.settings);
    if job.denoise.is_some() { need.and(Need::new(denoise::need(settings))) } else { need }
}

/// Denoises the pictures of a frame, if there is a denoiser. The frame is written while the next one is
/// rendered.
fn denoise_step(
    step: Step,
    all_finished: Vec<Finished>,
    denoising: &mut Denoising,
    behind: &mut Behind<'_>,
) -> Result<(), Failure> {
    let mut seen: Vec<Seen> = all_finished.into_iter().map(Seen::from).collect();
    if step.write {
        seen.iter_mut().try_for_each(|seen| denoising.clean_timed(seen))?;
    }
    behind.take(seen, step.write)
}

fn write_stats(options: &Options, record: &Record, memory: Memory) -> Result<(), Failure> {
    let Some(path) = &options.stats else { return Ok(()) };
    let job = &options.job;
    let settings = RunSettings {
        picture: job.settings.clone(),
        backend: job.backend.unwrap_or_default().name(),
        threads: options.threads.map_or_else(rayon::current_num_threads, NonZeroUsize::get),
    };
    let stats = RunStats {
        shot: &job.path.to_string_lossy(),
        settings: &settings,
        frames: &record.frames,
        run_up: (!record.run_up.is_empty()).then(|| Totals::new(&record.run_up)),
        eyes: Eyes::new(&record.frames),
        totals: record.totals(),
        memory,
    };
    write_json(path, &stats).map_err(Failure::of)
}

/// Fails if samples differ from traced ones, or cells show what their targets do not see: that breaks the program's promise.
pub fn audit_verdict(audit: Option<AuditCounts>) -> Result<(), Failure> {
    let Some(audit) = audit.filter(|audit| audit.wrong() > 0) else { return Ok(()) };
    let AuditCounts { differing, coverage, coverage_on_edge, .. } = audit;
    let mut found = Vec::new();
    if differing > 0 {
        found.push(format!("{differing} samples differ from what their rays see now"));
    }
    if coverage > 0 {
        found.push(format!("{coverage} cells show another surface than their targets see"));
    }
    if found.is_empty() {
        found.push(format!(
            "rounding decides what the targets of {coverage_on_edge} cells see, which is too often"
        ));
    }
    Err(Failure::Failed(format!(
        "audit: {}; please report this with the shot; --mode full renders without reuse",
        found.join(", and ")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_audit_that_finds_something_fails_the_run() {
        let nothing = AuditCounts { checked: 1000, on_edge: 5, coverage_on_edge: 3, ..Default::default() };
        assert_eq!(audit_verdict(None), Ok(()));
        assert_eq!(audit_verdict(Some(nothing)), Ok(()));
        for (found, says) in [
            (AuditCounts { differing: 3, ..nothing }, "3 samples"),
            (AuditCounts { coverage: 4, ..nothing }, "4 cells show another surface"),
            (AuditCounts { coverage_on_edge: 200, ..nothing }, "200 cells"),
        ] {
            let verdict = audit_verdict(Some(found));
            assert!(matches!(verdict, Err(Failure::Failed(text)) if text.contains(says)), "{says}");
        }
    }
}
