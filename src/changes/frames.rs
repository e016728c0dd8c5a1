//! The frames in which something differs from the frame before.

use crate::animation::{Keyed, Track, TransformTrack};
use crate::pose::LightPose;
use crate::scene::{Light, LightKind};

/// A value that has not changed for so many frames in a row, although its tracks do, counts as changed: frame by
/// frame the search would take too long.
const MOST_EQUAL: usize = 1_000_000;

/// What of a track does not depend on its values.
trait Keys {
    /// The first and the last key's frame.
    fn span(&self) -> (f64, f64);
    /// As [`Track::rests_until`].
    fn rests_until(&self, frame: f64) -> f64;
}

impl<T: Keyed> Keys for Track<T> {
    fn span(&self) -> (f64, f64) {
        let ends = (self.frames().next(), self.frames().last());
        (ends.0.unwrap_or(f64::INFINITY), ends.1.unwrap_or(f64::NEG_INFINITY))
    }

    fn rests_until(&self, frame: f64) -> f64 {
        Track::rests_until(self, frame)
    }
}

/// The frames g, rising, in which a model's transform at g differs from that at g - 1.
pub fn of_model(track: &TransformTrack) -> impl Iterator<Item = i64> + '_ {
    changes(vec![&track.translate, &track.rotate, &track.scale], |frame| track.at(frame))
}

/// The frames g, rising, in which a light's pose at g differs in anything from that at g - 1.
pub fn of_light(light: &Light) -> impl Iterator<Item = i64> + '_ {
    let mut tracks: Vec<&dyn Keys> = vec![&light.color, &light.power];
    match &light.kind {
        LightKind::Point { position } | LightKind::Sphere { position, .. } => tracks.push(position),
        LightKind::Directional { direction } | LightKind::Sun { direction, .. } => tracks.push(direction),
        LightKind::Spot { position, target, .. }
        | LightKind::Rectangle { position, target, .. }
        | LightKind::Disk { position, target, .. } => {
            tracks.push(position);
            tracks.push(target);
        }
    }
    changes(tracks, |frame| LightPose::of(light, frame))
}

/// The frames in which `at(frame)`, a function of the values of `tracks`, differs from `at(frame - 1)`.
fn changes<'a, T: PartialEq + 'a>(
    tracks: Vec<&'a dyn Keys>,
    at: impl Fn(f64) -> T + 'a,
) -> impl Iterator<Item = i64> + 'a {
    let first = tracks.iter().fold(f64::INFINITY, |least, track| least.min(track.span().0));
    let last = tracks.iter().fold(f64::NEG_INFINITY, |most, track| most.max(track.span().1));
    // outside of these all tracks rest; frames have 32 bits
    let whole = |frame: f64| (frame as i64).clamp(i32::MIN.into(), i32::MAX.into());
    let (mut frame, last) = (whole(first.floor()), whole(last.ceil()));
    let mut value = at(frame as f64);
    std::iter::from_fn(move || {
        for equal in 1.. {
            // the value is the same in all frames before this
            let rest =
                tracks.iter().fold(f64::INFINITY, |end, track| end.min(track.rests_until(frame as f64)));
            let next = (frame + 1).max(rest.ceil() as i64);
            if next > last {
                break;
            }
            let new = at(next as f64);
            let differs = new != value;
            (frame, value) = (next, new);
            if differs || equal == MOST_EQUAL {
                return Some(frame);
            }
        }
        frame = last;
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::Interpolation;
    use glam::{DVec3, Vec3};

    fn sliding(keys: &[(f64, f64)]) -> TransformTrack {
        let keys = keys.iter().map(|(frame, x)| (*frame, DVec3::X * *x)).collect();
        let translate = Track::through(keys, Interpolation::Linear).expect("keys are good");
        TransformTrack { translate, ..TransformTrack::identity() }
    }

    #[test]
    fn rests_are_skipped_and_fractions_round_outwards() {
        let track = sliding(&[(-3.5, 0.0), (-1.5, 1.0), (6.0, 1.0), (8.25, 2.0)]);
        assert_eq!(of_model(&track).collect::<Vec<_>>(), [-3, -2, -1, 7, 8, 9]);
        assert_eq!(of_model(&TransformTrack::identity()).count(), 0);
        let jump = TransformTrack { translate: track.translate.cut_at(&[8.25]), ..track };
        assert_eq!(of_model(&jump).collect::<Vec<_>>(), [-3, -2, -1, 9]);
    }

    #[test]
    fn a_shot_of_two_thousand_million_frames_is_searched_at_once() {
        let (early, late) = (f64::from(i32::MIN), f64::from(i32::MAX));
        let track = sliding(&[(early, 0.0), (late - 2.0, 0.0), (late, 1.0)]);
        assert_eq!(of_model(&track).collect::<Vec<_>>(), [i64::from(i32::MAX) - 1, i64::from(i32::MAX)]);
        let track = sliding(&[(early, 0.0), (late, 1.0)]);
        assert_eq!(of_model(&track).next(), Some(i64::from(i32::MIN) + 1));
    }

    #[test]
    fn a_light_changes_with_any_of_its_tracks() {
        let keys = vec![(1.0, 1.0), (3.0, 1.0), (4.0, 2.0)];
        let light = Light {
            name: "lamp".into(),
            kind: LightKind::Point { position: Track::constant(DVec3::ZERO) },
            color: Track::through(vec![(8.0, Vec3::ONE), (10.0, Vec3::X)], Interpolation::Linear)
                .expect("good"),
            power: Track::through(keys, Interpolation::Linear).expect("keys are good"),
            samples: 1,
            group: None,
        };
        assert_eq!(of_light(&light).collect::<Vec<_>>(), [4, 9, 10]);
    }
}
