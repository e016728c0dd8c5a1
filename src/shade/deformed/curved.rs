//! Curved geometry that deforms, at one time.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::DeformedPlace;
use crate::animation::{Chord, Shape};
use crate::exposure::TICKS;
use crate::geometry::Curved;

/// Number of steps of an exposure in whose middles and ends all shares of [chords](Chord) lie: see [`Sweeps`](crate::sweep::Sweeps).
const STEPS: usize = 2 * TICKS;

/// A geometry in its one shape, or at all shares of the way through an exposure.
#[derive(Debug, Clone)]
pub struct DeformedGeometry {
    ends: [Shape; 2],
    /// By share, in [`STEPS`]; one where it has one shape.
    moments: Vec<Arc<dyn Curved>>,
}

/// A geometry that deforms, at one time.
#[derive(Debug, Clone, Copy)]
pub struct DeformedCurved<'a> {
    /// As its samples are kept.
    pub rest: &'a dyn Curved,
    /// As it looks.
    pub now: &'a dyn Curved,
}

impl DeformedGeometry {
    /// Creates the geometry with the shapes of `chord`; `None` if it does not deform. `before`: the same at another time.
    pub fn new(rest: &dyn Curved, chord: &Chord, before: Option<&Self>) -> Option<Self> {
        if rest.shapes() == 0 {
            return None;
        }
        if let Some(before) = before.filter(|before| before.ends == chord.ends) {
            return Some(before.clone());
        }
        let steps = if chord.is_still() { 1 } else { STEPS };
        let shares: Vec<f32> = (0..steps).map(|step| step as f32 / steps as f32).collect();
        Some(Self { ends: chord.ends, moments: rest.between(&chord.ends, &shares) })
    }

    /// The geometry as it is on this way.
    #[inline]
    pub fn at<'a>(&'a self, rest: &'a dyn Curved, chord: &Chord) -> DeformedCurved<'a> {
        let step = (chord.share * self.moments.len() as f32) as usize;
        DeformedCurved { rest, now: &*self.moments[step.min(self.moments.len() - 1)] }
    }
}

impl DeformedCurved<'_> {
    /// Place of the `point` of a primitive that is there at rest.
    pub fn point(&self, primitive: u32, point: Vec3) -> Vec3 {
        self.now.point(primitive, self.rest.weights(primitive, point))
    }

    /// Place of a point, as in [`point`](Self::point), with the normal there.
    pub fn place(&self, primitive: u32, point: Vec3) -> DeformedPlace {
        let weights = self.rest.weights(primitive, point);
        let normal = self.now.normal(primitive, weights);
        DeformedPlace { point: self.now.point(primitive, weights), normal, geometric_normal: normal }
    }

    /// Normal of a primitive where its normal at rest is this one; on the same side, of unit length.
    pub fn normal(&self, primitive: u32, at_rest: Vec3) -> Vec3 {
        self.now.normal(primitive, self.rest.weights_of_normal(primitive, at_rest))
    }

    /// Side of a primitive at rest that a normal at a point is on: 1 for its outside, -1 for its inside.
    pub fn side_at_rest(&self, primitive: u32, point: Vec3, normal: Vec3) -> f32 {
        let outside = self.rest.normal(primitive, self.rest.weights(primitive, point));
        if outside.dot(normal) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Maps a `direction` along a primitive from rest to this time, of any length.
    pub fn direction(&self, primitive: u32, direction: Vec3) -> Vec3 {
        let parts = self.rest.axes(primitive).inverse() * direction.as_dvec3();
        (self.now.axes(primitive) * parts).as_vec3()
    }

    /// Intersects a line with a primitive, and returns the point of it at rest: see [`meet_line`](Curved::meet_line).
    pub fn meet(&self, primitive: u32, [origin, along]: [DVec3; 2], about: Vec3) -> Vec3 {
        let about = self.point(primitive, about);
        let met = self.now.meet_line(primitive, origin, along, about);
        self.rest.point(primitive, self.now.weights(primitive, met))
    }
}
