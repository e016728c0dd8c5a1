//! Alpha that cuts parts out of surfaces, of pictures and of vertices: leaves on quads, wire fences.
//!
//! A place of a surface is there or it is not: no ray meets a place whose opacity is below the least one. So what a ray hits stays
//! a yes or no, which can be kept from frame to frame; the edge of a leaf is smoothed as any edge is, by the samples of a pixel.
//!
//! A surface whose alpha is *blended* is there wherever it shows at all, and each place of it is a veil as clear as its alpha says:
//! as the sample [keeps it](super::look::Varied::opacity). Shadows stay a yes or no there, too: a shadow ray is stopped as often as a place
//! is opaque, by a number that belongs to a small part of the surface. So the shadow is right in the mean over many samples, the
//! sooner as the numbers of neighbouring parts are even, and the same ray always has the same answer.

pub mod outline;

use std::ops::Range;
use std::sync::Arc;

use glam::Vec2;

use super::on_mesh::{OnMesh, PlaceOfGraph};
use super::texture::Placement;
use super::{Mesh, Texture};
use crate::graph::Program;
use crate::scrambled::scrambled;

/// Least opacity of places that are there, where files do not state it.
pub const LEAST_OPACITY: f32 = 0.5;

/// Least opacity of places of blended surfaces that are there: half a step of a picture of 8 bits.
const LEAST_SEEN: f32 = 0.5 / 255.0;

/// Cosine of the angle at which shadow rays see what is there in part by the angle at which it is seen: their own does not count, so that
/// a shadow does not change as a light goes round. 45 degrees.
const ASLANT: f32 = std::f32::consts::FRAC_1_SQRT_2;

/// Opacity from which on places of blended surfaces are opaque: pictures that were compressed are not quite, and veils take rays.
pub const ALL_BUT_OPAQUE: f32 = 252.0 / 255.0;

/// What a ray asks of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asks {
    /// Whether it is seen: by the eye, by a path.
    Sight,
    /// Whether it keeps light from what is behind it.
    Shadow,
}

/// Parts of a material that are there: where its alpha is large enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cutout {
    /// Picture whose alpha counts: index into [`Scene::textures`](super::Scene::textures).
    pub map: Option<u32>,
    /// True if the alpha of vertices is a factor of it, where a mesh has that.
    pub by_vertices: bool,
    /// True if its material [computes](super::material::Computed::opacity) its alpha.
    pub by_graph: bool,
    /// Least alpha of places that are there, above 0.
    pub least: f32,
    /// Where alpha is blended: opacity of places whose alpha is 1.
    pub blended: Option<f32>,
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
        Self { map: Some(map), ..Self::below(least) }
    }

    /// Creates the cut-out of places where an alpha that is still to be named is below `least`.
    pub fn below(least: f32) -> Self {
        Self { map: None, by_vertices: false, by_graph: false, least, blended: None }
    }

    /// Creates the cut-out of a surface that blends with what is behind it by the alpha that its material computes, where `solid` is its
    /// opacity where that is 1.
    pub fn by_graph(solid: f32) -> Self {
        Self { by_graph: true, blended: Some(solid), ..Self::below(LEAST_SEEN) }
    }

    /// Creates the cut-out of a surface that blends with what is behind it by the alpha of picture number `map`, where `solid` is its
    /// opacity where that is 1.
    pub fn blended(map: u32, solid: f32) -> Self {
        Self { blended: Some(solid), ..Self::by_picture(map, LEAST_SEEN) }
    }

    /// The part of it that counts on a mesh with this vertex data, if there is any.
    pub fn on_mesh(self, has: VertexData) -> Option<Self> {
        let cutout =
            Self { map: self.map.filter(|_| has.uvs), by_vertices: self.by_vertices && has.alphas, ..self };
        (cutout.map.is_some() || cutout.by_vertices || cutout.by_graph).then_some(cutout)
    }
}

/// Alpha that cuts parts out of triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    alpha: Alpha,
    /// See [`Cutout::least`].
    least: f32,
    /// See [`Cutout::blended`].
    blended: Option<f32>,
}

/// Alpha of a mask. Pictures share their texels with the scene's.
#[derive(Debug, Clone, PartialEq)]
enum Alpha {
    /// That of a picture.
    Picture {
        texture: Texture,
        /// Place of its texels: at hand, because every ray that meets the surface asks for it.
        placement: Placement,
        /// State of the squares between each texel's centre and those of the next ones, to the right and below.
        squares: Arc<[Square]>,
    },
    /// That of vertices, times that of a picture if there is one.
    Vertices(Option<Texture>),
    /// That which a graph computes.
    Computed(ComputedAlpha),
}

/// Alpha that a graph computes of each place.
#[derive(Debug, Clone, PartialEq)]
struct ComputedAlpha {
    program: Arc<Program>,
    /// Pictures of the shot that it may take.
    textures: Arc<[Texture]>,
}

impl ComputedAlpha {
    /// Returns true if a place is there for a ray that asks this, where `solid` is its opacity where its alpha is 1.
    fn is_there(&self, on: &OnMesh<'_>, asks: Asks, solid: f32) -> bool {
        let on = &if self.program.is_of_eye() { on.seen_at(ASLANT) } else { *on };
        let place = PlaceOfGraph { on, textures: &self.textures };
        let alpha = self.program.value(&place).x;
        match asks {
            // how much of it is seen follows from who sees it: nothing at the least
            Asks::Sight => alpha >= LEAST_SEEN || self.program.is_of_eye(),
            Asks::Shadow => {
                let alpha = if alpha < ALL_BUT_OPAQUE { alpha } else { 1.0 };
                alpha * solid > chance_of(on.primitive, part_of(&place))
            }
        }
    }
}

/// Column and row of a part of a triangle that has a number of its own, in the plane of two axes to which the triangle is turned most.
fn part_of(place: &PlaceOfGraph<'_>) -> [u32; 2] {
    let [a, b, c] = place.on.corners();
    let [x, y, z] = (b - a).cross(c - a).abs().to_array();
    let (from_a, edge) = (place.on.position() - a, (b - a).abs().max((c - a).abs()).max_element());
    let [across, down] = match () {
        () if z >= x && z >= y => [from_a.x, from_a.y],
        () if y >= x => [from_a.x, from_a.z],
        () => [from_a.y, from_a.z],
    };
    // a cast of what is no number is 0
    [across, down].map(|way| ((way / edge + 1.0) * PARTS_OF_TRIANGLE) as u32)
}

/// Parts along the longest edge of a triangle.
const PARTS_OF_TRIANGLE: f32 = 1024.0;

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
    /// The table that it has of a picture: where it is, which tells it from others, and its bytes.
    pub fn table(&self) -> Option<(usize, u64)> {
        match &self.alpha {
            Alpha::Picture { squares, .. } => Some((squares.as_ptr().addr(), size_of_val(&**squares) as u64)),
            Alpha::Vertices(_) | Alpha::Computed(_) => None,
        }
    }

    /// Creates the mask of a cut-out whose alpha `program` computes, of these pictures of the shot.
    pub fn computed(cutout: Cutout, program: Arc<Program>, textures: Arc<[Texture]>) -> Self {
        let alpha = Alpha::Computed(ComputedAlpha { program, textures });
        Self { alpha, least: cutout.least, blended: cutout.blended }
    }

    /// Creates the mask of a cut-out, whose picture is `texture`.
    pub fn new(cutout: Cutout, texture: Option<Texture>) -> Self {
        let Cutout { least, blended, .. } = cutout;
        let alpha = match texture {
            Some(texture) if !cutout.by_vertices => {
                let (placement, squares) = (texture.placement(), squares_of(&texture, least));
                Alpha::Picture { texture, placement, squares }
            }
            texture => Alpha::Vertices(texture),
        };
        Self { alpha, least, blended }
    }

    /// Returns true if the alpha of vertices counts.
    fn asks_vertices(&self) -> bool {
        matches!(self.alpha, Alpha::Vertices(_))
    }

    /// Place in the picture of texture coordinates.
    fn place_of(&self, uv: Vec2) -> Vec2 {
        match &self.alpha {
            Alpha::Picture { placement, .. } => placement.mapping.at(uv),
            Alpha::Vertices(texture) => {
                texture.as_ref().map_or(uv, |texture| texture.placement().mapping.at(uv))
            }
            Alpha::Computed(_) => uv,
        }
    }

    /// Returns true if a `triangle` is there at this `place` in the picture, for a ray that asks this, where `of_vertices` gives the
    /// alpha of the vertices.
    #[inline(always)]
    pub fn is_there(
        &self,
        (triangle, place): (u32, Vec2),
        asks: Asks,
        of_vertices: impl FnOnce() -> f32,
    ) -> bool {
        match &self.alpha {
            Alpha::Picture { texture, placement, squares } => {
                let square = squares[placement.first_at(place)];
                match square {
                    Square::Gone => false,
                    Square::There if asks == Asks::Sight || self.blended.is_none() => true,
                    _ => self.is_between((texture, placement), (triangle, place), asks),
                }
            }
            Alpha::Vertices(texture) => {
                let of_picture = texture
                    .as_ref()
                    .map_or(1.0, |texture| texture.alpha_between(&texture.placement().between_at(place)));
                of_vertices() * of_picture >= self.least
            }
            // asked by the place on the mesh
            Alpha::Computed(_) => true,
        }
    }

    /// Asks the alpha between texels. Not inlined: most places are in squares that are there, or gone, as a whole.
    #[inline(never)]
    fn is_between(
        &self,
        (texture, placement): (&Texture, &Placement),
        (triangle, place): (u32, Vec2),
        asks: Asks,
    ) -> bool {
        let between = placement.between_at(place);
        let alpha = texture.alpha_between(&between);
        match self.blended {
            Some(solid) if asks == Asks::Shadow => {
                let alpha = if alpha < ALL_BUT_OPAQUE { alpha } else { 1.0 };
                alpha * solid > chance_of(triangle, between.part(PARTS, texture.size()[0]))
            }
            _ => alpha >= self.least,
        }
    }
}

/// Parts of a texel in each direction that have a number of their own: tracers find places that differ in their last bits, and hardly
/// ever another part.
const PARTS: u32 = 4;

/// A number from 0 to below 1 that belongs to a part of a triangle's picture, by the part's column and row.
///
/// The numbers of each square of 2ⁿ x 2ⁿ parts, n up to [`LEVELS`], lie in the 4ⁿ equal ranges from 0 to 1, one in each: rays that
/// pass near each other are stopped in nearly the right proportion, and shadows have less grain than by numbers that know nothing of
/// each other. The order is random: for each square and each size, by Owen's scrambling along the Morton curve (Ahmed and Wonka,
/// "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020).
fn chance_of(triangle: u32, [mut column, mut row]: [u32; 2]) -> f32 {
    let mut number = 0;
    for level in 0..LEVELS {
        let quarter = column & 1 | (row & 1) << 1;
        [column, row] = [column >> 1, row >> 1];
        let hash = scrambled(scrambled(scrambled(triangle ^ level << 28) ^ column) ^ row);
        number = number << 2 | (quarter ^ hash & 3);
        if level + 1 == LEVELS {
            number = number << BITS_BELOW | hash >> (32 - BITS_BELOW);
        }
    }
    number as f32 / (1 << (2 * LEVELS + BITS_BELOW)) as f32
}

/// Sizes of squares whose numbers are even: up to eight texels.
const LEVELS: u32 = 5;
/// Bits of the numbers that are left to chance.
const BITS_BELOW: u32 = 14;

/// State of the squares of a texture, where places are there whose alpha is at least `least`.
fn squares_of(texture: &Texture, least: f32) -> Arc<[Square]> {
    let [width, height] = texture.size().map(|edge| edge as usize);
    let is_there =
        |x: usize, y: usize| texture.texels().get(y % height * width + x % width).alpha() / 255.0 >= least;
    let square = |i: usize| {
        let (x, y) = (i % width, i / width);
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        match corners.iter().filter(|(x, y)| is_there(*x, *y)).count() {
            0 => Square::Gone,
            4 => Square::There,
            _ => Square::Both,
        }
    };
    (0..width * height).map(square).collect()
}

/// Triangles of a mesh that are cut out, which follow each other in [`Triangles::corners`](super::Triangles::corners).
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
    triangles: Vec<Cut>,
    /// Alphas of each triangle's corners; none at all if no mask asks for them.
    alphas: Vec<[f32; 3]>,
    masks: Vec<Mask>,
    /// The mesh, if a mask computes alpha of its places.
    mesh: Option<Box<Mesh>>,
}

/// A triangle that is cut out.
#[derive(Debug)]
struct Cut {
    /// Place of its first corner in the mask's picture, and the ways from there to the others.
    first: Vec2,
    ways: [Vec2; 2],
    /// Index of the mask.
    mask: u16,
}

impl CutoutTest {
    /// Creates the test for the triangles of `mesh` that are cut out. `None` if none is.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let cut = mesh.cut.as_deref()?;
        let all = mesh.as_triangles()?;
        let uv = |corner: u32| all.uvs.get(corner as usize).copied().unwrap_or_default();
        let place = |(triangle, mask): (usize, &u16)| {
            let [a, b, c] =
                all.corners[triangle].map(|corner| cut.masks[usize::from(*mask)].place_of(uv(corner)));
            Cut { first: a, ways: [b - a, c - a], mask: *mask }
        };
        let triangles = cut.range().zip(&cut.mask_of).map(place);
        let alpha = |corner: u32| mesh.details.alphas.get(corner as usize).copied().unwrap_or(1.0);
        let alphas = match cut.masks.iter().any(Mask::asks_vertices) {
            true => cut.range().map(|triangle| all.corners[triangle].map(alpha)).collect(),
            false => Vec::new(),
        };
        let is_computed = cut.masks.iter().any(|mask| matches!(mask.alpha, Alpha::Computed(_)));
        let mesh = is_computed.then(|| Box::new(mesh.clone()));
        Some(Self {
            first: cut.first,
            triangles: triangles.collect(),
            alphas,
            masks: cut.masks.clone(),
            mesh,
        })
    }

    /// Returns true if the place of `triangle` with the `weights` of its second and third corner is there, for a ray that asks this.
    /// `triangle`: by its number in the mesh; one that is not cut out is there as a whole.
    #[inline]
    pub fn is_there(&self, triangle: u32, [u, v]: [f32; 2], asks: Asks) -> bool {
        let number = triangle.wrapping_sub(self.first);
        let Some(Cut { first, ways: [to_second, to_third], mask }) = self.triangles.get(number as usize)
        else {
            return true;
        };
        let mask = &self.masks[usize::from(*mask)];
        if let (Alpha::Computed(alpha), Some(mesh)) = (&mask.alpha, &self.mesh) {
            return alpha.is_there(&OnMesh::new(mesh, triangle, [u, v]), asks, mask.blended.unwrap_or(1.0));
        }
        let place = *first + *to_second * u + *to_third * v;
        mask.is_there((triangle, place), asks, || {
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
            let mask = Mask::new(Cutout::by_picture(0, LEAST_OPACITY), Some(texture.clone()));
            let place = |i: u16| (f32::from(i) - 60.0) / 37.0;
            let mut there = 0;
            for (x, y) in (0..120).flat_map(|x| (0..120).map(move |y| (x, y))) {
                let uv = Vec2::new(place(x), place(y));
                let is_there = texture.alpha_between(&texture.between(uv)) >= LEAST_OPACITY;
                let is_seen = mask.is_there((0, mapping.at(uv)), Asks::Sight, || f32::NAN);
                assert_eq!(is_seen, is_there, "{uv}");
                there += u32::from(is_there);
            }
            assert!((1000..13400).contains(&there), "{there}");
        }
    }

    /// What is blended is seen wherever it shows at all, and stops as much light as it is opaque.
    #[test]
    fn blended_places_cast_shadows_as_often_as_they_are_opaque() {
        let texels = (0..=255).map(|alpha| [0, 0, 0, alpha]).collect();
        let texture = Texture::of_bytes(PathBuf::new(), [256, 1], texels, Mapping::default());
        for solid in [1.0_f32, 0.8] {
            let mask = Mask::new(Cutout::blended(0, solid), Some(texture.clone()));
            for alpha in 0..=255_u8 {
                let uv = Vec2::new((f32::from(alpha) + 0.5) / 256.0, 0.5);
                assert_eq!(mask.is_there((0, uv), Asks::Sight, || 1.0), alpha > 0, "{alpha} of {solid}");
                let casts = |triangle: &u32| mask.is_there((*triangle, uv), Asks::Shadow, || 1.0);
                let count = (0..10_000).filter(casts).count() as f32;
                let share = if alpha < 252 { f32::from(alpha) / 255.0 } else { 1.0 };
                let expected = share * solid * 1e4;
                assert!(share * solid < 1.0 || count == 1e4, "{alpha}: {count}");
                // four times the standard deviation
                assert!((count - expected).abs() <= 200.0, "{alpha} of {solid}: {count}");
            }
        }
    }

    /// Half of a picture that is half opaque is there, in any small part of it.
    #[test]
    fn shadows_of_blended_places_are_even() {
        let texture =
            Texture::of_bytes(PathBuf::new(), [16, 16], Arc::from([[0, 0, 0, 128]; 256]), Mapping::default());
        let mask = Mask::new(Cutout::blended(0, 1.0), Some(texture));
        // squares of four texels by as many: 256 parts, of which by chance alone 8 more or fewer would be there
        for triangle in 0..20 {
            for (x, y) in (0..3).flat_map(|x| (0..3).map(move |y| (x, y))) {
                let parts = (0..16).flat_map(|right| (0..16).map(move |down| (right, down)));
                let is_there = |(right, down): &(u32, u32)| {
                    let at = |texel: u32, part: u32| (4 * texel) as f32 + 0.5 + (part as f32 + 0.5) / 4.0;
                    let uv = Vec2::new(at(x, *right) / 16.0, 1.0 - at(y, *down) / 16.0);
                    mask.is_there((triangle, uv), Asks::Shadow, || 1.0)
                };
                let count = parts.filter(is_there).count();
                assert!(count.abs_diff(128) <= 1, "triangle {triangle}, {x} {y}: {count}");
            }
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
            let cutout = Cutout { by_vertices: true, ..Cutout::by_picture(0, 0.3) };
            let mask = Mask::new(cutout, texture);
            for alpha in [0.0, 0.29, 0.31, 0.74, 0.76, 1.0] {
                assert_eq!(
                    mask.is_there((0, uv), Asks::Shadow, || alpha),
                    alpha * of_picture >= 0.3,
                    "{alpha} times {of_picture}"
                );
            }
        }
    }
}
