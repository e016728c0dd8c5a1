//! Details of a mesh's surface that few meshes have: colours, alphas and more texture coordinates of its vertices, directions for
//! normal maps, and the space of graphs.

use std::sync::Arc;

use bevy_mikktspace::{Geometry, TangentSpace};
use glam::{Affine3A, DAffine3, DVec3, Vec2, Vec3};
use half::f16;

use super::cage::Cage;
use super::texture::UvSet;
use super::volume::Volume;
use super::{Material, Mesh, Triangles};
use crate::geometry::Bounds;

/// Details of a mesh; a list without entries where it has none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Details {
    /// Colours of the vertices, linear RGB: a factor of the reflectance.
    pub colors: Vec<[f16; 3]>,
    /// Second set of texture coordinates, by vertex, for textures that [take it](super::texture::UvSet).
    pub second_uvs: Vec<Vec2>,
    /// Alphas of the vertices, 0 to 1, where they [cut out](super::cutout) parts.
    pub alphas: Vec<f32>,
    /// Directions of the first texture coordinate, by triangle.
    pub tangents: Vec<Tangents>,
    /// Space in which [graphs](crate::graph) see the mesh, if a material of it has one.
    pub space: Option<ObjectSpace>,
    /// Values in what it is around.
    pub volume: Option<Arc<Volume>>,
    /// Cage that the mesh stands for until it is diced. A shot that was loaded has none.
    pub(crate) cage: Option<Arc<Cage>>,
}

/// Object space as the mesh's file has it, also where the mesh was placed in the world since.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectSpace {
    /// Map of the mesh's positions to that space.
    pub to_object: Affine3A,
    /// Lowest corner of the box around the mesh in that space, at rest.
    pub low: Vec3,
    /// Size of that box. Along an axis along which the mesh is flat the box is 2 wide around it, as Blender's.
    pub size: Vec3,
}

impl ObjectSpace {
    /// That of positions which are in it.
    pub fn around(positions: &[[f32; 3]]) -> Self {
        Self::in_box(positions.iter().map(|place| Vec3::from(*place)).fold(Bounds::EMPTY, Bounds::with))
    }

    /// That of what is in this box.
    pub fn in_box(Bounds { low, high }: Bounds) -> Self {
        let is_flat = high.cmple(low);
        let size = Vec3::select(is_flat, Vec3::splat(2.0), high - low);
        let low = Vec3::select(is_flat, low - 1.0, low);
        Self { to_object: Affine3A::IDENTITY, low, size }
    }

    /// Length of the steps by which the slope of heights is found, in the space of the mesh's positions: far less than what is seen of a
    /// mesh, and far more than the rounding of its positions.
    pub fn step(&self) -> f32 {
        self.size.max_element() * self.size_of_unit() / 4096.0
    }

    /// Length of a unit of object space, in the space of the mesh's positions.
    pub fn size_of_unit(&self) -> f32 {
        let volume = self.to_object.matrix3.determinant().abs();
        if volume > 0.0 { volume.cbrt().recip() } else { 1.0 }
    }

    /// The same, of positions that `map` has placed.
    pub fn placed(self, map: DAffine3) -> Self {
        let to_object = self.to_object.as_daffine3() * map.inverse();
        Self {
            to_object: if to_object.is_finite() { to_object.as_affine3a() } else { self.to_object },
            ..self
        }
    }
}

/// Directions in which the first texture coordinate grows at the corners of a triangle.
///
/// They are stated by the triangle's edges, so that they go with it wherever it is moved, mapped or deformed: a direction is so
/// much of the edge from the first corner to the second, and so much of that to the third. It is the tangent, moved along the
/// corner's normal into the plane of the triangle: without its part along the normal it is the tangent again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangents {
    /// Shares of the two edges, by corner.
    pub corners: [Vec2; 3],
    /// True if the picture is seen as in a mirror: the second texture coordinate grows to the other side.
    pub is_mirrored: bool,
}

/// Colour of a vertex as it is kept: shares from 0 to 1, where what is no number is black.
pub fn vertex_color(light: [f32; 3]) -> [f16; 3] {
    light.map(|share| f16::from_f32(if share > 0.0 { share.min(1.0) } else { 0.0 }))
}

impl Details {
    /// Details of the mesh's mirror image, whose second and third corners have changed places.
    pub fn mirrored(&self) -> Self {
        let turned = |Tangents { corners: [a, b, c], is_mirrored }: &Tangents| {
            let corners = [a, c, b].map(|shares| Vec2::new(shares.y, shares.x));
            Tangents { corners, is_mirrored: !is_mirrored }
        };
        Self { tangents: self.tangents.iter().map(turned).collect(), ..self.clone() }
    }
}

impl Tangents {
    /// Along the first edge: for triangles whose texture coordinates say nothing.
    const ALONG_AN_EDGE: Self = Self { corners: [Vec2::X; 3], is_mirrored: false };

    /// Creates the tangents of a triangle with these corners and normals from `tangents`, of any length.
    pub fn new(corners: [Vec3; 3], normals: [Vec3; 3], tangents: [Vec3; 3], is_mirrored: bool) -> Self {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3());
        let edges = [b - a, c - a];
        let shares = |normal: Vec3, tangent: Vec3| in_edges(edges, normal.as_dvec3(), tangent.as_dvec3());
        let all = [0, 1, 2].map(|corner| shares(normals[corner], tangents[corner]));
        match all {
            [Some(first), Some(second), Some(third)] => Self { corners: [first, second, third], is_mirrored },
            _ => Self { is_mirrored, ..Self::ALONG_AN_EDGE },
        }
    }

    /// Tangent at weights `u`, `v` of the second and third corner of a triangle with these edges, and normal to a unit `normal`;
    /// then the direction in which the second texture coordinate grows. `None` if the tangent has no direction there.
    pub fn axes(&self, [u, v]: [f32; 2], edges: [Vec3; 2], normal: Vec3) -> Option<[Vec3; 2]> {
        let [first, second, third] = self.corners;
        let shares = first * (1.0 - u - v) + second * u + third * v;
        let along = edges[0] * shares.x + edges[1] * shares.y;
        let along = (along - normal * normal.dot(along)).try_normalize()?;
        let up = normal.cross(along);
        Some([along, if self.is_mirrored { -up } else { up }])
    }
}

/// Shares of two edges that make up a tangent, once it is moved along `normal` into their plane.
fn in_edges([first, second]: [DVec3; 2], normal: DVec3, tangent: DVec3) -> Option<Vec2> {
    let face = first.cross(second);
    let square = face.length_squared();
    let lean = normal.dot(face);
    // a normal that lies in the triangle leads nowhere: the tangent is dropped onto it instead
    let normal = if lean.abs() > 1e-3 * normal.length() * square.sqrt() { normal } else { face };
    let inside = tangent - normal * (tangent.dot(face) / normal.dot(face));
    let shares = [inside.cross(second).dot(face) / square, first.cross(inside).dot(face) / square];
    let shares = Vec2::from(shares.map(|share| share as f32));
    (shares.is_finite() && shares != Vec2::ZERO).then_some(shares)
}

impl Mesh {
    /// Returns true if it has what a material may need to bend its normals: tangents for pictures, or a space for graphs.
    #[inline]
    pub fn may_bend_normals(&self) -> bool {
        !self.details.tangents.is_empty() || self.space_of_heights().is_some()
    }

    /// Returns true if it has what this material needs to bend its normals.
    pub fn is_bent_by(&self, material: &Material) -> bool {
        let by_picture = material.normal_map.is_some() && !self.details.tangents.is_empty();
        by_picture || material.bump.is_some() && self.space_of_heights().is_some()
    }

    /// The space in which heights bend its normals, if they do: not those of curved geometry, whose weights are none of corners.
    #[inline]
    pub fn space_of_heights(&self) -> Option<ObjectSpace> {
        self.details.space.filter(|_| !self.is_curved())
    }

    /// One of its sets of texture coordinates; empty if it has none.
    pub fn uvs_of(&self, set: UvSet) -> &[Vec2] {
        match set {
            UvSet::First => self.as_triangles().map_or(&[], |triangles| &triangles.uvs),
            UvSet::Second => &self.details.second_uvs,
        }
    }

    /// Tangents of all triangles of a mesh with texture coordinates: those of its vertices if all have one, and computed ones
    /// otherwise; none for other geometry. `uvs`: the texture coordinates of a material's normal map.
    pub(crate) fn tangents(&self, of_vertices: &[[f32; 4]], uvs: impl Fn(u16) -> UvSet) -> Vec<Tangents> {
        let Some(triangles) = self.as_triangles() else { return Vec::new() };
        let stated = |triangle: usize| {
            let vertex = |corner: u32| of_vertices.get(corner as usize).copied();
            let [a, b, c] = triangles.corners[triangle].map(vertex);
            let corners = [a?, b?, c?];
            let tangents = corners.map(|[x, y, z, _]| Vec3::new(x, y, z));
            let is_good = |tangent: Vec3| tangent.is_finite() && tangent != Vec3::ZERO;
            let (places, normals) =
                (corner_positions(triangles, triangle), corner_normals(triangles, triangle));
            let all = || Tangents::new(places, normals, tangents, corners[0][3] < 0.0);
            tangents.into_iter().all(is_good).then(all)
        };
        let all: Option<Vec<Tangents>> = (0..triangles.corners.len()).map(stated).collect();
        all.unwrap_or_else(|| self.computed_tangents(triangles, uvs))
    }

    /// Computes the tangents of all triangles as the programs do that make normal maps
    /// (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008; the crate is the one that Bevy keeps up).
    fn computed_tangents(&self, triangles: &Triangles, uvs: impl Fn(u16) -> UvSet) -> Vec<Tangents> {
        let tangents = vec![Tangents::ALONG_AN_EDGE; triangles.corners.len()];
        let mut corners = CornersOfMesh { mesh: self, triangles, uvs, tangents, given: [Vec3::ZERO; 3] };
        // it fails for triangles alone that it is not told of
        let _ = bevy_mikktspace::generate_tangents(&mut corners);
        corners.tangents
    }
}

/// Positions of a triangle's corners, object space.
fn corner_positions(triangles: &Triangles, triangle: usize) -> [Vec3; 3] {
    triangles.positions_of(triangle as u32)
}

/// Normals at a triangle's corners: its own where the mesh has none.
fn corner_normals(triangles: &Triangles, triangle: usize) -> [Vec3; 3] {
    let [a, b, c] = corner_positions(triangles, triangle).map(|corner| corner.as_dvec3());
    let own = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3();
    let normal = |corner: u32| triangles.normals.get(corner as usize).copied().unwrap_or(own);
    triangles.corners[triangle].map(normal).map(|normal| if normal == Vec3::ZERO { own } else { normal })
}

/// A mesh, as the algorithm asks for it.
struct CornersOfMesh<'a, F> {
    mesh: &'a Mesh,
    triangles: &'a Triangles,
    /// Texture coordinates of a material's normal map.
    uvs: F,
    tangents: Vec<Tangents>,
    /// Tangents of the triangle whose corners are being given.
    given: [Vec3; 3],
}

impl<F: Fn(u16) -> UvSet> Geometry for CornersOfMesh<'_, F> {
    fn num_faces(&self) -> usize {
        self.triangles.corners.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        corner_positions(self.triangles, face)[corner].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        corner_normals(self.triangles, face)[corner].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let uvs = self.mesh.uvs_of((self.uvs)(self.mesh.material_of[face]));
        let vertex = self.triangles.corners[face][corner] as usize;
        uvs.get(vertex).copied().unwrap_or_default().to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some(space) = space else { return };
        self.given[corner] = Vec3::from_array(space.tangent());
        if corner == 2 {
            let is_mirrored = space.tangent_encoded()[3] < 0.0;
            let (corners, normals) =
                (corner_positions(self.triangles, face), corner_normals(self.triangles, face));
            self.tangents[face] = Tangents::new(corners, normals, self.given, is_mirrored);
        }
    }
}
