//! Curved geometry behind Embree's interface: geometries of which it knows only the boxes.

use std::array::from_fn;
use std::ops::Range;
use std::sync::Arc;

use embree::{Bounds, PrimitiveHit, Primitives, Segment};

use crate::geometry::curved::{FOUR, Meeting, Ray};
use crate::geometry::{self, Curved};

/// Some primitives of a curved geometry, which follow each other.
#[derive(Debug)]
pub struct CurvedPart {
    /// The geometry.
    pub of: Arc<dyn Curved>,
    /// Numbers of the primitives.
    pub range: Range<u32>,
}

impl Primitives for CurvedPart {
    fn count(&self) -> u32 {
        self.range.len() as u32 * self.of.boxes()
    }

    fn number(&self, primitive: u32) -> u32 {
        primitive / self.of.boxes()
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        let (number, part) = (self.number(primitive), primitive % self.of.boxes());
        let geometry::Bounds { low, high } = self.of.bounds_of_part(self.range.start + number, part);
        Bounds { lower: low.to_array(), upper: high.to_array() }
    }

    fn meet(&self, primitive: u32, ray: &Segment, ends_here: bool) -> Option<PrimitiveHit> {
        let met = self.of.meet(self.range.start + self.number(primitive), &of_segment(ray, ends_here))?;
        let Meeting { t, weights: [u, v] } = met;
        Some(PrimitiveHit { t, u, v })
    }

    fn meet_four(&self, primitive: u32, rays: &[(Segment, bool)]) -> [Option<PrimitiveHit>; FOUR] {
        let Some(last) = rays.len().checked_sub(1) else { return [None; FOUR] };
        // lanes without a ray repeat the last one
        let four = from_fn(|lane| {
            let (ray, ends_here) = &rays[lane.min(last)];
            of_segment(ray, *ends_here)
        });
        let (met, meetings) = self.of.meet_four(self.range.start + self.number(primitive), &four);
        from_fn(|lane| {
            let Meeting { t, weights: [u, v] } = meetings[lane];
            (met >> lane & 1 != 0).then_some(PrimitiveHit { t, u, v })
        })
    }
}

fn of_segment(ray: &Segment, ends_here: bool) -> Ray {
    let (origin, direction) = (ray.origin.into(), ray.direction.into());
    Ray { origin, direction, near: ray.near, far: ray.far, ends_here }
}
