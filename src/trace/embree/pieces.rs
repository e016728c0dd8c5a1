//! Quadrics, as Embree asks for them: geometries of which it knows boxes alone.

use std::sync::Arc;

use embree::{Bounds, PrimitiveHit, Primitives, Segment};

use crate::geometry::{self, Quadric, quadric};

/// A quadric's pieces.
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
        let (origin, direction) = (ray.origin.into(), ray.direction.into());
        let ray = quadric::Ray { origin, direction, near: ray.near, far: ray.far, ends_here };
        let met = self.0.meet(piece, &ray)?;
        Some(PrimitiveHit { t: met.t, u: met.weights[0], v: met.weights[1] })
    }
}
