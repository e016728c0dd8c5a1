//! Which frames are rendered, in which order, and which of them are base frames.
//!
//! The invariant that farms rely on: whether a frame is a base frame, and which frame it is inferred
//! from, follow from its absolute number, the shot, and the step of its run. Where a chunk starts never
//! matters; a chunk that starts between base frames renders a *run-up* from the base frame before it,
//! which is not written. Chunks of the same step and phase (position within the step, counted from the
//! shot's first frame) form one *chain* and give the same pictures.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use crate::scene::frames::Run;

/// More steps than this are taken for a mistake.
const MOST_STEPS: usize = 1_000_000;

/// What makes a base frame.
#[derive(Debug, Clone, Copy)]
pub struct Rule<'a> {
    /// The shot's first frame. Nothing is inferred from what is before it: earlier frames that were
    /// asked for are base frames, each of them.
    pub shot_first: i32,
    /// A base frame every so many frames, counted from `shot_first`; 0: no more than the first.
    pub base_every: u32,
    /// Each is the first frame after a cut of the camera.
    pub cuts: &'a [i32],
    /// Every frame is traced from nothing (`--mode full`).
    pub full: bool,
}

/// One frame to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Its number.
    pub frame: i32,
    /// Inferred from the step before it in the schedule; otherwise a base frame.
    pub reuse: bool,
    /// Asked for, and not finished by an earlier run. Other frames are run-up.
    pub write: bool,
}

/// How the samples of a frame come about: which base frame they began in, and how many frames lie between one step and the
/// next. Frames of one ancestry and one number are the same, whatever else is rendered with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ancestry {
    /// The frame is a base frame itself.
    Base,
    /// Inferred, step by step.
    Inferred {
        /// The base frame.
        from: i32,
        /// Frames from one step to the next.
        stride: u32,
    },
}

impl fmt::Display for Ancestry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base => f.write_str("base"),
            Self::Inferred { from, stride } => write!(f, "from {from} by {stride}"),
        }
    }
}

/// The schedule would be absurdly long. The text says why and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TooLong {
    frame: i32,
}

impl fmt::Display for TooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frame {} is more than {MOST_STEPS} frames after the base frame it depends on; \
             set --base-every, or --mode full, or correct --frames",
            self.frame
        )
    }
}

impl std::error::Error for TooLong {}

impl Rule<'_> {
    /// Whether `frame` of a chain with that step is traced from nothing.
    fn is_base(&self, frame: i64, step: i64) -> bool {
        let before = frame - step;
        self.full
            || before < i64::from(self.shot_first)
            || self.interval(before) != self.interval(frame)
            || self.cuts.iter().any(|&cut| before < i64::from(cut) && i64::from(cut) <= frame)
    }

    /// The number of the interval between base frames that `frame` lies in.
    fn interval(&self, frame: i64) -> i64 {
        match self.base_every {
            0 => 0,
            every => (frame - i64::from(self.shot_first)).div_euclid(i64::from(every)),
        }
    }
}

/// Orders the frames of `runs`, chain by chain, each chain in rising order; every frame is written once.
///
/// `finished` tells the frames that an earlier run has written (`--resume`): they are rendered only
/// where a later frame that is not finished is inferred from them.
pub fn schedule(runs: &[Run], rule: &Rule<'_>, finished: impl Fn(i32) -> bool) -> Result<Vec<Step>, TooLong> {
    let mut steps = Vec::new();
    for (stride, frames) in chains(runs, rule.shot_first) {
        let mut last = None;
        for frame in frames.into_iter().filter(|&frame| !finished(frame)) {
            let way = way_to(frame, stride, last, rule)?;
            if steps.len() + way.len() > MOST_STEPS {
                return Err(TooLong { frame });
            }
            steps.extend(way);
            last = Some(frame);
        }
    }
    Ok(steps)
}

/// The ancestry of each frame of `runs`.
pub fn ancestries(runs: &[Run], rule: &Rule<'_>) -> Result<BTreeMap<i32, Ancestry>, TooLong> {
    let mut ancestries = BTreeMap::new();
    for (stride, frames) in chains(runs, rule.shot_first) {
        let (mut last, mut base) = (None, 0);
        for frame in frames {
            let way = way_to(frame, stride, last, rule)?;
            // a way that begins with no base frame goes on where the last one ended
            base = way.first().filter(|step| !step.reuse).map_or(base, |step| step.frame);
            last = Some(frame);
            let is_base = way.last().is_some_and(|step| !step.reuse);
            let ancestry = if is_base { Ancestry::Base } else { Ancestry::Inferred { from: base, stride } };
            ancestries.insert(frame, ancestry);
        }
    }
    Ok(ancestries)
}

/// The frames to render so that `frame` is there, when `last` was the chain's last one before.
fn way_to(frame: i32, stride: u32, last: Option<i32>, rule: &Rule<'_>) -> Result<Vec<Step>, TooLong> {
    let mut way = Vec::new();
    let mut at = frame;
    while Some(at) != last {
        let base = rule.is_base(i64::from(at), i64::from(stride));
        way.push(Step { frame: at, reuse: !base, write: at == frame });
        if base {
            break;
        }
        if way.len() > MOST_STEPS {
            return Err(TooLong { frame });
        }
        // no base, so the frame before is not before the shot's first: it fits
        at = (i64::from(at) - i64::from(stride)) as i32;
    }
    way.reverse();
    Ok(way)
}

/// Frames by chain, with the chain's step. A frame of several chains belongs to the first.
fn chains(runs: &[Run], shot_first: i32) -> Vec<(u32, BTreeSet<i32>)> {
    let mut chains: Vec<((u32, i64), BTreeSet<i32>)> = Vec::new();
    let mut taken = BTreeSet::new();
    for run in runs {
        let stride = run.step.max(1);
        let phase = (i64::from(run.first) - i64::from(shot_first)).rem_euclid(i64::from(stride));
        let key = (stride, phase);
        let index = chains.iter().position(|chain| chain.0 == key).unwrap_or_else(|| {
            chains.push((key, BTreeSet::new()));
            chains.len() - 1
        });
        let frames = (run.first..=run.last).step_by(stride as usize);
        chains[index].1.extend(frames.filter(|&frame| taken.insert(frame)));
    }
    chains.into_iter().map(|((stride, _), frames)| (stride, frames)).collect()
}

/// What to say about the frames that are rendered without being written, if there are any. `remedy` says how to have fewer.
pub fn run_up_note(steps: &[Step], remedy: &str) -> Option<String> {
    let count = steps.iter().filter(|step| !step.write).count();
    let first = steps.iter().find(|step| !step.write)?;
    let (frames, are) = if count == 1 { ("frame", "is") } else { ("frames", "are") };
    // then most of the time goes into frames that nobody asked for
    let much = match steps.len() - count {
        written if count > written => format!(", more than the {written} to write"),
        _ => String::new(),
    };
    Some(format!(
        "run-up: {count} {frames} from {} on {are} rendered without being written{much}, because later frames \
         are inferred from them ({remedy})",
        first.frame
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::frames::Frames;

    const RULE: Rule<'_> = Rule { shot_first: 1, base_every: 10, cuts: &[], full: false };

    fn plan(frames: &str, rule: &Rule<'_>) -> Vec<Step> {
        resumed(frames, rule, &[])
    }

    fn resumed(frames: &str, rule: &Rule<'_>, finished: &[i32]) -> Vec<Step> {
        let frames = Frames::parse(frames).expect("a good range");
        schedule(frames.runs(), rule, |frame| finished.contains(&frame)).expect("short enough")
    }

    fn bases(steps: &[Step]) -> Vec<i32> {
        steps.iter().filter(|step| !step.reuse).map(|step| step.frame).collect()
    }

    fn written(steps: &[Step]) -> Vec<i32> {
        steps.iter().filter(|step| step.write).map(|step| step.frame).collect()
    }

    /// (frame, inferred from) for each written frame.
    fn ancestry(steps: &[Step]) -> Vec<(i32, Vec<i32>)> {
        let mut chain = Vec::new();
        let mut all = Vec::new();
        for step in steps {
            if !step.reuse {
                chain.clear();
            }
            chain.push(step.frame);
            if step.write {
                all.push((step.frame, chain.clone()));
            }
        }
        all.sort();
        all
    }

    #[test]
    fn bases_lie_on_a_grid_from_the_shots_first_frame() {
        let steps = plan("1-25", &RULE);
        assert_eq!(bases(&steps), [1, 11, 21]);
        assert_eq!(written(&steps), (1..=25).collect::<Vec<_>>());
        let once = Rule { base_every: 0, ..RULE };
        assert_eq!(bases(&plan("1-25", &once)), [1]);
    }

    #[test]
    fn a_chunk_starts_at_the_base_frame_before_it() {
        let steps = plan("15-17", &RULE);
        assert_eq!(steps.len(), 7);
        assert_eq!((bases(&steps), written(&steps)), (vec![11], vec![15, 16, 17]));
        let note = |frames| run_up_note(&plan(frames, &RULE), "remedy");
        assert!(note("11-20").is_none());
        for (frames, words) in [
            (
                "15-17",
                "4 frames from 11 on are rendered without being written, more than the 3 to write, because",
            ),
            (
                "19-20",
                "8 frames from 11 on are rendered without being written, more than the 2 to write, because",
            ),
            ("12-20", "1 frame from 11 on is rendered without being written, because"),
        ] {
            let note = note(frames).expect("frames that are not written");
            assert!(note.contains(words) && note.ends_with("(remedy)"), "{note}");
        }
    }

    #[test]
    fn chunks_give_every_frame_the_ancestry_that_the_whole_gives() {
        for rule in [RULE, Rule { base_every: 0, ..RULE }, Rule { cuts: &[8, 19], ..RULE }] {
            for step in 1..=4 {
                let whole = ancestry(&plan(&format!("1-40x{step}"), &rule));
                let second = 1 + step * 3;
                let mut chunks = ancestry(&plan(&format!("1-{}x{step}", second - 1), &rule));
                chunks.extend(ancestry(&plan(&format!("{second}-40x{step}"), &rule)));
                assert_eq!(whole, chunks, "step {step}, {rule:?}");
            }
        }
    }

    #[test]
    fn a_step_across_the_grid_makes_a_base() {
        // 1 4 7 10 | 13 16 19 | 22 25: the first of each ten
        assert_eq!(bases(&plan("1-25x3", &RULE)), [1, 13, 22]);
        // another phase has its own first frame
        assert_eq!(bases(&plan("2-25x3", &RULE)), [2, 11, 23]);
    }

    #[test]
    fn a_cut_is_a_base_even_if_the_step_jumps_over_it() {
        let rule = Rule { base_every: 0, cuts: &[8], ..RULE };
        assert_eq!(bases(&plan("1-12", &rule)), [1, 8]);
        assert_eq!(bases(&plan("1-12x3", &rule)), [1, 10]);
        assert_eq!(bases(&plan("10-12", &rule)), [8]);
    }

    #[test]
    fn before_the_shots_first_frame_each_frame_is_a_base() {
        let steps = plan("-2-3", &RULE);
        assert_eq!(bases(&steps), [-2, -1, 0, 1]);
        assert_eq!(written(&steps).len(), steps.len());
    }

    #[test]
    fn full_mode_needs_no_run_up() {
        let rule = Rule { full: true, ..RULE };
        let steps = plan("15-17,99", &rule);
        assert_eq!((bases(&steps), written(&steps)), (vec![15, 16, 17, 99], vec![15, 16, 17, 99]));
    }

    #[test]
    fn a_later_run_of_the_same_chain_goes_on_where_it_is_nearer() {
        let once = Rule { base_every: 0, ..RULE };
        assert_eq!(plan("1-3,6-7", &once).len(), 7);
        // with a base frame between, that is the nearer start
        assert_eq!(bases(&plan("1-3,22", &RULE)), [1, 21]);
    }

    #[test]
    fn frames_asked_for_twice_are_written_once() {
        assert_eq!(written(&plan("1-6,4-8,2-8x2", &RULE)), (1..=8).collect::<Vec<_>>());
    }

    #[test]
    fn resume_renders_finished_frames_only_as_run_up() {
        let all: Vec<i32> = (1..=30).collect();
        assert!(resumed("1-30", &RULE, &all).is_empty());
        let steps = resumed("1-30", &RULE, &all[..14]);
        assert_eq!((steps[0].frame, written(&steps)), (11, (15..=30).collect()));
        // a hole: up to it, and then on from the next base frame
        let steps = resumed("1-30", &RULE, &[1, 2, 3, 5, 6, 7, 8, 9, 10]);
        let frames: Vec<i32> = steps.iter().map(|step| step.frame).collect();
        assert_eq!(frames, (1..=4).chain(11..=30).collect::<Vec<_>>());
    }

    #[test]
    fn resumed_frames_keep_their_ancestry() {
        let whole = ancestry(&plan("1-30", &RULE));
        let rest = ancestry(&resumed("1-30", &RULE, &[1, 2, 3, 4, 9, 17]));
        assert!(rest.iter().all(|frame| whole.contains(frame)));
    }

    #[test]
    fn ancestries_are_those_of_the_schedule() {
        let rules = [RULE, Rule { base_every: 0, ..RULE }, Rule { cuts: &[8, 19], ..RULE }];
        let ranges = ["1-40", "3-40x3", "-2-3", "15-17,33", "1-40x2,2-40x3", "5"];
        for (rule, range) in rules.iter().flat_map(|rule| ranges.iter().map(move |range| (rule, range))) {
            let frames = Frames::parse(range).expect("a good range");
            let ancestries = ancestries(frames.runs(), rule).expect("short enough");
            let whole = ancestry(&plan(range, rule));
            assert_eq!(whole.len(), ancestries.len(), "{range}");
            for (frame, chain) in whole {
                let expected = match chain[..] {
                    [_] => Ancestry::Base,
                    [from, next, ..] => Ancestry::Inferred { from, stride: (next - from) as u32 },
                    [] => unreachable!("a chain ends with its frame"),
                };
                assert_eq!(ancestries[&frame], expected, "{frame} of {range}, {rule:?}");
            }
        }
    }

    #[test]
    fn extreme_numbers_are_an_error_not_an_overflow() {
        let once = Rule { base_every: 0, ..RULE };
        let frames = Frames::parse("2147483647").expect("good");
        let error = schedule(frames.runs(), &once, |_| false).expect_err("too far");
        assert!(error.to_string().contains("--base-every"));
        assert_eq!(plan("2147483647", &RULE).len(), 7);
        let low = Rule { shot_first: i32::MIN, ..once };
        assert_eq!(plan("-2147483648", &low).len(), 1);
        assert_eq!(plan("-2147483648-2147483647x4294967295", &low).len(), 2);
    }
}
