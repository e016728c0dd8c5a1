//! Divides what sends light into parts that lie apart.

use std::ops::Range;

use glam::DVec3;

use crate::scene::render_space::Extent;

/// What is divided: where it is, and how much light it sends.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    /// World space.
    pub place: DVec3,
    /// Relative to the others.
    pub weight: f64,
}

/// A part, how much it is worth to divide it, and where.
struct Candidate {
    range: Range<usize>,
    worth: f64,
    axis: usize,
    middle: f64,
}

impl Candidate {
    fn new<T>(all: &[T], range: Range<usize>, item: &impl Fn(&T) -> Item, least_length: f64) -> Self {
        let of_part = all[range.clone()].iter().map(item);
        let extent = of_part.clone().fold(Extent::NONE, |extent, each| extent.with(each.place));
        let size = extent.size();
        let axis = (1..3).fold(0, |longest, axis| if size[axis] > size[longest] { axis } else { longest });
        let light: f64 = of_part.map(|each| each.weight).sum();
        let worth = if size[axis] > least_length { light * size[axis] * size[axis] } else { 0.0 };
        Self { range, worth, axis, middle: extent.center()[axis] }
    }
}

/// Sorts `all` into at most so many parts, and returns these: again and again the part that sends most light from the
/// largest box is divided in the middle of that. A part that is no longer than `least_length` stays whole.
pub fn divide<T>(
    all: &mut [T],
    item: impl Fn(&T) -> Item,
    least_length: f64,
    most: usize,
) -> Vec<Range<usize>> {
    if all.is_empty() {
        return Vec::new();
    }
    let mut parts = vec![Candidate::new(all, 0..all.len(), &item, least_length)];
    while parts.len() < most {
        let largest = (0..parts.len()).max_by(|a, b| parts[*a].worth.total_cmp(&parts[*b].worth));
        let Some(at) = largest.filter(|at| parts[*at].worth > 0.0) else { break };
        let Candidate { range, axis, middle, .. } = &parts[at];
        let (range, is_below) = (range.clone(), |each: &T| item(each).place[*axis] < *middle);
        // stable: what a scene is told once it is told again
        all[range.clone()].sort_by_key(|each| !is_below(each));
        let border = range.start + all[range.clone()].partition_point(is_below);
        if border == range.start || border == range.end {
            // they lie apart by no more than a rounding
            parts[at].worth = 0.0;
            continue;
        }
        parts[at] = Candidate::new(all, range.start..border, &item, least_length);
        parts.push(Candidate::new(all, border..range.end, &item, least_length));
    }
    parts.sort_by_key(|part| part.range.start);
    parts.into_iter().map(|part| part.range).collect()
}
