//! Blender's Map Range and Clamp nodes.
use super::{divided, named};
use crate::lanes::{F32x8, Vec3x8};

named! {
    /// How Blender's Map Range node gets from one end of a range to the other.
    Progress {
        /// In a straight line.
        Linear = "linear",
        /// In steps of equal heights.
        Stepped = "stepped",
        /// By `3 t^2 - 2 t^3`, clamped to the range.
        Smoothstep = "smoothstep",
        /// By `6 t^5 - 15 t^4 + 10 t^3`, clamped to the range.
        Smootherstep = "smootherstep",
    }
}

named! {
    /// A type of Blender's Clamp node.
    Clamp {
        /// At least the minimum, then at most the maximum: the maximum, where it is below the minimum.
        MinMax = "minmax",
        /// Between both, whichever is the larger one.
        Range = "range",
    }
}

impl Clamp {
    /// The value, clamped.
    pub fn apply(self, value: F32x8, minimum: F32x8, maximum: F32x8) -> F32x8 {
        let clamped = value.max(minimum).min(maximum);
        match self {
            Self::Range => minimum.gt(maximum).select(value.max(maximum).min(minimum), clamped),
            Self::MinMax => clamped,
        }
    }
}

/// The ranges of a Map Range node, of numbers or vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges<T> {
    /// The ends of the range that values come from: Blender's From Min, From Max.
    pub from: [T; 2],
    /// The ends of the range that they are mapped to: Blender's To Min, To Max.
    pub to: [T; 2],
    /// The number of steps, for [`Progress::Stepped`]. What is not positive gives the first end.
    pub steps: T,
}

impl Ranges<F32x8> {
    /// Maps a number, as Blender's node with type Float does. `clamp` keeps the result in the range `to`.
    pub fn map(&self, progress: Progress, clamp: bool, value: F32x8) -> F32x8 {
        let [first, last] = self.from;
        // A range without width gives 0, whatever it is mapped to. It is clamped then.
        let mapped = first.equals(last).select(F32x8::ZERO, mapped(self, progress, value));
        if clamp { Clamp::Range.apply(mapped, self.to[0], self.to[1]) } else { mapped }
    }
}

impl Ranges<Vec3x8> {
    /// Maps each component, as Blender's node with type Vector does. `clamp` keeps the result in the range `to`.
    pub fn map(&self, progress: Progress, clamp: bool, value: Vec3x8) -> Vec3x8 {
        let axis = |of: fn(&Vec3x8) -> F32x8| {
            let ranges = Ranges {
                from: self.from.map(|end| of(&end)),
                to: self.to.map(|end| of(&end)),
                steps: of(&self.steps),
            };
            // A range without width gives the first end here, unlike that of a number.
            let mapped = mapped(&ranges, progress, of(&value));
            if clamp { Clamp::Range.apply(mapped, ranges.to[0], ranges.to[1]) } else { mapped }
        };
        Vec3x8::from([axis(|vector| vector.x), axis(|vector| vector.y), axis(|vector| vector.z)])
    }
}

/// A number, mapped and not clamped.
fn mapped(ranges: &Ranges<F32x8>, progress: Progress, value: F32x8) -> F32x8 {
    let ([first, last], [start, end]) = (ranges.from, ranges.to);
    let straight = divided(value - first, last - first);
    let factor = match progress {
        Progress::Linear => straight,
        Progress::Stepped => {
            let stepped = (straight * (ranges.steps + 1.0)).floor() / ranges.steps;
            ranges.steps.gt(F32x8::ZERO).select(stepped, F32x8::ZERO)
        }
        Progress::Smoothstep => smoothstep(straight),
        Progress::Smootherstep => smootherstep(straight),
    };
    (start + factor * (end - start)).finite_or_zero()
}

/// `3 t^2 - 2 t^3`, clamped to 0 to 1.
pub fn smoothstep(t: F32x8) -> F32x8 {
    let t = t.finite_or_zero().clamp(0.0, 1.0);
    (F32x8::splat(3.0) - t * 2.0) * (t * t)
}

/// `6 t^5 - 15 t^4 + 10 t^3`, clamped to 0 to 1.
pub fn smootherstep(t: F32x8) -> F32x8 {
    let t = t.finite_or_zero().clamp(0.0, 1.0);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}
