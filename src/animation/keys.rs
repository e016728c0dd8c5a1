//! Timing of a track, which does not depend on the type of its values.

use super::{Keyed, ShapeTrack, Track};

/// When a value has keys, and rests.
pub trait Keys {
    /// Frames of the first and the last key.
    fn span(&self) -> (f64, f64);
    /// See [`Track::rests_until`].
    fn rests_until(&self, frame: f64) -> f64;
    /// See [`Track::rests_since`].
    fn rests_since(&self, frame: f64) -> f64;
}

impl<T: Keyed> Keys for Track<T> {
    fn span(&self) -> (f64, f64) {
        let ends = (self.frames().next(), self.frames().last());
        (ends.0.unwrap_or(f64::INFINITY), ends.1.unwrap_or(f64::NEG_INFINITY))
    }

    fn rests_until(&self, frame: f64) -> f64 {
        Self::rests_until(self, frame)
    }

    fn rests_since(&self, frame: f64) -> f64 {
        Self::rests_since(self, frame)
    }
}

impl Keys for ShapeTrack {
    fn span(&self) -> (f64, f64) {
        Self::span(self)
    }

    fn rests_until(&self, frame: f64) -> f64 {
        Self::rests_until(self, frame)
    }

    fn rests_since(&self, frame: f64) -> f64 {
        Self::rests_since(self, frame)
    }
}
