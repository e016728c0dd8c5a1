//! Places of models that move within an exposure.
//!
//! A model that moves has a place for each of the exposure's [`TICKS`], or for groups of successive ones where many models
//! move: [`Sweeps::places_of_each`]. Whether it is there at all follows from the exposure's middle.
//!
//! A model that deforms goes straight from its shape when the exposure begins to that when it is over ([`Chord`]): what tracers take as
//! two steps of one geometry.

use rayon::prelude::*;

use crate::animation::{Chord, Shape, Transform, TransformTrack};
use crate::exposure::{Clock, TICKS, Tick};
use crate::scene::Scene;

/// Largest number of places at an exposure: some 2 MB.
const MOST_PLACES: usize = 8192;

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
            places(&scene.models[model].track, (clock, moment), &middles[model], each).map(|all| (model, all))
        };
        let swept: Vec<(usize, Vec<Transform>)> =
            (0..middles.len()).into_par_iter().filter_map(sweep).collect();
        if swept.is_empty() {
            return Self::default();
        }
        let mut firsts = vec![RESTS; middles.len()];
        for (number, (model, sweep)) in swept.iter().enumerate() {
            firsts[*model] = (number * each) as u32;
            middles[*model].shape = shape_in_middle(&middles[*model], sweep);
        }
        Self { firsts, each, places: swept.into_iter().flat_map(|(_, places)| places).collect() }
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

    /// Place of a model at a tick, if it moves.
    #[inline(always)]
    pub fn at(&self, model: usize, tick: Tick) -> Option<&Transform> {
        let places = self.of(model)?;
        Some(&places[self.group(tick)])
    }
}

/// Places of a model within a `moment` of `clock`, for each of `each` groups of ticks; `None` if it rests, or is not there. `middle`: its
/// place in the moment's middle.
fn places(
    track: &TransformTrack,
    (clock, moment): (&Clock, i64),
    middle: &Transform,
    each: usize,
) -> Option<Vec<Transform>> {
    let ends = [0.0, 1.0].map(|share| clock.time_within(moment, share));
    let shapes = track.shapes.as_ref().map(|shapes| ends.map(|time| shapes.at(time)));
    let shapes: Option<[Shape; 2]> = shapes.filter(|[open, close]| open != close);
    if !middle.is_visible || track.rests(ends[0], ends[1]) && shapes.is_none() {
        return None;
    }
    let place = |number: usize| {
        let share = (number as f64 + 0.5) / each as f64;
        let time = clock.time_within(moment, share);
        let shape = shapes.map_or(middle.shape, |ends| Chord::between(ends, share as f32));
        let place = Transform::new(track.map_at(time));
        // between keys a scale may pass through nothing
        Transform { shape, ..if place.is_finite() { place } else { *middle } }
    };
    let places: Vec<Transform> = (0..each).map(place).collect();
    places.iter().any(|place| place != middle).then_some(places)
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
    let mut middle = track.at(clock.time(moment));
    let swept =
        if each > 1 && !clock.is_instant() { places(track, (clock, moment), &middle, each) } else { None };
    let swept = swept.unwrap_or_default();
    middle.shape = shape_in_middle(&middle, &swept);
    std::iter::once(middle).chain(swept).collect()
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
