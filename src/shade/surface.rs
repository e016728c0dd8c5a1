//! The point of a surface that a ray has met, and how rays leave it.

use glam::{DVec2, DVec3, Vec2, Vec3};

use crate::motion::Transform;
use crate::scene::{Material, Mesh, Scene};
use crate::trace::Hit;

/// A point of a surface as shading sees it, world space. Normals have unit length and point to the side
/// from which the surface is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// World space.
    pub point: Vec3,
    /// Interpolated from the corners where the mesh has normals.
    pub normal: Vec3,
    /// Of the triangle itself.
    pub facet: Vec3,
    /// Diffuse reflectance, texture included.
    pub albedo: Vec3,
    /// Index into [`Scene::materials`].
    pub material: u16,
    /// Whether the back of the triangle is seen.
    pub from_behind: bool,
}

/// What a triangle is at one of its points, object space, normals as the mesh has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Object space.
    pub point: Vec3,
    /// Unit length; the facet's where the mesh has none.
    pub normal: Vec3,
    /// Unit length, by the right-hand rule over the corners.
    pub facet: Vec3,
    /// Texture coordinates, zero where the mesh has none.
    pub uv: Vec2,
}

/// `triangle` of `mesh` at barycentric `u`, `v` (weights of its second and third corner).
pub fn interpolate(mesh: &Mesh, triangle: u32, u: f32, v: f32) -> Corner {
    let [first, second, third] = mesh.triangles[triangle as usize];
    let [first, second, third] = [first as usize, second as usize, third as usize];
    let at = |corner: usize| Vec3::from_array(mesh.positions.as_slice()[corner]);
    let (a, b, c) = (at(first), at(second), at(third));
    let facet = (b - a).cross(c - a);
    // tiny triangles: the cross product of edges of 1e-20 is 0 in f32
    let facet = facet.try_normalize().unwrap_or_else(|| {
        (b - a).as_dvec3().cross((c - a).as_dvec3()).try_normalize().map_or(Vec3::Y, |n| n.as_vec3())
    });
    let w = 1.0 - u - v;
    let normal = match mesh.normals.as_slice() {
        [] => facet,
        normals => {
            (normals[first] * w + normals[second] * u + normals[third] * v).try_normalize().unwrap_or(facet)
        }
    };
    let uv = match mesh.uvs.as_slice() {
        [] => Vec2::ZERO,
        uvs => uvs[first] * w + uvs[second] * u + uvs[third] * v,
    };
    Corner { point: a + (b - a) * u + (c - a) * v, normal, facet, uv }
}

/// Barycentric coordinates (second and third corner) of `point` in a triangle; `None` where it lies
/// farther than `reach` from it.
pub fn barycentric([a, b, c]: [DVec3; 3], point: DVec3, reach: f64) -> Option<DVec2> {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    if area == 0.0 {
        return None;
    }
    let at = DVec2::new(ap.cross(ac).dot(normal) / area, ab.cross(ap).dot(normal) / area);
    let clamped = {
        let inside = at.max(DVec2::ZERO);
        inside / (inside.x + inside.y).max(1.0)
    };
    let nearest = a + ab * clamped.x + ac * clamped.y;
    (nearest.distance(point) <= reach).then_some(clamped)
}

/// Diffuse reflectance of `material` at `uv`.
pub fn albedo(scene: &Scene, material: &Material, uv: Vec2) -> Vec3 {
    match material.diffuse_map {
        Some(map) => material.diffuse * scene.textures[map as usize].sample(uv),
        None => material.diffuse,
    }
}

impl Surface {
    /// What a ray that goes along `direction` sees where it met `hit`; `transform` places the model.
    pub fn at(scene: &Scene, transform: &Transform, hit: Hit, direction: Vec3) -> Self {
        let mesh = &scene.models[hit.model as usize].mesh;
        let corner = interpolate(mesh, hit.triangle, hit.u, hit.v);
        let material = mesh.material_of[hit.triangle as usize];
        let facet = transform.normal(corner.facet);
        let from_behind = facet.dot(direction) > 0.0;
        let side = if from_behind { -1.0 } else { 1.0 };
        Self {
            point: transform.point(corner.point),
            normal: transform.normal(corner.normal) * side,
            facet: facet * side,
            albedo: albedo(scene, &scene.materials[usize::from(material)], corner.uv),
            material,
            from_behind,
        }
    }

    /// Where a ray starts that leaves the surface on the side of `direction`.
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let outward = if self.facet.dot(direction) < 0.0 { -self.facet } else { self.facet };
        off_surface(self.point, outward)
    }
}

/// `point`, moved along `normal` just so far that a ray from there does not meet the surface again.
///
/// Integer steps in the floats' own units make the distance fit the size of the coordinates; near zero
/// a fixed distance serves (Wächter and Binder, "A Fast and Robust Method for Avoiding
/// Self-Intersection", Ray Tracing Gems, chapter 6).
pub fn off_surface(point: Vec3, normal: Vec3) -> Vec3 {
    const STEPS: f32 = 256.0;
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    const FIXED: f32 = 1.0 / 65536.0;
    let moved = |p: f32, n: f32| {
        if p.abs() < NEAR_ZERO {
            return p + FIXED * n;
        }
        let steps = (STEPS * n) as i32;
        f32::from_bits((p.to_bits() as i32).wrapping_add(if p < 0.0 { -steps } else { steps }) as u32)
    };
    Vec3::new(moved(point.x, normal.x), moved(point.y, normal.y), moved(point.z, normal.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_outwards_on_both_sides_of_zero() {
        for at in [-2.7e6_f32, -3.0, -0.01, 0.0, 0.01, 3.0, 2.7e6] {
            assert!(off_surface(Vec3::splat(at), Vec3::X).x > at);
            assert!(off_surface(Vec3::splat(at), Vec3::NEG_X).x < at);
        }
        let far = off_surface(Vec3::splat(1000.0), Vec3::X).x - 1000.0;
        assert!(far < 1000.0 * 1e-4, "the step stays in proportion: {far}");
    }

    #[test]
    fn a_point_off_its_triangle_is_found_out() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!(barycentric(corners, DVec3::new(0.25, 0.5, 0.0), 1e-6), Some(DVec2::new(0.25, 0.5)));
        assert_eq!(barycentric(corners, DVec3::new(0.25, 0.5, 1e-3), 1e-6), None);
        assert_eq!(barycentric(corners, DVec3::new(0.8, 0.5, 0.0), 1e-6), None);
        assert!(barycentric(corners, DVec3::new(0.5, 0.5 + 1e-7, 0.0), 1e-6).is_some());
    }
}
