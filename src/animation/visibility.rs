//! Visibility of a thing over time.

use super::{Interpolation, Track};

/// Keyed visibility, without a transition from key to key.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Visibility {
    /// 1 while it is visible and 0 while it is not, cut at every key; none: always visible.
    track: Option<Track<f64>>,
}

impl Visibility {
    /// Visible at all frames.
    pub const ALWAYS: Self = Self { track: None };

    /// Creates a visibility: `before` up to the first of `keys`, which are pairs of a frame and the
    /// visibility from that frame on, in any order.
    ///
    /// `None` if two keys share a frame, or if a frame is not finite.
    pub fn through(before: bool, mut keys: Vec<(f64, bool)>) -> Option<Self> {
        let first = keys.iter().map(|(frame, _)| *frame).fold(f64::INFINITY, f64::min);
        keys.push((if keys.is_empty() { 0.0 } else { first - 1.0 }, before));
        if keys.iter().all(|(_, is_there)| *is_there) {
            return Some(Self::ALWAYS);
        }
        let frames: Vec<f64> = keys.iter().map(|(frame, _)| *frame).collect();
        let values = keys.into_iter().map(|(frame, is_there)| (frame, f64::from(u8::from(is_there))));
        let track = Track::through(values.collect(), Interpolation::Linear)?;
        Some(Self { track: Some(track.cut_at(&frames)) })
    }

    /// Creates the visibility of what is visible while both are.
    pub fn and(&self, other: &Self) -> Self {
        let tracks = || [self, other].into_iter().filter_map(|one| one.track.as_ref());
        if tracks().count() < 2 {
            return if self.is_always() { other.clone() } else { self.clone() };
        }
        let mut frames: Vec<f64> = tracks().flat_map(Track::frames).collect();
        frames.sort_by(f64::total_cmp);
        frames.dedup();
        let both = |frame: f64| self.at(frame) && other.at(frame);
        let keys = frames.into_iter().map(|frame| (frame, both(frame))).collect();
        Self::through(both(f64::NEG_INFINITY), keys).expect("frames are finite, and each is there once")
    }

    /// Returns true if it is visible at `frame`.
    pub fn at(&self, frame: f64) -> bool {
        self.track.as_ref().is_none_or(|track| track.at(frame) != 0.0)
    }

    /// Returns true if it is visible in all frames.
    pub fn is_always(&self) -> bool {
        self.track.is_none()
    }

    /// Returns true if it is visible in no frame.
    pub fn is_never(&self) -> bool {
        self.track.as_ref().is_some_and(|track| track.values().all(|value| value == 0.0))
    }

    /// Values of the track, 0 and 1; none if it is always visible.
    pub(crate) fn track(&self) -> Option<&Track<f64>> {
        self.track.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_changes_at_its_keys_and_nowhere_else() {
        let visible = Visibility::through(true, vec![(8.5, true), (3.0, false)]).expect("good");
        let there: Vec<bool> = (0..12).map(|frame| visible.at(f64::from(frame))).collect();
        let away = 3..9;
        assert_eq!(there, (0..12).map(|frame| !away.contains(&frame)).collect::<Vec<_>>());
        assert!(!visible.at(8.25) && visible.at(8.5) && visible.at(-1e9) && visible.at(1e9));
        assert!(!visible.is_always() && !visible.is_never());
    }

    #[test]
    fn always_and_never() {
        let always = Visibility::through(true, vec![(4.0, true)]).expect("good");
        assert_eq!(always, Visibility::ALWAYS);
        assert!(always.at(-3.0) && always.is_always() && !always.is_never());
        for keys in [vec![], vec![(4.0, false)]] {
            let never = Visibility::through(false, keys).expect("good");
            assert!(!never.at(0.0) && !never.at(9.0) && never.is_never() && !never.is_always());
        }
    }

    #[test]
    fn of_two_both_count() {
        let first = Visibility::through(false, vec![(2.0, true), (8.0, false)]).expect("good");
        let second = Visibility::through(true, vec![(4.0, false), (6.0, true)]).expect("good");
        for (one, other) in [(&first, &second), (&second, &first), (&first, &Visibility::ALWAYS)] {
            let both = one.and(other);
            for frame in (-4..40).map(|quarter| f64::from(quarter) * 0.25) {
                assert_eq!(both.at(frame), one.at(frame) && other.at(frame), "{frame}");
            }
        }
        assert!(Visibility::ALWAYS.and(&Visibility::ALWAYS).is_always());
    }

    #[test]
    fn two_keys_in_one_frame_are_refused() {
        assert_eq!(Visibility::through(true, vec![(1.0, false), (1.0, true)]), None);
        assert_eq!(Visibility::through(true, vec![(f64::NAN, false)]), None);
    }
}
