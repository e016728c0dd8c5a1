//! Decides which frames are rendered, in which order, and which of them are base frames.
//!
//! The invariant that farms rely on: whether a frame is a base frame, and which frame it is inferred
//! from, follow from its absolute number, the shot, and the step of its run. Where a chunk starts never
//! matters; a chunk that starts between base frames renders a *run-up* from the base frame of its segment,
//! which is not written. Chunks of the same step and phase (position within the step, counted from the
//! shot's first frame) form one *chain* and give the same pictures.
//!
//! A *segment* lies between two borders: cuts, and those that the rule sets every so many frames. Its base
//! frame is its first one, or the one in its middle. From there frames are inferred step by step, later ones first and
//! then, from the base frame again, earlier ones backwards in time.

pub mod followers;
pub mod steps;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::scene::Shot;
use crate::scene::frames::Run;
use crate::settings::{BasePlace, Mode, Settings};

/// Maximum number of steps: more are taken for a mistake.
const MOST_STEPS: usize = 1_000_000;

/// Rule that decides base frames.
#[derive(Debug, Clone, Copy)]
pub struct Rule<'a> {
    /// The shot's first frame. Nothing is inferred from earlier frames: those that are requested are all base
    /// frames.
    pub shot_first: i32,
    /// The shot's last frame, if it says which frames it has: a segment ends there.
    pub shot_last: Option<i32>,
    /// Number of frames of a segment, counted from `shot_first`. 0: cuts are the only borders.
    pub base_every: u32,
    /// Position of the base frame in its segment.
    pub base_place: BasePlace,
    /// First frame after each cut of the camera.
    pub cuts: &'a [i32],
    /// True if every frame is traced from nothing (`--mode full`).
    pub full: bool,
}

/// Source of the samples from which a frame is inferred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// No source: it is a base frame.
    Nothing,
    /// The step before it in the schedule.
    Before,
    /// The last base frame, backwards in time. If there were steps since, a copy of its samples was kept.
    Base,
    /// A store that an earlier run has saved.
    Saved,
}

/// One frame to render.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// Number of the frame.
    pub frame: i32,
    /// Source of its samples.
    pub origin: Origin,
    /// True if a copy of its samples is needed later: see [`Origin::Base`].
    pub keep: bool,
    /// True if it is requested, and not finished by an earlier run. Other frames are run-up.
    pub write: bool,
}

impl Step {
    /// Returns true if it is inferred from another frame.
    pub fn reuses(&self) -> bool {
        self.origin != Origin::Nothing
    }
}

/// Origin of a frame's samples: the base frame in which they began, and the number of frames from one step to
/// the next. Frames of one ancestry and one number are the same, whatever else is rendered with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ancestry {
    /// The frame is a base frame itself.
    Base,
    /// Inferred, step by step.
    Inferred {
        /// The base frame, before it or after it.
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

impl FromStr for Ancestry {
    type Err = ();

    /// Parses the text that [`Display`](fmt::Display) gives.
    fn from_str(text: &str) -> Result<Self, ()> {
        if text == "base" {
            return Ok(Self::Base);
        }
        let (from, stride) = text.strip_prefix("from ").and_then(|text| text.split_once(" by ")).ok_or(())?;
        let stride = stride.parse().ok().filter(|stride| *stride > 0).ok_or(())?;
        Ok(Self::Inferred { from: from.parse().map_err(drop)?, stride })
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
            "frame {} is more than {MOST_STEPS} frames away from the base frame it depends on; \
             set --base-every, or --mode full, or correct --frames",
            self.frame
        )
    }
}

impl std::error::Error for TooLong {}

impl<'a> Rule<'a> {
    /// Creates the rule for frames of `shot` that are rendered with `settings`.
    pub fn new(shot: &'a Shot, settings: &Settings) -> Self {
        Self {
            shot_first: shot.frames.first(),
            shot_last: shot.says_frames.then(|| shot.frames.last()),
            base_every: settings.base_every,
            base_place: settings.base_place,
            cuts: &shot.scene.camera.cuts,
            full: settings.mode == Mode::Full,
        }
    }
}

impl Rule<'_> {
    /// The base frame from which `frame` of a chain with that step is inferred; the frame itself if it is one.
    fn base_of(&self, frame: i32, step: u32) -> Result<i32, TooLong> {
        let (number, step) = (i64::from(frame), i64::from(step));
        if self.full || frame < self.shot_first {
            return Ok(frame);
        }
        let segment = self.segment(number);
        // how many frames of the chain there are in the segment, on either side
        let before = (number - segment.start) / step;
        let after = (segment.end - 1 - number) / step;
        let way = match self.base_place {
            BasePlace::First => -before,
            BasePlace::Middle => (before + after + 1) / 2 - before,
        };
        if way.unsigned_abs() >= MOST_STEPS as u64 {
            return Err(TooLong { frame });
        }
        Ok((number + way * step) as i32) // it is a frame of the segment, which has 32 bits
    }

    /// The segment in which `frame` is; frames before the shot's first are in none.
    fn segment(&self, frame: i64) -> Range<i64> {
        let (first, every) = (i64::from(self.shot_first), i64::from(self.base_every));
        let mut segment = match every {
            0 => first..i64::MAX,
            _ => {
                let start = first + (frame - first).div_euclid(every) * every;
                start..start + every
            }
        };
        let after_last = self.shot_last.map(|last| i64::from(last) + 1);
        let after_last = after_last.filter(|_| self.base_place == BasePlace::Middle);
        let beyond = i64::from(i32::MAX) + 1;
        for border in self.cuts.iter().map(|cut| i64::from(*cut)).chain(after_last).chain([beyond]) {
            if border <= frame {
                segment.start = segment.start.max(border);
            } else {
                segment.end = segment.end.min(border);
            }
        }
        segment
    }
}

/// Orders the frames of `runs`, chain by chain, in each chain segment by segment; every frame is written once.
///
/// `finished` tells the frames that an earlier run has written (`--resume`): they are rendered only
/// where a frame that is not finished is inferred from them. `saved`: the frame of which there is a store, and the chain in which
/// it was made.
pub fn schedule(
    runs: &[Run],
    rule: &Rule<'_>,
    saved: Option<Saved>,
    finished: impl Fn(i32) -> bool,
) -> Result<Vec<Step>, TooLong> {
    let mut steps = Vec::new();
    for (chain, frames) in chains(runs, rule.shot_first) {
        let mut segments: BTreeMap<i32, BTreeSet<i32>> = BTreeMap::new();
        for frame in frames.into_iter().filter(|&frame| !finished(frame)) {
            segments.entry(rule.base_of(frame, chain.stride)?).or_default().insert(frame);
        }
        let saved = saved.filter(|saved| saved.fits(chain, rule)).map(|saved| saved.frame);
        for (base, frames) in segments {
            let segment = Segment { base, stride: chain.stride, frames, saved };
            let ends =
                [segment.frames.first(), segment.frames.last()].map(|frame| frame.copied().unwrap_or(base));
            let length: u64 =
                ends.iter().map(|end| u64::from(end.abs_diff(base)) / u64::from(chain.stride)).sum();
            if steps.len() as u64 + length > MOST_STEPS as u64 {
                return Err(TooLong { frame: ends[1] });
            }
            segment.schedule(&mut steps);
        }
    }
    Ok(steps)
}

/// Frames of `runs` by segment, each as runs of its chain's step: what may be rendered apart from the rest without a run-up. The
/// pictures are those of all frames in one run.
pub fn segments(runs: &[Run], rule: &Rule<'_>) -> Result<Vec<Vec<Run>>, TooLong> {
    let mut all = Vec::new();
    for (chain, frames) in chains(runs, rule.shot_first) {
        let mut segments: BTreeMap<i32, Vec<Run>> = BTreeMap::new();
        for frame in frames {
            let runs = segments.entry(rule.base_of(frame, chain.stride)?).or_default();
            match runs.last_mut() {
                Some(run) if i64::from(run.last) + i64::from(chain.stride) == i64::from(frame) => {
                    run.last = frame;
                }
                _ => runs.push(Run { first: frame, last: frame, step: chain.stride }),
            }
        }
        all.extend(segments.into_values());
    }
    Ok(all)
}

/// A store that an earlier run has saved: of which frame, and how that came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Saved {
    /// The frame.
    pub frame: i32,
    /// Ancestry of the frame.
    pub ancestry: Ancestry,
}

impl Saved {
    /// Returns true if the frame has this ancestry by `rule`, too.
    pub fn holds(&self, rule: &Rule<'_>) -> Result<bool, TooLong> {
        match self.ancestry {
            // whether it is one depends on the step of the run
            Ancestry::Base => Ok(true),
            Ancestry::Inferred { stride, .. } => Ok(rule.ancestry(self.frame, stride)? == self.ancestry),
        }
    }

    /// Returns true if frames of `chain` may be inferred from it.
    fn fits(&self, chain: Chain, rule: &Rule<'_>) -> bool {
        chain.phase_of(self.frame, rule.shot_first) == chain.phase
            && rule.ancestry(self.frame, chain.stride).is_ok_and(|ancestry| ancestry == self.ancestry)
    }
}

/// The frames of one chain in one segment that are to be made.
struct Segment {
    base: i32,
    stride: u32,
    /// Frames to make; at least one.
    frames: BTreeSet<i32>,
    /// Frame of the chain of which there is a store.
    saved: Option<i32>,
}

impl Segment {
    fn schedule(&self, steps: &mut Vec<Step>) {
        let later = self.frames.range(self.base..).next_back().copied();
        let earlier = self.frames.range(..self.base).next().copied();
        let mut base_step = None;
        if let Some(last) = later {
            let saved = self.saved.filter(|saved| self.spares(*saved, *saved >= self.base, self.base..=last));
            if saved.is_none() {
                base_step = Some(steps.len());
                self.push(steps, self.base, Origin::Nothing);
            }
            let first = saved.map_or(Origin::Before, |_| Origin::Saved);
            self.walk(steps, saved.unwrap_or(self.base), last, first);
        }
        let Some(earliest) = earlier else { return };
        let is_spared = |saved: &i32| self.spares(*saved, *saved <= self.base, earliest..=self.base - 1);
        let saved = self.saved.filter(is_spared);
        match base_step.filter(|_| saved.is_none()) {
            Some(step) => steps[step].keep = later > Some(self.base),
            None if saved.is_none() => self.push(steps, self.base, Origin::Nothing),
            None => {}
        }
        let first = saved.map_or(Origin::Base, |_| Origin::Saved);
        self.walk(steps, saved.unwrap_or(self.base), earliest, first);
    }

    /// Returns true if the store of frame `saved` lies on the way from the base frame to all wanted frames in
    /// the range `of`. `on_this_side`: the frame lies on the same side of the base frame as that range.
    fn spares(&self, saved: i32, on_this_side: bool, of: std::ops::RangeInclusive<i32>) -> bool {
        let distance = saved.abs_diff(self.base);
        on_this_side && self.frames.range(of).all(|frame| frame.abs_diff(self.base) > distance)
    }

    /// Appends the steps from behind frame `after` to frame `to`. The first of them is made from `first`.
    fn walk(&self, steps: &mut Vec<Step>, after: i32, to: i32, first: Origin) {
        let count = i64::from(after.abs_diff(to)) / i64::from(self.stride);
        let step = if to < after { -i64::from(self.stride) } else { i64::from(self.stride) };
        for number in 1..=count {
            // between two frames that fit
            let frame = (i64::from(after) + number * step) as i32;
            self.push(steps, frame, if number == 1 { first } else { Origin::Before });
        }
    }

    fn push(&self, steps: &mut Vec<Step>, frame: i32, origin: Origin) {
        steps.push(Step { frame, origin, keep: false, write: self.frames.contains(&frame) });
    }
}

impl Rule<'_> {
    /// Ancestry of `frame` in a chain with that step.
    fn ancestry(&self, frame: i32, stride: u32) -> Result<Ancestry, TooLong> {
        let from = self.base_of(frame, stride)?;
        Ok(if from == frame { Ancestry::Base } else { Ancestry::Inferred { from, stride } })
    }
}

/// The ancestry of each frame of `runs`.
pub fn ancestries(runs: &[Run], rule: &Rule<'_>) -> Result<BTreeMap<i32, Ancestry>, TooLong> {
    let mut ancestries = BTreeMap::new();
    for (chain, frames) in chains(runs, rule.shot_first) {
        for frame in frames {
            ancestries.insert(frame, rule.ancestry(frame, chain.stride)?);
        }
    }
    Ok(ancestries)
}

/// Frames that are inferred from one another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Chain {
    stride: u32,
    phase: i64,
}

impl Chain {
    fn phase_of(self, frame: i32, shot_first: i32) -> i64 {
        (i64::from(frame) - i64::from(shot_first)).rem_euclid(i64::from(self.stride))
    }
}

/// Frames by chain. A frame of several chains belongs to the first.
fn chains(runs: &[Run], shot_first: i32) -> Vec<(Chain, BTreeSet<i32>)> {
    let mut chains: Vec<(Chain, BTreeSet<i32>)> = Vec::new();
    let mut taken = BTreeSet::new();
    for run in runs {
        let chain = Chain { stride: run.step.max(1), phase: 0 };
        let chain = Chain { phase: chain.phase_of(run.first, shot_first), ..chain };
        let index = chains.iter().position(|other| other.0 == chain).unwrap_or_else(|| {
            chains.push((chain, BTreeSet::new()));
            chains.len() - 1
        });
        let frames = (run.first..=run.last).step_by(chain.stride as usize);
        chains[index].1.extend(frames.filter(|&frame| taken.insert(frame)));
    }
    chains
}

/// Note on the frames that are rendered without being written, if there are any. `remedy` says how to have
/// fewer.
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
        "run-up: {count} {frames} from {} on {are} rendered without being written{much}, because other frames \
         are inferred from them ({remedy})",
        first.frame
    ))
}

#[cfg(test)]
mod tests;
