//! How far along its curve a place lies, as a share of the curve's length.

use glam::Vec3;

use super::{Curves, Points};

/// Most pieces of a curve whose lengths are summed whenever they are asked for: those of a hair need no memory.
const MOST_SUMMED: usize = 64;

/// Points between two whose way from the first point is kept, where curves are longer: an eighth of a byte for each.
const STEP: usize = 64;

impl Points {
    /// Length of the piece from a point to the next one.
    fn length(&self, first: usize) -> f32 {
        let [a, b] = [first, first + 1].map(|at| Vec3::from_slice(&self.all[at]));
        a.distance(b)
    }

    /// Length of the way from the first of all points to this one, through those between them, whatever curve they are of.
    fn way_to(&self, point: usize) -> f64 {
        let length = |first: usize| f64::from(self.length(first));
        let ways = self.ways.get_or_init(|| {
            let steps = (0..self.all.len() - 1).step_by(STEP);
            let ends = steps.map(|first| (first, (first + STEP).min(self.all.len() - 1)));
            let mut way = 0.0;
            let behind = ends.map(|(first, end)| {
                way += (first..end).map(length).sum::<f64>();
                way
            });
            [0.0].into_iter().chain(behind).collect()
        });
        let step = point / STEP;
        ways[step] + (step * STEP..point).map(length).sum::<f64>()
    }
}

impl Curves {
    /// Share of its curve's length at which a place lies, from 0 to 1.
    pub(super) fn share(&self, primitive: u32, weight: f32) -> f32 {
        let (number, firsts) = (self.number(primitive), &self.chains.firsts);
        let curve = self.curve_of(number);
        let begin = self.chains.curves[curve] as usize;
        let end = self.chains.curves.get(curve + 1).map_or(firsts.len(), |next| *next as usize);
        let weight = weight.clamp(0.0, 1.0);
        // the points of a curve follow each other
        let [from, at, to] = [begin, number, end - 1].map(|number| firsts[number] as usize);
        if end - begin > MOST_SUMMED {
            let [from, before, to] = [from, at, to + 1].map(|point| self.own.way_to(point));
            let within = f64::from(self.own.length(at)) * f64::from(weight);
            return ((before - from + within) / (to - from)) as f32;
        }
        let before: f32 = (from..at).map(|first| self.own.length(first)).sum();
        let all = before + (at..=to).map(|first| self.own.length(first)).sum::<f32>();
        (before + self.own.length(at) * weight) / all
    }
}
