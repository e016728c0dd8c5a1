//! Geometries of meshes: triangles, or primitives that are evaluated one by one.

use std::sync::Arc;

use embree::VertexBuffer;
use glam::{Vec2, Vec3};

use super::Shapes;
use crate::geometry::{Bounds, Curved};

/// What a mesh is made of: primitives, which are numbered from 0 on.
#[derive(Debug, Clone)]
pub enum Geometry {
    /// Flat triangles, which are handled eight at a time by their corners.
    Triangles(Triangles),
    /// Primitives that are met and evaluated one at a time.
    Curved(Arc<dyn Curved>),
}

/// Triangles with the vertex data that shading needs, object space.
///
/// All per-vertex lists have either no entry or one a vertex.
#[derive(Debug, Clone)]
pub struct Triangles {
    /// Vertex positions. Finite, shared with Embree.
    pub positions: Arc<VertexBuffer>,
    /// Corners of each triangle as indices into the per-vertex lists, counter-clockwise seen from outside. Never empty.
    pub corners: Arc<Vec<[u32; 3]>>,
    /// Vertex normals of unit length, or zero if the file's was unusable (the face's normal is used then).
    pub normals: Vec<Vec3>,
    /// Texture coordinates: v = 0 at the bottom of the picture, as in OBJ.
    pub uvs: Vec<Vec2>,
    /// Vertex positions by shape, if they deform. Then `positions` is the shape at rest: samples keep the point in that shape.
    pub shapes: Option<Arc<Shapes>>,
}

impl Geometry {
    /// Number of its primitives; at least one.
    pub fn count(&self) -> usize {
        match self {
            Self::Triangles(triangles) => triangles.corners.len(),
            Self::Curved(curved) => curved.count() as usize,
        }
    }

    /// Box around a primitive, object space, at rest.
    pub fn bounds(&self, primitive: u32) -> Bounds {
        match self {
            Self::Triangles(triangles) => {
                triangles.positions_of(primitive).into_iter().fold(Bounds::EMPTY, Bounds::with)
            }
            Self::Curved(curved) => curved.bounds(primitive),
        }
    }
}

impl Triangles {
    /// Creates triangles of these vertices, without normals, texture coordinates and shapes.
    pub fn new(positions: Vec<[f32; 3]>, corners: Vec<[u32; 3]>) -> Self {
        Self {
            positions: Arc::new(VertexBuffer::new(positions)),
            corners: Arc::new(corners),
            normals: Vec::new(),
            uvs: Vec::new(),
            shapes: None,
        }
    }

    /// Positions of the three corners of a triangle, at rest.
    #[inline(always)]
    pub fn positions_of(&self, triangle: u32) -> [Vec3; 3] {
        let positions = self.positions.as_slice();
        self.corners[triangle as usize].map(|corner| Vec3::from_array(positions[corner as usize]))
    }

    /// Positions of the vertices in each shape; at rest, if they do not deform.
    pub fn all_positions(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        let own = self.shapes.is_none().then_some(self.positions.as_slice());
        let shapes = self.shapes.iter().flat_map(|shapes| shapes.list()).map(Vec::as_slice);
        own.into_iter().chain(shapes)
    }
}

impl From<Triangles> for Geometry {
    fn from(triangles: Triangles) -> Self {
        Self::Triangles(triangles)
    }
}
