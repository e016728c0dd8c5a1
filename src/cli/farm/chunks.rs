//! Division of a shot into chunks, by the schedule that renders them.

use std::num::NonZeroU32;

use crate::cli::args::Job;
use crate::cli::failure::Failure;
use crate::scene::frames::{Frames, Run};
use crate::schedule::{self, Rule, Step};

/// Maximum number of chunks. Slurm takes arrays of 1000 unless it is told otherwise, Open Job Description lists of 1024.
const MOST_CHUNKS: usize = 1000;

/// Frames of one task.
#[derive(Debug, Clone)]
pub struct Chunk {
    /// The frames that it writes.
    pub frames: Frames,
    /// Frames that it renders, run-up included.
    pub steps: Vec<Step>,
}

/// Divides the frames of `job`: by segments, or so many at a time. Those with the least run-up come first: when the others begin, the
/// chunks before them may have handed on their samples.
pub fn divide(job: &Job, rule: &Rule<'_>, size: Option<NonZeroU32>) -> Result<Vec<Chunk>, Failure> {
    let usage = |error: schedule::TooLong| Failure::Usage(error.to_string());
    let segments = schedule::segments(job.frames.runs(), rule).map_err(usage)?;
    let parts: Vec<Vec<Run>> = match size {
        None => segments,
        Some(size) => {
            let frames: Vec<Run> = segments.into_iter().flatten().flat_map(single).collect();
            frames.chunks(size.get() as usize).map(joined).collect()
        }
    };
    let at_once = parts.len().div_ceil(MOST_CHUNKS).max(1);
    let parts = parts.chunks(at_once).map(|parts| joined(&parts.concat()));
    let chunk = |runs: Vec<Run>| {
        let steps = schedule::schedule(&runs, rule, None, |_| false).map_err(usage)?;
        Ok(Chunk { frames: Frames::of_runs(&runs), steps })
    };
    let mut chunks: Vec<Chunk> = parts.map(chunk).collect::<Result<_, Failure>>()?;
    chunks.sort_by_key(|chunk| run_up(std::slice::from_ref(chunk)));
    Ok(chunks)
}

/// Frames of a run, as runs of one frame with the same step.
fn single(run: Run) -> impl Iterator<Item = Run> {
    (run.first..=run.last).step_by(run.step as usize).map(move |frame| Run {
        first: frame,
        last: frame,
        ..run
    })
}

/// These frames in as few runs as possible.
fn joined(runs: &[Run]) -> Vec<Run> {
    let mut all: Vec<Run> = Vec::new();
    for run in runs {
        match all.last_mut() {
            Some(last)
                if last.step == run.step
                    && i64::from(last.last) + i64::from(run.step) == i64::from(run.first) =>
            {
                last.last = run.last;
            }
            _ => all.push(*run),
        }
    }
    all
}

/// Number of frames that all chunks render.
fn steps(chunks: &[Chunk]) -> usize {
    chunks.iter().map(|chunk| chunk.steps.len()).sum()
}

/// Number of frames that all chunks write.
pub fn frames(chunks: &[Chunk]) -> usize {
    chunks.iter().map(|chunk| chunk.steps.iter().filter(|step| step.write).count()).sum()
}

/// Number of frames that all chunks render without writing them, if none goes on from the samples of another.
pub fn run_up(chunks: &[Chunk]) -> usize {
    steps(chunks) - frames(chunks)
}

/// Note on chunks that render more than they write, or that are one.
pub fn note(chunks: &[Chunk]) -> Option<String> {
    let run_up = run_up(chunks);
    if run_up > 0 {
        return Some(format!(
            "chunks do not end with segments: {run_up} of {} rendered frames are run-up, unless the chunk before has finished and \
             handed on its samples; leave out --chunk, or give --base-every the same number",
            steps(chunks)
        ));
    }
    (chunks.len() == 1 && frames(chunks) > 1).then(|| {
        String::from("all frames are one segment, and one chunk: set base_every in the shot, or --base-every after `--`")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_where_they_meet() {
        let run = |first, last, step| Run { first, last, step };
        assert_eq!(joined(&[run(1, 4, 1), run(5, 5, 1), run(7, 9, 1)]), [run(1, 5, 1), run(7, 9, 1)]);
        assert_eq!(joined(&[run(1, 5, 2), run(7, 7, 2), run(8, 8, 1)]), [run(1, 7, 2), run(8, 8, 1)]);
        let frames: Vec<Run> = single(run(1, 7, 3)).collect();
        assert_eq!(frames, [run(1, 1, 3), run(4, 4, 3), run(7, 7, 3)]);
        assert_eq!(joined(&frames), [run(1, 7, 3)]);
    }
}
