//! Blender's nodes of curves: RGB Curves, Vector Curves, and Float Curve.
//!
//! Cycles samples a curve at 257 places from its first point to its last, and draws straight lines between the samples. So do we:
//! a curve comes as its samples, which Blender's `CurveMapping.evaluate` makes. The four curves of an RGB node come as three, where
//! the combined one is applied first: red at x is `evaluate(red, evaluate(combined, x))`.
use super::{finite, mix};
use crate::lanes::{F32x8, Vec3x8};

/// How many samples Cycles takes of a curve, and of a colour ramp.
pub const SAMPLES: usize = 257;

/// A curve as samples at equal distances.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Where the first sample is: the smallest place of a point, of all curves of the node.
    pub from: f32,
    /// Where the last sample is: the largest place of a point, of all curves of the node.
    pub to: f32,
    /// The samples, from the first place to the last, both included. Cycles has [`SAMPLES`]; none make a curve of 0.
    pub values: Vec<f32>,
    /// Whether the curve goes on beyond its ends, along its first and last line; otherwise it is level there.
    pub extrapolate: bool,
}

impl Table {
    /// The curve at places.
    pub fn values(&self, at: F32x8) -> F32x8 {
        at.each(|at| self.value(at))
    }

    /// The curve at a place.
    pub fn value(&self, at: f32) -> f32 {
        let [first, .., last] = self.values[..] else {
            return finite(self.values.first().copied().unwrap_or(0.0));
        };
        let lines = (self.values.len() - 1) as f32;
        let along = finite((at - self.from) / (self.to - self.from));
        let place = along.clamp(0.0, 1.0) * lines;
        // The last sample is the end of the last line, and the first of none.
        let line = (place as usize).min(self.values.len() - 2);
        let [start, end] = [self.values[line], self.values[line + 1]];
        let beyond = if along < 0.0 { along } else { along - 1.0 };
        let share = place - line as f32;
        finite(match self.extrapolate && !(0.0..=1.0).contains(&along) {
            true => (if along < 0.0 { first } else { last }) + (end - start) * (beyond * lines),
            false => (1.0 - share) * start + share * end,
        })
    }
}

/// Blender's Float Curve node: the value on the curve, mixed with the value itself by a factor.
pub fn float(factor: F32x8, value: F32x8, curve: &Table) -> F32x8 {
    mix::float(factor, value, curve.values(value))
}

/// Blender's RGB Curves and Vector Curves nodes: each channel on its curve, mixed with the channel itself by a factor.
pub fn channels(factor: F32x8, value: Vec3x8, [red, green, blue]: &[Table; 3]) -> Vec3x8 {
    let curved = [red.values(value.x), green.values(value.y), blue.values(value.z)];
    mix::vector(factor, value, curved.into())
}
