//! Quadrics behind Embree's interface: geometries of which it knows only the boxes.

use std::array::from_fn;
use std::sync::Arc;

use embree::{Bounds, PrimitiveHit, Primitives, Segment};

use crate::geometry::quadric::{FOUR, Meeting};
use crate::geometry::{self, Quadric, quadric};

/// Pieces of a quadric.
#[derive(Debug)]
pub struct Pieces(pub Arc<Quadric>);

impl Primitives for Pieces {
    fn count(&self) -> u32 {
        self.0.count()
    }

    fn bounds(&self, piece: u32) -> Bounds {
        let geometry::Bounds { low, high } = self.0.bounds(piece);
        Bounds { lower: low.to_array(), upper: high.to_array() }
    }

    fn meet(&self, piece: u32, ray: &Segment, ends_here: bool) -> Option<PrimitiveHit> {
        let [hit, ..] = self.meet_four(piece, &[(*ray, ends_here)]);
        hit
    }

    fn meet_four(&self, piece: u32, rays: &[(Segment, bool)]) -> [Option<PrimitiveHit>; FOUR] {
        let Some(last) = rays.len().checked_sub(1) else { return [None; FOUR] };
        // lanes without a ray repeat the last one
        let four = from_fn(|lane| {
            let (ray, ends_here) = &rays[lane.min(last)];
            let (origin, direction) = (ray.origin.into(), ray.direction.into());
            quadric::Ray { origin, direction, near: ray.near, far: ray.far, ends_here: *ends_here }
        });
        let (met, meetings) = self.0.meet_four(piece, &four);
        from_fn(|lane| {
            let Meeting { t, weights: [u, v] } = meetings[lane];
            (met >> lane & 1 != 0).then_some(PrimitiveHit { t, u, v })
        })
    }
}
