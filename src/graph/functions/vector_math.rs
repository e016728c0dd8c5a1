//! The operations of Blender's Vector Math node.
use super::math::fraction;
use super::{divided, each, each2, each3, finite, finite_vector, named, normalized, power, sign};
use glam::Vec3;

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
    pub fn value(self, a: Vec3, b: Vec3) -> f32 {
        finite(match self {
            Self::DotProduct => a.dot(b),
            Self::Distance => a.distance(b),
            Self::Length => a.length(),
            _ => 0.0,
        })
    }

    /// The result of an operation that gives a vector; 0 for the others. What the operation does not use may be anything.
    pub fn vector(self, a: Vec3, b: Vec3, c: Vec3, scale: f32) -> Vec3 {
        finite_vector(match self {
            Self::CrossProduct => a.cross(b),
            Self::Project => project(a, b),
            Self::Reflect => reflect(a, normalized(b)),
            Self::Refract => refract(a, normalized(b), scale),
            Self::Faceforward if c.dot(b) < 0.0 => a,
            Self::Faceforward => -a,
            Self::Scale => a * scale,
            Self::Normalize => normalized(a),
            Self::MultiplyAdd => a * b + c,
            Self::Wrap => each3(a, b, c, wrap),
            _ if self.inputs() == 2 => each2(a, b, |a, b| self.of_two(a, b)),
            _ => each(a, |a| self.of_one(a)),
        })
    }

    fn of_two(self, a: f32, b: f32) -> f32 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => divided(a, b),
            Self::Power => power(a, b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Modulo if b != 0.0 => a - (a / b).trunc() * b,
            Self::Snap => divided(a, b).floor() * b,
            _ => 0.0,
        }
    }

    fn of_one(self, a: f32) -> f32 {
        match self {
            Self::Absolute => a.abs(),
            Self::Sign => sign(a),
            Self::Round => (a + 0.5).floor(),
            Self::Floor => a.floor(),
            Self::Ceil => a.ceil(),
            Self::Fraction => fraction(a),
            Self::Sine => a.sin(),
            Self::Cosine => a.cos(),
            Self::Tangent => a.tan(),
            _ => 0.0,
        }
    }
}

/// A number, repeated in a range; the range's minimum where it is empty.
fn wrap(value: f32, maximum: f32, minimum: f32) -> f32 {
    let (above, range) = (value - minimum, maximum - minimum);
    if range == 0.0 { minimum } else { above - (above / range).floor() * range + minimum }
}

fn project(vector: Vec3, onto: Vec3) -> Vec3 {
    onto * divided(vector.dot(onto), onto.length_squared())
}

fn reflect(vector: Vec3, normal: Vec3) -> Vec3 {
    vector - normal * (2.0 * vector.dot(normal))
}

/// A direction after a surface, by Snell's law, with the ratio of the refractive indices; 0 where all light is reflected.
fn refract(vector: Vec3, normal: Vec3, ratio: f32) -> Vec3 {
    let cosine = normal.dot(vector);
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if squared < 0.0 { Vec3::ZERO } else { vector * ratio - normal * (ratio * cosine + squared.sqrt()) }
}
