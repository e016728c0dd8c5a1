//! Blender's Mapping and Vector Rotate nodes.
use super::{divided, each2, finite_vector, named, normalized};
use glam::{Mat3, Vec3};

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
    pub fn apply(self, vector: Vec3, location: Vec3, rotation: Vec3, scale: Vec3) -> Vec3 {
        let turn = euler(rotation);
        finite_vector(match self {
            Self::Point => turn * (vector * scale) + location,
            Self::Texture => each2(turn.transpose() * (vector - location), scale, divided),
            Self::Vector => turn * (vector * scale),
            Self::Normal => normalized(turn * each2(vector, scale, divided)),
        })
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
    pub axis: Vec3,
    /// The angle in radians, except for [`Rotate::Euler`].
    pub angle: f32,
    /// The angles of [`Rotate::Euler`] in radians.
    pub rotation: Vec3,
    /// Whether to turn the other way: back, for [`Rotate::Euler`].
    pub invert: bool,
}

impl Rotate {
    /// Turns a point around a center.
    pub fn apply(self, vector: Vec3, center: Vec3, turn: &Turn) -> Vec3 {
        let angle = if turn.invert { -turn.angle } else { turn.angle };
        let matrix = match self {
            Self::Euler if turn.invert => euler(turn.rotation).transpose(),
            Self::Euler => euler(turn.rotation),
            Self::X => around(Vec3::X, angle),
            Self::Y => around(Vec3::Y, angle),
            Self::Z => around(Vec3::Z, angle),
            Self::AxisAngle if turn.axis.length() == 0.0 => return finite_vector(vector),
            Self::AxisAngle => around(turn.axis / turn.axis.length(), angle),
        };
        finite_vector(matrix * (vector - center) + center)
    }
}

/// The rotation around x, then y, then z, by angles in radians.
fn euler(angles: Vec3) -> Mat3 {
    Mat3::from_rotation_z(angles.z) * Mat3::from_rotation_y(angles.y) * Mat3::from_rotation_x(angles.x)
}

/// The rotation around an axis of length 1, by Rodrigues' formula.
fn around(axis: Vec3, angle: f32) -> Mat3 {
    let (sine, cosine) = angle.sin_cos();
    let (side, Vec3 { x, y, z }) = (axis * (1.0 - cosine), axis * sine);
    Mat3::from_cols(
        axis * side.x + Vec3::new(cosine, z, -y),
        axis * side.y + Vec3::new(-z, cosine, x),
        axis * side.z + Vec3::new(y, -x, cosine),
    )
}
