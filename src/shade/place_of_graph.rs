//! Places on meshes, as graphs see them.

use glam::{Affine3A, Vec2, Vec3};

use super::on_mesh::OnMesh;
use crate::graph::{Place, UvSet};
use crate::scene::Texture;

/// A place on a mesh, and the pictures of the shot.
pub struct PlaceOfGraph<'a> {
    pub on: &'a OnMesh<'a>,
    pub textures: &'a [Texture],
}

impl PlaceOfGraph<'_> {
    /// The place in the space of the mesh's positions, at rest.
    fn position(&self) -> Vec3 {
        let OnMesh { mesh, primitive, weights: [u, v], .. } = *self.on;
        if let Some(quadric) = &mesh.quadric {
            return quadric.point(primitive, [u, v]);
        }
        let [a, b, c] = self.corners();
        a * (1.0 - u - v) + b * u + c * v
    }

    fn corners(&self) -> [Vec3; 3] {
        let positions = self.on.mesh.positions.as_slice();
        self.on.mesh.triangles[self.on.primitive as usize]
            .map(|corner| Vec3::from(positions[corner as usize]))
    }
}

impl Place for PlaceOfGraph<'_> {
    fn uv(&self, set: UvSet) -> Vec2 {
        self.on.uv_of(set)
    }

    fn point(&self) -> Vec3 {
        let position = self.position();
        self.on.mesh.details.space.map_or(position, |space| space.to_object.transform_point3(position))
    }

    fn generated(&self) -> Vec3 {
        let point = self.point();
        self.on.mesh.details.space.map_or(point, |space| (point - space.low) / space.size)
    }

    fn normal(&self) -> Vec3 {
        let OnMesh { mesh, primitive, weights: [u, v], .. } = *self.on;
        let normal = match &mesh.quadric {
            Some(quadric) => quadric.normal(primitive, [u, v]),
            None => {
                let [a, b, c] = self.corners();
                let of_face = (b - a).cross(c - a);
                let corner = |corner: u32| mesh.normals.get(corner as usize).copied().unwrap_or_default();
                let [a, b, c] = mesh.triangles[primitive as usize].map(corner);
                let smooth = a * (1.0 - u - v) + b * u + c * v;
                if smooth == Vec3::ZERO { of_face } else { smooth }
            }
        };
        // normals are mapped by the transposed inverse, which the map to object space is that of the map into the world
        let normal = match mesh.details.space {
            Some(space) => space.to_object.matrix3.inverse().transpose() * normal,
            None => normal,
        };
        normal.normalize_or(Vec3::Z)
    }

    fn world_point(&self) -> Vec3 {
        let point = self.point();
        self.on.to_world.map_or(point, |map| map.transform_point3(point))
    }

    fn world_normal(&self) -> Vec3 {
        let normal = self.normal();
        let in_world = |map: &Affine3A| (map.matrix3.inverse().transpose() * normal).normalize_or(normal);
        self.on.to_world.map_or(normal, in_world)
    }

    fn vertex_color(&self) -> Vec3 {
        self.on.vertex_color()
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        let Some(texture) = self.textures.get(number as usize) else { return [0.0; 4] };
        let (uv, level) = match at {
            None => (self.on.uv_of(texture.mapping.uvs), self.on.level(texture)),
            Some(uv) => (uv, 0),
        };
        let Vec3 { x, y, z } = texture.value(uv, level);
        [x, y, z, texture.alpha_between(&texture.between(uv))]
    }
}
