//! Finds frames of an earlier run that equal those of this run: `--resume` keeps them.
//!
//! Each frame has a [`Fingerprint`] of what it was made from. Its settings are those that change pixels, and
//! the frame's ancestry: the base frame from which it was inferred, and the steps. So kept and new frames
//! are, pixel by pixel, those of one run without an interruption.

use std::cell::RefCell;
use std::collections::BTreeMap;

use super::frame_list;
use super::target::{FileState, Target};
use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::digest::Digest;
use crate::frame;
use crate::output::Fingerprint;
use crate::output::fingerprint::MadeFrom;
use crate::report::{arithmetic, versions};
use crate::schedule::{self, Ancestry, Rule};
use crate::settings::{Budget, FileFormat, Mode, Settings};
use crate::trace::BackendKind;

/// Fingerprints of the frames of a run.
#[derive(Debug, Clone)]
pub struct Fingerprints {
    /// Fingerprint without the ancestry, common to all frames.
    all: Fingerprint,
    ancestries: BTreeMap<i32, Ancestry>,
}

impl Fingerprints {
    /// Computes the fingerprints of the frames that `job` asks for, by the schedule's `rule`.
    pub fn new(job: &Job, rule: &Rule<'_>) -> Result<Self, Failure> {
        let ancestries = schedule::ancestries(job.frames.runs(), rule);
        let ancestries = ancestries.map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Self { all: Self::of_all_frames(job), ancestries })
    }

    /// Fingerprint that all frames of `job` have in common.
    pub fn of_all_frames(job: &Job) -> Fingerprint {
        Fingerprint {
            version: version(job.backend.unwrap_or_default()),
            shot: job.shot.content.shot,
            inputs: job.shot.content.inputs,
            settings: settings(job),
        }
    }

    /// Ancestry of a requested frame.
    pub fn ancestry(&self, frame: i32) -> Ancestry {
        self.ancestries.get(&frame).copied().unwrap_or(Ancestry::Base)
    }

    /// Returns true if `frame` is a requested one.
    pub fn has(&self, frame: i32) -> bool {
        self.ancestries.contains_key(&frame)
    }

    /// Fingerprints of a requested frame, and of the run.
    pub fn made_from(&self, frame: i32) -> MadeFrom {
        MadeFrom { frame: self.at(frame), run: self.all }
    }

    /// Fingerprint of a requested frame.
    pub fn at(&self, frame: i32) -> Fingerprint {
        self.with(self.ancestry(frame))
    }

    /// Fingerprint of a frame with that ancestry, requested or not.
    pub fn with(&self, ancestry: Ancestry) -> Fingerprint {
        let ancestry = ancestry.to_string();
        let settings = Digest::of_all([self.all.settings, Digest::new(ancestry.as_bytes())]);
        Fingerprint { settings, ..self.all }
    }
}

/// Digest of the program's version, and of all that decides how this machine rounds: nodes of a farm may differ in it.
fn version(backend: BackendKind) -> Digest {
    let library = match backend {
        BackendKind::Embree => versions::embree(),
        BackendKind::Rust => String::new(),
    };
    let arithmetic = arithmetic::name(backend);
    Digest::new(format!("{} {library} {arithmetic}", versions::AFTERIMAGE).as_bytes())
}

/// Digest of all settings that change pixels, the header's frame rate, or the format of files. Each setting
/// is named here, or left out for a reason: a new one does not compile until somebody has decided.
fn settings(job: &Job) -> Digest {
    let Settings {
        width,
        height,
        overscan: _, // stands in the data window, and changes no pixel of it
        crop: _,
        samples,
        refinement,
        filter,
        filter_radius: _, // of which it follows how far the filter reaches
        depth,
        reflections,
        paths,
        paths_per_frame,
        budget,
        bounces,
        volume_bounces,
        volume_samples,
        caustics,
        clamp,
        only_lights,
        occlusion_rays,
        occlusion_radius,
        tree_memory: _, // kept or traced again, trees bring the same
        stereo,
        shutter: _, // these say how a frame is exposed, if it is blurred
        exposures: _,
        mode,
        reuse,
        base_every: _, // says which ancestry a frame has, which stands apart
        base_place,
        layers,
        background,
        audit: _, // looks, and changes nothing
        build,
        wanted: _, // the counts that follow from it stand here
    } = &job.settings;
    let shadow_rays = job.shadow_rays();
    let backend = job.backend.unwrap_or_default().name();
    let FileFormat { multipart, compression } = job.format;
    // without reuse its rule does not matter
    let reuses = *mode != Mode::Full;
    let reuse = reuses.then_some(reuse);
    // the radius of occlusion that no layer and no light needs does not matter
    let occlusion = job.shot.scene.asks_openness(*layers).then_some((occlusion_rays, occlusion_radius));
    // with base frames in the middle, answers expire sooner: visible if paths share a budget
    let base_place = (reuses && *paths > 0 && *budget != Budget::None).then_some(base_place);
    let exposures = frame::exposures(&job.shot.scene, &job.settings);
    let (radius, window) = (job.settings.filter_radius(), job.settings.data_window());
    let text = format!(
        "{width}x{height} {window} {samples} {refinement:?} {filter:?} {radius} {depth} {reflections} {paths} {paths_per_frame} {budget:?} {bounces} {volume_bounces} {volume_samples} {caustics:?} {clamp:?} {only_lights:?} \
         {occlusion:?} {mode:?} {reuse:?} {layers:?} {background:?} {build:?} {backend} {multipart} {compression:?} {stereo:?} {:?} {:?} {exposures:?} {base_place:?} {shadow_rays:?}",
        job.denoise, job.shot.rate
    );
    Digest::new(text.as_bytes())
}

/// Reviews the frames of an earlier run, and remembers why some of them are not kept.
pub struct Review<'a> {
    target: &'a Target,
    fingerprints: &'a Fingerprints,
    /// Frames that are not kept, by reason.
    refused: RefCell<BTreeMap<String, Vec<i32>>>,
}

impl<'a> Review<'a> {
    /// Creates a review of the frames at `target`.
    pub fn new(target: &'a Target, fingerprints: &'a Fingerprints) -> Self {
        Self { target, fingerprints, refused: RefCell::default() }
    }

    /// Returns true if `frame` exists, is whole, and equals the frame that this run would make.
    pub fn keeps(&self, frame: i32) -> bool {
        let why = match self.target.left(frame, &self.fingerprints.at(frame)) {
            FileState::Nothing => return false,
            FileState::Finished => return true,
            other => other.to_string(),
        };
        self.refused.borrow_mut().entry(why).or_default().push(frame);
        false
    }

    /// Note on existing frames that are rendered again, with each reason once.
    pub fn note(self) -> Option<String> {
        let refused = self.refused.into_inner();
        let reasons = refused.into_iter().map(|(why, mut frames)| {
            frames.sort_unstable();
            format!("{} ({why})", frame_list::frames(&frames))
        });
        let reasons: Vec<String> = reasons.collect();
        (!reasons.is_empty()).then(|| format!("resume: rendering again {}", reasons.join("; ")))
    }
}
