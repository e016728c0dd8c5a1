//! Blender's Map Range and Clamp nodes.
use super::{divided, finite, named};
use glam::Vec3;

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
    pub fn apply(self, value: f32, minimum: f32, maximum: f32) -> f32 {
        match self {
            Self::Range if minimum > maximum => value.max(maximum).min(minimum),
            _ => value.max(minimum).min(maximum),
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

impl Ranges<f32> {
    /// Maps a number, as Blender's node with type Float does. `clamp` keeps the result in the range `to`.
    pub fn map(&self, progress: Progress, clamp: bool, value: f32) -> f32 {
        let [first, last] = self.from;
        // A range without width gives 0, whatever it is mapped to. It is clamped then.
        let mapped = if first == last { 0.0 } else { mapped(self, progress, value) };
        if clamp { Clamp::Range.apply(mapped, self.to[0], self.to[1]) } else { mapped }
    }
}

impl Ranges<Vec3> {
    /// Maps each component, as Blender's node with type Vector does. `clamp` keeps the result in the range `to`.
    pub fn map(&self, progress: Progress, clamp: bool, value: Vec3) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|axis| {
            let ranges = Ranges {
                from: self.from.map(|end| end[axis]),
                to: self.to.map(|end| end[axis]),
                steps: self.steps[axis],
            };
            // A range without width gives the first end here, unlike that of a number.
            let mapped = mapped(&ranges, progress, value[axis]);
            if clamp { Clamp::Range.apply(mapped, ranges.to[0], ranges.to[1]) } else { mapped }
        }))
    }
}

/// A number, mapped and not clamped.
fn mapped(ranges: &Ranges<f32>, progress: Progress, value: f32) -> f32 {
    let ([first, last], [start, end]) = (ranges.from, ranges.to);
    let straight = divided(value - first, last - first);
    let factor = match progress {
        Progress::Linear => straight,
        Progress::Stepped if ranges.steps > 0.0 => (straight * (ranges.steps + 1.0)).floor() / ranges.steps,
        Progress::Stepped => 0.0,
        Progress::Smoothstep => smoothstep(straight),
        Progress::Smootherstep => smootherstep(straight),
    };
    finite(start + factor * (end - start))
}

/// `3 t^2 - 2 t^3`, clamped to 0 to 1.
pub fn smoothstep(t: f32) -> f32 {
    let t = finite(t).clamp(0.0, 1.0);
    (3.0 - 2.0 * t) * (t * t)
}

/// `6 t^5 - 15 t^4 + 10 t^3`, clamped to 0 to 1.
pub fn smootherstep(t: f32) -> f32 {
    let t = finite(t).clamp(0.0, 1.0);
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}
