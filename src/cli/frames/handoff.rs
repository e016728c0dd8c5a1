//! Handoffs: sample stores that a run leaves beside its frames for runs of neighbouring frames, which go on from them instead of
//! rendering a run-up.
//!
//! Nothing depends on them but time: a store that is not there, damaged or of something else costs a run-up, and no picture.

use std::collections::{BTreeSet, HashSet};
use std::fs;
use std::path::{Path, PathBuf};

use super::resume::Fingerprints;
use super::store::{self, Loaded};
use super::target::Target;
use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::cli::say::terminal::Terminal;
use crate::frame::Renderer;
use crate::output::remove_leftovers;
use crate::output::store_file::StoreFile;
use crate::schedule::followers::Followers;
use crate::schedule::{self, Ancestry, Origin, Rule, Step};

/// Ending of the names of handoffs, and of checkpoints, from which a neighbour may go on as well.
const HANDOFF: &str = "handoff";
const CHECKPOINT: &str = "checkpoint";

/// Handoffs that a run takes and leaves.
pub struct Handoffs<'a> {
    job: &'a Job,
    rule: Rule<'a>,
    target: &'a Target,
    fingerprints: &'a Fingerprints,
    /// Steps from one frame of a chain to the next, in any run of the job.
    strides: BTreeSet<u32>,
    /// Requested frames.
    requested: BTreeSet<i32>,
    /// Reasons why a store could not be left.
    failures: Vec<String>,
}

impl<'a> Handoffs<'a> {
    /// Creates the handoffs of a run of `job`. Removes what killed runs left of one that was not whole.
    pub fn new(job: &'a Job, rule: Rule<'a>, target: &'a Target, fingerprints: &'a Fingerprints) -> Self {
        let strides = job.frames.runs().iter().map(|run| run.step.max(1)).collect();
        let requested = target.frames().iter().copied().collect();
        let handoffs = Self { job, rule, target, fingerprints, strides, requested, failures: Vec::new() };
        remove_leftovers(target.folder(), |name| handoffs.frame_of(name).is_some());
        handoffs
    }

    /// Loads the samples that spare most of the run-up of `steps` into `renderer`, if there are any beside the frames. Returns the
    /// steps that are left then: the first of them goes on from these samples.
    pub fn take(
        &self,
        steps: &[Step],
        renderer: &mut Renderer<'_>,
        terminal: &Terminal,
    ) -> Result<Option<Vec<Step>>, Failure> {
        if steps.iter().all(|step| step.write) {
            return Ok(None);
        }
        let refuse = |path: &Path, failure: Failure| {
            // one that has gone meanwhile was another run's to remove
            if path.exists() {
                terminal.note(&format!("--handoff: {} is not taken: {failure}", path.display()));
            }
        };
        let wanted: HashSet<i32> = steps.iter().filter(|step| step.write).map(|step| step.frame).collect();
        let mut found = Vec::new();
        for path in self.stores() {
            match Loaded::open(&path, self.job, &self.rule) {
                Ok(loaded) => {
                    let runs = self.job.frames.runs();
                    let saved = Some(loaded.saved());
                    let left = schedule::schedule(runs, &self.rule, saved, |frame| !wanted.contains(&frame));
                    let left = left.map_err(|error| Failure::Usage(error.to_string()))?;
                    if left.first().is_some_and(|step| step.origin == Origin::Saved) {
                        found.push((left, loaded, path));
                    }
                }
                Err(failure) => refuse(&path, failure),
            }
        }
        found.sort_by_key(|(left, ..)| left.len());
        for (left, loaded, path) in found {
            match loaded.give(self.job, renderer) {
                Ok(()) => {
                    let frame = loaded.saved().frame;
                    terminal.note(&format!("--handoff: goes on from frame {frame} ({})", path.display()));
                    return Ok(Some(left));
                }
                Err(failure) => refuse(&path, failure),
            }
        }
        Ok(None)
    }

    /// Leaves the samples of the frame of `step`, which `renderer` rendered last, if frames that other runs have not made yet follow
    /// from it.
    pub fn leave(&mut self, step: Step, renderer: &Renderer<'_>) {
        let leads_out = |stride: &u32| {
            let Followers { ways, .. } = self.rule.followers(step.frame, *stride);
            ways.iter().filter_map(|way| way.first()).any(|next| !self.requested.contains(next))
        };
        let mut strides: Vec<u32> = self.strides.iter().copied().collect();
        if let Ancestry::Inferred { stride, .. } = self.fingerprints.ancestry(step.frame) {
            strides = vec![stride];
        }
        strides.retain(leads_out);
        if !self.fingerprints.has(step.frame) || !self.is_needed(step.frame, &strides) {
            return;
        }
        let Some((moment, pictures)) = renderer.samples() else { return };
        let path = self.target.handoff(step.frame);
        if let Err(failure) = store::write(&path, self.job, self.fingerprints, renderer, (moment, &pictures))
        {
            self.failures
                .push(format!("--handoff: no samples are left for the frames that follow: {failure}"));
        }
    }

    /// Notes on stores that could not be left.
    pub fn notes(&self) -> &[String] {
        &self.failures
    }

    /// Removes stores that nobody needs any more: all frames are made that would be made of them, and not of a later one.
    pub fn tidy(&self) {
        for (frame, path) in self.handoffs() {
            let Ok(loaded) = Loaded::open(&path, self.job, &self.rule) else { continue };
            let strides = match loaded.saved().ancestry {
                Ancestry::Base => self.strides.iter().copied().collect(),
                Ancestry::Inferred { stride, .. } => vec![stride],
            };
            if loaded.saved().frame == frame && !self.is_needed(frame, &strides) {
                // another run may have been faster
                drop(fs::remove_file(path));
            }
        }
    }

    /// Returns true if frames that are not made follow from `frame` in chains with these steps, before the next store.
    fn is_needed(&self, frame: i32, strides: &[u32]) -> bool {
        strides.iter().any(|stride| {
            let Followers { ancestry, ways } = self.rule.followers(frame, *stride);
            let made_from = self.fingerprints.with(ancestry);
            ways.iter().any(|way| {
                let unmade = way.iter().find(|frame| !self.target.is_made(**frame, &made_from));
                let next_store = way.iter().find(|frame| self.leaves(**frame, ancestry));
                match (unmade, next_store) {
                    (Some(unmade), Some(store)) => unmade.abs_diff(frame) <= store.abs_diff(frame),
                    (unmade, _) => unmade.is_some(),
                }
            })
        })
    }

    /// Returns true if a handoff of `frame` with that ancestry is there.
    fn leaves(&self, frame: i32, ancestry: Ancestry) -> bool {
        StoreFile::open(&self.target.handoff(frame)).is_ok_and(|file| {
            let header = file.header();
            header.frame == frame
                && header.ancestry == ancestry.to_string()
                && header.fingerprint == store::fingerprint(self.job)
        })
    }

    /// Handoffs and checkpoints of other runs beside the frames, in the order of their names.
    fn stores(&self) -> Vec<PathBuf> {
        let own = self.target.checkpoint(self.job.frames.first(), self.job.frames.last());
        let is_store = |name: &str| self.frame_of(name).is_some() || self.is_checkpoint(name);
        let paths = self.names().into_iter().filter(|name| is_store(name));
        paths.map(|name| self.target.folder().join(name)).filter(|path| *path != own).collect()
    }

    /// Handoffs beside the frames.
    fn handoffs(&self) -> Vec<(i32, PathBuf)> {
        let frames = self.names().into_iter().filter_map(|name| self.frame_of(&name));
        frames.map(|frame| (frame, self.target.handoff(frame))).collect()
    }

    fn names(&self) -> Vec<String> {
        let entries = self.target.folder().read_dir().into_iter().flatten().filter_map(Result::ok);
        let mut names: Vec<String> =
            entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
        names.sort_unstable();
        names
    }

    /// Frame of the handoff with that name.
    fn frame_of(&self, name: &str) -> Option<i32> {
        let frame = self.middle(name, HANDOFF)?.parse().ok()?;
        self.target.handoff(frame).ends_with(name).then_some(frame)
    }

    fn is_checkpoint(&self, name: &str) -> bool {
        // `-` may also be a sign
        let is_numbers = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-');
        self.middle(name, CHECKPOINT).is_some_and(is_numbers)
    }

    /// Text between the shot's name and `ending`.
    fn middle<'n>(&self, name: &'n str, ending: &str) -> Option<&'n str> {
        let rest = name.strip_prefix(self.target.shot())?.strip_prefix('.')?;
        rest.strip_suffix(ending)?.strip_suffix('.')
    }
}
