//! Frames that follow from a frame in its segment: who has its samples needs nothing else to make them.

use super::{Ancestry, Rule};
use crate::settings::BasePlace;

/// Frames of one chain that are inferred from a frame, one after the other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Followers {
    /// Ancestry that all of them have.
    pub ancestry: Ancestry,
    /// Later ones and earlier ones, from the nearest to the end of the segment.
    pub ways: [Vec<i32>; 2],
}

impl Rule<'_> {
    /// Frames that follow from `frame` in a chain with that step. None follow in a segment without an end: where neither the shot
    /// nor the rule says one.
    pub fn followers(&self, frame: i32, stride: u32) -> Followers {
        let (number, step) = (i64::from(frame), i64::from(stride.max(1)));
        let base = self.base_of(frame, stride).ok().filter(|_| !self.full && frame >= self.shot_first);
        let ancestry = Ancestry::Inferred { from: base.unwrap_or(frame), stride };
        let Some(base) = base else { return Followers { ancestry, ways: Default::default() } };
        let segment = self.segment(number);
        let end = self.shot_last.map_or(segment.end, |last| segment.end.min(i64::from(last) + 1));
        let is_endless = end > i64::from(i32::MAX);
        // between two frames that fit
        let frames =
            |count: i64, step: i64| (1..=count).map(|at| (number + at * step) as i32).collect::<Vec<_>>();
        let later = (frame >= base && !is_endless).then(|| (end - 1 - number).max(0) / step);
        let goes_back = self.base_place == BasePlace::Middle && frame <= base;
        let earlier = goes_back.then(|| (number - segment.start) / step);
        Followers { ancestry, ways: [frames(later.unwrap_or(0), step), frames(earlier.unwrap_or(0), -step)] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULE: Rule<'static> = Rule {
        shot_first: 1,
        shot_last: Some(20),
        base_every: 8,
        base_place: BasePlace::First,
        cuts: &[14],
        full: false,
    };

    #[track_caller]
    fn assert_ways(rule: &Rule<'_>, frame: i32, stride: u32, later: &[i32], earlier: &[i32]) {
        assert_eq!(rule.followers(frame, stride).ways, [later, earlier]);
    }

    #[test]
    fn frames_follow_up_to_the_end_of_the_segment() {
        assert_ways(&RULE, 5, 1, &[6, 7, 8], &[]);
        assert_ways(&RULE, 1, 3, &[4, 7], &[]);
        assert_eq!(RULE.followers(5, 1).ancestry, Ancestry::Inferred { from: 1, stride: 1 });
        assert_ways(&RULE, 8, 1, &[], &[]); // a base frame comes next
        assert_ways(&RULE, 13, 1, &[], &[]); // a cut comes next
        assert_ways(&RULE, 18, 1, &[19, 20], &[]); // the shot ends
        assert_ways(&RULE, 20, 1, &[], &[]);
        assert_ways(&RULE, 30, 1, &[], &[]); // behind the shot
        assert_ways(&RULE, -3, 1, &[], &[]); // before the shot all are base frames
        assert_ways(&Rule { full: true, ..RULE }, 5, 1, &[], &[]);
        let endless = Rule { shot_last: None, base_every: 0, cuts: &[], ..RULE };
        assert_ways(&endless, 5, 1, &[], &[]);
    }

    #[test]
    fn from_a_base_frame_in_the_middle_frames_follow_on_both_sides() {
        let rule = Rule { base_place: BasePlace::Middle, ..RULE };
        assert_eq!(rule.base_of(1, 1), Ok(5));
        assert_ways(&rule, 5, 1, &[6, 7, 8], &[4, 3, 2, 1]);
        assert_ways(&rule, 7, 1, &[8], &[]);
        assert_ways(&rule, 3, 1, &[], &[2, 1]);
    }
}
