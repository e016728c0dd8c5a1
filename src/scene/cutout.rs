//! Pictures that cut parts out of surfaces: leaves on quads, wire fences.
//!
//! A place of a surface is there or it is not: no ray meets a place whose opacity is below the least one. So what a ray hits stays
//! a yes or no, which can be kept from frame to frame; the edge of a leaf is smoothed as any edge is, by the samples of a pixel.

use std::ops::Range;
use std::sync::Arc;

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
    texture: Texture,
    /// See [`Cutout::least`].
    least: f32,
    /// State of the squares between each texel's centre and those of the next ones, to the right and below.
    squares: Arc<[Square]>,
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
        Self { texture, least, squares }
    }

    /// Returns true if the place at `uv` is there.
    pub fn is_there(&self, uv: Vec2) -> bool {
        let between = self.texture.between(uv);
        match self.squares[between.first()] {
            Square::There => true,
            Square::Gone => false,
            Square::Both => self.texture.alpha_between(&between) >= self.least,
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

    /// Returns true if the place of `triangle` with the weights `u` and `v` of its second and third corner is
    /// there. `triangle`: by its number in the mesh; one that is not cut out is there as a whole.
    pub fn is_there(&self, triangle: u32, u: f32, v: f32) -> bool {
        let at = triangle.checked_sub(self.first).and_then(|at| self.triangles.get(at as usize));
        at.is_none_or(|([a, b, c], mask)| {
            self.masks[usize::from(*mask)].is_there(*a * (1.0 - u - v) + *b * u + *c * v)
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
                assert_eq!(mask.is_there(uv), is_there, "{uv}");
                there += u32::from(is_there);
            }
            assert!((1000..13400).contains(&there), "{there}");
        }
    }
}
