//! Checkpoints: sample stores that a run writes on its way, so that it goes on from the last one if it is killed.

use std::fs;
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use super::resume::Fingerprints;
use super::store::{self, Loaded};
use super::target::Target;
use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::frame::Renderer;
use crate::output::store_file::StoreFile;
use crate::output::{WriteError, folder_of, remove_leftovers};
use crate::schedule::{Origin, Rule, Step};

/// Checkpoints of a run, or of a part of it.
#[derive(Debug)]
pub struct Checkpoints {
    path: PathBuf,
    /// Number of frames from one checkpoint to the next.
    every: NonZeroU32,
    /// Number of frames rendered since the last one.
    since: u32,
}

impl Checkpoints {
    /// Creates the checkpoints of a run of the frames from `first` to `last`, one `every` so many frames. Removes what killed runs left
    /// of one that was not whole.
    pub fn new(target: &Target, (first, last): (i32, i32), every: NonZeroU32) -> Self {
        let path = target.checkpoint(first, last);
        remove_leftovers(folder_of(&path), |name| path.file_name().is_some_and(|own| own == name));
        Self { path, every, since: 0 }
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Opens the checkpoint of an earlier run, if there is one, and reads it to its end.
    ///
    /// # Errors It is damaged, or of another shot, version or settings: the text says which. The run then begins at a base frame.
    pub fn open(&self, job: &Job, rule: &Rule<'_>) -> Result<Option<Loaded>, Failure> {
        if self.path.symlink_metadata().is_err() {
            return Ok(None);
        }
        let loaded = Loaded::open(&self.path, job, rule)?;
        StoreFile::open(&self.path).and_then(StoreFile::check).map_err(Failure::of)?;
        Ok(Some(loaded))
    }

    /// Counts the frame of `step`; returns true if a checkpoint of it is due. None is due where the `next` step begins anew, and none of
    /// frames that only serve the run-up: their ancestry is that of another run.
    pub fn is_due(&mut self, step: Step, next: Option<&Step>, fingerprints: &Fingerprints) -> bool {
        self.since += 1;
        self.since >= self.every.get()
            && next.is_some_and(|next| next.origin == Origin::Before)
            && fingerprints.has(step.frame)
    }

    /// Writes the samples of the frame that `renderer` rendered last. All frames up to it must be on the disk: a run that goes on from
    /// here makes none of them again.
    pub fn write(
        &mut self,
        job: &Job,
        fingerprints: &Fingerprints,
        renderer: &Renderer<'_>,
    ) -> Result<(), Failure> {
        if let Some((moment, pictures)) = renderer.samples() {
            store::write(&self.path, job, fingerprints, renderer, (moment, &pictures))?;
            self.since = 0;
        }
        Ok(())
    }

    /// Removes the file: its frames are complete.
    pub fn remove(&self) -> Result<(), Failure> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(Failure::of(WriteError { path: self.path.clone(), source: error }))
            }
            _ => Ok(()),
        }
    }
}
