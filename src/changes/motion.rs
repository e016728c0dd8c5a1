//! Motion of a whole shot, with queries about segments.

use glam::Vec3;
use rayon::prelude::*;

use super::frames::{self, Direction};
use super::leaves::{Mover, leaves};
use super::tree::Tree;
use super::until::Until;
use crate::exposure::Clock;
use crate::scene::{Light, Model, Scene};
use crate::sweep::{Sweeps, outermost_places};

/// Largest number of leaves: some 60 MB of nodes.
const MOST_LEAVES: usize = 1 << 20;

/// Factor by which segments are tested beyond their ends: the distances at which rays meet surfaces are
/// rounded.
const BEYOND_END: f32 = 1.0 + 1e-5;

/// Frames in which models that move touch a segment, and in which lights change. Time runs forwards or
/// backwards: "later" is later in its direction, and "before" is earlier in it. A frame is seen at its
/// [moment](Clock).
///
/// Results are never later than the truth. They are earlier where a box around a part of a model is touched
/// and the model is not, and in shots with so much motion that boxes are shared by parts, or by places of
/// several frames.
#[derive(Debug, Clone, Default)]
pub struct Motion {
    /// [Count](Direction::count) of the frame two before the first one in which anything differs from the
    /// frame before; 0 if nothing ever moves. Other frames are counted from here.
    start: i64,
    /// Direction in which frames are counted.
    direction: Direction,
    /// Hierarchy of the models' motion.
    tree: Tree,
    /// True if a model moves after the last frame that [`Until`] can name: there everything counts as
    /// touched.
    moves_later: bool,
    /// Changes of each of the scene's lights; empty if nothing ever changes.
    lights: Vec<Changes>,
    /// Changes of each of the scene's models; empty if nothing ever changes.
    models: Vec<Changes>,
}

/// Frames in which something changes.
#[derive(Debug, Clone, Default)]
struct Changes {
    /// Frames, rising.
    frames: Vec<u16>,
    /// True if it changes after the last frame that [`Until`] can name.
    changes_later: bool,
}

impl Motion {
    /// Motion of all models and lights of `scene`; time runs forwards.
    pub fn of(scene: &Scene) -> Self {
        Self::in_direction(scene, &Clock::FRAMES, Direction::Forward, 1)
    }

    /// Motion of all models and lights of `scene`, at the moments of `clock`: one of `count` that are kept.
    pub fn in_direction(scene: &Scene, clock: &Clock, direction: Direction, count: usize) -> Self {
        Self::with_limit(scene, clock, direction, MOST_LEAVES / count.max(1))
    }

    /// Motion with not many more than `limit` leaves.
    pub(super) fn with_limit(scene: &Scene, clock: &Clock, direction: Direction, limit: usize) -> Self {
        let moving = (0..).zip(&scene.models).filter(|(_, model)| !model.track.is_constant());
        let models: Vec<(u32, &Model)> = moving.collect();
        let each = Sweeps::places_of_each(scene);
        let first_of_model =
            |(_, model): &(u32, &Model)| frames::of_model(&model.track, (clock, each), direction).next();
        let first_of_light = |light: &Light| frames::of_light(light, clock, direction).next();
        let first_changes = (
            models.par_iter().filter_map(first_of_model).min(),
            scene.lights.par_iter().filter_map(first_of_light).min(),
        );
        let Some(start) = first_changes.0.into_iter().chain(first_changes.1).min() else {
            return Self { direction, ..Self::default() };
        };
        // counted from two frames before it: the first two numbers of `Until` are not frames
        let start = start - 2;
        let of_model = |(_, model): &(u32, &Model)| {
            Changes::new(frames::of_model(&model.track, (clock, each), direction), start)
        };
        let changes: Vec<Changes> = models.par_iter().map(of_model).collect();
        let moves_later = changes.iter().any(|changes| changes.changes_later);
        let mut of_models = vec![Changes::default(); scene.models.len()];
        for ((number, _), changes) in models.iter().zip(&changes) {
            of_models[*number as usize] = changes.clone();
        }
        let has_medium = |material: &u16| scene.materials[usize::from(*material)].medium.is_some();
        let has_media = scene.materials.iter().any(|material| material.medium.is_some());
        let is_filled = |model: &Model| has_media && model.mesh.material_of.iter().any(has_medium);
        let movers = models.into_iter().zip(changes).filter(|(_, changes)| !changes.frames.is_empty());
        let movers: Vec<Mover<'_>> = movers
            .map(|((_, model), changes)| Mover {
                model,
                is_filled: is_filled(model),
                changes: changes.frames,
            })
            .collect();
        let places = |mover: &Mover<'_>, count: i64| {
            outermost_places(&mover.model.track, (clock, direction.count(start + count)), each)
        };
        Self {
            start,
            direction,
            tree: Tree::of(leaves(&movers, places, limit)),
            moves_later,
            lights: (scene.lights.iter())
                .map(|light| Changes::new(frames::of_light(light, clock, direction), start))
                .collect(),
            models: of_models,
        }
    }

    /// First frame after `after` in which something that moves may touch the segment `origin + t *
    /// direction`, t in `0..=far`, arriving or leaving: until then a result about the segment that was found
    /// in frame `after` holds. World space; `far` may be infinite, `direction` has any length but zero.
    ///
    /// This covers occluders that rest at first, and segments that end on a model that moves later: the model
    /// touches the segment when it leaves.
    pub fn first_touch(&self, origin: Vec3, direction: Vec3, far: f32, after: impl Into<i64>) -> Until {
        self.first_touch_before(origin, direction, far, after, Until::FOREVER)
    }

    /// Like [`first_touch`](Self::first_touch), or `before` if that is earlier: less is searched then.
    pub fn first_touch_before(
        &self,
        origin: Vec3,
        direction: Vec3,
        far: f32,
        after: impl Into<i64>,
        before: Until,
    ) -> Until {
        let (after, end) = (self.count(after), end(self.moves_later).min(before));
        // a segment that ends on a surface may meet, at the same place, one that arrives there: rounding
        // decides which of the two is nearer
        let far = far * BEYOND_END;
        let frame = self.tree.first_touch(origin, direction, far, after as f32, f32::from(end.to_bits()));
        Until::from_bits(frame as u16)
    }

    /// Number of nodes that [`Motion::first_touch`] visits.
    #[cfg(test)]
    pub(super) fn visits(&self, origin: Vec3, direction: Vec3, far: f32, after: impl Into<i64>) -> usize {
        let (after, end) = (self.count(after), f32::from(end(self.moves_later).to_bits()));
        let mut visits = 0;
        self.tree.search(origin, direction, far, after as f32, end, || visits += 1);
        visits
    }

    /// First frame after `after` in which light number `light` differs in anything from the frame before.
    pub fn first_light_change(&self, light: usize, after: impl Into<i64>) -> Until {
        self.lights.get(light).map_or(Until::FOREVER, |changes| changes.first_after(self.count(after)))
    }

    /// First frame after `after` in which a model differs from the frame before: in place or shape, or
    /// because it appears or disappears. For results that depend on the place or presence of a model: if a
    /// segment that ends on the model is touched is a matter of rounding.
    pub fn first_change_of(&self, model: u32, after: impl Into<i64>) -> Until {
        self.models
            .get(model as usize)
            .map_or(Until::FOREVER, |changes| changes.first_after(self.count(after)))
    }

    /// Returns true if a result is invalid in `frame`. It is valid from the frame in which it was found up to
    /// the last one before this becomes true.
    pub fn has_expired(&self, until: Until, frame: impl Into<i64>) -> bool {
        let frame = self.since_start(frame);
        until != Until::FOREVER && (until <= Until::EXPIRED || frame >= i64::from(until.to_bits()))
    }

    /// Returns true if a result that is valid in `frame` is invalid in the frame after.
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
        // before the first frame of motion, frames have no numbers
        let count = other.since_start(frame) + frames;
        Until::frame(count.clamp(Until::EXPIRED.to_bits().into(), Until::LAST.into()) as u16)
    }

    /// Returns true if nothing ever moves or changes.
    pub fn is_none(&self) -> bool {
        self.tree.nodes() == 0 && self.lights.iter().all(|light| light.frames.is_empty())
    }

    /// Number of nodes of the hierarchy.
    pub fn nodes(&self) -> usize {
        self.tree.nodes()
    }

    /// Counts a frame from [`start`](Self::start): -1 for all that are before it, and [`Until::LAST`] for
    /// those that cannot be named. The first frame of motion is 2.
    fn count(&self, frame: impl Into<i64>) -> i32 {
        self.since_start(frame).clamp(-1, Until::LAST.into()) as i32
    }

    fn since_start(&self, frame: impl Into<i64>) -> i64 {
        self.direction.count(frame.into()) - self.start
    }
}

/// Expiry of a result that holds in all frames with numbers.
fn end(changes_later: bool) -> Until {
    if changes_later { Until::frame(Until::LAST) } else { Until::FOREVER }
}

impl Changes {
    /// Collects those of the `counts` that can be named, counted from `start`, and notes if there are others
    /// after them.
    fn new(counts: impl Iterator<Item = i64>, start: i64) -> Self {
        let mut frames = Vec::new();
        for frame in counts.map(|frame| frame - start) {
            match u16::try_from(frame) {
                Ok(frame) if frame <= Until::LAST => frames.push(frame),
                _ => return Self { frames, changes_later: true },
            }
        }
        Self { frames, changes_later: false }
    }

    /// First change after frame `after`, counted from [`Motion::start`].
    fn first_after(&self, after: i32) -> Until {
        let next = self.frames.partition_point(|frame| i32::from(*frame) <= after);
        self.frames.get(next).map_or(end(self.changes_later), |frame| Until::frame(*frame))
    }
}
