//! Places of models that move within an exposure.
//!
//! A model that moves has a place for each of the exposure's [`TICKS`], or for groups of successive ones where many models
//! move: [`Sweeps::places_of_each`]. Whether it is there at all follows from the exposure's middle.
//!
//! A model that deforms goes straight from its shape when the exposure begins to that when it is over ([`Chord`]), and so does a place whose
//! way bends [little](MOST_BEND): what tracers take as two steps of one geometry, or of an instance.

use glam::DAffine3;
use rayon::prelude::*;

use crate::animation::{Chord, Keyed, Shape, Transform, TransformTrack};
use crate::exposure::{Clock, TICKS, Tick};
use crate::scene::Scene;

/// Largest number of places at an exposure: some 2 MB.
const MOST_PLACES: usize = 8192;

/// Furthest that a way lies from the straight one that is taken for it, for each unit of length: half a pixel where it is 100 pixels long.
/// What turns by less than 2.3 degrees goes straight.
const MOST_BEND: f64 = 0.005;

/// Number of a model without places of its own.
const RESTS: u32 = u32::MAX;

/// Places of the models that move within an exposure.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sweeps {
    /// For each model the index of its first place, or [`RESTS`]; empty if all rest.
    firsts: Vec<u32>,
    /// Number of places of each.
    each: usize,
    places: Vec<Transform>,
    /// For each model that moves where it is when the exposure begins and when it is over, if it goes straight.
    ends: Vec<Option<[Transform; 2]>>,
}

/// How a model goes through an exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Way<'a> {
    /// Each number of its place changes evenly between these two: when the exposure begins and when it is over.
    Straight(&'a [Transform; 2]),
    /// It has these places, one for each group of ticks.
    Bent(&'a [Transform]),
}

/// Places of a model that moves within an exposure.
struct Swept {
    places: Vec<Transform>,
    /// The first and the last of a straight way.
    ends: Option<[Transform; 2]>,
}

impl Sweeps {
    /// Places of the models of `scene` that move within a `moment` of `clock`. `middles`: places of all models in its middle; those of
    /// models that deform get their shapes on the way.
    pub fn new(scene: &Scene, clock: &Clock, moment: i64, middles: &mut [Transform]) -> Self {
        let each = Self::places_of_each(scene);
        if each <= 1 || clock.is_instant() {
            return Self::default();
        }
        let sweep = |model: usize| {
            swept(&scene.models[model].track, (clock, moment), &middles[model], each).map(|all| (model, all))
        };
        let swept: Vec<(usize, Swept)> = (0..middles.len()).into_par_iter().filter_map(sweep).collect();
        if swept.is_empty() {
            return Self::default();
        }
        let mut firsts = vec![RESTS; middles.len()];
        let mut all = Self { each, ..Self::default() };
        for (number, (model, Swept { places, ends })) in swept.into_iter().enumerate() {
            firsts[model] = (number * each) as u32;
            middles[model].shape = shape_in_middle(&middles[model], &places);
            all.places.extend(places);
            all.ends.push(ends);
        }
        Self { firsts, ..all }
    }

    /// Number of places of each model that moves: the same in all of a shot, so that models that rest are never taken for ones that
    /// move. 1 where so many models move in some frame that all have the place of the exposure's middle.
    pub fn places_of_each(scene: &Scene) -> usize {
        let movable = scene.models.iter().filter(|model| !model.track.is_constant()).count();
        let most = (MOST_PLACES / movable.max(1)).clamp(1, TICKS);
        1 << most.ilog2()
    }

    /// Returns true if no model moves.
    pub fn is_empty(&self) -> bool {
        self.firsts.is_empty()
    }

    /// Number of groups of ticks that models have places for, at least 1.
    pub fn groups(&self) -> usize {
        self.each.max(1)
    }

    /// Number of the group of a tick.
    #[inline(always)]
    pub fn group(&self, tick: Tick) -> usize {
        usize::from(tick) * self.groups() / TICKS
    }

    /// Places of a model, one for each group of ticks, if it moves.
    #[inline(always)]
    pub fn of(&self, model: usize) -> Option<&[Transform]> {
        let first = *self.firsts.get(model).filter(|first| **first != RESTS)? as usize;
        Some(&self.places[first..first + self.each])
    }

    /// How a model goes, if it moves.
    pub fn way(&self, model: usize) -> Option<Way<'_>> {
        let places = self.of(model)?;
        let number = self.firsts[model] as usize / self.each;
        Some(self.ends[number].as_ref().map_or(Way::Bent(places), Way::Straight))
    }

    /// Returns true if all that moves goes straight.
    pub fn are_straight(&self) -> bool {
        self.ends.iter().all(Option::is_some)
    }

    /// Place of a model at a tick, if it moves.
    #[inline(always)]
    pub fn at(&self, model: usize, tick: Tick) -> Option<&Transform> {
        let places = self.of(model)?;
        Some(&places[self.group(tick)])
    }
}

/// Places of a model within a `moment` of `clock`, for each of `each` groups of ticks; `None` if it rests, or is not there. `middle`: its
/// place in the moment's middle.
fn swept(
    track: &TransformTrack,
    (clock, moment): (&Clock, i64),
    middle: &Transform,
    each: usize,
) -> Option<Swept> {
    let times = [0.0, 1.0].map(|share| clock.time_within(moment, share));
    let shapes = track.shapes.as_ref().map(|shapes| times.map(|time| shapes.at(time)));
    let shapes: Option<[Shape; 2]> = shapes.filter(|[open, close]| open != close);
    if !middle.is_visible || track.rests(times[0], times[1]) && shapes.is_none() {
        return None;
    }
    let shares: Vec<f64> = (0..each).map(|number| (number as f64 + 0.5) / each as f64).collect();
    let exact = shares.iter().map(|share| track.map_at(clock.time_within(moment, *share)));
    let mut maps: Vec<DAffine3> = exact.collect();
    let ends = times.map(|time| track.map_at(time));
    let is_straight = maps.iter().zip(&shares).all(|(map, share)| lies_between(map, &ends, *share));
    if is_straight {
        maps = shares.iter().map(|share| between(&ends, *share)).collect();
    }
    let place = |map: DAffine3, share: f64| {
        let shape = shapes.map_or(middle.shape, |ends| Chord::between(ends, share as f32));
        Transform { shape, ..Transform::new(map) }
    };
    let placed = maps.into_iter().zip(shares).map(|(map, share)| place(map, share));
    let mut places: Vec<Transform> = placed.collect();
    let ends = [0, 1].map(|end| place(ends[end], end as f64));
    let is_straight = is_straight && places.iter().chain(&ends).all(Transform::is_finite);
    // between keys a scale may pass through nothing
    for place in places.iter_mut().filter(|place| !place.is_finite()) {
        *place = Transform { shape: place.shape, ..*middle };
    }
    let moves = places.iter().any(|place| place != middle);
    moves.then(|| Swept { places, ends: is_straight.then_some(ends) })
}

/// The map on the straight way between two.
fn between([open, close]: &[DAffine3; 2], share: f64) -> DAffine3 {
    // what rests stays where it is, to the bit
    if open == close { *open } else { open.scaled(1.0 - share).plus(close.scaled(share)) }
}

/// Returns true if each column of `map` is near enough to that of the straight way, at this share of it.
fn lies_between(map: &DAffine3, ends: &[DAffine3; 2], share: f64) -> bool {
    /// Length, for each unit of it, that is nothing but rounding.
    const ROUNDING: f64 = 1e-9;
    let columns =
        |map: &DAffine3| [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation];
    let (there, straight, [open, close]) =
        (columns(map), columns(&between(ends, share)), ends.each_ref().map(columns));
    (0..4).all(|at| {
        let way = (close[at] - open[at]).length();
        (there[at] - straight[at]).length() <= MOST_BEND * way + ROUNDING * there[at].length()
    })
}

/// Shape of a model in the middle of an exposure in which it has these places.
fn shape_in_middle(middle: &Transform, places: &[Transform]) -> Chord {
    match places.first() {
        Some(Transform { shape, .. }) if !shape.is_still() => Chord { share: 0.5, ..*shape },
        _ => middle.shape,
    }
}

/// All places of a model at a `moment` of `clock`: that of its middle, and those of groups of ticks if it moves.
pub fn all_places(track: &TransformTrack, (clock, moment): (&Clock, i64), each: usize) -> Vec<Transform> {
    let (middle, swept) = within(track, (clock, moment), each);
    places_of(middle, swept)
}

/// Place of a model in the middle of a `moment`, and those within it if it moves.
fn within(track: &TransformTrack, (clock, moment): (&Clock, i64), each: usize) -> (Transform, Option<Swept>) {
    let middle = track.at(clock.time(moment));
    let can_move = each > 1 && !clock.is_instant();
    (middle, if can_move { swept(track, (clock, moment), &middle, each) } else { None })
}

fn places_of(mut middle: Transform, swept: Option<Swept>) -> Vec<Transform> {
    let places = swept.map_or_else(Vec::new, |swept| swept.places);
    middle.shape = shape_in_middle(&middle, &places);
    std::iter::once(middle).chain(places).collect()
}

/// Places of a model at a `moment` of `clock` among which all of [`all_places`] lie: a box around what it contains at these contains it at all.
pub fn outermost_places(
    track: &TransformTrack,
    (clock, moment): (&Clock, i64),
    each: usize,
) -> Vec<Transform> {
    let (middle, swept) = within(track, (clock, moment), each);
    match swept {
        // what deforms on a straight way does not go straight where that turns
        Some(Swept { places, ends: Some(_) }) if places.iter().all(|place| place.shape.is_still()) => {
            places.first().into_iter().chain([&middle]).chain(places.last()).copied().collect()
        }
        swept => places_of(middle, swept),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::animation::{Interpolation, Track};
    use crate::changes::world::{mesh_of_two, model, scene};
    use crate::exposure::{Exposures, Shutter, Strata};

    fn sliding() -> TransformTrack {
        let keys = vec![(1.0, DVec3::ZERO), (2.0, DVec3::X), (3.0, DVec3::X)];
        let translate = Track::through(keys, Interpolation::Linear).expect("keys are good");
        TransformTrack { translate, ..TransformTrack::identity() }
    }

    fn exposures() -> Exposures {
        Exposures::new(Strata { across: 2 }, Some(&Shutter::new(-0.5, 0.5)), &[])
    }

    #[test]
    fn a_model_has_a_place_for_each_tick_while_it_moves() {
        let scene = scene(
            vec![model(mesh_of_two(), TransformTrack::identity()), model(mesh_of_two(), sliding())],
            vec![],
        );
        let exposures = exposures();
        for (moment, index, moves) in [(1, 3, true), (2, 0, true), (2, 2, false), (3, 1, false)] {
            let clock = exposures.clock(index);
            let mut middles: Vec<Transform> =
                scene.models.iter().map(|model| model.track.at(clock.time(moment))).collect();
            let sweeps = Sweeps::new(&scene, clock, moment, &mut middles);
            assert_eq!(sweeps.of(1).is_some(), moves, "{moment} {index}");
            assert_eq!(sweeps.of(0), None);
            for tick in 0..TICKS as Tick {
                let at = sweeps.at(1, tick).copied().unwrap_or(middles[1]);
                assert_eq!(at, sliding().at(clock.time_of_tick(moment, tick)), "{moment} {index} {tick}");
            }
        }
    }

    /// Turns by so many degrees in an exposure, a quarter of a shutter of half a frame, about a point that lies beside it.
    fn turning(degrees: f64) -> TransformTrack {
        let rotate = Track::through(
            vec![(0.0, DVec3::ZERO), (4.0, DVec3::new(0.0, 32.0 * degrees, 0.0))],
            Interpolation::Linear,
        );
        let aside = DAffine3::from_translation(DVec3::X * 3.0);
        let rotate = rotate.expect("keys are good");
        TransformTrack { rotate, matrix: Some(Track::constant(aside)), ..TransformTrack::identity() }
    }

    #[test]
    fn ways_that_bend_little_are_straight_and_others_are_exact() {
        const MOMENT: i64 = 2;
        let exposures = Exposures::new(Strata { across: 2 }, Some(&Shutter::new(-0.25, 0.25)), &[]);
        let clock = exposures.clock(1);
        for (track, goes_straight) in [
            (sliding(), true),
            (turning(0.5), true),
            (turning(2.0), true),
            (turning(2.6), false),
            (turning(90.0), false),
            // back in the same place when the exposure is over
            (turning(360.0), false),
        ] {
            let scene = scene(vec![model(mesh_of_two(), track.clone())], vec![]);
            let mut middles = vec![track.at(clock.time(MOMENT))];
            let sweeps = Sweeps::new(&scene, clock, MOMENT, &mut middles);
            assert_eq!(sweeps.are_straight(), goes_straight, "{track:?}");
            let exact = |share| Transform::new(track.map_at(clock.time_within(MOMENT, share)));
            let (point, tick) = (glam::Vec3::new(0.5, 0.25, -0.5), 5);
            let share = (f64::from(tick) + 0.5) / TICKS as f64;
            let there = sweeps.at(0, tick as Tick).expect("it moves").point(point);
            match sweeps.way(0).expect("it moves") {
                Way::Straight([open, close]) => {
                    assert_eq!((*open, *close), (exact(0.0), exact(1.0)));
                    let between = open.point(point).lerp(close.point(point), share as f32);
                    assert!(there.distance(between) < 1e-5, "{there} {between}");
                    let way = open.point(point).distance(close.point(point));
                    assert!(there.distance(exact(share).point(point)) <= MOST_BEND as f32 * way + 1e-5);
                }
                Way::Bent(places) => {
                    assert_eq!(places.len(), TICKS);
                    assert_eq!(there, exact(share).point(point));
                }
            }
        }
    }

    #[test]
    fn a_way_with_a_corner_is_not_straight() {
        let keys = [(1.0, DVec3::ZERO), (1.1, DVec3::X), (2.0, DVec3::Y)];
        let translate = Track::through(keys.to_vec(), Interpolation::Linear).expect("keys are good");
        let track = TransformTrack { translate, ..TransformTrack::identity() };
        let exposures = Exposures::new(Strata::ONE, Some(&Shutter::new(-0.25, 0.25)), &[]);
        let scene = scene(vec![model(mesh_of_two(), track.clone())], vec![]);
        let clock = exposures.clock(0);
        let sweeps = Sweeps::new(&scene, clock, 1, &mut [track.at(clock.time(1))]);
        assert!(matches!(sweeps.way(0), Some(Way::Bent(_))));
    }

    #[test]
    fn many_models_share_places_and_far_too_many_have_one() {
        let of = |count: usize| {
            let mesh = mesh_of_two();
            let models = (0..count).map(|_| model(mesh.clone(), sliding())).collect();
            Sweeps::places_of_each(&scene(models, vec![]))
        };
        assert_eq!([1, 512, 513, 1024, 3000, 9000].map(of), [16, 16, 8, 8, 2, 1]);
    }
}
