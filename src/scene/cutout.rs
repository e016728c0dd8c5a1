//! Alpha that cuts parts out of surfaces, of pictures and of vertices: leaves on quads, wire fences.
//!
//! A place of a surface is there or it is not: no ray meets a place whose opacity is below the least one. So what a ray hits stays
//! a yes or no, which can be kept from frame to frame; the edge of a leaf is smoothed as any edge is, by the samples of a pixel.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec2;

use super::{Mesh, Texture};

/// Least opacity of places that are there, where files do not state it.
pub const LEAST_OPACITY: f32 = 0.5;

/// Parts of a material that are there: where its alpha is large enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutout {
    /// Picture whose alpha counts: index into [`Scene::textures`](super::Scene::textures).
    pub map: Option<u32>,
    /// True if the alpha of vertices is a factor of it, where a mesh has that.
    pub by_vertices: bool,
    /// Least alpha of places that are there, above 0.
    pub least: f32,
}

/// Vertex data that a mesh has, of which cut-outs need one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VertexData {
    /// True for texture coordinates.
    pub uvs: bool,
    /// True for alphas.
    pub alphas: bool,
}

impl Cutout {
    /// Creates the cut-out of places where the alpha of picture number `map` is below `least`.
    pub fn by_picture(map: u32, least: f32) -> Self {
        Self { map: Some(map), by_vertices: false, least }
    }

    /// The part of it that counts on a mesh with this vertex data, if there is any.
    pub fn on_mesh(self, has: VertexData) -> Option<Self> {
        let cutout =
            Self { map: self.map.filter(|_| has.uvs), by_vertices: self.by_vertices && has.alphas, ..self };
        (cutout.map.is_some() || cutout.by_vertices).then_some(cutout)
    }
}

/// Alpha that cuts parts out of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    alpha: Alpha,
    /// See [`Cutout::least`].
    least: f32,
}

/// Alpha of a mask. Pictures share their texels with the scene's.
#[derive(Debug, Clone, PartialEq)]
enum Alpha {
    /// That of a picture.
    Picture {
        texture: Texture,
        /// State of the squares between each texel's centre and those of the next ones, to the right and below.
        squares: Arc<[Square]>,
    },
    /// That of vertices, times that of a picture if there is one.
    Vertices(Option<Texture>),
}

/// A square between the centres of four texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Square {
    /// All of it is there.
    There,
    /// None of it is there.
    Gone,
    /// Its alpha has to be interpolated.
    Both,
}

impl Mask {
    /// Creates a mask of the places where the alpha of `texture` is at least `least`.
    pub fn new(texture: Texture, least: f32) -> Self {
        let [width, height] = texture.size().map(|edge| edge as usize);
        let is_there = |x: usize, y: usize| {
            texture.texels().get(y % height * width + x % width).alpha() / 255.0 >= least
        };
        let square = |i: usize| {
            let (x, y) = (i % width, i / width);
            let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            match corners.iter().filter(|(x, y)| is_there(*x, *y)).count() {
                0 => Square::Gone,
                4 => Square::There,
                _ => Square::Both,
            }
        };
        let squares = (0..width * height).map(square).collect();
        Self { alpha: Alpha::Picture { texture, squares }, least }
    }

    /// Creates a mask of the places where the alpha of vertices, times that of `texture`, is at least `least`.
    pub fn by_vertices(texture: Option<Texture>, least: f32) -> Self {
        Self { alpha: Alpha::Vertices(texture), least }
    }

    /// Returns true if the alpha of vertices counts.
    fn asks_vertices(&self) -> bool {
        matches!(self.alpha, Alpha::Vertices(_))
    }

    /// Returns true if the place at `uv` is there, where `of_vertices` gives the alpha of the vertices.
    #[inline]
    pub fn is_there(&self, uv: Vec2, of_vertices: impl FnOnce() -> f32) -> bool {
        match &self.alpha {
            Alpha::Picture { texture, squares } => {
                let between = texture.between(uv);
                match squares[between.first()] {
                    Square::There => true,
                    Square::Gone => false,
                    Square::Both => texture.alpha_between(&between) >= self.least,
                }
            }
            Alpha::Vertices(texture) => {
                let of_picture =
                    texture.as_ref().map_or(1.0, |texture| texture.alpha_between(&texture.between(uv)));
                of_vertices() * of_picture >= self.least
            }
        }
    }
}

/// Triangles of a mesh that are cut out, which follow each other in [`Mesh::triangles`].
#[derive(Debug, Clone, PartialEq)]
pub struct CutTriangles {
    /// Number of the first one.
    pub first: u32,
    /// Index into `masks` for each of them. Never empty.
    pub mask_of: Vec<u16>,
    /// Masks that cut them.
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
    /// Alphas of each triangle's corners; none at all if no mask asks for them.
    alphas: Vec<[f32; 3]>,
    masks: Vec<Mask>,
}

impl CutoutTest {
    /// Creates the test for the triangles of `mesh` that are cut out. `None` if none is.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let cut = mesh.cut.as_deref()?;
        let uv = |corner: u32| mesh.uvs.get(corner as usize).copied().unwrap_or_default();
        let corners = |triangle: usize| mesh.triangles[triangle].map(uv);
        let triangles = cut.range().zip(&cut.mask_of).map(|(triangle, mask)| (corners(triangle), *mask));
        let alpha = |corner: u32| mesh.details.alphas.get(corner as usize).copied().unwrap_or(1.0);
        let alphas = match cut.masks.iter().any(Mask::asks_vertices) {
            true => cut.range().map(|triangle| mesh.triangles[triangle].map(alpha)).collect(),
            false => Vec::new(),
        };
        Some(Self { first: cut.first, triangles: triangles.collect(), alphas, masks: cut.masks.clone() })
    }

    /// Returns true if the place of `triangle` with the weights `u` and `v` of its second and third corner is
    /// there. `triangle`: by its number in the mesh; one that is not cut out is there as a whole.
    pub fn is_there(&self, triangle: u32, u: f32, v: f32) -> bool {
        let Some(number) = triangle.checked_sub(self.first) else { return true };
        let Some(([a, b, c], mask)) = self.triangles.get(number as usize) else { return true };
        let uv = *a * (1.0 - u - v) + *b * u + *c * v;
        self.masks[usize::from(*mask)].is_there(uv, || {
            let [a, b, c] = self.alphas[number as usize];
            a * (1.0 - u - v) + b * u + c * v
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::scene::texture::{Mapping, Wrap};

    /// The look-up by squares says what interpolation says, at any place, repeating and clamped.
    #[test]
    fn masks_are_interpolated_alpha() {
        let alpha = [[0, 255, 255, 40], [255, 255, 255, 0], [0, 10, 200, 100]];
        let texels = alpha.as_flattened().iter().map(|alpha| [0, 0, 0, *alpha]).collect();
        let repeating = Texture::of_bytes(PathBuf::new(), [4, 3], texels, Mapping::default());
        for wrap in [Wrap::Clamp, Wrap::Mirror, Wrap::Repeat] {
            let mapping = Mapping::scaled(Vec2::new(1.5, -1.0), Vec2::new(0.2, 0.1), [wrap; 2]);
            let texture = Texture { mapping, ..repeating.clone() };
            let mask = Mask::new(texture.clone(), LEAST_OPACITY);
            let place = |i: u16| (f32::from(i) - 60.0) / 37.0;
            let mut there = 0;
            for (x, y) in (0..120).flat_map(|x| (0..120).map(move |y| (x, y))) {
                let uv = Vec2::new(place(x), place(y));
                let is_there = texture.alpha_between(&texture.between(uv)) >= LEAST_OPACITY;
                assert_eq!(mask.is_there(uv, || f32::NAN), is_there, "{uv}");
                there += u32::from(is_there);
            }
            assert!((1000..13400).contains(&there), "{there}");
        }
    }

    /// Alphas of vertices are interpolated, and a factor of the picture's.
    #[test]
    fn alphas_of_vertices_are_a_factor() {
        let texels = Arc::from([[0, 0, 0, 255], [0, 0, 0, 102]]);
        let texture = Texture::of_bytes(PathBuf::new(), [2, 1], texels, Mapping::default());
        let [opaque, veil] = [Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.5)];
        for (texture, uv, of_picture) in
            [(None, veil, 1.0), (Some(texture.clone()), opaque, 1.0), (Some(texture), veil, 0.4)]
        {
            let mask = Mask::by_vertices(texture, 0.3);
            for alpha in [0.0, 0.29, 0.31, 0.74, 0.76, 1.0] {
                assert_eq!(
                    mask.is_there(uv, || alpha),
                    alpha * of_picture >= 0.3,
                    "{alpha} times {of_picture}"
                );
            }
        }
    }
}
