//! `afterimage compare`: the same frames, reprojected and traced in full, by each tracer, in one run.
//!
//! The order of the two ways alternates from frame to frame, and the tracers take turns with every
//! frame, so that whatever else the machine does strikes all. Tables, files and the report tell of the first
//! tracer, as if there were no other; what all of them were measured at follows.
//!
//! A frame is packed before the next one is rendered: what is measured shares the processors with nothing. Only the disk is waited
//! for meanwhile (`writing.rs`).

pub mod backend_table;
pub mod reference;
pub mod shown;
pub mod table;

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender};

use clap::Args;
use rayon::ThreadPool;

use self::reference::Judge;
use self::shown::Shown;
use self::table::{header, row, summary};
use crate::cli::args::{self, Job, ShotArgs};
use crate::cli::denoising::Denoising;
use crate::cli::failure::Failure;
use crate::cli::frames::paths::{self, Report};
use crate::cli::frames::target::Target;
use crate::cli::frames::writing::{self, Behind, Frame, Seen, Waiting};
use crate::cli::render::{audit_verdict, plan, warn_about};
use crate::cli::say::terminal::Terminal;
use crate::frame::{self, Finished, Renderer, Watcher};
use crate::layers::Layers;
use crate::memory::{self, Need};
use crate::output::exr::Packing;
use crate::report::backends::{Agreement, BackendRun, RaySpeeds, most_apart};
use crate::report::both_ways::{BothTotals, ComparedFrame, Difference, Saving};
use crate::report::comparison::Comparison;
use crate::report::file::{write_json, write_text};
use crate::report::html::{self, Pictures};
use crate::report::reference::Reference;
use crate::report::versions::Versions;
use crate::schedule::steps::Walk;
use crate::schedule::{self, Step};
use crate::settings::{MOST_SAMPLES, Mode, Settings};
use crate::stats::{RunSettings, held_bytes};
use crate::stereo::Eye;
use crate::trace::BackendKind;

/// Examples, printed below the options in `--help`.
const EXAMPLES: &str = "\
Examples:
  afterimage compare city.toml
      each frame twice with each backend: tables of rays and seconds, what reuse saved, and how the
      backends compare
  afterimage compare city.toml --backend embree
      with Embree only
  afterimage compare statue.obj --frames 1-24 --audit --report statue.html
      with an HTML report, and the proof that no sample is wrong
  afterimage compare city.toml -o city.####.exr --png --json city.json
      also keeps the frames rendered with reuse
  afterimage compare city.toml --backend embree --reference 8
      measures which way has the smaller error for its time, against 8x8 samples a pixel

Table: seconds of both ways without writing files; million rays of both, all kinds; mean difference of the
pictures (linear R, G, B) and the percentage of pixels of which any channel differs by more than 0.02. Edges
differ, because the two ways sample different positions. With --reference: RMSE of both (linear R, G, B,
clamped to 0 to 1) and their ratio; below the table the speed-up at equal error, if error squared x seconds
is constant. Table of backends: million rays a second by kind, for one thread while it is in the tracer;
number of pixels that differ between backends (at edges, by rounding). Exit code: 0, 1 if something failed,
--audit found a difference or backends disagree, 2 if the command line is invalid.";

/// Arguments as typed.
#[derive(Debug, Clone, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArgs {
    #[command(flatten)]
    shot: ShotArgs,

    /// Write the frames rendered with reuse, with #### or %04d for the frame number [default: none]
    #[arg(short, long, value_name = "DIR/name.####.exr")]
    output: Option<String>,

    /// Show denoised pictures in the report, and write them as `render --denoise` does. Without Open Image Denoise a warning
    /// says that they are as traced
    #[arg(long)]
    denoise: bool,

    /// Also render each frame with N x N samples a pixel, and measure the error of both ways against it. N must be
    /// greater than --samples; an even multiple shares no sample with fully traced frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SAMPLES)))]
    reference: Option<u32>,

    /// Write all measurements
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,

    /// Write a page with charts and pictures
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Validated arguments.
#[derive(Debug)]
struct Options {
    job: Job,
    target: Option<Target>,
    /// Samples along a pixel's edge in the reference, if there is one.
    reference: Option<u32>,
    json: Option<PathBuf>,
    report: Option<PathBuf>,
    threads: Option<NonZeroUsize>,
    command: String,
}

impl CompareArgs {
    /// Output streams for these arguments.
    pub fn terminal(&self) -> Terminal {
        Terminal::new(self.shot.progress, self.shot.quiet)
    }

    /// Compares. `command` is the command line, for the report.
    pub fn execute(self, command: String, terminal: &mut Terminal) -> Result<(), Failure> {
        let pool = args::pool(self.shot.threads)?;
        pool.install(|| compare(&self.settle(command)?, &pool, terminal))
    }

    fn settle(self, command: String) -> Result<Options, Failure> {
        if self.shot.png && self.output.is_none() {
            return Err(Failure::Usage(String::from(
                "--png writes previews beside EXR files: name them with -o",
            )));
        }
        let mut job = self.shot.load(None)?;
        // a shot that asks for full tracing would be compared with itself
        if job.settings.mode == Mode::Full {
            job.settings.mode = Mode::Auto;
        }
        job.denoise = self.denoise.then_some(job.shot.denoise_quality);
        let output = self.output.as_deref();
        let target = output.map(|text| job.target(Some(text), self.shot.png)).transpose()?;
        let Self { shot, reference, json, report, .. } = self;
        reference.map_or(Ok(()), |samples| reference::check(&job.settings, samples))?;
        paths::check(&job, target.as_ref(), &reports(&json, &report))?;
        Ok(Options { job, target, reference, json, report, threads: shot.threads, command })
    }
}

fn reports<'a>(json: &'a Option<PathBuf>, report: &'a Option<PathBuf>) -> Vec<Report<'a>> {
    let named = [("--json", json), ("--report", report)];
    named.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?))).collect()
}

/// One tracer's renderers of the two ways. Each has its own store and its own scene in the tracer.
struct Pair<'s> {
    kind: BackendKind,
    ours: Renderer<'s>,
    /// Position of that renderer in its schedule.
    walk: Walk,
    full: Renderer<'s>,
    /// Growth of the process's memory, bytes, while the first of the two was built.
    build_bytes: u64,
}

impl<'s> Pair<'s> {
    fn new(kind: BackendKind, job: &'s Job, settings: &Settings) -> Result<Self, Failure> {
        let full_settings = in_full(settings);
        let held = || held_bytes().unwrap_or(0);
        let before = held();
        let ours = Renderer::with(kind, &job.shot.scene, settings).map_err(Failure::of)?;
        let build_bytes = held().saturating_sub(before);
        let full = Renderer::with(kind, &job.shot.scene, &full_settings).map_err(Failure::of)?;
        Ok(Self { kind, ours, walk: Walk::default(), full, build_bytes })
    }

    /// Renders a frame for `eye` in both ways.
    fn render(&mut self, eye: Eye, step: Step, ours_first: bool) -> Result<(Finished, Finished), Failure> {
        if ours_first {
            let ours = self.infer(eye, step)?;
            Ok((ours, render(&mut self.full, eye, step.frame)?))
        } else {
            let full = render(&mut self.full, eye, step.frame)?;
            Ok((self.infer(eye, step)?, full))
        }
    }

    /// Renders a frame for `eye`, with reuse.
    fn infer(&mut self, eye: Eye, step: Step) -> Result<Finished, Failure> {
        self.walk.render(&mut self.ours, eye, step, |_| Ok(()))
    }
}

fn in_full(settings: &Settings) -> Settings {
    Settings { mode: Mode::Full, audit: false, ..settings.clone() }
}

/// Memory needed by all renderers together, and by a frame that is being written.
fn need(options: &Options, made_by: &Settings, denoising: &Denoising, steps: &[Step]) -> Need {
    let Options { job, reference, .. } = options;
    let need = |settings: &Settings, kind: BackendKind| {
        frame::need(&job.shot, settings, kind, steps.len(), rayon::current_num_threads())
    };
    let keeps = steps.iter().any(|step| step.keep);
    let ours = |kind| match need(made_by, kind) {
        need if keeps => frame::with_kept(need, &job.shot, made_by),
        need => need,
    };
    let both = |kind| [ours(kind), need(&in_full(made_by), kind)];
    let judge = reference.map(|samples| need(&reference::settings(job, samples), kinds(job)[0]));
    let renderers = kinds(job).into_iter().flat_map(both).chain(judge).fold(Need::default(), Need::and);
    let need = match options.target {
        Some(_) => frame::with_writing(renderers, &job.shot.scene, &job.settings),
        None => renderers,
    };
    denoising.need(need, made_by)
}

/// Tracers to compare; the first one leads.
fn kinds(job: &Job) -> Vec<BackendKind> {
    job.backend.map_or_else(|| vec![BackendKind::Embree, BackendKind::Rust], |kind| vec![kind])
}

/// Compares the frames. `pool` is the thread pool of the calling thread.
fn compare(options: &Options, pool: &ThreadPool, terminal: &mut Terminal) -> Result<(), Failure> {
    let job = &options.job;
    warn_about(job, terminal);
    options.target.as_ref().map_or(Ok(()), Target::check)?;
    let steps = plan(job, false, None, |_| false)?;
    if let Some(note) = schedule::run_up_note(&steps, "--base-every makes it shorter") {
        terminal.note(&note);
    }
    let mut denoising = denoising(job, terminal);
    let settings = denoising.settings(job);
    need(options, &settings, &denoising, &steps).check(&memory::left()).map_err(Failure::of)?;
    options.target.as_ref().map_or(Ok(()), Target::prepare)?;
    paths::prepare(&reports(&options.json, &options.report))?;

    let pairs = kinds(job).into_iter().map(|kind| Pair::new(kind, job, &settings));
    let mut pairs = pairs.collect::<Result<Vec<Pair>, Failure>>()?;
    let judge = options.reference.map(|samples| Judge::new(pairs[0].kind, job, samples)).transpose();
    let mut contest = Contest { pairs: &mut pairs, judge: judge?, denoising: &mut denoising };
    let mut made = Made::new(contest.pairs, options.report.as_ref().map(|_| Shown::new(&steps, job.look)));
    let watcher = terminal.watcher();
    contest.watch(watcher.as_ref());
    terminal.begin(steps.len(), contest.tiles());
    terminal.result(&header(job.settings.stereo.is_some(), options.reference.is_some()));
    let (measured, to_tell) = mpsc::channel();
    let (mut frames, target) = (Vec::new(), options.target.as_ref());
    let (told, out) = (&mut frames, &mut *terminal);
    let write = move |frame: &mut Frame, _: &Waiting| write(frame, target, pool, &to_tell, told, out);
    let layers = target.map_or(Layers::NONE, |_| job.settings.layers);
    let outcome = writing::behind(layers, write, |behind| {
        let mut out = Out { measured, behind, writes: target.is_some(), watcher: watcher.clone() };
        steps.iter().try_for_each(|step| compare_step(*step, &mut contest, &mut made, &mut out))
    });
    terminal.end();

    // what was measured is reported even if a later frame failed
    let pictures = made.shown.take().map(Shown::into_pictures).unwrap_or_default();
    made.frames[0] = frames;
    let runs = made.runs(&pairs);
    let comparison = comparison(options, made.frames.swap_remove(0), runs, &pairs[0]);
    terminal.result(&summary(&comparison));
    let reports = write_reports(options, &comparison, &pictures, terminal);
    let outcome = outcome.and_then(|()| target.map_or(Ok(()), Target::check_all_there));
    outcome.and(reports).and_then(|()| verdict(&comparison.backends, comparison.settings.picture.paths))
}

/// Denoiser, if it is asked for and the library is there. A missing library is no failure: the measurements
/// need none.
fn denoising(job: &Job, terminal: &Terminal) -> Denoising {
    Denoising::new(job).unwrap_or_else(|error| {
        terminal.warn(&format!("pictures are shown as traced: {error}"));
        Denoising::default()
    })
}

/// Fails if the audit of any tracer found samples that differ, or if tracers disagree; `paths`: those of each
/// sample.
fn verdict(runs: &[BackendRun], paths: u32) -> Result<(), Failure> {
    runs.iter().try_for_each(|run| audit_verdict(run.totals.reprojected.audit))?;
    match runs.iter().find(|run| !run.agrees(paths)) {
        None => Ok(()),
        Some(run) => Err(Failure::Failed(format!(
            "the pictures of {} and {} differ in more than {:.0} % of the pixels; please report this with \
             the shot",
            runs[0].backend,
            run.backend,
            most_apart(paths)
        ))),
    }
}

/// Results of the frames.
struct Made {
    /// Measurements by tracer; those of the first one come when the frames are written.
    frames: Vec<Vec<ComparedFrame>>,
    /// Number of frames that were made in both ways.
    count: usize,
    /// Agreement of each tracer with the first one's pictures, reprojected and in full.
    agreements: Vec<[Agreement; 2]>,
    /// Pictures for the report.
    shown: Option<Shown>,
}

impl Made {
    fn new(pairs: &[Pair], shown: Option<Shown>) -> Self {
        let agreements = vec![[Agreement::default(); 2]; pairs.len()];
        Self { frames: vec![Vec::new(); pairs.len()], count: 0, agreements, shown }
    }

    /// Measurements of each tracer.
    fn runs(&self, pairs: &[Pair]) -> Vec<BackendRun> {
        let runs = pairs.iter().zip(&self.frames).zip(&self.agreements).enumerate();
        runs.map(|(number, ((pair, frames), agreement))| {
            let totals = BothTotals::new(frames);
            BackendRun {
                backend: pair.kind.name(),
                build_seconds: pair.ours.build_seconds(),
                build_bytes: pair.build_bytes,
                totals,
                saved: Saving::new(frames),
                speeds: RaySpeeds::new(&totals.reprojected),
                full_speeds: RaySpeeds::new(&totals.full),
                agreement: (number > 0).then_some(*agreement),
            }
        })
        .collect()
    }
}

/// All renderers of a comparison, and the denoiser.
struct Contest<'p, 's> {
    pairs: &'p mut [Pair<'s>],
    judge: Option<Judge<'s>>,
    /// The denoiser, which runs when all have rendered a frame.
    denoising: &'p mut Denoising,
}

impl Contest<'_, '_> {
    /// Reports all finished tiles to `watcher`.
    fn watch(&mut self, watcher: Option<&Watcher>) {
        for pair in &mut *self.pairs {
            pair.ours.watch(watcher.cloned());
            pair.full.watch(watcher.cloned());
        }
        if let Some(judge) = &mut self.judge {
            judge.watch(watcher.cloned());
        }
    }

    /// Number of tiles of a frame that is made in all ways.
    fn tiles(&self) -> usize {
        let pairs = self.pairs.iter().map(|pair| pair.ours.tiles_a_frame() + pair.full.tiles_a_frame());
        pairs.sum::<usize>() + self.judge.as_ref().map_or(0, Judge::tiles_a_frame)
    }
}

/// Destination of finished frames.
struct Out<'b, 'w> {
    /// Receives the measurements of each frame, by eye, before the frame itself; empty for run-up.
    measured: Sender<Vec<ComparedFrame>>,
    behind: &'b mut Behind<'w>,
    /// True if files are written.
    writes: bool,
    /// Receives the tiles that are left out.
    watcher: Option<Watcher>,
}

fn compare_step(
    step: Step,
    contest: &mut Contest<'_, '_>,
    made: &mut Made,
    out: &mut Out<'_, '_>,
) -> Result<(), Failure> {
    let eyes = contest.pairs[0].ours.eyes();
    if !step.write {
        let mut seen: Vec<Seen> = Vec::new();
        for (number, pair) in contest.pairs.iter_mut().enumerate() {
            for eye in eyes {
                let run_up = pair.infer(*eye, step)?;
                seen.extend((number == 0).then(|| run_up.into()));
            }
        }
        if let Some(watch) = &out.watcher {
            let ours: usize = contest.pairs.iter().map(|pair| pair.ours.tiles_a_frame()).sum();
            watch(contest.tiles() - ours);
        }
        // it is heard as long as frames are taken
        let _ = out.measured.send(Vec::new());
        return out.behind.take(seen, false);
    }
    let ours_first = made.count % 2 == 0;
    made.count += 1;
    let (mut seen, mut measured) = (Vec::new(), Vec::new());
    for eye in eyes {
        let (ours, frame) = compare_eye(*eye, step, ours_first, contest, made, out.writes)?;
        seen.push(ours);
        measured.push(frame);
    }
    let _ = out.measured.send(measured);
    out.behind.take_and_pack(seen, out.writes)
}

/// Renders a frame for `eye` in both ways with each tracer. Returns the first tracer's picture with reuse,
/// and the measurements.
fn compare_eye(
    eye: Eye,
    step: Step,
    ours_first: bool,
    Contest { pairs, judge, denoising }: &mut Contest<'_, '_>,
    made: &mut Made,
    writes: bool,
) -> Result<(Seen, ComparedFrame), Failure> {
    let (ours, full) = pairs[0].render(eye, step, ours_first)?;
    for (number, pair) in pairs.iter_mut().enumerate().skip(1) {
        let theirs = pair.render(eye, step, ours_first)?;
        made.agreements[number][0] += Agreement::between(&ours.film, &theirs.0.film);
        made.agreements[number][1] += Agreement::between(&full.film, &theirs.1.film);
        made.frames[number].push(compared(&theirs.0, &theirs.1));
    }
    let judged = judge.as_mut().map(|judge| judge.errors(eye, [&ours, &full])).transpose()?;
    let (error, reference) = judged.unzip();
    let frame = ComparedFrame { error, ..compared(&ours, &full) };
    let (mut ours, mut full) = (Seen::from(ours), Seen::from(full));
    if writes {
        denoising.clean_timed(&mut ours)?;
    }
    if let Some(shown) = made.shown.as_mut().filter(|_| eye == Eye::Left) {
        if shown.takes(&ours.finished) {
            let noisy = [&mut ours, &mut full].into_iter().filter(|seen| seen.denoised.is_none());
            noisy.map(|seen| denoising.clean(seen)).try_for_each(|cleaned| cleaned.map(|_| ()))?;
        }
        shown.offer(&ours, &full, reference.as_deref());
    }
    Ok((ours, frame))
}

/// Writes a frame if it is to be written, and reports it. Its seconds include the whole time of writing, even
/// if nothing waited for it.
fn write(
    frame: &mut Frame,
    target: Option<&Target>,
    pool: &ThreadPool,
    to_tell: &Receiver<Vec<ComparedFrame>>,
    frames: &mut Vec<ComparedFrame>,
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    let Frame { seen, write, copying, packed } = frame;
    let packing = Packing { threads: Some(pool), done: packed.take() };
    let file = target.filter(|_| *write).map(|target| target.write(seen, None, packing)).transpose()?;
    if let Some(last) = seen.last_mut().filter(|_| file.is_some()) {
        last.finished.stats.seconds.write += *copying;
        last.finished.stats.seconds.total += *copying;
    }
    let measured = to_tell.recv().unwrap_or_default();
    for (measured, Seen { finished, .. }) in measured.into_iter().zip(&*seen) {
        let measured = ComparedFrame { reprojected: finished.stats.clone(), ..measured };
        terminal.result(&row(&measured));
        frames.push(measured);
    }
    if let Some(Seen { finished, .. }) = seen.last() {
        terminal.frame_done(&finished.stats, file.as_deref());
    }
    Ok(())
}

fn compared(ours: &Finished, full: &Finished) -> ComparedFrame {
    ComparedFrame {
        frame: ours.stats.frame,
        difference: Difference::between(&ours.film, &full.film),
        reprojected: ours.stats.clone(),
        full: full.stats.clone(),
        error: None,
    }
}

fn render(renderer: &mut Renderer<'_>, eye: Eye, frame: i32) -> Result<Finished, Failure> {
    let finished = renderer.render_eye(eye, frame, false);
    finished.map_err(|error| Failure::Failed(format!("frame {frame}: {error}")))
}

fn comparison(
    options: &Options,
    frames: Vec<ComparedFrame>,
    backends: Vec<BackendRun>,
    first: &Pair,
) -> Comparison {
    let job = &options.job;
    let versions = Versions::here();
    let mut comparison = Comparison {
        shot: job.path.display().to_string(),
        title: job.shot.title.clone(),
        settings: RunSettings {
            picture: job.settings.clone(),
            backend: first.kind.name(),
            threads: options.threads.map_or(versions.threads, NonZeroUsize::get),
        },
        reference: options.reference.map(|samples| Reference::of(samples, &frames)),
        frames,
        totals: BothTotals::new(&[]),
        saved: Saving::default(),
        saved_inferred: Saving::default(),
        eyes: None,
        memory: first.ours.memory().with_peak(),
        build_seconds: first.ours.build_seconds(),
        backends,
        command: options.command.clone(),
        versions,
    };
    comparison.sum_up();
    comparison
}

fn write_reports(
    options: &Options,
    comparison: &Comparison,
    pictures: &[Pictures],
    terminal: &mut Terminal,
) -> Result<(), Failure> {
    if let Some(path) = &options.json {
        write_json(path, comparison).map_err(Failure::of)?;
        terminal.result(&format!("{:<9}{}", "json", path.display()));
    }
    if let Some(path) = &options.report {
        write_text(path, &html::page(comparison, pictures)).map_err(Failure::of)?;
        terminal.result(&format!("{:<9}{}", "report", path.display()));
    }
    if let Some(target) = &options.target {
        terminal.result(&format!("{:<9}{}", "files", target.text()));
    }
    Ok(())
}
