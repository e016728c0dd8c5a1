//! The operations of Blender's Math node.
use super::{divided, finite, named, power, sign};
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
    pub fn apply(self, a: f32, b: f32, c: f32) -> f32 {
        finite(match self.inputs() {
            1 => self.of_one(a),
            2 => self.of_two(a, b),
            _ => self.of_three(a, b, c),
        })
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

    fn of_one(self, a: f32) -> f32 {
        match self {
            Self::Sqrt => a.max(0.0).sqrt(),
            Self::InverseSqrt if a > 0.0 => 1.0 / a.sqrt(),
            Self::Absolute => a.abs(),
            Self::Exponent => a.exp(),
            Self::Sign => sign(a),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Truncate => a.trunc(),
            Self::Fraction => fraction(a),
            Self::Radians => a * (PI / 180.0),
            Self::Degrees => a * (180.0 / PI),
            _ => self.of_angle(a),
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

    fn of_two(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::Power => power(a, b),
            Self::Logarithm if a > 0.0 && b > 0.0 => divided(a.ln(), b.ln()),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::LessThan => f32::from(a < b),
            Self::GreaterThan => f32::from(a > b),
            Self::Modulo if b != 0.0 => a % b,
            Self::FlooredModulo if b != 0.0 => a - (a / b).floor() * b,
            Self::Snap => divided(a, b).floor() * b,
            Self::PingPong if b != 0.0 => (fraction((a - b) / (b * 2.0)) * b * 2.0 - b).abs(),
            // The angle of the origin differs between platforms, and for a zero with a sign.
            Self::Arctangent2 if a != 0.0 || b != 0.0 => a.atan2(b),
            _ => 0.0,
        }
    }

    fn of_three(self, a: f32, b: f32, c: f32) -> f32 {
        match self {
            Self::MultiplyAdd => a * b + c,
            Self::Compare => f32::from(a == b || (a - b).abs() <= c.max(f32::EPSILON)),
            Self::SmoothMin => smooth_minimum(a, b, c),
            Self::SmoothMax => -smooth_minimum(-a, -b, c),
            Self::Wrap => wrap(a, b, c),
            _ => 0.0,
        }
    }
}

/// What a number exceeds the whole number below it by.
pub(super) fn fraction(value: f32) -> f32 {
    value - value.floor()
}

/// A number, repeated in a range; the range's minimum where it is empty.
fn wrap(value: f32, maximum: f32, minimum: f32) -> f32 {
    let range = maximum - minimum;
    if range == 0.0 { minimum } else { value - range * ((value - minimum) / range).floor() }
}

/// The smaller number, less what rounds the edge where both are equal.
fn smooth_minimum(a: f32, b: f32, width: f32) -> f32 {
    let sharp = a.min(b);
    if width == 0.0 {
        return sharp;
    }
    let near = (width - (a - b).abs()).max(0.0) / width;
    sharp - near * near * near * width / 6.0
}
