//! Normals of vertices: means of the faces around them.

use glam::{DVec3, Vec3};

use super::angle;

/// What a triangle adds to the normals of its corners: to each its own normal, as long as its angle there in radians.
///
/// Weighted by angles (Thürmer and Wüthrich, "Computing vertex normals from polygonal facets", 1998), means do not depend on how polygons
/// are cut into triangles; those by areas do. Blender takes the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Unit length; zero for a triangle that has no area.
    normal: Vec3,
    /// Angles at the corners.
    angles: [f32; 3],
}

impl Face {
    /// Face with these corners.
    pub fn new([a, b, c]: [DVec3; 3]) -> Self {
        let [ab, bc, ca] = [b - a, c - b, a - c];
        let across = ca.cross(ab);
        let sine = across.length();
        let cosines = [-ca.dot(ab), -ab.dot(bc), -bc.dot(ca)];
        let largest = cosines.iter().fold(sine, |largest, cosine| largest.max(cosine.abs()));
        if sine == 0.0 || !largest.is_finite() {
            return Self { normal: Vec3::ZERO, angles: [0.0; 3] };
        }
        let angle = |cosine: f64| {
            let largest = sine.max(cosine.abs());
            angle::of((sine / largest) as f32, (cosine / largest) as f32)
        };
        Self { normal: (across / sine).as_vec3(), angles: cosines.map(angle) }
    }

    /// What it adds to the normal of corner 0, 1 or 2.
    pub fn share(&self, corner: usize) -> DVec3 {
        self.normal.as_dvec3() * f64::from(self.angles[corner])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn share(corners: [DVec3; 3]) -> DVec3 {
        Face::new(corners).share(0)
    }

    #[test]
    fn a_mean_is_the_same_however_a_polygon_is_cut() {
        let [a, b, c, d, up] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 0.9, 0.0), DVec3::Y, DVec3::Z];
        let around = |triangles: &[[DVec3; 2]]| {
            let side = share([a, up, b]) + share([a, d, up]);
            (triangles.iter().map(|[from, to]| share([a, *from, *to])).sum::<DVec3>() + side).normalize()
        };
        let (cut, whole) = (around(&[[b, c], [c, d]]), around(&[[b, d]]));
        assert!(cut.abs_diff_eq(whole, 1e-6));
    }

    #[test]
    fn shares_are_as_long_as_angles_at_any_scale() {
        for scale in [1e-15, 1.0, 1e15] {
            let share = share([DVec3::ZERO, DVec3::X * scale, DVec3::new(1.0, 1.0, 0.0) * scale]);
            assert!(share.abs_diff_eq(DVec3::Z * std::f64::consts::FRAC_PI_4, 1e-6), "{scale}: {share}");
        }
        assert_eq!(share([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]), DVec3::ZERO);
    }

    #[test]
    fn each_corner_has_its_own_angle() {
        let corners = [DVec3::ZERO, DVec3::X * 3.0, DVec3::Y * 3.0_f64.sqrt()];
        let face = Face::new(corners);
        for (corner, degrees) in [90.0_f64, 30.0, 60.0].into_iter().enumerate() {
            assert!(face.share(corner).abs_diff_eq(DVec3::Z * degrees.to_radians(), 1e-6), "{corner}");
            let mut turned = corners;
            turned.rotate_left(corner);
            assert!(face.share(corner).abs_diff_eq(share(turned), 1e-6), "{corner}");
        }
    }
}
