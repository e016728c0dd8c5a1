//! Triangles with the vertex data that shading needs, or a quadric.

use std::collections::BTreeSet;
use std::sync::Arc;

use embree::VertexBuffer;
use glam::{DVec3, Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::Shapes;
use super::cutout::CutTriangles;
use super::details::Details;
use crate::geometry::{Bounds, Quadric};

/// Number of triangles that one thread handles in one go.
const BLOCK: usize = 1 << 14;

/// A triangle mesh in object space, or a quadric.
///
/// A quadric's pieces are numbered as triangles are. For each there is a stand-in among the triangles, which no ray meets: its
/// corners span the box around the piece, so that whatever asks corners for boxes need not know quadrics.
///
/// All per-vertex lists have either no entry or one a vertex.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Vertex positions. Finite, shared with Embree.
    pub positions: Arc<VertexBuffer>,
    /// Triangles as indices into the per-vertex lists, counter-clockwise seen from outside. Never empty.
    pub triangles: Arc<Vec<[u32; 3]>>,
    /// Vertex normals of unit length, or zero if the file's was unusable (the face's normal is used then).
    pub normals: Vec<Vec3>,
    /// Texture coordinates: v = 0 at the bottom of the picture, as in OBJ.
    pub uvs: Vec<Vec2>,
    /// Number of `triangles`, from the first on, that cast shadows. Shadow rays pass the rest.
    pub shadow_casting: usize,
    /// Index into [`Scene::materials`](super::Scene::materials) for each triangle.
    pub material_of: Vec<u16>,
    /// Names that the file gives to parts of the mesh.
    pub groups: Arc<Groups>,
    /// Triangles of which alpha cuts parts out; the mesh has texture coordinates or alphas then.
    pub cut: Option<Arc<CutTriangles>>,
    /// Quadric that is seen instead of the triangles.
    pub quadric: Option<Arc<Quadric>>,
    /// Vertex positions by shape, if the mesh deforms. Then `positions` is the shape at rest: samples on the
    /// mesh keep the point in that shape.
    pub shapes: Option<Arc<Shapes>>,
    /// Colours, alphas and tangents, where it has any.
    pub details: Arc<Details>,
}

/// Groups of a mesh's triangles, as OBJ files name them with `g` and `o`.
#[derive(Debug, Clone, PartialEq)]
pub struct Groups {
    /// Distinct names.
    names: Vec<String>,
    /// Runs of consecutive triangles of the same group: the first triangle and the number of the group. In
    /// order; the first run begins at triangle 0.
    begins: Vec<(u32, u32)>,
}

impl Default for Groups {
    /// Puts all triangles in one group.
    fn default() -> Self {
        Self { names: vec![String::from("default")], begins: vec![(0, 0)] }
    }
}

impl Groups {
    /// Creates groups with these names, without triangles yet.
    pub fn named(names: impl Iterator<Item = String>) -> Self {
        Self { names: names.collect(), begins: Vec::new() }
    }

    /// Puts all triangles from number `first` on in this group. `first` rises from call to call.
    pub fn begin(&mut self, first: u32, group: u32) {
        if self.begins.last().is_none_or(|(_, last)| *last != group) {
            self.begins.push((first, group));
        }
    }

    /// Runs of consecutive triangles of the same group: the first triangle and the number of the group, in order.
    pub fn runs(&self) -> &[(u32, u32)] {
        &self.begins
    }

    /// Numbers of the groups that have triangles.
    pub fn used(&self) -> BTreeSet<usize> {
        self.begins.iter().map(|(_, group)| *group as usize).collect()
    }

    /// Names by number. The first is that of triangles that the file puts in no group.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of a triangle's group.
    #[inline]
    pub fn of(&self, triangle: u32) -> usize {
        let after = match &self.begins[..] {
            [_] => 1,
            begins => begins.partition_point(|(first, _)| *first <= triangle),
        };
        self.begins[after - 1].1 as usize
    }
}

impl Mesh {
    /// Returns true if its surface has texture coordinates.
    pub fn has_uvs(&self) -> bool {
        self.quadric.is_some() || !self.uvs.is_empty()
    }

    /// Creates a quadric of one material.
    pub fn of_quadric(quadric: Quadric, material: u16, casts_shadow: bool) -> Self {
        let count = quadric.count();
        let corners = |piece| {
            let Bounds { low, high } = quadric.bounds(piece);
            [low, high, low.with_y(high.y)].map(|corner| corner.to_array())
        };
        Self {
            positions: Arc::new(VertexBuffer::new((0..count).flat_map(corners).collect())),
            triangles: Arc::new((0..count).map(|piece| [0, 1, 2].map(|corner| 3 * piece + corner)).collect()),
            normals: Vec::new(),
            uvs: Vec::new(),
            shadow_casting: if casts_shadow { count as usize } else { 0 },
            material_of: vec![material; count as usize],
            groups: Arc::default(),
            cut: None,
            quadric: Some(Arc::new(quadric)),
            shapes: None,
            details: Arc::default(),
        }
    }

    /// Vertex positions, object space: in each of its shapes, if it deforms.
    fn all_positions(&self) -> impl Iterator<Item = &[[f32; 3]]> {
        let own = self.shapes.is_none().then_some(self.positions.as_slice());
        let shapes = self.shapes.iter().flat_map(|shapes| shapes.list()).map(Vec::as_slice);
        own.into_iter().chain(shapes)
    }

    /// The smallest box around the vertices that triangles use, object space, in all shapes. Unused vertices
    /// must not make the model seem larger than it is.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let all = self.all_positions().map(|positions| self.bounds_of(positions));
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        all.fold(nothing, |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    fn bounds_of(&self, positions: &[[f32; 3]]) -> (DVec3, DVec3) {
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
    /// Computes the box around all vertices of `mesh`, object space, in all of its shapes, whether a triangle
    /// uses them or not.
    pub fn of(mesh: &Mesh) -> Self {
        mesh.all_positions().flatten().fold(Self::EMPTY, |all, point| all.with(Vec3::from_array(*point)))
    }
}
