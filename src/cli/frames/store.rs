//! `--save-store` and `--load-store`: samples that go from one run to the next.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::changes::Direction;
use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::cli::frames::resume::Fingerprints;
use crate::cli::say::terminal::Terminal;
use crate::digest::Digest;
use crate::exposure::Shutter;
use crate::frame::{self, Moment, Renderer, Snapshot, ValidDirection};
use crate::memory::Bytes;
use crate::output::Fingerprint;
use crate::output::fingerprint::Kind;
use crate::output::store_file::{self, Header, StoreError, StoreErrorKind, StoreFile};
use crate::report::file::Destination;
use crate::samples::SampleStore;
use crate::samples::saved::PictureSamples;
use crate::schedule::{Ancestry, Rule, Saved, TooLong};
use crate::settings::{BasePlace, Mode, Refinement, Settings};
use crate::stereo::Stereo;

/// Arguments as typed.
#[derive(Debug, Clone, Default, Args)]
pub struct StoreArgs {
    /// Write the samples of the last frame to this file at the end: a run with --load-store goes on from them
    #[arg(long, value_name = "FILE")]
    save_store: Option<PathBuf>,

    /// Go on from samples that a run of the same shot with the same settings has saved: instead of rendering from the last base
    /// frame on
    #[arg(long, value_name = "FILE")]
    load_store: Option<PathBuf>,
}

/// A store that a run continues from.
#[derive(Debug)]
pub struct Loaded {
    path: PathBuf,
    header: Header,
    ancestry: Ancestry,
}

impl StoreArgs {
    /// File that is written, as a report.
    pub fn report(&self) -> Option<(&'static str, &Path)> {
        Some(("--save-store", self.save_store.as_deref()?))
    }

    /// File that is read, if it exists and is not the one that is written: no other output may replace it.
    pub fn input(&self) -> Option<(&'static str, &Path)> {
        let load = self.load_store.as_deref().filter(|load| self.save_store.as_deref() != Some(*load));
        Some(("--load-store", load.filter(|load| load.is_file())?))
    }

    /// Checks that the arguments make sense.
    pub fn check(&self, job: &Job) -> Result<(), Failure> {
        let option = match (&self.save_store, &self.load_store) {
            (None, None) => return Ok(()),
            (_, Some(_)) => "--load-store",
            (Some(_), None) => "--save-store",
        };
        if job.settings.mode == Mode::Full {
            return Err(Failure::Usage(format!(
                "{option}: in `full` mode no frame is made of the samples of another; leave it out"
            )));
        }
        match self.save_store.as_deref().map(destination) {
            Some(Err(error)) => Err(error),
            _ => Ok(()),
        }
    }

    /// Opens the store to continue from, if there is one, and checks that it is of this shot, with these
    /// settings, in a chain of `rule`.
    pub fn open(&self, job: &Job, rule: &Rule<'_>) -> Result<Option<Loaded>, Failure> {
        self.load_store.as_deref().map(|path| Loaded::open(path, job, rule)).transpose()
    }

    /// Returns true if the file to write exists already, with the samples of `frame`.
    pub fn has(&self, job: &Job, fingerprints: &Fingerprints, frame: i32) -> bool {
        let file = self.save_store.as_deref().and_then(|path| StoreFile::open(path).ok());
        file.is_some_and(|file| {
            let Header { fingerprint: made_from, frame: of, ancestry, .. } = file.header();
            *made_from == fingerprint(job)
                && *of == frame
                && *ancestry == fingerprints.ancestry(frame).to_string()
        })
    }

    /// Returns true if the run continues from a store.
    pub fn loads(&self) -> bool {
        self.load_store.is_some()
    }

    /// Returns true if the run writes a store.
    pub fn saves(&self) -> bool {
        self.save_store.is_some()
    }

    /// Writes the samples of the frame that `renderer` has rendered last.
    pub fn save(
        &self,
        job: &Job,
        fingerprints: &Fingerprints,
        renderer: &Renderer<'_>,
        terminal: &mut Terminal,
    ) -> Result<(), Failure> {
        let (Some(path), Some((moment, pictures))) = (&self.save_store, renderer.samples()) else {
            return Ok(());
        };
        let frame = moment.frame;
        let bytes = write(&destination(path)?, job, fingerprints, renderer, (moment, &pictures))?;
        terminal.result(&format!("{:<9}{} ({bytes}, the samples of frame {frame})", "store", path.display()));
        Ok(())
    }
}

/// Writes `samples` of `renderer` to `path`, whole or not at all. Returns the size of the file.
pub fn write(
    path: &Path,
    job: &Job,
    fingerprints: &Fingerprints,
    renderer: &Renderer<'_>,
    (moment, pictures): (Moment, &[PictureSamples<&SampleStore>]),
) -> Result<Bytes, Failure> {
    let Moment { frame, rendered, valid: _ } = moment; // that follows from the ancestry
    let ancestry = fingerprints.ancestry(frame).to_string();
    let header = Header { fingerprint: fingerprint(job), frame, sampling: sampling(job), ancestry, rendered };
    let written = store_file::write(path, &header, pictures, renderer.shape().layout);
    Ok(Bytes(written.map_err(Failure::of)?))
}

/// The regular file that `path` leads to.
fn destination(path: &Path) -> Result<PathBuf, Failure> {
    match Destination::new(path).map_err(Failure::of)? {
        Destination::File(file) => Ok(file),
        _ => Err(Failure::Usage(format!("--save-store {}: is no file; give a file's name", path.display()))),
    }
}

impl Loaded {
    /// Opens the store at `path`, and checks that it is of the shot of `job`, with its settings, in a chain of `rule`.
    pub fn open(path: &Path, job: &Job, rule: &Rule<'_>) -> Result<Self, Failure> {
        let file = StoreFile::open(path).map_err(Failure::of)?;
        let header = file.header().clone();
        let changes = fingerprint(job).changes(&header.fingerprint);
        if !changes.is_empty() {
            let [theirs, ours] = [&header.sampling, &sampling(job)];
            let differ =
                if theirs == ours { String::new() } else { format!(" ({theirs}; this run has {ours})") };
            return Err(Failure::Failed(format!(
                "{}: this sample store was made with {}{differ}; run what made it again with --save-store, or go on without --load-store",
                path.display(),
                changes.into_iter().map(Kind::other).collect::<Vec<_>>().join(", and ")
            )));
        }
        let damaged = || Failure::of(StoreError { path: path.to_owned(), kind: StoreErrorKind::Damaged });
        let ancestry: Ancestry = header.ancestry.parse().map_err(|()| damaged())?;
        let loaded = Self { path: path.to_owned(), header, ancestry };
        let is_as_here =
            loaded.saved().holds(rule).map_err(|error: TooLong| Failure::Usage(error.to_string()))?;
        if !is_as_here {
            return Err(Failure::Failed(format!(
                "{}: in this run frame {} comes about in another way than the one of this sample store ({}); take the same \
                 --base-every and --base-place, and the same cuts",
                path.display(),
                loaded.header.frame,
                loaded.ancestry
            )));
        }
        Ok(loaded)
    }

    /// Description of the store for the schedule.
    pub fn saved(&self) -> Saved {
        Saved { frame: self.header.frame, ancestry: self.ancestry }
    }

    /// Loads the samples into `renderer`.
    pub fn give(&self, job: &Job, renderer: &mut Renderer<'_>) -> Result<(), Failure> {
        let file = StoreFile::open(&self.path).map_err(Failure::of)?;
        if *file.header() != self.header {
            let path = self.path.display();
            return Err(Failure::Failed(format!("{path}: another run has replaced this file; start again")));
        }
        // so that there are never those of two frames
        renderer.forget();
        let pictures = file.read(&renderer.shape(), &job.shot.scene).map_err(Failure::of)?;
        let Header { frame, rendered, .. } = self.header;
        let valid = match self.ancestry {
            Ancestry::Base if job.settings.base_place == BasePlace::Middle => ValidDirection::Both,
            Ancestry::Inferred { from, .. } if from > frame => ValidDirection::To(Direction::Backward),
            _ => ValidDirection::To(Direction::Forward),
        };
        renderer.restore(Snapshot { moment: Moment { frame, rendered, valid }, pictures });
        Ok(())
    }

    /// Note for a store from which no frame is made.
    pub fn unused_note(&self) -> String {
        format!(
            "--load-store {}: nothing is taken from it, because no frame of this run follows from its frame {}, or it is rendered \
             in any case",
            self.path.display(),
            self.header.frame
        )
    }
}

/// Fingerprint of everything that decides the samples of a job's frames, without their ancestry.
pub fn fingerprint(job: &Job) -> Fingerprint {
    let of_frames = Fingerprints::of_all_frames(job);
    Fingerprint { settings: settings(job), ..of_frames }
}

/// Sampling of a job's pictures in words: samples a pixel, eyes and exposures.
fn sampling(job: &Job) -> String {
    let Settings { samples, refinement, shutter, stereo, .. } = &job.settings;
    let mut parts = vec![match refinement {
        Some(Refinement { most, .. }) => format!("{samples}x{samples} to {most}x{most} samples a pixel"),
        None => format!("{samples}x{samples} samples a pixel"),
    }];
    if let Some(exposures) = frame::exposures(&job.shot.scene, &job.settings) {
        parts.push(match exposures.all.len() {
            1 => String::from("1 exposure"),
            count => format!("{count} exposures"),
        });
        parts.extend(shutter.as_ref().map(Shutter::to_string));
        parts.extend(job.shot.scene.camera.has_lens().then(|| String::from("a lens")));
    }
    parts.extend(stereo.map(|Stereo { separation, .. }| format!("two eyes {separation} apart")));
    parts.join(", ")
}

/// Digest of the settings that decide the samples and their content. Each is named here, or left out for a
/// reason, as in [`resume`](crate::cli::frames::resume).
fn settings(job: &Job) -> Digest {
    let Settings {
        width,
        height,
        overscan: _, // stands in the data window
        crop: _,
        samples,
        refinement,
        filter: _, // makes pixels of samples
        filter_radius: _,
        depth,
        reflections,
        paths,
        paths_per_frame,
        budget,
        bounces,
        volume_bounces,
        volume_samples: _, // what media show no sample keeps
        caustics,
        clamp,
        only_lights,
        occlusion_rays,
        occlusion_radius,
        tree_memory: _, // no store has trees
        mode,
        reuse,
        base_every: _, // says which ancestry a frame has, which stands apart
        base_place,    // the same, and how long answers of base frames hold
        layers,        // but for what they ask of samples they only show them
        background: _,
        stereo,
        shutter: _, // these say how a frame is exposed, if it is blurred
        exposures: _,
        audit: _,
        build,
        wanted: _, // the counts that follow from it stand here
    } = &job.settings;
    let shadow_rays = job.shadow_rays();
    let backend = job.backend.unwrap_or_default().name();
    let occlusion = job.shot.scene.asks_openness(*layers).then_some((occlusion_rays, occlusion_radius));
    let window = job.settings.data_window();
    let exposures = frame::exposures(&job.shot.scene, &job.settings);
    let text = format!(
        "{width}x{height} {window} {samples} {refinement:?} {depth} {reflections} {paths} {paths_per_frame} {budget:?} \
         {bounces} {volume_bounces} {caustics:?} {clamp:?} {only_lights:?} {occlusion:?} {mode:?} {reuse:?} {base_place:?} {build:?} {backend} {stereo:?} {exposures:?} {shadow_rays:?}"
    );
    Digest::new(text.as_bytes())
}
