//! The operations of Blender's Math node.
use super::{divided, fraction, named, power, sign};
use crate::lanes::{F32x8, Mask};
use std::f32::consts::PI;

named! {
    /// An operation of Blender's Math node. `a`, `b`, `c` are its inputs from the top.
    Math {
        /// `a + b`.
        Add = "add",
        /// `a - b`.
        Subtract = "subtract",
        /// `a * b`.
        Multiply = "multiply",
        /// `a / b`; 0 where `b` is 0.
        Divide = "divide",
        /// `a * b + c`.
        MultiplyAdd = "multiply_add",
        /// `a` to the power of `b`; 0 for a negative `a` and a `b` that is no whole number.
        Power = "power",
        /// The logarithm of `a` to the base `b`; 0 where one of them is not positive, or `b` is 1.
        Logarithm = "logarithm",
        /// The square root; 0 for negative numbers.
        Sqrt = "sqrt",
        /// 1 / the square root; 0 for what is not positive.
        InverseSqrt = "inverse_sqrt",
        /// The number without its sign.
        Absolute = "absolute",
        /// e to the power of `a`; 0 above 88.7, where it exceeds the range of `f32`.
        Exponent = "exponent",
        /// The smaller one of `a` and `b`.
        Minimum = "minimum",
        /// The larger one of `a` and `b`.
        Maximum = "maximum",
        /// 1 where `a < b`, otherwise 0.
        LessThan = "less_than",
        /// 1 where `a > b`, otherwise 0.
        GreaterThan = "greater_than",
        /// -1, 0 or 1.
        Sign = "sign",
        /// 1 where `a` and `b` differ by `c` or less, otherwise 0.
        Compare = "compare",
        /// The smaller one of `a` and `b`, with a transition of width `c`, by a cubic polynomial.
        SmoothMin = "smooth_min",
        /// The larger one of `a` and `b`, with a transition of width `c`, by a cubic polynomial.
        SmoothMax = "smooth_max",
        /// The nearest whole number; halves are rounded up.
        Round = "round",
        /// The largest whole number that is not above `a`.
        Floor = "floor",
        /// The smallest whole number that is not below `a`.
        Ceil = "ceil",
        /// The whole part, towards 0.
        Truncate = "trunc",
        /// What `a` exceeds the whole number below it by: 0 to 1, also for negative numbers.
        Fraction = "fract",
        /// The rest of the division, with the sign of `a`; 0 where `b` is 0.
        Modulo = "modulo",
        /// The rest of the division, with the sign of `b`; 0 where `b` is 0.
        FlooredModulo = "floored_modulo",
        /// `a`, repeated in the range from `c` to `b`; `c` where the range is empty.
        Wrap = "wrap",
        /// The multiple of `b` below `a`; 0 where `b` is 0.
        Snap = "snap",
        /// `a`, mirrored in the range from 0 to `b`; 0 where `b` is 0.
        PingPong = "pingpong",
        /// The sine of radians.
        Sine = "sine",
        /// The cosine of radians.
        Cosine = "cosine",
        /// The tangent of radians.
        Tangent = "tangent",
        /// The angle with this sine, in radians, of a number that is clamped to -1 to 1.
        Arcsine = "arcsine",
        /// The angle with this cosine, in radians, of a number that is clamped to -1 to 1.
        Arccosine = "arccosine",
        /// The angle with this tangent, in radians.
        Arctangent = "arctangent",
        /// The angle of the point with y = `a`, x = `b`, in radians; 0 for the origin.
        Arctangent2 = "arctan2",
        /// The hyperbolic sine; 0 where it exceeds the range of `f32`.
        HyperbolicSine = "sinh",
        /// The hyperbolic cosine; 0 where it exceeds the range of `f32`.
        HyperbolicCosine = "cosh",
        /// The hyperbolic tangent.
        HyperbolicTangent = "tanh",
        /// Degrees to radians.
        Radians = "radians",
        /// Radians to degrees.
        Degrees = "degrees",
    }
}

impl Math {
    /// The result. What the operation does not use (see [`inputs`](Self::inputs)) may be anything. A result that is infinite or NaN
    /// is 0. Blender's option to clamp is the caller's: a result to 0 to 1.
    pub fn apply(self, a: F32x8, b: F32x8, c: F32x8) -> F32x8 {
        match self.inputs() {
            1 => self.of_one(a),
            2 => self.of_two(a, b),
            _ => self.of_three(a, b, c),
        }
        .finite_or_zero()
    }

    /// How many inputs the operation uses: 1 to 3, from the top.
    pub fn inputs(self) -> usize {
        use Math::*;
        match self {
            MultiplyAdd | Compare | SmoothMin | SmoothMax | Wrap => 3,
            Add | Subtract | Multiply | Divide | Power | Logarithm | Minimum | Maximum | LessThan
            | GreaterThan | Modulo | FlooredModulo | Snap | PingPong | Arctangent2 => 2,
            _ => 1,
        }
    }

    fn of_one(self, a: F32x8) -> F32x8 {
        match self {
            Self::Sqrt => a.max(F32x8::ZERO).sqrt(),
            Self::InverseSqrt => a.gt(F32x8::ZERO).select(F32x8::ONE / a.sqrt(), F32x8::ZERO),
            Self::Absolute => a.abs(),
            Self::Exponent => a.each(f32::exp),
            Self::Sign => sign(a),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Truncate => a.truncated(),
            Self::Fraction => fraction(a),
            Self::Radians => a * (PI / 180.0),
            Self::Degrees => a * (180.0 / PI),
            _ => a.each(|a| self.of_angle(a)),
        }
    }

    fn of_angle(self, a: f32) -> f32 {
        match self {
            Self::Sine => a.sin(),
            Self::Cosine => a.cos(),
            Self::Tangent => a.tan(),
            Self::Arcsine => a.clamp(-1.0, 1.0).asin(),
            Self::Arccosine => a.clamp(-1.0, 1.0).acos(),
            Self::Arctangent => a.atan(),
            Self::HyperbolicSine => a.sinh(),
            Self::HyperbolicCosine => a.cosh(),
            Self::HyperbolicTangent => a.tanh(),
            _ => 0.0,
        }
    }

    fn of_two(self, a: F32x8, b: F32x8) -> F32x8 {
        // what divides by zero has no value
        let unless_zero = |value: F32x8| b.is_zero().select(F32x8::ZERO, value);
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::Power => power(a, b),
            Self::Logarithm => logarithm(a, b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::LessThan => truth(a.lt(b)),
            Self::GreaterThan => truth(a.gt(b)),
            Self::Modulo => unless_zero(a.each_with(b, |a, b| a % b)),
            Self::FlooredModulo => unless_zero(a - (a / b).floor() * b),
            Self::Snap => divided(a, b).floor() * b,
            Self::PingPong => unless_zero((fraction((a - b) / (b * 2.0)) * b * 2.0 - b).abs()),
            // The angle of the origin differs between platforms, and for a zero with a sign.
            Self::Arctangent2 => (a.is_zero() & b.is_zero()).select(F32x8::ZERO, a.each_with(b, f32::atan2)),
            _ => F32x8::ZERO,
        }
    }

    fn of_three(self, a: F32x8, b: F32x8, c: F32x8) -> F32x8 {
        match self {
            Self::MultiplyAdd => a * b + c,
            Self::Compare => truth(a.equals(b) | (a - b).abs().le(c.max(F32x8::splat(f32::EPSILON)))),
            Self::SmoothMin => smooth_minimum(a, b, c),
            Self::SmoothMax => -smooth_minimum(-a, -b, c),
            Self::Wrap => wrap(a, b, c),
            _ => F32x8::ZERO,
        }
    }
}

/// 1 where it is true, otherwise 0.
fn truth(mask: Mask) -> F32x8 {
    mask.select(F32x8::ONE, F32x8::ZERO)
}

fn logarithm(a: F32x8, base: F32x8) -> F32x8 {
    let has_one = a.gt(F32x8::ZERO) & base.gt(F32x8::ZERO);
    has_one.select(divided(a.each(f32::ln), base.each(f32::ln)), F32x8::ZERO)
}

/// A number, repeated in a range; the range's minimum where it is empty.
fn wrap(value: F32x8, maximum: F32x8, minimum: F32x8) -> F32x8 {
    let range = maximum - minimum;
    range.is_zero().select(minimum, value - range * ((value - minimum) / range).floor())
}

/// The smaller number, less what rounds the edge where both are equal.
fn smooth_minimum(a: F32x8, b: F32x8, width: F32x8) -> F32x8 {
    let sharp = a.min(b);
    let near = (width - (a - b).abs()).max(F32x8::ZERO) / width;
    width.is_zero().select(sharp, sharp - near * near * near * width / 6.0)
}
