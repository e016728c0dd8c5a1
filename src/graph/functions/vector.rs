//! Blender's Mapping and Vector Rotate nodes.
use super::{divided, named, normalized, rest_of};
use crate::lanes::{F32x8, Mask, Vec3x8};

named! {
    /// A type of Blender's Mapping node.
    Mapping {
        /// Scales, rotates, and then moves.
        Point = "point",
        /// The inverse of `Point`: what moves, rotates and scales a texture. 0 for axes with scale 0.
        Texture = "texture",
        /// Scales and rotates: as `Point` without a location.
        Vector = "vector",
        /// Divides by the scale, rotates, and gives the result length 1. 0 for axes with scale 0.
        Normal = "normal",
    }
}

impl Mapping {
    /// Maps a vector. The rotation is in radians, around x first, then y, then z.
    pub fn apply(self, vector: Vec3x8, location: Vec3x8, rotation: Vec3x8, scale: Vec3x8) -> Vec3x8 {
        let turn = Matrix::euler(rotation);
        match self {
            Self::Point => turn.times(vector * scale) + location,
            Self::Texture => turn.transposed_times(vector - location).each_with(scale, divided),
            Self::Vector => turn.times(vector * scale),
            Self::Normal => normalized(turn.times(vector.each_with(scale, divided))),
        }
        .finite_or_zero()
    }
}

named! {
    /// A type of Blender's Vector Rotate node.
    Rotate {
        /// Around a given axis. Nothing turns around one without a length.
        AxisAngle = "axis_angle",
        /// Around x.
        X = "x_axis",
        /// Around y.
        Y = "y_axis",
        /// Around z.
        Z = "z_axis",
        /// Around x first, then y, then z.
        Euler = "euler_xyz",
    }
}

/// What a Vector Rotate node turns by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// The axis of [`Rotate::AxisAngle`], of any length.
    pub axis: Vec3x8,
    /// The angle in radians, except for [`Rotate::Euler`].
    pub angle: F32x8,
    /// The angles of [`Rotate::Euler`] in radians.
    pub rotation: Vec3x8,
    /// Whether to turn the other way: back, for [`Rotate::Euler`].
    pub invert: bool,
}

impl Rotate {
    /// Turns a point around a center.
    pub fn apply(self, vector: Vec3x8, center: Vec3x8, turn: &Turn) -> Vec3x8 {
        let angle = if turn.invert { -turn.angle } else { turn.angle };
        let from_center = vector - center;
        let [one, zero] = [F32x8::ONE, F32x8::ZERO];
        let around = |axis: [F32x8; 3]| Matrix::around(axis.into(), angle).times(from_center);
        let turned = match self {
            Self::Euler if turn.invert => Matrix::euler(turn.rotation).transposed_times(from_center),
            Self::Euler => Matrix::euler(turn.rotation).times(from_center),
            Self::X => around([one, zero, zero]),
            Self::Y => around([zero, one, zero]),
            Self::Z => around([zero, zero, one]),
            Self::AxisAngle => around((turn.axis / turn.axis.length()).into()),
        };
        let is_left = match self {
            Self::AxisAngle => turn.axis.length().is_zero(),
            _ => Mask::NONE,
        };
        is_left.select3(vector, turned + center).finite_or_zero()
    }
}

/// Matrices, by their columns.
struct Matrix([Vec3x8; 3]);

impl Matrix {
    /// The rotation around x, then y, then z, by angles in radians.
    fn euler(angles: Vec3x8) -> Self {
        let of = |angle: F32x8| (angle.each(f32::sin), angle.each(f32::cos));
        let [(sin_x, cos_x), (sin_y, cos_y), (sin_z, cos_z)] = [of(angles.x), of(angles.y), of(angles.z)];
        // around y and z, the first column of which a turn around x leaves
        let first = [cos_z * cos_y, sin_z * cos_y, -sin_y];
        let second = Vec3x8::from([-sin_z, cos_z, F32x8::ZERO]);
        let third = Vec3x8::from([cos_z * sin_y, sin_z * sin_y, cos_y]);
        Self([first.into(), second * cos_x + third * sin_x, third * cos_x - second * sin_x])
    }

    /// The rotation around an axis of length 1, by Rodrigues' formula.
    fn around(axis: Vec3x8, angle: F32x8) -> Self {
        let (sine, cosine) = (angle.each(f32::sin), angle.each(f32::cos));
        let (side, Vec3x8 { x, y, z }) = (axis * rest_of(cosine), axis * sine);
        let column = |share: F32x8, plus: [F32x8; 3]| axis * share + Vec3x8::from(plus);
        Self([
            column(side.x, [cosine, z, -y]),
            column(side.y, [-z, cosine, x]),
            column(side.z, [y, -x, cosine]),
        ])
    }

    fn times(&self, vector: Vec3x8) -> Vec3x8 {
        let Self([first, second, third]) = *self;
        first * vector.x + second * vector.y + third * vector.z
    }

    fn transposed_times(&self, vector: Vec3x8) -> Vec3x8 {
        self.0.map(|column| column.dot(vector)).into()
    }
}
