//! Where a model stands: scale, then rotation, then translation.

use glam::{Affine3A, DAffine3, DMat3, DQuat, DVec3, EulerRot, Mat3A, Vec3, Vec3A};

use super::Track;

/// Keyed scale, rotation and translation of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct TransformTrack {
    /// World units.
    pub translate: Track<DVec3>,
    /// Degrees about X, then Y, then Z (fixed axes). Each angle is interpolated by itself, so that a
    /// key of 720 turns twice.
    pub rotate: Track<DVec3>,
    /// Factor along each axis of the object, none zero.
    pub scale: Track<DVec3>,
}

impl TransformTrack {
    /// Stays where the file puts it.
    pub fn identity() -> Self {
        Self {
            translate: Track::constant(DVec3::ZERO),
            rotate: Track::constant(DVec3::ZERO),
            scale: Track::constant(DVec3::ONE),
        }
    }

    /// Object to world at `frame`.
    pub fn at(&self, frame: f64) -> Transform {
        Transform::new(self.map_at(frame))
    }

    /// Object to world at `frame`, exactly.
    pub fn map_at(&self, frame: f64) -> DAffine3 {
        let angles = self.rotate.at(frame) * (std::f64::consts::PI / 180.0);
        // intrinsic Z-Y-X is extrinsic X-Y-Z: about X first, then Y, then Z, all fixed axes
        let rotation = DQuat::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x);
        DAffine3::from_scale_rotation_translation(self.scale.at(frame), rotation, self.translate.at(frame))
    }

    /// The frames of all keys.
    pub fn key_frames(&self) -> Vec<f64> {
        self.translate.frames().chain(self.rotate.frames()).chain(self.scale.frames()).collect()
    }

    /// Whether the model stands still for the whole shot.
    pub fn is_constant(&self) -> bool {
        self.translate.is_constant() && self.rotate.is_constant() && self.scale.is_constant()
    }
}

/// An affine map between object and world space, computed in f64, applied in f32: the same floats for
/// Embree's instances and for reprojection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform {
    /// Object to world.
    pub to_world: Affine3A,
    /// Inverse transpose of the linear part: takes normals to world space (not to unit length).
    pub normal: Mat3A,
    /// World to object.
    pub to_object: Affine3A,
    /// Whether nothing changes: most of most scenes stands where its file put it.
    pub is_identity: bool,
}

impl Transform {
    /// Nothing changes.
    pub const IDENTITY: Self = Self {
        to_world: Affine3A::IDENTITY,
        normal: Mat3A::IDENTITY,
        to_object: Affine3A::IDENTITY,
        is_identity: true,
    };

    /// From an exact map; it must have an inverse.
    pub fn new(map: DAffine3) -> Self {
        let inverse = map.inverse();
        let normal: DMat3 = inverse.matrix3.transpose();
        Self {
            to_world: affine(map),
            normal: Mat3A::from_cols(
                normal.x_axis.as_vec3a(),
                normal.y_axis.as_vec3a(),
                normal.z_axis.as_vec3a(),
            ),
            to_object: affine(inverse),
            is_identity: map == DAffine3::IDENTITY,
        }
    }

    /// A point, object to world.
    #[inline]
    pub fn point(&self, point: Vec3) -> Vec3 {
        if self.is_identity {
            return point;
        }
        self.to_world.transform_point3(point)
    }

    /// A direction, object to world, of any length.
    #[inline]
    pub fn direction(&self, direction: Vec3) -> Vec3 {
        if self.is_identity {
            return direction;
        }
        self.to_world.transform_vector3(direction)
    }

    /// A normal of unit length, object to world, of unit length.
    #[inline]
    pub fn normal(&self, normal: Vec3) -> Vec3 {
        if self.is_identity {
            return normal;
        }
        (self.normal * Vec3A::from(normal)).normalize_or_zero().into()
    }

    /// A normal, object to world, of any length: for questions about its sign alone.
    #[inline]
    pub fn geometric_normal(&self, normal: Vec3) -> Vec3 {
        if self.is_identity {
            return normal;
        }
        (self.normal * Vec3A::from(normal)).into()
    }

    /// Column-major 3x4, as Embree takes it.
    pub fn columns(&self) -> [f32; 12] {
        self.to_world.to_cols_array()
    }
}

fn affine(map: DAffine3) -> Affine3A {
    Affine3A {
        matrix3: Mat3A::from_cols(
            map.matrix3.x_axis.as_vec3a(),
            map.matrix3.y_axis.as_vec3a(),
            map.matrix3.z_axis.as_vec3a(),
        ),
        translation: map.translation.as_vec3a(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::animation::Interpolation;

    fn still(rotate: DVec3) -> TransformTrack {
        TransformTrack { rotate: Track::constant(rotate), ..TransformTrack::identity() }
    }

    #[test]
    fn rotates_about_x_before_y_before_z() {
        let turned = still(DVec3::new(90.0, 90.0, 0.0)).at(1.0).point(Vec3::Y);
        // about X: +Y -> +Z; then about Y: +Z -> +X
        assert!(turned.distance(Vec3::X) < 1e-6, "{turned}");
    }

    #[test]
    fn normals_stay_perpendicular_under_uneven_scale() {
        let track = TransformTrack {
            scale: Track::constant(DVec3::new(1.0, 3.0, 1.0)),
            ..TransformTrack::identity()
        };
        let transform = track.at(1.0);
        let edge = transform.to_world.transform_vector3(Vec3::new(1.0, -1.0, 0.0));
        let normal = transform.normal(Vec3::new(1.0, 1.0, 0.0).normalize());
        assert!(edge.dot(normal).abs() < 1e-6);
    }

    #[test]
    fn knows_whether_it_ever_moves() {
        let keys = vec![(1.0, DVec3::ZERO), (2.0, DVec3::X)];
        let moving = TransformTrack {
            translate: Track::through(keys, Interpolation::Linear).expect("good"),
            ..TransformTrack::identity()
        };
        assert!(TransformTrack::identity().is_constant() && !moving.is_constant());
    }
}
