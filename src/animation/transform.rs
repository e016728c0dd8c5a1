//! Placement of a model: a matrix, then scale, then rotation, then translation; its visibility, and its
//! shape.

use glam::{Affine3A, DAffine3, DMat3, DQuat, DVec3, EulerRot, Mat3A, Vec3, Vec3A};

use super::{Chord, Shape, ShapeTrack, Track, Visibility};
use crate::lanes::{F32x8, Vec3x8};

/// Keyed placement of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct TransformTrack {
    /// Translation, world units.
    pub translate: Track<DVec3>,
    /// Rotation, degrees about X, then Y, then Z (fixed axes). Each angle is interpolated by itself, so that
    /// a key of 720 turns twice.
    pub rotate: Track<DVec3>,
    /// Factor along each axis, none zero.
    pub scale: Track<DVec3>,
    /// Matrix that is applied before the scale: any affine map with an inverse, which may shear and mirror.
    /// Between keys each element is interpolated by itself.
    pub matrix: Option<Track<DAffine3>>,
    /// Visibility of the model over time.
    pub visible: Visibility,
    /// Shapes of the model over time, if it deforms.
    pub shapes: Option<ShapeTrack>,
}

impl TransformTrack {
    /// Creates the track of a model that stays where its file puts it.
    pub fn identity() -> Self {
        Self {
            translate: Track::constant(DVec3::ZERO),
            rotate: Track::constant(DVec3::ZERO),
            scale: Track::constant(DVec3::ONE),
            matrix: None,
            visible: Visibility::ALWAYS,
            shapes: None,
        }
    }

    /// Transform from object to world space at `frame`.
    pub fn at(&self, frame: f64) -> Transform {
        if !self.visible.at(frame) {
            return Transform::HIDDEN;
        }
        let shape = self.shapes.as_ref().map_or(Shape::FIRST, |shapes| shapes.at(frame));
        Transform { shape: Chord::still(shape), ..Transform::new(self.map_at(frame)) }
    }

    /// Exact map from object to world space at `frame`, whether the model is visible or not.
    pub fn map_at(&self, frame: f64) -> DAffine3 {
        let angles = self.rotate.at(frame) * (std::f64::consts::PI / 180.0);
        // intrinsic Z-Y-X is extrinsic X-Y-Z: about X first, then Y, then Z, all fixed axes
        let rotation = DQuat::from_euler(EulerRot::ZYX, angles.z, angles.y, angles.x);
        let placed = DAffine3::from_scale_rotation_translation(
            self.scale.at(frame),
            rotation,
            self.translate.at(frame),
        );
        self.matrix.as_ref().map_or(placed, |matrix| placed * matrix.at(frame))
    }

    /// Returns true if the place is the same from one frame to another, both included.
    pub fn rests(&self, from: f64, to: f64) -> bool {
        let tracks = [&self.translate, &self.rotate, &self.scale];
        tracks.into_iter().all(|track| track.rests_until(from) > to)
            && self.matrix.as_ref().is_none_or(|matrix| matrix.rests_until(from) > to)
    }

    /// Frames of all keys for the place.
    pub fn key_frames(&self) -> Vec<f64> {
        let frames = self.translate.frames().chain(self.rotate.frames()).chain(self.scale.frames());
        frames.chain(self.matrix.iter().flat_map(Track::frames)).collect()
    }

    /// Returns true if the model is visible, and stands still, for the whole shot. Never true for a model
    /// with shapes: not even a single one need be that of its file.
    pub fn is_constant(&self) -> bool {
        self.shapes.is_none()
            && self.translate.is_constant()
            && self.rotate.is_constant()
            && self.scale.is_constant()
            && self.matrix.as_ref().is_none_or(Track::is_constant)
            && self.visible.is_always()
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
    /// True if the map changes nothing: in most scenes most models stand where their file put them.
    pub is_identity: bool,
    /// True if the model is visible. An invisible model has no place, and all its transforms are equal.
    pub is_visible: bool,
    /// Shape of the model, if it deforms: the map applies to this shape.
    pub shape: Chord,
}

impl Transform {
    /// Transform that changes nothing.
    pub const IDENTITY: Self = Self {
        to_world: Affine3A::IDENTITY,
        normal: Mat3A::IDENTITY,
        to_object: Affine3A::IDENTITY,
        is_identity: true,
        is_visible: true,
        shape: Chord::FIRST,
    };

    /// Transform of an invisible model: no ray meets it, and it has no samples.
    pub const HIDDEN: Self = Self { is_visible: false, ..Self::IDENTITY };

    /// Creates a transform from an exact map, which must have an inverse.
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
            is_visible: true,
            shape: Chord::FIRST,
        }
    }

    /// Returns true if all of its numbers are finite: it has an inverse.
    pub fn is_finite(&self) -> bool {
        self.to_world.is_finite() && self.to_object.is_finite()
    }

    /// Transforms a point from object to world space.
    #[inline]
    pub fn point(&self, point: Vec3) -> Vec3 {
        if self.is_identity {
            return point;
        }
        self.to_world.transform_point3(point)
    }

    /// Transforms a direction of any length from object to world space.
    #[inline]
    pub fn direction(&self, direction: Vec3) -> Vec3 {
        if self.is_identity {
            return direction;
        }
        self.to_world.transform_vector3(direction)
    }

    /// Upper bound of an object's length in object space if it extends by `reach` along each axis of the
    /// world.
    pub fn length_in_object(&self, reach: Vec3) -> f32 {
        if self.is_identity {
            return reach.length();
        }
        let columns = self.to_object.matrix3;
        let lengths = [columns.x_axis, columns.y_axis, columns.z_axis].map(|column| column.length());
        reach.abs().dot(Vec3::from_array(lengths))
    }

    /// Upper bound of a length in the world for each unit of length in object space.
    pub fn most_stretch(&self) -> f32 {
        if self.is_identity {
            return 1.0;
        }
        let axes = self.to_world.matrix3;
        let squares = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.length_squared());
        squares.into_iter().sum::<f32>().sqrt()
    }

    /// Length in object space for each unit of length in the world: the mean over all directions, in so far as volumes tell it.
    pub fn scale_to_object(&self) -> f32 {
        if self.is_identity { 1.0 } else { self.to_object.matrix3.determinant().abs().cbrt() }
    }

    /// Transforms a normal of unit length from object to world space; the result has unit length.
    #[inline]
    pub fn normal(&self, normal: Vec3) -> Vec3 {
        if self.is_identity {
            return normal;
        }
        (self.normal * Vec3A::from(normal)).normalize_or_zero().into()
    }

    /// Transforms a normal from object to world space; the result has any length. For questions about its
    /// sign alone.
    #[inline]
    pub fn geometric_normal(&self, normal: Vec3) -> Vec3 {
        if self.is_identity {
            return normal;
        }
        (self.normal * Vec3A::from(normal)).into()
    }

    /// Transforms eight points like [`point`](Self::point), to the bit.
    #[inline(always)]
    pub fn points(&self, points: Vec3x8) -> Vec3x8 {
        if self.is_identity {
            return points;
        }
        mapped(self.to_world.matrix3, points) + Vec3x8::splat(self.to_world.translation.into())
    }

    /// Transforms eight normals like [`normal`](Self::normal), to the bit.
    #[inline(always)]
    pub fn normals(&self, normals: Vec3x8) -> Vec3x8 {
        if self.is_identity {
            return normals;
        }
        let normals = mapped(self.normal, normals);
        let scale = F32x8::ONE / normals.dot(normals).sqrt();
        let is_usable = scale.gt(F32x8::ZERO) & scale.lt(F32x8::splat(f32::INFINITY));
        is_usable.select3(normals * scale, Vec3x8::ZERO)
    }

    /// Transforms eight normals like [`geometric_normal`](Self::geometric_normal), to the bit.
    #[inline(always)]
    pub fn geometric_normals(&self, normals: Vec3x8) -> Vec3x8 {
        if self.is_identity { normals } else { mapped(self.normal, normals) }
    }

    /// Transforms a line from a point along a direction from world to object space.
    pub fn line_to_object(&self, (origin, along): (Vec3, Vec3)) -> [DVec3; 2] {
        let line = match self.is_identity {
            true => [origin, along],
            false => [self.to_object.transform_point3(origin), self.to_object.transform_vector3(along)],
        };
        line.map(|part| part.as_dvec3())
    }

    /// Columns of the 3x4 matrix, as Embree takes them.
    pub fn columns(&self) -> [f32; 12] {
        self.to_world.to_cols_array()
    }
}

/// Applies a linear map to eight vectors: in the order in which `glam` adds.
#[inline(always)]
fn mapped(map: Mat3A, Vec3x8 { x, y, z }: Vec3x8) -> Vec3x8 {
    let [across, up, along] = [map.x_axis, map.y_axis, map.z_axis].map(|axis| Vec3x8::splat(axis.into()));
    across * x + up * y + along * z
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

    /// Samples are placed eight at a time and one by one: what is kept of them must not depend on which.
    #[test]
    fn eight_are_placed_as_one_is_to_the_bit() {
        use crate::lanes::LANES;
        use crate::shade::sampling::PathRandom;
        for round in 0..500 {
            let three = |index: u32| {
                let [x, y, z, _] = PathRandom::new(round, index).four(0);
                (Vec3::new(x, y, z) * 2.0 - 1.0) * 10.0_f32.powi((round % 9) as i32 - 4)
            };
            let columns = [1, 2, 3].map(|index| three(index).as_dvec3());
            let map = DAffine3::from_cols(columns[0], columns[1], columns[2], three(4).as_dvec3());
            let transform = Transform::new(map);
            let [mut points, mut normals] = [Vec3x8::ZERO; 2];
            for lane in 0..LANES {
                points.set_lane(lane, three(10 + lane as u32));
                normals.set_lane(lane, three(20 + lane as u32).normalize_or_zero());
            }
            normals.set_lane(3, Vec3::ZERO);
            let (placed, turned) = (transform.points(points), transform.normals(normals));
            let sides = transform.geometric_normals(normals);
            for lane in 0..LANES {
                let (point, normal) = (points.lane(lane), normals.lane(lane));
                assert_eq!(placed.lane(lane), transform.point(point), "round {round}");
                assert_eq!(turned.lane(lane), transform.normal(normal), "round {round}");
                assert_eq!(sides.lane(lane), transform.geometric_normal(normal), "round {round}");
            }
        }
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
    fn a_matrix_comes_before_scale_rotation_and_translation() {
        let shear = DAffine3::from_mat3_translation(
            DMat3::from_cols(DVec3::X, DVec3::new(2.0, 1.0, 0.0), DVec3::Z),
            DVec3::new(0.0, 0.0, 5.0),
        );
        let track = TransformTrack {
            translate: Track::constant(DVec3::X * 10.0),
            rotate: Track::constant(DVec3::new(0.0, 90.0, 0.0)),
            scale: Track::constant(DVec3::new(3.0, 1.0, 1.0)),
            matrix: Some(Track::constant(shear)),
            ..TransformTrack::identity()
        };
        // (0, 1, 0) is sheared to (2, 1, 5), scaled to (6, 1, 5), turned to (5, 1, -6)
        let there = track.at(1.0).point(Vec3::Y);
        assert!(there.distance(Vec3::new(15.0, 1.0, -6.0)) < 1e-5, "{there}");
        assert!(track.is_constant());
    }

    #[test]
    fn elements_of_matrices_are_interpolated_one_by_one() {
        let mirror = DAffine3::from_scale_rotation_translation(
            DVec3::new(-1.0, 3.0, 1.0),
            DQuat::from_rotation_z(0.5),
            DVec3::new(4.0, 0.0, 2.0),
        );
        let other = DAffine3::from_mat3(DMat3::from_cols(DVec3::NEG_X, DVec3::ONE, DVec3::Z));
        let keys = vec![(1.0, mirror), (5.0, other)];
        let matrix = Track::through(keys, Interpolation::Linear).expect("good");
        let track = TransformTrack { matrix: Some(matrix), ..TransformTrack::identity() };
        let expected =
            mirror.to_cols_array().into_iter().zip(other.to_cols_array()).map(|(a, b)| a * 0.75 + b * 0.25);
        let expected: Vec<f64> = expected.collect();
        assert!(track.map_at(2.0).abs_diff_eq(DAffine3::from_cols_slice(&expected), 1e-12));
        assert!(!track.is_constant() && track.key_frames().contains(&5.0));
    }

    #[test]
    fn mirrored_and_sheared_normals_stay_outside() {
        let map = DAffine3::from_mat3(DMat3::from_cols(
            DVec3::new(-2.0, 0.0, 0.5),
            DVec3::new(1.0, 1.0, 0.0),
            DVec3::new(0.0, 0.25, 1.0),
        ));
        let transform = Transform::new(map);
        assert!(map.matrix3.determinant() < 0.0, "a mirror image");
        // of the triangle (1,0,0) (0,1,0) (0,0,1), whose outside is away from the origin
        let normal = transform.normal(Vec3::ONE.normalize());
        let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|corner| transform.point(corner));
        assert!(normal.dot(corners[1] - corners[0]).abs() < 1e-6);
        assert!(normal.dot(corners[2] - corners[0]).abs() < 1e-6);
        assert!(normal.dot(corners[0] - transform.point(Vec3::ZERO)) > 0.1);
    }

    #[test]
    fn what_is_not_there_is_equal_wherever_it_would_be() {
        let keys = vec![(1.0, DVec3::ZERO), (9.0, DVec3::X)];
        let track = TransformTrack {
            translate: Track::through(keys, Interpolation::Linear).expect("good"),
            visible: Visibility::through(true, vec![(3.0, false), (6.0, true)]).expect("good"),
            ..TransformTrack::identity()
        };
        assert_eq!((track.at(3.0), track.at(5.0)), (Transform::HIDDEN, Transform::HIDDEN));
        assert!(track.at(2.0).is_visible && track.at(6.0).is_visible && track.at(6.0) != track.at(5.0));
        assert_ne!(Transform::HIDDEN, Transform::IDENTITY);
    }

    #[test]
    fn knows_whether_it_ever_moves() {
        let keys = vec![(1.0, DVec3::ZERO), (2.0, DVec3::X)];
        let moving = TransformTrack {
            translate: Track::through(keys, Interpolation::Linear).expect("good"),
            ..TransformTrack::identity()
        };
        assert!(TransformTrack::identity().is_constant() && !moving.is_constant());
        let hidden = Visibility::through(false, vec![]).expect("good");
        let never_there = TransformTrack { visible: hidden, ..TransformTrack::identity() };
        assert!(!never_there.is_constant(), "it must not be taken for what always stands there");
    }
}
