//! Normals of vertices: means of the faces around them.

use glam::DVec3;

use super::angle;

/// What a triangle adds to the normal of its first corner: its own normal, as long as its angle there in radians. Zero for a triangle that
/// has no area.
///
/// Weighted by angles (Thürmer and Wüthrich, "Computing vertex normals from polygonal facets", 1998), means do not depend on how polygons
/// are cut into triangles; those by areas do. Blender takes the same.
pub fn share([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (to_b, to_c) = (b - a, c - a);
    let across = to_b.cross(to_c);
    let (sine, cosine) = (across.length(), to_b.dot(to_c));
    let largest = sine.max(cosine.abs());
    if sine == 0.0 || !largest.is_finite() {
        return DVec3::ZERO;
    }
    let angle = angle::of((sine / largest) as f32, (cosine / largest) as f32);
    across * (f64::from(angle) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
