//! The operations of Blender's Vector Math node.
use super::{divided, fraction, named, normalized, power, sign};
use crate::lanes::{F32x8, Vec3x8};

named! {
    /// An operation of Blender's Vector Math node. `a`, `b`, `c` are its vectors from the top, `scale` its number. Those without
    /// further words are as those of [`Math`](super::math::Math), for each component.
    VectorMath {
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
        /// The cross product.
        CrossProduct = "cross_product",
        /// `a` projected onto the direction of `b`; 0 where `b` is 0.
        Project = "project",
        /// `a` mirrored at the plane with normal `b`.
        Reflect = "reflect",
        /// `a` refracted at the plane with normal `b`, where `scale` is the ratio of the indices; 0 for total reflection.
        Refract = "refract",
        /// `a`, turned round where the directions of `b` and `c` agree.
        Faceforward = "faceforward",
        /// The dot product: a value.
        DotProduct = "dot_product",
        /// The distance between the points `a` and `b`: a value.
        Distance = "distance",
        /// The length of `a`: a value.
        Length = "length",
        /// `a * scale`.
        Scale = "scale",
        /// `a` at length 1; 0 where it is 0.
        Normalize = "normalize",
        /// Without signs.
        Absolute = "absolute",
        /// `a` to the power of `b`.
        Power = "power",
        /// -1, 0 or 1.
        Sign = "sign",
        /// The smaller ones.
        Minimum = "minimum",
        /// The larger ones.
        Maximum = "maximum",
        /// The nearest whole numbers. Blender has it since 5.1.
        Round = "round",
        /// The whole numbers below.
        Floor = "floor",
        /// The whole numbers above.
        Ceil = "ceil",
        /// What exceeds the whole numbers below.
        Fraction = "fraction",
        /// The rest of the division, with the sign of `a`.
        Modulo = "modulo",
        /// `a`, repeated in the range from `c` to `b`; `c` where the range is empty.
        Wrap = "wrap",
        /// The multiple of `b` below `a`.
        Snap = "snap",
        /// The sine of radians.
        Sine = "sine",
        /// The cosine of radians.
        Cosine = "cosine",
        /// The tangent of radians.
        Tangent = "tangent",
    }
}

impl VectorMath {
    /// Whether the result is a number, of [`value`](Self::value), instead of a vector.
    pub fn gives_value(self) -> bool {
        matches!(self, Self::DotProduct | Self::Distance | Self::Length)
    }

    /// How many vectors the operation uses: 1 to 3, from the top.
    pub fn inputs(self) -> usize {
        use VectorMath::*;
        match self {
            MultiplyAdd | Faceforward | Wrap => 3,
            Add | Subtract | Multiply | Divide | CrossProduct | Project | Reflect | Refract | DotProduct
            | Distance | Power | Minimum | Maximum | Modulo | Snap => 2,
            _ => 1,
        }
    }

    /// Whether the operation uses `scale`.
    pub fn has_scale(self) -> bool {
        matches!(self, Self::Scale | Self::Refract)
    }

    /// The result of an operation that gives a number; 0 for the others.
    pub fn value(self, a: Vec3x8, b: Vec3x8) -> F32x8 {
        match self {
            Self::DotProduct => a.dot(b),
            Self::Distance => (a - b).length(),
            Self::Length => a.length(),
            _ => F32x8::ZERO,
        }
        .finite_or_zero()
    }

    /// The result of an operation that gives a vector; 0 for the others. What the operation does not use may be anything.
    pub fn vector(self, a: Vec3x8, b: Vec3x8, c: Vec3x8, scale: F32x8) -> Vec3x8 {
        match self {
            Self::CrossProduct => a.cross(b),
            Self::Project => project(a, b),
            Self::Reflect => reflect(a, normalized(b)),
            Self::Refract => refract(a, normalized(b), scale),
            Self::Faceforward => c.dot(b).lt(F32x8::ZERO).select3(a, -a),
            Self::Scale => a * scale,
            Self::Normalize => normalized(a),
            Self::MultiplyAdd => a * b + c,
            Self::Wrap => Vec3x8::from([wrap(a.x, b.x, c.x), wrap(a.y, b.y, c.y), wrap(a.z, b.z, c.z)]),
            _ if self.inputs() == 2 => a.each_with(b, |a, b| self.of_two(a, b)),
            _ => a.each(|a| self.of_one(a)),
        }
        .finite_or_zero()
    }

    fn of_two(self, a: F32x8, b: F32x8) -> F32x8 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::Power => power(a, b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Modulo => b.is_zero().select(F32x8::ZERO, a - (a / b).truncated() * b),
            Self::Snap => divided(a, b).floor() * b,
            _ => F32x8::ZERO,
        }
    }

    fn of_one(self, a: F32x8) -> F32x8 {
        match self {
            Self::Absolute => a.abs(),
            Self::Sign => sign(a),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Fraction => fraction(a),
            Self::Sine => a.each(f32::sin),
            Self::Cosine => a.each(f32::cos),
            Self::Tangent => a.each(f32::tan),
            _ => F32x8::ZERO,
        }
    }
}

/// A number, repeated in a range; the range's minimum where it is empty.
fn wrap(value: F32x8, maximum: F32x8, minimum: F32x8) -> F32x8 {
    let (above, range) = (value - minimum, maximum - minimum);
    range.is_zero().select(minimum, above - (above / range).floor() * range + minimum)
}

fn project(vector: Vec3x8, onto: Vec3x8) -> Vec3x8 {
    onto * divided(vector.dot(onto), onto.dot(onto))
}

fn reflect(vector: Vec3x8, normal: Vec3x8) -> Vec3x8 {
    vector - normal * (vector.dot(normal) * 2.0)
}

/// A direction after a surface, by Snell's law, with the ratio of the refractive indices; 0 where all light is reflected.
fn refract(vector: Vec3x8, normal: Vec3x8, ratio: F32x8) -> Vec3x8 {
    let cosine = normal.dot(vector);
    let squared = F32x8::ONE - ratio * ratio * (F32x8::ONE - cosine * cosine);
    let through = vector * ratio - normal * (ratio * cosine + squared.sqrt());
    squared.lt(F32x8::ZERO).select3(Vec3x8::ZERO, through)
}
