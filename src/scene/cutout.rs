//! Pictures that cut parts out of surfaces: leaves on quads, wire fences.
//!
//! A place of a surface is there or it is not: no ray meets a place whose opacity is below the least one. So what a ray hits stays
//! a yes or no, which can be kept from frame to frame; the edge of a leaf is smoothed as any edge is, by the samples of a pixel.

use std::ops::Range;

use glam::Vec2;

use super::{Mesh, Texture};

/// Least opacity of places that are there, where files do not state it.
pub const LEAST_OPACITY: f32 = 0.5;

/// Parts of a material that are there: where the alpha of a picture is large enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutout {
    /// Picture: index into [`Scene::textures`](super::Scene::textures).
    pub map: u32,
    /// Least alpha of places that are there, above 0 and up to 1.
    pub least: f32,
}

/// Picture that cuts parts out of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    /// Picture whose alpha counts. It shares its texels with the scene's.
    pub texture: Texture,
    /// See [`Cutout::least`].
    pub least: f32,
}

/// Triangles of a mesh that are cut out, which follow each other in [`Mesh::triangles`].
#[derive(Debug, Clone, PartialEq)]
pub struct CutTriangles {
    /// Number of the first one.
    pub first: u32,
    /// Index into `masks` for each of them. Never empty.
    pub mask_of: Vec<u16>,
    /// Pictures.
    pub masks: Vec<Mask>,
}

impl CutTriangles {
    /// Numbers of the triangles.
    pub fn range(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + self.mask_of.len()
    }
}

/// Answers whether places of cut-out triangles are there, for a tracer.
#[derive(Debug)]
pub struct CutoutTest {
    first: u32,
    /// Texture coordinates of each triangle's corners, and the index of its mask.
    triangles: Vec<([Vec2; 3], u16)>,
    masks: Vec<Mask>,
}

impl CutoutTest {
    /// Creates the test for the triangles of `mesh` that are cut out. `None` if none is.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let cut = mesh.cut.as_deref()?;
        let corners = |triangle: usize| mesh.triangles[triangle].map(|corner| mesh.uvs[corner as usize]);
        let triangles = cut.range().zip(&cut.mask_of).map(|(triangle, mask)| (corners(triangle), *mask));
        Some(Self { first: cut.first, triangles: triangles.collect(), masks: cut.masks.clone() })
    }

    /// Number of the first triangle that is cut out.
    pub fn first(&self) -> u32 {
        self.first
    }

    /// Returns true if the place of `triangle` with the weights `u` and `v` of its second and third corner is
    /// there. `triangle`: by its number in the mesh; one that is not cut out is there as a whole.
    pub fn is_there(&self, triangle: u32, u: f32, v: f32) -> bool {
        let at = triangle.checked_sub(self.first).and_then(|at| self.triangles.get(at as usize));
        at.is_none_or(|([a, b, c], mask)| {
            let Mask { texture, least } = &self.masks[usize::from(*mask)];
            texture.alpha(*a * (1.0 - u - v) + *b * u + *c * v) >= *least
        })
    }
}
