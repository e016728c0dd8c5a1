//! Tangents of places on meshes: the direction along which surfaces are brushed.

use glam::{Vec2, Vec3};

use super::{OnMesh, PlaceOfGraph, STEP};

impl OnMesh<'_> {
    /// Direction along the first texture coordinate, in the space of the mesh's positions, at rest, of any length; zero where there is none.
    pub fn tangent(&self) -> Vec3 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let (corners, uvs) = match &mesh.quadric {
            Some(quadric) => {
                let corners = [[u, v], [u + STEP, v], [u, v + STEP]];
                (corners.map(|at| quadric.point(primitive, at)), corners.map(|at| quadric.uv(primitive, at)))
            }
            None => {
                let uv = |corner: u32| mesh.uvs.get(corner as usize).copied().unwrap_or_default();
                (self.corners(), mesh.triangles[primitive as usize].map(uv))
            }
        };
        along_u(corners, uvs)
    }

    /// Direction around an `axis` of object space, through the middle of the mesh's box, as grooves of turned metal are: otherwise as
    /// [`tangent`](Self::tangent), which is what it is on a quadric.
    pub fn tangent_around(&self, axis: Vec3) -> Vec3 {
        let Some(space) = self.mesh.details.space.filter(|_| self.mesh.quadric.is_none()) else {
            return self.tangent();
        };
        let position = PlaceOfGraph { on: self, textures: &[] }.position();
        let away = space.to_object.transform_point3(position) - (space.low + 0.5 * space.size);
        space.to_object.inverse().transform_vector3(axis.cross(away))
    }
}

/// Direction in which the first texture coordinate grows on a triangle, and the second one stays.
fn along_u([a, b, c]: [Vec3; 3], [at_a, at_b, at_c]: [Vec2; 3]) -> Vec3 {
    let (b, c, at_b, at_c) = (b - a, c - a, at_b - at_a, at_c - at_a);
    let turned = at_b.perp_dot(at_c);
    let tangent = (b * at_c.y - c * at_b.y) * turned.signum();
    if turned != 0.0 && tangent.is_finite() { tangent } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tangent_leads_where_u_grows() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Z];
        let uvs = [Vec2::ZERO, Vec2::new(0.0, 2.0), Vec2::new(-3.0, 0.0)];
        assert_eq!(along_u(corners, uvs).normalize(), Vec3::NEG_Z);
        let mirrored = [Vec2::ZERO, Vec2::new(1.0, 0.0), Vec2::new(0.0, -1.0)];
        assert_eq!(along_u(corners, mirrored).normalize(), Vec3::X);
        assert_eq!(along_u(corners, [Vec2::ONE; 3]), Vec3::ZERO, "all in one place");
    }
}
