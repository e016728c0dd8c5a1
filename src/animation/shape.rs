//! Shapes of deforming models over time: the two shapes that a model lies between, and its position on the
//! way.

use glam::Vec3;

/// A shape on the way between two of a model's shapes. Equal values are the same shape, to the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Number of the shape at the beginning of the way.
    pub from: u32,
    /// Number of the shape at the end of the way; the same number if the shape is one of the model's own.
    pub to: u32,
    /// Position on the way: 0 to below 1.
    pub share: f64,
}

impl Shape {
    /// The first one. Models that do not deform have no other.
    pub const FIRST: Self = Self::alone(0);

    /// Creates one of a model's own shapes.
    pub const fn alone(number: u32) -> Self {
        Self { from: number, to: number, share: 0.0 }
    }

    fn on_way(from: u32, to: u32, share: f64) -> Self {
        // one shape has one name, however it is reached
        if from == to || share == 0.0 { Self::alone(from) } else { Self { from, to, share } }
    }

    /// Interpolates a point that is at `from` in the one shape and at `to` in the other. Points that are
    /// equal in both stay equal, to the bit.
    #[inline]
    pub fn between(&self, from: Vec3, to: Vec3) -> Vec3 {
        let (from, to) = (from.as_dvec3(), to.as_dvec3());
        (from + (to - from) * self.share).as_vec3()
    }
}

/// The shape of a model at one time: on the straight way between two shapes, by which it deforms within an exposure. Equal values are the
/// same shape, to the bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// The shapes at its ends: when an exposure begins and when it is over, or twice the one shape.
    pub ends: [Shape; 2],
    /// Position on the way: 0 to below 1.
    pub share: f32,
}

impl Chord {
    /// The first shape. Models that do not deform have no other.
    pub const FIRST: Self = Self::still(Shape::FIRST);

    /// Creates what has one shape.
    pub const fn still(shape: Shape) -> Self {
        Self { ends: [shape; 2], share: 0.0 }
    }

    /// Creates a shape between two.
    pub fn between(ends: [Shape; 2], share: f32) -> Self {
        if ends[0] == ends[1] { Self::still(ends[0]) } else { Self { ends, share } }
    }

    /// Returns true if it has one shape.
    pub fn is_still(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// Interpolates what is at one place in the one shape and at another in the other. Equal ones stay equal, to the bit.
    #[inline]
    pub fn point(&self, [open, close]: [Vec3; 2]) -> Vec3 {
        open + (close - open) * self.share
    }
}

/// Keyed shapes of a model. Before the first key the shape is the first one; after the last it stays, or all
/// shapes repeat.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeTrack {
    /// Keys: frames, rising, and numbers of shapes; never empty.
    keys: Vec<(f64, u32)>,
    /// Frames from the last key to the repetition of the first one. None: nothing repeats.
    again: Option<f64>,
}

impl ShapeTrack {
    /// Creates a track through `keys`, pairs of frame and the number of a shape. `again`: the frames after
    /// the last key at which the first shape comes again, and all others after it, for ever.
    ///
    /// `None` if there are no keys, if frames do not rise or are not finite, or if `again` is not above 0.
    pub fn through(keys: Vec<(f64, u32)>, again: Option<f64>) -> Option<Self> {
        let rise = keys.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let finite = keys.iter().map(|(frame, _)| *frame).chain(again).all(f64::is_finite);
        (!keys.is_empty() && rise && finite && again.is_none_or(|again| again > 0.0))
            .then_some(Self { keys, again })
    }

    /// The shape at `frame`.
    pub fn at(&self, frame: f64) -> Shape {
        let [first, last] = self.ends();
        let frame = match self.again {
            // exact: the remainder of two floats is one
            Some(again) if frame > first => first + (frame - first) % (last - first + again),
            _ => frame,
        };
        let after = self.keys.partition_point(|(key, _)| *key <= frame);
        let Some((before, from)) = after.checked_sub(1).map(|key| self.keys[key]) else {
            return Shape::alone(self.keys[0].1);
        };
        match (self.keys.get(after), self.again) {
            (Some((next, to)), _) => Shape::on_way(from, *to, (frame - before) / (next - before)),
            (None, Some(again)) => Shape::on_way(from, self.keys[0].1, (frame - before) / again),
            (None, None) => Shape::alone(from),
        }
    }

    /// First and last frame between which the shape may change.
    pub fn span(&self) -> (f64, f64) {
        let [first, last] = self.ends();
        (first, if self.again.is_some() { f64::INFINITY } else { last })
    }

    /// End of the rest around `frame`: see [`Track::rests_until`](super::Track::rests_until).
    pub fn rests_until(&self, frame: f64) -> f64 {
        let after = self.keys.partition_point(|(key, _)| *key <= frame);
        let next = self.keys.get(after);
        match (after.checked_sub(1), next) {
            _ if self.is_constant() => f64::INFINITY,
            (None, Some((next, _))) => *next,
            // what comes again is looked at frame by frame
            _ if self.again.is_some() => frame,
            (Some(before), Some((next, to))) if self.keys[before].1 == *to => *next,
            (_, Some(_)) => frame,
            (_, None) => f64::INFINITY,
        }
    }

    /// Beginning of the rest around `frame`: see [`Track::rests_since`](super::Track::rests_since).
    pub fn rests_since(&self, frame: f64) -> f64 {
        let [first, last] = self.ends();
        if frame <= first || self.is_constant() {
            f64::NEG_INFINITY
        } else if self.again.is_none() && frame > last {
            last
        } else {
            frame
        }
    }

    /// Numbers of all shapes, key by key.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        self.keys.iter().map(|(_, number)| *number)
    }

    /// Returns true if all keys have the same shape.
    pub fn is_constant(&self) -> bool {
        self.numbers().all(|number| number == self.keys[0].1)
    }

    /// Frames of the first and of the last key.
    pub fn ends(&self) -> [f64; 2] {
        [self.keys[0].0, self.keys[self.keys.len() - 1].0]
    }

    /// Returns true if all shapes repeat.
    pub fn repeats(&self) -> bool {
        self.again.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(keys: &[(f64, u32)], again: Option<f64>) -> ShapeTrack {
        ShapeTrack::through(keys.to_vec(), again).expect("keys are good")
    }

    fn on_way(from: u32, to: u32, share: f64) -> Shape {
        Shape { from, to, share }
    }

    #[test]
    fn shapes_change_evenly_between_keys_and_rest_outside() {
        let track = track(&[(2.0, 0), (3.0, 1), (7.0, 2), (9.0, 2)], None);
        for (frame, shape) in [
            (-5.0, Shape::alone(0)),
            (2.0, Shape::alone(0)),
            (2.25, on_way(0, 1, 0.25)),
            (3.0, Shape::alone(1)),
            (6.0, on_way(1, 2, 0.75)),
            (8.5, Shape::alone(2)),
            (90.0, Shape::alone(2)),
        ] {
            assert_eq!(track.at(frame), shape, "{frame}");
        }
    }

    #[test]
    fn what_repeats_comes_again_after_the_way_back_to_the_first() {
        let track = track(&[(2.0, 0), (3.0, 1), (4.0, 2)], Some(1.0));
        for (frame, shape) in [
            (1.0, Shape::alone(0)),
            (4.0, Shape::alone(2)),
            (4.5, on_way(2, 0, 0.5)),
            (5.0, Shape::alone(0)),
            (5.5, on_way(0, 1, 0.5)),
            (3002.25, on_way(0, 1, 0.25)),
        ] {
            assert_eq!(track.at(frame), shape, "{frame}");
        }
    }

    #[test]
    fn rests_are_true() {
        let keys = [(2.0, 0), (3.0, 1), (5.0, 1), (7.0, 2), (9.0, 2)];
        for again in [None, Some(2.0)] {
            let track = track(&keys, again);
            for frame in (-8..60).map(|quarter| f64::from(quarter) * 0.25) {
                let (until, since) = (track.rests_until(frame), track.rests_since(frame));
                for other in (-20..80).map(|quarter| f64::from(quarter) * 0.25) {
                    if (since..=frame).contains(&other) || (frame..until).contains(&other) {
                        assert_eq!(track.at(other), track.at(frame), "{again:?}: {frame}, {other}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_track_is_refused() {
        assert_eq!(ShapeTrack::through(vec![], None), None);
        assert_eq!(ShapeTrack::through(vec![(1.0, 0), (1.0, 1)], None), None);
        assert_eq!(ShapeTrack::through(vec![(f64::NAN, 0)], None), None);
        assert_eq!(ShapeTrack::through(vec![(1.0, 0)], Some(0.0)), None);
    }
}
