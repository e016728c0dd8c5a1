//! Chooses the frames that the report of `compare` shows: some that reused samples, spread evenly from the
//! first to the last.
//!
//! A frame's reuse is known only when it is done: with `--mode auto` a frame that could be inferred may have
//! been traced in full. The next one that was inferred replaces it.

use std::collections::VecDeque;

use crate::cli::frames::writing::Seen;
use crate::film::Film;
use crate::frame::Finished;
use crate::report::html::Pictures;
use crate::schedule::Step;
use crate::settings::Look;

/// Maximum number of frames.
const MOST: usize = 4;

/// Chooses frames, and keeps their pictures.
#[derive(Debug, Default)]
pub struct Shown {
    /// Numbers of the frames to show, in rising order: offered frames count from 0.
    due: VecDeque<usize>,
    /// Exposure and view transform of the pictures.
    look: Look,
    /// Number of frames offered so far.
    offered: usize,
    pictures: Vec<Pictures>,
    /// Pictures of the first frame, until a frame was inferred.
    base: Option<Pictures>,
}

impl Shown {
    /// Chooses among the frames that `steps` write; `look` is that of the pictures.
    pub fn new(steps: &[Step], look: Look) -> Self {
        Self { due: due(steps), look, ..Self::default() }
    }

    /// Returns true if pictures are taken of the frame that is offered next; `ours` is that frame.
    pub fn takes(&self, ours: &Finished) -> bool {
        if ours.stats.samples.reused() == 0 { self.offered == 0 } else { self.is_due() }
    }

    fn is_due(&self) -> bool {
        self.due.front().is_some_and(|due| *due <= self.offered)
    }

    /// Offers a frame, made in both ways, and its `reference`, if there is one. All written frames are
    /// offered in their order.
    pub fn offer(&mut self, ours: &Seen, full: &Seen, reference: Option<&Film>) {
        if self.takes(&ours.finished) {
            let films = [&*ours.finished.film, &*full.finished.film];
            let denoised = [ours.denoised.as_ref(), full.denoised.as_ref()];
            let stats = &ours.finished.stats;
            let pictures = Pictures::of(stats.frame, films, denoised, reference, self.look);
            if stats.samples.reused() == 0 {
                self.base = pictures;
            } else {
                while self.is_due() {
                    self.due.pop_front();
                }
                self.pictures.extend(pictures);
            }
        }
        self.offered += 1;
    }

    /// Pictures of the chosen frames; of the first one if none was inferred.
    pub fn into_pictures(self) -> Vec<Pictures> {
        if self.pictures.is_empty() { self.base.into_iter().collect() } else { self.pictures }
    }
}

/// Frames that may be inferred, counted among those that are written.
fn due(steps: &[Step]) -> VecDeque<usize> {
    let written = steps.iter().filter(|step| step.write).enumerate();
    let inferred: Vec<usize> = written.filter(|(_, step)| step.reuses()).map(|(place, _)| place).collect();
    let Some(last) = inferred.len().checked_sub(1) else { return VecDeque::new() };
    let mut due: Vec<usize> = (0..MOST).map(|i| inferred[i * last / (MOST - 1)]).collect();
    due.dedup();
    due.into()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::cli::frames::writing::tests::finished;
    use crate::schedule::Origin;
    use crate::stats::SampleCounts;

    fn steps(count: i32, first_written: i32) -> Vec<Step> {
        let origin = |frame| if frame > 1 { Origin::Before } else { Origin::Nothing };
        let step = |frame| Step { frame, origin: origin(frame), keep: false, write: frame >= first_written };
        (1..=count).map(step).collect()
    }

    /// Numbers of the frames that are shown of a run in which these frames of `steps` reuse nothing.
    fn shown(steps: &[Step], traced: impl Fn(i32) -> bool) -> Vec<i32> {
        let mut shown = Shown::new(steps, Look::default());
        for step in steps.iter().filter(|step| step.write) {
            let full = finished(step.frame);
            let mut ours = Finished { film: Arc::clone(&full.film), ..finished(step.frame) };
            let good = u64::from(step.reuses() && !traced(step.frame));
            ours.stats.samples = SampleCounts { good, base: 1 - good, ..SampleCounts::default() };
            shown.offer(&ours.into(), &full.into(), None);
        }
        shown.into_pictures().iter().map(|pictures| pictures.frame).collect()
    }

    #[test]
    fn the_report_shows_inferred_frames_from_first_to_last() {
        assert_eq!(shown(&steps(60, 3), |_| false), [3, 22, 41, 60]);
        assert_eq!(shown(&steps(60, 1), |_| false), [2, 21, 40, 60]);
        assert_eq!(shown(&steps(4, 3), |_| false), [3, 4]);
        assert!(shown(&[], |_| false).is_empty());
    }

    #[test]
    fn a_frame_that_was_traced_in_full_is_shown_only_where_no_other_is() {
        assert_eq!(shown(&steps(60, 1), |frame| frame % 10 < 5), [5, 25, 45]);
        assert_eq!(shown(&steps(60, 1), |frame| frame < 50), [50, 60]);
        assert_eq!(shown(&steps(60, 1), |_| true), [1]);
        assert_eq!(shown(&steps(1, 1), |_| false), [1]);
    }
}
