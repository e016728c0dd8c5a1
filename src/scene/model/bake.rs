//! Bakes still models into world space once, so that all of them can share one still Embree scene. Copies
//! that would be [too many](super::copies) are left out.

use embree::VertexBuffer;
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

use crate::animation::TransformTrack;
use crate::geometry::Bounds;
use crate::scene::details::Details;
use crate::scene::import::faces::are_within_reach;
use crate::scene::{Geometry, Mesh, Model, Triangles};

impl Model {
    /// Puts the mesh of a model that never moves into world space; other models stay as they are. `None` if a
    /// vertex comes to lie too far away.
    pub(crate) fn settled(self) -> Option<Self> {
        if !self.track.is_constant() || self.track == TransformTrack::identity() {
            return Some(self);
        }
        let still = baked(&self.mesh, self.track.map_at(0.0))?;
        Some(Self { mesh: still.into(), track: TransformTrack::identity(), ..self })
    }
}

/// Maps `mesh` by `map`, computed in f64. `None` if a vertex comes to lie too far away to be rendered.
fn baked(mesh: &Mesh, map: DAffine3) -> Option<Mesh> {
    let geometry = match &mesh.geometry {
        Geometry::Triangles(triangles) => Geometry::Triangles(baked_triangles(triangles, map)?),
        Geometry::Curved(curved) => {
            let curved = curved.mapped(map);
            let ends = |primitive| {
                let Bounds { low, high } = curved.bounds(primitive);
                [low, high].map(|corner| corner.to_array())
            };
            let ends: Vec<[f32; 3]> = (0..curved.count()).flat_map(ends).collect();
            if !are_within_reach(&ends) {
                return None;
            }
            Geometry::Curved(curved)
        }
    };
    Some(Mesh {
        geometry,
        material_of: mesh.material_of.clone(),
        groups: mesh.groups.clone(),
        shadow_casting: mesh.shadow_casting,
        cut: mesh.cut.clone(),
        details: details(mesh, map, map.matrix3.determinant() < 0.0),
    })
}

/// Maps triangles: see [`baked`].
fn baked_triangles(triangles: &Triangles, map: DAffine3) -> Option<Triangles> {
    let positions: Vec<[f32; 3]> = triangles
        .positions
        .as_slice()
        .par_iter()
        .map(|p| map.transform_point3(Vec3::from(*p).as_dvec3()).as_vec3().to_array())
        .collect();
    if !are_within_reach(&positions) {
        return None;
    }
    let to_normal = map.matrix3.inverse().transpose();
    let normal = |n: &Vec3| (to_normal * n.as_dvec3()).normalize_or(DVec3::ZERO).as_vec3();
    Some(Triangles {
        positions: Arc::new(VertexBuffer::new(positions)),
        corners: if map.matrix3.determinant() < 0.0 {
            // a mirror image turns the other way; its outside must stay outside
            Arc::new(triangles.corners.par_iter().map(|[a, b, c]| [*a, *c, *b]).collect())
        } else {
            triangles.corners.clone()
        },
        normals: triangles.normals.par_iter().map(normal).collect(),
        uvs: triangles.uvs.clone(),
        shapes: None,
    })
}

fn details(mesh: &Mesh, map: DAffine3, is_mirrored: bool) -> Arc<Details> {
    let space = mesh.details.space.map(|space| space.placed(map));
    match (is_mirrored, space) {
        (false, None) => mesh.details.clone(),
        (true, _) => Arc::new(Details { space, ..mesh.details.mirrored() }),
        (false, Some(_)) => Arc::new(Details { space, ..Details::clone(&mesh.details) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    fn triangle() -> Mesh {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let triangles = Triangles::new(positions, vec![[0, 1, 2]]);
        let normals = vec![Vec3::new(0.6, 0.0, 0.8); 3];
        Mesh::plain(Triangles { normals, ..triangles }.into(), 0, true)
    }

    #[test]
    fn moves_points_and_keeps_normals_perpendicular() {
        let map = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0)),
            DVec3::new(0.0, 0.0, 5.0),
        );
        let mesh = baked(&triangle(), map).expect("finite");
        let mesh = mesh.triangles();
        assert_eq!(mesh.positions.as_slice()[1], [2.0, 0.0, 5.0]);
        let expected = Vec3::new(0.3, 0.0, 0.8).normalize();
        assert!(mesh.normals[0].abs_diff_eq(expected, 1e-6));
    }

    #[test]
    fn mirror_images_keep_their_outside() {
        let map = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(*baked(&triangle(), map).expect("finite").triangles().corners, [[0, 2, 1]]);
    }

    #[test]
    fn too_far_is_refused() {
        assert!(baked(&triangle(), DAffine3::from_scale(DVec3::splat(1e30))).is_none());
    }
}
