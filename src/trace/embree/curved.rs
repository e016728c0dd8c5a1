//! Curved geometry behind Embree's interface: geometries of which it knows only the boxes.

use std::array::from_fn;
use std::ops::Range;
use std::sync::Arc;

use embree::{Bounds, PrimitiveHit, Primitives, Segment};

use super::places::times_of_ends;
use crate::animation::Shape;
use crate::geometry::curved::{FOUR, Meeting, Ray};
use crate::geometry::{self, Curved};

/// A curved geometry that goes straight from one of its shapes to another while the exposure lasts.
#[derive(Debug, Clone)]
pub struct MovingCurved {
    /// At its beginning and its end.
    ends: [Arc<dyn Curved>; 2],
    /// As rays of each group of ticks see it.
    groups: Arc<[Arc<dyn Curved>]>,
}

impl MovingCurved {
    /// Creates `rest` between two shapes, for so many groups of ticks; `None` if it does not deform.
    pub fn new(rest: &dyn Curved, ends: &[Shape; 2], groups: usize) -> Option<Self> {
        let shares: Vec<f32> =
            (0..groups).map(|group| (group as f32 + 0.5) / groups as f32).chain([0.0, 1.0]).collect();
        let mut moments = rest.between(ends, &shares);
        let (close, open) = (moments.pop()?, moments.pop()?);
        Some(Self { ends: [open, close], groups: moments.into() })
    }

    /// The geometry when the exposure begins.
    pub fn first(&self) -> &dyn Curved {
        self.ends[0].as_ref()
    }

    /// The geometry that a ray of this time sees.
    #[inline]
    fn at(&self, time: f32) -> &dyn Curved {
        let groups = self.groups.len();
        // times of groups are multiples of their share
        self.groups[((time * groups as f32 + 0.5) as usize).min(groups - 1)].as_ref()
    }
}

/// Some primitives of a geometry that moves, which follow each other.
#[derive(Debug)]
pub struct MovingPart {
    pub of: MovingCurved,
    /// Numbers of the primitives.
    pub range: Range<u32>,
}

impl MovingPart {
    fn bounds_at(&self, end: usize, primitive: u32) -> Bounds {
        let of = &self.of.ends[end];
        box_of(of.as_ref(), self.range.start + primitive / of.boxes(), primitive % of.boxes())
    }
}

impl Primitives for MovingPart {
    fn count(&self) -> u32 {
        self.range.len() as u32 * self.of.first().boxes()
    }

    fn number(&self, primitive: u32) -> u32 {
        primitive / self.of.first().boxes()
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        self.bounds_at(0, primitive)
    }

    fn times(&self) -> Option<[f32; 2]> {
        Some(times_of_ends(self.of.groups.len()))
    }

    fn later_bounds(&self, primitive: u32) -> Bounds {
        self.bounds_at(1, primitive)
    }

    fn meet(&self, primitive: u32, ray: &Segment, ends_here: bool) -> Option<PrimitiveHit> {
        let number = self.range.start + self.number(primitive);
        let Meeting { t, weights: [u, v] } =
            self.of.at(ray.time).meet(number, &of_segment(ray, ends_here))?;
        Some(PrimitiveHit { t, u, v })
    }
}

/// Some primitives of a curved geometry, which follow each other.
#[derive(Debug)]
pub struct CurvedPart {
    of: Arc<dyn Curved>,
    /// Numbers of the primitives.
    range: Range<u32>,
    /// Boxes of each: asked once, since rays come to each box.
    boxes: u32,
}

impl CurvedPart {
    /// The primitives of a geometry that have these numbers.
    pub fn new(of: Arc<dyn Curved>, range: Range<u32>) -> Self {
        let boxes = of.boxes();
        Self { of, range, boxes }
    }
}

impl Primitives for CurvedPart {
    fn count(&self) -> u32 {
        self.range.len() as u32 * self.boxes
    }

    #[inline(always)]
    fn number(&self, primitive: u32) -> u32 {
        // most have one, and divisions take long
        if self.boxes == 1 { primitive } else { primitive / self.boxes }
    }

    fn bounds(&self, primitive: u32) -> Bounds {
        let (number, part) = (self.number(primitive), primitive % self.boxes);
        box_of(self.of.as_ref(), self.range.start + number, part)
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

fn box_of(curved: &dyn Curved, primitive: u32, part: u32) -> Bounds {
    let geometry::Bounds { low, high } = curved.bounds_of_part(primitive, part);
    Bounds { lower: low.to_array(), upper: high.to_array() }
}

fn of_segment(ray: &Segment, ends_here: bool) -> Ray {
    let (origin, direction) = (ray.origin.into(), ray.direction.into());
    Ray { origin, direction, near: ray.near, far: ray.far, ends_here }
}
