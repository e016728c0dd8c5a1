//! Bakes still models into world space once, so that all of them can share one still Embree scene. Copies
//! that would be [too many](super::copies) are left out.

use embree::VertexBuffer;
use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use std::sync::Arc;

use crate::animation::TransformTrack;
use crate::scene::details::Details;
use crate::scene::import::faces::are_within_reach;
use crate::scene::{Mesh, Model};

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
    if let Some(quadric) = &mesh.quadric {
        let placed = Mesh::of_quadric(quadric.placed(map), mesh.material_of[0], mesh.shadow_casting > 0);
        let mesh = Mesh { details: details(mesh, map, false), ..placed };
        return are_within_reach(mesh.positions.as_slice()).then_some(mesh);
    }
    let positions: Vec<[f32; 3]> = mesh
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
    let mirrored = map.matrix3.determinant() < 0.0;
    Some(Mesh {
        positions: Arc::new(VertexBuffer::new(positions)),
        triangles: if mirrored {
            // a mirror image turns the other way; its outside must stay outside
            Arc::new(mesh.triangles.par_iter().map(|[a, b, c]| [*a, *c, *b]).collect())
        } else {
            mesh.triangles.clone()
        },
        normals: mesh.normals.par_iter().map(normal).collect(),
        uvs: mesh.uvs.clone(),
        material_of: mesh.material_of.clone(),
        groups: mesh.groups.clone(),
        shadow_casting: mesh.shadow_casting,
        cut: mesh.cut.clone(),
        quadric: None,
        shapes: None,
        details: details(mesh, map, mirrored),
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
        Mesh {
            positions: Arc::new(VertexBuffer::new(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])),
            triangles: Arc::new(vec![[0, 1, 2]]),
            normals: vec![Vec3::new(0.6, 0.0, 0.8); 3],
            uvs: Vec::new(),
            material_of: vec![0],
            groups: Default::default(),
            cut: None,
            quadric: None,
            shapes: None,
            details: Default::default(),
            shadow_casting: 1,
        }
    }

    #[test]
    fn moves_points_and_keeps_normals_perpendicular() {
        let map = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(2.0, 1.0, 1.0)),
            DVec3::new(0.0, 0.0, 5.0),
        );
        let mesh = baked(&triangle(), map).expect("finite");
        assert_eq!(mesh.positions.as_slice()[1], [2.0, 0.0, 5.0]);
        let expected = Vec3::new(0.3, 0.0, 0.8).normalize();
        assert!(mesh.normals[0].abs_diff_eq(expected, 1e-6));
    }

    #[test]
    fn mirror_images_keep_their_outside() {
        let map = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(*baked(&triangle(), map).expect("finite").triangles, [[0, 2, 1]]);
    }

    #[test]
    fn too_far_is_refused() {
        assert!(baked(&triangle(), DAffine3::from_scale(DVec3::splat(1e30))).is_none());
    }
}
