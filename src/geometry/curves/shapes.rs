//! Curves that deform: where their points are in each of several shapes, and the curves at rest on which samples are kept.
//!
//! Points and radii go straight from shape to shape. A place of a primitive is the same [weights](super::hull) in all of them.
//!
//! *At rest.* A place must have weights of its own there, whatever becomes of the curve: one that grows out of nothing, or whose tip is a point in
//! some shape, cannot be kept in that. So the curves at rest are as thick everywhere as they ever are anywhere, and pieces that are far shorter
//! in the first shape than in another are as long as in that. They are never seen.

use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};

use super::{Curves, Points};
use crate::animation::Shape;

/// What points go to: those of another shape, and the share of the way there.
#[derive(Debug, Clone)]
pub struct Later {
    pub points: Arc<Points>,
    pub share: f32,
}

/// Share of its greatest length that a piece has in the first shape at least, where that is as it is kept.
const LEAST_LENGTH: f32 = 1.0 / 16.0;

impl Later {
    /// The ends of a primitive, of which number `first` is the first point, between where they are `now` and where they go.
    #[inline]
    pub fn between(&self, first: usize, now: [[f32; 4]; 2]) -> [[f32; 4]; 2] {
        let end = |at: usize| {
            let (from, to) = (Vec4::from(now[at]), Vec4::from(self.points.all[first + at]));
            // equal ones stay equal, to the bit
            (from + (to - from) * self.share).to_array()
        };
        [end(0), end(1)]
    }
}

impl Curves {
    /// Creates curves with these shapes, each as of [`new`](Self::new): as many points, in the same order. Returns, too, the numbers of the points that
    /// remain: those that are in the place of the one before in every shape are left out. `None` if no curve remains.
    pub fn deforming(shapes: &[Vec<[f32; 4]>], counts: &[u32], uvs: &[Vec2]) -> Option<(Self, Vec<u32>)> {
        let (mut curves, kept) = Self::new(&at_rest(shapes, counts), counts, uvs)?;
        let of_kept = |points: &Vec<[f32; 4]>| {
            Arc::new(Points::new(kept.iter().map(|number| points[*number as usize]).collect()))
        };
        curves.shapes = Some(Arc::new(shapes.iter().map(of_kept).collect()));
        Some((curves, kept))
    }

    /// The curves at these shares of the straight way between two shapes; none if they do not deform.
    pub(super) fn moments(&self, [open, close]: &[Shape; 2], shares: &[f32]) -> Vec<Self> {
        let Some(shapes) = &self.shapes else { return Vec::new() };
        let first = in_shape(shapes, open);
        let second = (open != close).then(|| in_shape(shapes, close));
        let at = |share: &f32| Self {
            own: Arc::clone(&first),
            later: second.as_ref().map(|points| Later { points: Arc::clone(points), share: *share }),
            shapes: None,
            tree: Arc::default(),
            ..self.clone()
        };
        shares.iter().map(at).collect()
    }

    /// The greatest radius, in the space of the points.
    pub(super) fn greatest_radius(&self) -> f32 {
        self.later.as_ref().map_or(0.0, |later| later.points.most_radius).max(self.own.most_radius)
    }
}

/// Points in a shape: those of one of the list, or on the way between two of them.
fn in_shape(list: &[Arc<Points>], shape: &Shape) -> Arc<Points> {
    let [from, to] = [shape.from, shape.to].map(|number| &list[number as usize]);
    if shape.from == shape.to {
        return Arc::clone(from);
    }
    let between = |(from, to): (&[f32; 4], &[f32; 4])| {
        let place = shape.between(Vec3::from_slice(from), Vec3::from_slice(to));
        let radius = shape.between(Vec3::splat(from[3]), Vec3::splat(to[3])).x;
        place.extend(radius).to_array()
    };
    Arc::new(Points::new(from.all.iter().zip(&to.all).map(between).collect()))
}

/// The curves on which samples are kept.
fn at_rest(shapes: &[Vec<[f32; 4]>], counts: &[u32]) -> Vec<[f32; 4]> {
    let place = |shape: &Vec<[f32; 4]>, at: usize| Vec3::from_slice(&shape[at]);
    let mut rest = Vec::with_capacity(shapes[0].len());
    let mut begin = 0;
    for count in counts.iter().map(|count| *count as usize) {
        let points = begin..begin + count;
        let radii = shapes.iter().flat_map(|shape| shape[points.clone()].iter().map(|point| point[3]));
        let radius = radii.fold(0.0, f32::max);
        // to the next point, as it is in the first shape and in that in which it is longest
        let steps = |at: usize| {
            let step = |shape| place(shape, at + 1) - place(shape, at);
            let longest = shapes.iter().map(step).max_by(|a, b| a.length().total_cmp(&b.length()));
            [step(&shapes[0]), longest.unwrap_or_default()]
        };
        let is_short = |at: usize| {
            let [first, longest] = steps(at);
            first.length() < LEAST_LENGTH * longest.length()
        };
        let inner = || points.start..points.end.saturating_sub(1).max(points.start);
        let keeps_first = !inner().any(is_short);
        let mut at = points.clone().next().map_or(Vec3::ZERO, |first| place(&shapes[0], first));
        for number in points.clone() {
            rest.push(if keeps_first { place(&shapes[0], number) } else { at }.extend(radius).to_array());
            if inner().contains(&number) {
                let [first, longest] = steps(number);
                at += if is_short(number) { longest } else { first };
            }
        }
        begin = points.end;
    }
    rest
}
