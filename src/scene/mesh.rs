//! Triangles with what shading needs at their corners.

use std::sync::Arc;

use embree::VertexBuffer;
use glam::{DVec3, Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use crate::geometry::Bounds;

/// Triangles that one thread looks at in one go.
const BLOCK: usize = 1 << 14;

/// A triangle mesh in object space.
///
/// All per-vertex lists have either no entry or one a vertex.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Finite, shared with Embree.
    pub positions: Arc<VertexBuffer>,
    /// Counter-clockwise seen from outside; indices into the per-vertex lists. Never empty.
    pub triangles: Arc<Vec<[u32; 3]>>,
    /// Unit length, or zero where the file's was unusable (the face's normal serves then).
    pub normals: Vec<Vec3>,
    /// v = 0 at the bottom of the picture, as in OBJ.
    pub uvs: Vec<Vec2>,
    /// How many of `triangles`, from the first on, cast shadows; the rest lets shadow rays pass.
    pub shadow_casting: usize,
    /// Index into [`Scene::materials`](super::Scene::materials) for each triangle.
    pub material_of: Vec<u16>,
}

impl Mesh {
    /// The smallest box around the vertices that triangles use, object space: stray ones must not make the model
    /// small.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let positions = self.positions.as_slice();
        let nothing = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        let joined = |a: (Vec3A, Vec3A), b: (Vec3A, Vec3A)| (a.0.min(b.0), a.1.max(b.1));
        let of_block = |block: &[[u32; 3]]| {
            let corners = block.as_flattened().iter().map(|i| Vec3A::from(positions[*i as usize]));
            corners.fold(nothing, |bounds, corner| joined(bounds, (corner, corner)))
        };
        let (low, high) = self.triangles.par_chunks(BLOCK).map(of_block).reduce(|| nothing, joined);
        (low.as_dvec3(), high.as_dvec3())
    }
}

impl Bounds {
    /// Around all vertices of `mesh`, object space, used by a triangle or not.
    pub fn of(mesh: &Mesh) -> Self {
        mesh.positions.as_slice().iter().fold(Self::EMPTY, |all, point| all.with(Vec3::from_array(*point)))
    }
}
