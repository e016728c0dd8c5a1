//! Triangles with what shading needs at their corners.

use std::sync::Arc;

use embree::VertexBuffer;
use glam::{Vec2, Vec3};

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
