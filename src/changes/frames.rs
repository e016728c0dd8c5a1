//! Moments at which something differs from the moment before. These are frames, if each is seen at its own
//! time alone.

use crate::animation::{Keys, TransformTrack};
use crate::exposure::Clock;
use crate::pose::LightPose;
use crate::scene::{Light, Scene};
use crate::sweep::all_places;

/// Number of moments in a row without a change of a value, although its tracks change, after which it counts
/// as changed: frame by frame the search would take too long.
const MOST_EQUAL: usize = 1_000_000;

/// Direction of time in which one frame is inferred from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// Time runs to higher numbers.
    #[default]
    Forward,
    /// Time runs to lower numbers.
    Backward,
}

impl Direction {
    /// Converts a moment's number to a count that rises in this direction of time. Applied to the count, it
    /// gives the moment.
    pub fn count(self, moment: i64) -> i64 {
        match self {
            Self::Forward => moment,
            Self::Backward => -moment,
        }
    }
}

/// Moments of `clock` at which a model's shape, or any of its transforms, of which it has `each` at a moment, differs from that of the moment
/// that comes before it in `direction`, or at which it appears or disappears: rising, as [counts](Direction::count).
pub fn of_model<'a>(
    track: &'a TransformTrack,
    (clock, each): (&'a Clock, usize),
    direction: Direction,
) -> impl Iterator<Item = i64> + 'a {
    let mut tracks: Vec<&dyn Keys> = vec![&track.translate, &track.rotate, &track.scale];
    tracks.extend(track.matrix.iter().map(|matrix| matrix as &dyn Keys));
    tracks.extend(track.visible.track().map(|visible| visible as &dyn Keys));
    tracks.extend(track.shapes.iter().map(|shapes| shapes as &dyn Keys));
    changes(tracks, clock, direction, move |moment| all_places(track, (clock, moment), each))
}

/// Moments at which a light differs in anything at any tick, as [`of_model`] gives them.
pub fn of_light<'a>(
    light: &'a Light,
    clock: &'a Clock,
    direction: Direction,
) -> impl Iterator<Item = i64> + 'a {
    changes(light.keys(), clock, direction, |moment| {
        let middle = LightPose::new(light, clock.time(moment));
        let at_ticks = LightPose::at_ticks(std::slice::from_ref(light), clock, moment, &[middle]);
        (middle, at_ticks)
    })
}

/// Returns true if anything in the scene but the camera changes between two moments, as far as tracks tell.
pub fn anything_changes(scene: &Scene) -> bool {
    !scene.models.iter().all(|model| model.track.is_constant())
        || !scene.lights.iter().all(Light::is_constant)
}

/// Counts of moments at which `at(moment)`, a function of the values of `tracks` within the moment, differs from that of the
/// count before.
fn changes<'a, T: PartialEq + 'a>(
    tracks: Vec<&'a dyn Keys>,
    clock: &'a Clock,
    direction: Direction,
    at: impl Fn(i64) -> T + 'a,
) -> impl Iterator<Item = i64> + 'a {
    let first = tracks.iter().fold(f64::INFINITY, |least, track| least.min(track.span().0));
    let last = tracks.iter().fold(f64::NEG_INFINITY, |most, track| most.max(track.span().1));
    // outside of these all tracks rest
    let [earliest, latest] = Clock::bounds();
    let ends = [clock.at_or_before(first, 1.0), clock.at_or_after(last, 0.0)]
        .map(|moment| direction.count(moment.clamp(earliest, latest)));
    let (mut count, last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    // conversion is its own inverse: this gives a count's moment
    let time = move |count: i64, share: f64| clock.time_within(direction.count(count), share);
    let mut value = at(direction.count(count));
    std::iter::from_fn(move || {
        for equal in 1.. {
            // the value is the same at all moments before this
            let rest = match direction {
                Direction::Forward => {
                    let ends = tracks.iter().map(|track| track.rests_until(time(count, 0.0)));
                    clock.at_or_after(ends.fold(f64::INFINITY, f64::min), 1.0)
                }
                Direction::Backward => {
                    let begins = tracks.iter().map(|track| track.rests_since(time(count, 1.0)));
                    1 - clock.at_or_after(begins.fold(f64::NEG_INFINITY, f64::max), 0.0)
                }
            };
            let next = (count + 1).max(rest);
            if next > last {
                break;
            }
            let new = at(direction.count(next));
            let differs = new != value;
            (count, value) = (next, new);
            if differs || equal == MOST_EQUAL {
                return Some(count);
            }
        }
        count = last;
        None
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::{Interpolation, Track, Visibility};
    use crate::scene::LightKind;
    use glam::{DAffine3, DVec3, Vec3};

    fn sliding(keys: &[(f64, f64)]) -> TransformTrack {
        let keys = keys.iter().map(|(frame, x)| (*frame, DVec3::X * *x)).collect();
        let translate = Track::through(keys, Interpolation::Linear).expect("keys are good");
        TransformTrack { translate, ..TransformTrack::identity() }
    }

    #[test]
    fn rests_are_skipped_and_fractions_round_outwards() {
        let track = sliding(&[(-3.5, 0.0), (-1.5, 1.0), (6.0, 1.0), (8.25, 2.0)]);
        assert_eq!(
            of_model(&track, (&Clock::FRAMES, 1), Direction::Forward).collect::<Vec<_>>(),
            [-3, -2, -1, 7, 8, 9]
        );
        assert_eq!(of_model(&TransformTrack::identity(), (&Clock::FRAMES, 1), Direction::Forward).count(), 0);
        let jump = TransformTrack { translate: track.translate.cut_at(&[8.25]), ..track };
        assert_eq!(
            of_model(&jump, (&Clock::FRAMES, 1), Direction::Forward).collect::<Vec<_>>(),
            [-3, -2, -1, 9]
        );
    }

    #[test]
    fn backwards_a_change_is_that_from_the_frame_after() {
        let tracks = [
            sliding(&[(-3.5, 0.0), (-1.5, 1.0), (6.0, 1.0), (8.25, 2.0)]),
            sliding(&[(2.0, 1.0), (5.0, 1.0), (6.0, 3.0), (7.0, 3.0), (9.0, 3.0), (10.0, 3.0), (12.5, 1.0)]),
            sliding(&[(1.0, 4.0), (9.0, 2.0), (10.5, 2.0), (13.0, 2.0)]),
        ];
        let cut = |track: &TransformTrack| {
            let cuts = [-1.5, 8.25, 6.0, 9.0, 13.0];
            TransformTrack { translate: track.translate.clone().cut_at(&cuts), ..track.clone() }
        };
        for track in tracks.iter().cloned().chain(tracks.iter().map(cut)) {
            let differs = |count: &i64| track.at(-*count as f64) != track.at((-*count + 1) as f64);
            let expected: Vec<i64> = (-40..40).filter(differs).collect();
            assert_eq!(
                of_model(&track, (&Clock::FRAMES, 1), Direction::Backward).collect::<Vec<_>>(),
                expected
            );
        }
    }

    #[test]
    fn coming_and_going_counts_and_hidden_motion_does_not() {
        let track = TransformTrack {
            visible: Visibility::through(true, vec![(4.0, false), (8.0, true), (20.0, false)]).expect("good"),
            ..sliding(&[(2.0, 0.0), (10.0, 1.0)])
        };
        assert_eq!(
            of_model(&track, (&Clock::FRAMES, 1), Direction::Forward).collect::<Vec<_>>(),
            [3, 4, 8, 9, 10, 20]
        );
        let differs = |count: &i64| track.at(-*count as f64) != track.at((-*count + 1) as f64);
        let expected: Vec<i64> = (-40..40).filter(differs).collect();
        assert_eq!(of_model(&track, (&Clock::FRAMES, 1), Direction::Backward).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn a_matrix_counts() {
        let keys = vec![(2.0, DAffine3::IDENTITY), (4.0, DAffine3::from_scale(DVec3::new(-1.0, 1.0, 2.0)))];
        let matrix = Track::through(keys, Interpolation::Linear).expect("keys are good");
        let track = TransformTrack { matrix: Some(matrix), ..TransformTrack::identity() };
        assert_eq!(of_model(&track, (&Clock::FRAMES, 1), Direction::Forward).collect::<Vec<_>>(), [3, 4]);
    }

    #[test]
    fn a_shot_of_two_thousand_million_frames_is_searched_at_once() {
        let (early, late) = (f64::from(i32::MIN), f64::from(i32::MAX));
        let track = sliding(&[(early, 0.0), (late - 2.0, 0.0), (late, 1.0)]);
        assert_eq!(
            of_model(&track, (&Clock::FRAMES, 1), Direction::Forward).collect::<Vec<_>>(),
            [i64::from(i32::MAX) - 1, i64::from(i32::MAX)]
        );
        let track = sliding(&[(early, 0.0), (late, 1.0)]);
        assert_eq!(
            of_model(&track, (&Clock::FRAMES, 1), Direction::Forward).next(),
            Some(i64::from(i32::MIN) + 1)
        );
        let back = sliding(&[(early, 1.0), (late, 0.0)]);
        assert_eq!(
            of_model(&back, (&Clock::FRAMES, 1), Direction::Backward).next(),
            Some(1 - i64::from(i32::MAX))
        );
        let track = sliding(&[(early, 1.0), (early + 2.0, 0.0), (late, 0.0)]);
        let ends = [-1 - i64::from(i32::MIN), -i64::from(i32::MIN)];
        assert_eq!(of_model(&track, (&Clock::FRAMES, 1), Direction::Backward).collect::<Vec<_>>(), ends);
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
            links: Default::default(),
        };
        assert_eq!(of_light(&light, &Clock::FRAMES, Direction::Forward).collect::<Vec<_>>(), [4, 9, 10]);
    }
}
