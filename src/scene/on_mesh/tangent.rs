//! Tangents of places on meshes: the direction along which surfaces are brushed.

use glam::{Vec2, Vec3};

use super::OnMesh;
use crate::scene::texture::UvSet;

impl OnMesh<'_> {
    /// Direction along the first texture coordinate, in the space of the mesh's positions, at rest, of any length; zero where there is none.
    pub fn tangent(&self) -> Vec3 {
        along_u(self.corners(), self.uvs_of_corners(UvSet::First))
    }

    /// Direction around an `axis` of object space, through the middle of the mesh's box, as grooves of turned metal are: otherwise as
    /// [`tangent`](Self::tangent), which is what it is on curved geometry.
    pub fn tangent_around(&self, axis: Vec3) -> Vec3 {
        let Some(space) = self.mesh.details.space.filter(|_| !self.mesh.is_curved()) else {
            return self.tangent();
        };
        let away = space.to_object.transform_point3(self.position()) - (space.low + 0.5 * space.size);
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
