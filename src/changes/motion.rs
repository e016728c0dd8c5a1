//! All motion of a shot, to be asked about segments.

use glam::Vec3;
use rayon::prelude::*;

use super::frames::{self, Direction};
use super::leaves::{Mover, leaves};
use super::tree::Tree;
use super::until::Until;
use crate::exposure::Clock;
use crate::scene::{Light, Model, Scene};

/// Leaves at most: some 60 MB of nodes.
const MOST_LEAVES: usize = 1 << 20;

/// How far beyond their ends segments are looked at: the distances at which rays meet surfaces are rounded.
const BEYOND_END: f32 = 1.0 + 1e-5;

/// When what moves in a shot touches a segment, and when its lights change. Time runs forwards in it, or backwards: "later" is what
/// comes later in its direction, and "before" what came before. Where frames are seen at several times, it counts their
/// [moments](Clock) instead of frames.
///
/// Never later than the truth. Earlier where a box around a part of a model is touched and the model is not, and in
/// shots with so much motion that boxes are shared by parts, or by places of several frames.
#[derive(Debug, Clone, Default)]
pub struct Motion {
    /// The [count](Direction::count) of the frame two before the first one in which anything differs from the frame before; 0 if
    /// nothing ever moves. Other frames are counted from here.
    start: i64,
    /// In which frames are counted.
    direction: Direction,
    /// Of the models.
    tree: Tree,
    /// Whether a model moves after the last frame that [`Until`] can name: there everything counts as touched.
    moves_later: bool,
    /// One for each of the scene's, or none if nothing ever changes.
    lights: Vec<Changes>,
    /// One for each of the scene's, or none if nothing ever changes.
    models: Vec<Changes>,
}

/// When something changes.
#[derive(Debug, Clone, Default)]
struct Changes {
    /// Rising.
    frames: Vec<u16>,
    /// Whether it changes after the last frame that [`Until`] can name.
    changes_later: bool,
}

impl Motion {
    /// Of all models and lights of `scene`; time runs forwards.
    pub fn of(scene: &Scene) -> Self {
        Self::in_direction(scene, &Clock::FRAMES, Direction::Forward)
    }

    /// Of all models and lights of `scene`, at the moments of `clock`.
    pub fn in_direction(scene: &Scene, clock: &Clock, direction: Direction) -> Self {
        Self::with_limit(scene, clock, direction, MOST_LEAVES)
    }

    /// With not many more than `limit` leaves.
    pub(super) fn with_limit(scene: &Scene, clock: &Clock, direction: Direction, limit: usize) -> Self {
        let moving = (0..).zip(&scene.models).filter(|(_, model)| !model.track.is_constant());
        let models: Vec<(u32, &Model)> = moving.collect();
        let first_of_model =
            |(_, model): &(u32, &Model)| frames::of_model(&model.track, clock, direction).next();
        let first_of_light = |light: &Light| frames::of_light(light, clock, direction).next();
        let first_changes = (
            models.par_iter().filter_map(first_of_model).min(),
            scene.lights.par_iter().filter_map(first_of_light).min(),
        );
        let Some(start) = first_changes.0.into_iter().chain(first_changes.1).min() else {
            return Self { direction, ..Self::default() };
        };
        // counted from two frames before it: the first two numbers of `Until` name none
        let start = start - 2;
        let of_model =
            |(_, model): &(u32, &Model)| Changes::of(frames::of_model(&model.track, clock, direction), start);
        let changes: Vec<Changes> = models.par_iter().map(of_model).collect();
        let moves_later = changes.iter().any(|changes| changes.changes_later);
        let mut of_models = vec![Changes::default(); scene.models.len()];
        for ((number, _), changes) in models.iter().zip(&changes) {
            of_models[*number as usize] = changes.clone();
        }
        let movers = models.into_iter().zip(changes);
        let movers = movers.map(|((_, model), changes)| Mover { model, changes: changes.frames });
        let movers: Vec<Mover<'_>> = movers.filter(|mover| !mover.changes.is_empty()).collect();
        let place =
            |mover: &Mover<'_>, count: i64| mover.model.track.at(clock.time(direction.count(start + count)));
        Self {
            start,
            direction,
            tree: Tree::of(leaves(&movers, place, limit)),
            moves_later,
            lights: (scene.lights.iter())
                .map(|light| Changes::of(frames::of_light(light, clock, direction), start))
                .collect(),
            models: of_models,
        }
    }

    /// For an answer about the segment `origin + t * direction`, t in `0..=far`, that was found in frame `after`: the
    /// first later frame in which something that moves may touch it, arriving or leaving. World space; `far` may be
    /// infinite, `direction` has any length but zero.
    ///
    /// What rests in the way, and the end of the segment on a model that moves later, are seen to: the model touches
    /// the segment when it leaves.
    pub fn first_touch(&self, origin: Vec3, direction: Vec3, far: f32, after: impl Into<i64>) -> Until {
        self.first_touch_before(origin, direction, far, after, Until::FOREVER)
    }

    /// The same, but `before` if that is earlier: less is looked at then.
    pub fn first_touch_before(
        &self,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        after: impl Into<i64>,
        before: Until,
    ) -> Until {
        let (after, end) = (self.count(after), end(self.moves_later).min(before));
        // what ends on a surface may meet, at the same place, what comes there: which of the two is nearer is rounding
        let far = far * BEYOND_END;
        let frame = self.tree.first_touch(origin, direction, far, after as f32, f32::from(end.to_bits()));
        Until::from_bits(frame as u16)
    }

    /// How many nodes [`Motion::first_touch`] looks at.
    #[cfg(test)]
    pub(super) fn visits(&self, origin: Vec3, direction: Vec3, far: f32, after: impl Into<i64>) -> usize {
        let (after, end) = (self.count(after), f32::from(end(self.moves_later).to_bits()));
        let mut visits = 0;
        self.tree.search(origin, direction, far, after as f32, end, || visits += 1);
        visits
    }

    /// The first frame after `after` in which light number `light` differs in anything from the frame before.
    pub fn first_light_change(&self, light: usize, after: impl Into<i64>) -> Until {
        self.lights.get(light).map_or(Until::FOREVER, |changes| changes.first_after(self.count(after)))
    }

    /// The first frame after `after` in which a model differs from the frame before: in place or shape, or because it appears or
    /// disappears. Whoever depends on where a model is, or that it is there, asks this: where a segment ends on it is a matter of
    /// rounding.
    pub fn first_change_of(&self, model: u32, after: impl Into<i64>) -> Until {
        self.models
            .get(model as usize)
            .map_or(Until::FOREVER, |changes| changes.first_after(self.count(after)))
    }

    /// Whether an answer does not hold in `frame`. It holds in the frames from that on in which it was found to the one
    /// before this is true.
    pub fn has_expired(&self, until: Until, frame: impl Into<i64>) -> bool {
        let frame = self.since_start(frame);
        until != Until::FOREVER && (until <= Until::EXPIRED || frame >= i64::from(until.to_bits()))
    }

    /// Whether an answer does not hold in the frame after `frame`, if it does in that.
    pub fn expires_next(&self, until: Until, frame: impl Into<i64>) -> bool {
        until <= Until::EXPIRED
            || until != Until::FOREVER && i64::from(until.to_bits()) <= self.since_start(frame) + 1
    }

    /// Converts an expiry that was found in `frame` to the motion `other`, in which time runs the other way. The number of frames stays
    /// the same.
    pub fn to_opposite(&self, until: Until, frame: impl Into<i64>, other: &Self) -> Until {
        let frame = frame.into();
        if until == Until::FOREVER || until <= Until::EXPIRED {
            return until;
        }
        let frames = i64::from(until.to_bits()) - self.since_start(frame);
        // before the first frame of motion none has a number
        let count = other.since_start(frame) + frames;
        Until::frame(count.clamp(Until::EXPIRED.to_bits().into(), Until::LAST.into()) as u16)
    }

    /// Whether nothing ever moves or changes.
    pub fn is_none(&self) -> bool {
        self.tree.nodes() == 0 && self.lights.iter().all(|light| light.frames.is_empty())
    }

    /// Nodes of the hierarchy.
    pub fn nodes(&self) -> usize {
        self.tree.nodes()
    }

    /// A frame counted from [`start`](Self::start): -1 for all that are before it, and [`Until::LAST`] for those that
    /// cannot be named. The first frame of motion is 2.
    fn count(&self, frame: impl Into<i64>) -> i32 {
        self.since_start(frame).clamp(-1, Until::LAST.into()) as i32
    }

    fn since_start(&self, frame: impl Into<i64>) -> i64 {
        self.direction.count(frame.into()) - self.start
    }
}

/// What holds of an answer after all frames with numbers.
fn end(changes_later: bool) -> Until {
    if changes_later { Until::frame(Until::LAST) } else { Until::FOREVER }
}

impl Changes {
    /// Those of the `counts` that can be named, counted from `start`, and whether there are others after them.
    fn of(counts: impl Iterator<Item = i64>, start: i64) -> Self {
        let mut frames = Vec::new();
        for frame in counts.map(|frame| frame - start) {
            match u16::try_from(frame) {
                Ok(frame) if frame <= Until::LAST => frames.push(frame),
                _ => return Self { frames, changes_later: true },
            }
        }
        Self { frames, changes_later: false }
    }

    /// The first one after frame `after`, counted as [`Motion::start`] says.
    fn first_after(&self, after: i32) -> Until {
        let next = self.frames.partition_point(|frame| i32::from(*frame) <= after);
        self.frames.get(next).map_or(end(self.changes_later), |frame| Until::frame(*frame))
    }
}
