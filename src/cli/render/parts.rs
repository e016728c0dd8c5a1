//! Parts of a run: all of it, or the segments that no other process has taken (`--shared`).

use std::collections::HashSet;
use std::io::ErrorKind;
use std::num::NonZeroU32;
use std::thread;
use std::time::Duration;

use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::cli::frames::checkpoint::Checkpoints;
use crate::cli::frames::resume::{Fingerprints, Review};
use crate::cli::frames::store::Loaded;
use crate::cli::frames::target::Target;
use crate::output::lock::Lock;
use crate::scene::frames::{Frames, Run};
use crate::schedule::{self, Rule, Step};

/// Pause before a process that has nothing to do looks again whether a lock is free.
const PAUSE: Duration = Duration::from_millis(500);

/// Frames that are rendered one after the other.
#[derive(Debug, Default)]
pub struct Part {
    /// Their schedule.
    pub steps: Vec<Step>,
    /// Store from which they go on, if there is one.
    pub loaded: Option<Loaded>,
    /// Checkpoints to write, if they are asked for.
    pub checkpoints: Option<Checkpoints>,
    /// Lock that keeps other processes away, in a shared run.
    lock: Option<Lock>,
}

impl Part {
    /// Creates a part that no other process wants.
    pub fn new(steps: Vec<Step>, loaded: Option<Loaded>, checkpoints: Option<Checkpoints>) -> Self {
        Self { steps, loaded, checkpoints, lock: None }
    }

    /// Ends the part, whose frames are all on the disk: the checkpoint goes, and then the lock.
    pub fn finish(self) -> Result<(), Failure> {
        let removed = self.checkpoints.as_ref().map_or(Ok(()), Checkpoints::remove);
        drop(self.lock);
        removed
    }
}

/// Supply of parts.
pub enum Parts<'a> {
    /// One part, until it is taken.
    One(Option<Part>),
    /// Segments, of which each process takes what is free.
    Shared(Shared<'a>),
}

impl Parts<'_> {
    /// Returns the next part, or `None` if there is no more to do. In a shared run it waits for segments that other processes have:
    /// if one of them is killed, its lock is free, and its segment comes. `check` fails if waiting is to end.
    pub fn next(&mut self, check: impl Fn() -> Result<(), Failure>) -> Result<Option<Part>, Failure> {
        match self {
            Self::One(part) => Ok(part.take()),
            Self::Shared(shared) => loop {
                match shared.take()? {
                    Taken::Part(part) => return Ok(Some(*part)),
                    Taken::AllDone => return Ok(None),
                    Taken::Busy => {
                        check()?;
                        thread::sleep(PAUSE);
                    }
                }
            },
        }
    }
}

enum Taken {
    Part(Box<Part>),
    /// Other processes have all that is left.
    Busy,
    AllDone,
}

/// A run that several processes share.
pub struct Shared<'a> {
    job: &'a Job,
    rule: Rule<'a>,
    target: &'a Target,
    fingerprints: &'a Fingerprints,
    checkpoint: Option<NonZeroU32>,
    /// Frames that were not finished when the run began.
    wanted: HashSet<i32>,
    /// Segments that are not known to be finished.
    open: Vec<Vec<Run>>,
}

impl<'a> Shared<'a> {
    /// Divides the frames of `job` into segments. `steps` is the schedule of all frames that are not finished.
    pub fn new(
        job: &'a Job,
        rule: Rule<'a>,
        (target, fingerprints): (&'a Target, &'a Fingerprints),
        checkpoint: Option<NonZeroU32>,
        steps: &[Step],
    ) -> Result<Self, Failure> {
        let wanted: HashSet<i32> = steps.iter().filter(|step| step.write).map(|step| step.frame).collect();
        let open = schedule::segments(job.frames.runs(), &rule);
        let open = open.map_err(|error| Failure::Usage(error.to_string()))?;
        let is_open = |segment: &Vec<Run>| frames_of(segment).iter().any(|frame| wanted.contains(frame));
        let open = open.into_iter().filter(is_open).collect();
        Ok(Self { job, rule, target, fingerprints, checkpoint, wanted, open })
    }

    /// Takes the first segment that is neither finished nor locked.
    fn take(&mut self) -> Result<Taken, Failure> {
        let mut at = 0;
        while let Some(segment) = self.open.get(at) {
            let frames = frames_of(segment);
            let ends = (frames[0], frames[frames.len() - 1]);
            let lock = Lock::take(&self.target.lock(ends.0, ends.1)).map_err(|error| {
                if error.source.kind() == ErrorKind::AlreadyExists {
                    return Failure::of(error);
                }
                Failure::Failed(format!(
                    "{error}; --shared needs a file system with locks (flock): without one, give each process its own --frames"
                ))
            })?;
            let Some(lock) = lock else {
                at += 1;
                continue;
            };
            // only now does nobody else write them
            let segment = self.open.remove(at);
            let part = self.part(&segment, ends)?;
            if !part.steps.is_empty() {
                return Ok(Taken::Part(Box::new(Part { lock: Some(lock), ..part })));
            }
            part.finish()?;
        }
        Ok(if self.open.is_empty() { Taken::AllDone } else { Taken::Busy })
    }

    /// Schedule of what is left of a segment, from its checkpoint on if a killed process has left one.
    fn part(&self, segment: &[Run], ends: (i32, i32)) -> Result<Part, Failure> {
        let checkpoints = self.checkpoint.map(|every| Checkpoints::new(self.target, ends, every));
        // one that does not fit, or is damaged, is as good as none
        let loaded = checkpoints.as_ref().and_then(|all| all.open(self.job, &self.rule).ok().flatten());
        let review = Review::new(self.target, self.fingerprints);
        let is_finished = |frame: i32| !self.wanted.contains(&frame) || review.keeps(frame);
        let saved = loaded.as_ref().map(Loaded::saved);
        let steps = schedule::schedule(segment, &self.rule, saved, is_finished);
        let steps = steps.map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Part::new(steps, loaded, checkpoints))
    }
}

/// Frames of a segment, which has some, in rising order.
fn frames_of(segment: &[Run]) -> Vec<i32> {
    Frames::of_runs(segment).list()
}
