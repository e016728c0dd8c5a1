//! Attributes of a place on a mesh, by pictures and vertices: texture coordinates, material, reflectance, bent normals.

mod computed;
mod tangent;

use glam::{Affine3A, Vec2, Vec3};

pub use computed::{PlaceOfGraph, appearances, displacements, heights};

use super::geometry::{Geometry, Triangles};
use super::look::Varied;
use super::texture::UvSet;
use super::{Material, Mesh, Model, Scene, Texture};

/// A place on a primitive of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct OnMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Number of the triangle, or of the curved primitive.
    pub primitive: u32,
    /// Weights of the second and third corner, or of the place on a curved primitive.
    pub weights: [f32; 2],
    /// Map to the world of files of the model that it is on: see [`Model::to_world`].
    pub to_world: Option<&'a Affine3A>,
    /// Number of the model that it is on: see [`Model::random`].
    pub random: f32,
    /// Width of the part of the surface over which textures are filtered, object space; 0: they are shown texel by texel.
    pub width: f32,
    /// See [`Place::facing`](crate::graph::Place::facing).
    pub facing: f32,
}

impl<'a> OnMesh<'a> {
    /// Creates the place with these weights.
    pub fn new(mesh: &'a Mesh, primitive: u32, weights: [f32; 2]) -> Self {
        Self { mesh, primitive, weights, to_world: None, random: 0.0, width: 0.0, facing: 1.0 }
    }

    /// Creates the place with these weights on the mesh of a model.
    pub fn on(model: &'a Model, primitive: u32, weights: [f32; 2]) -> Self {
        Self {
            to_world: model.to_world.as_ref(),
            random: model.random,
            ..Self::new(&model.mesh, primitive, weights)
        }
    }

    /// This place, with textures filtered over a part of the surface that is `width` wide.
    pub fn with_width(self, width: f32) -> Self {
        Self { width, ..self }
    }

    /// This place, seen at an angle with this cosine: see [`Place::facing`](crate::graph::Place::facing).
    pub fn seen_at(self, facing: f32) -> Self {
        Self { facing, ..self }
    }

    /// Texture coordinates; zero if the mesh has none.
    #[inline]
    pub fn uv(&self) -> Vec2 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let Triangles { corners, uvs, .. } = match &mesh.geometry {
            Geometry::Triangles(triangles) => triangles,
            Geometry::Curved(curved) => return curved.uv(primitive, [u, v]),
        };
        let [a, b, c] = corners[primitive as usize].map(|corner| corner as usize);
        match uvs.as_slice() {
            [] => Vec2::ZERO,
            uvs => uvs[a] * (1.0 - u - v) + uvs[b] * u + uvs[c] * v,
        }
    }

    /// Texture coordinates of a set; zero if the mesh does not have it.
    #[inline]
    pub(super) fn uv_of(&self, set: UvSet) -> Vec2 {
        match set {
            UvSet::First => self.uv(),
            UvSet::Second => self.second_uv(),
        }
    }

    /// Second set of texture coordinates. Not inlined: hardly any surface has it.
    #[inline(never)]
    fn second_uv(&self) -> Vec2 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let uv = |corner: u32| mesh.details.second_uvs.get(corner as usize).copied().unwrap_or_default();
        let Some(Triangles { corners, .. }) = mesh.as_triangles() else { return Vec2::ZERO };
        let [a, b, c] = corners[primitive as usize].map(uv);
        a * (1.0 - u - v) + b * u + c * v
    }

    /// The place in the space of the mesh's positions, at rest.
    pub fn position(&self) -> Vec3 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        match &mesh.geometry {
            Geometry::Triangles(triangles) => {
                let [a, b, c] = triangles.positions_of(primitive);
                a * (1.0 - u - v) + b * u + c * v
            }
            Geometry::Curved(curved) => curved.point(primitive, [u, v]),
        }
    }

    /// Corners of its triangle, in the space of the mesh's positions, at rest; of one that touches a curved primitive about there.
    #[inline]
    pub(super) fn corners(&self) -> [Vec3; 3] {
        match &self.mesh.geometry {
            Geometry::Triangles(triangles) => triangles.positions_of(self.primitive),
            Geometry::Curved(curved) => self.steps_of_weights().map(|at| curved.point(self.primitive, at)),
        }
    }

    /// Texture coordinates at the [corners](Self::corners); zero if the mesh does not have the set.
    #[inline]
    fn uvs_of_corners(&self, set: UvSet) -> [Vec2; 3] {
        match &self.mesh.geometry {
            Geometry::Triangles(triangles) => {
                let uvs = self.mesh.uvs_of(set);
                let uv = |corner: u32| uvs.get(corner as usize).copied().unwrap_or_default();
                triangles.corners[self.primitive as usize].map(uv)
            }
            Geometry::Curved(curved) => self.steps_of_weights().map(|at| curved.uv(self.primitive, at)),
        }
    }

    /// Its weights, and a [`STEP`] of either beside them.
    fn steps_of_weights(&self) -> [[f32; 2]; 3] {
        let [u, v] = self.weights;
        [[u, v], [u + STEP, v], [u, v + STEP]]
    }

    /// Normal of the curved surface for which its triangle stands, at rest, of any length, on the outside: nothing bends it.
    pub fn normal(&self) -> Vec3 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let Triangles { corners, normals, .. } = match &mesh.geometry {
            Geometry::Triangles(triangles) => triangles,
            Geometry::Curved(curved) => return curved.normal(primitive, [u, v]),
        };
        let corner = |corner: u32| normals.get(corner as usize).copied().unwrap_or_default();
        let [a, b, c] = corners[primitive as usize].map(corner);
        let smooth = a * (1.0 - u - v) + b * u + c * v;
        if smooth != Vec3::ZERO {
            return smooth;
        }
        let [a, b, c] = self.corners();
        (b - a).cross(c - a)
    }

    /// Index of the material.
    #[inline]
    pub fn material(&self) -> u16 {
        self.mesh.material_of[self.primitive as usize]
    }

    /// Emission of its material, there: radiance, linear RGB.
    pub fn emission(&self, scene: &Scene) -> Vec3 {
        let material = &scene.materials[usize::from(self.material())];
        let varied = if material.varies() { self.appearance(scene, material).1 } else { Varied::NONE };
        material.emission_at(varied)
    }

    /// [`reflectance`](Self::reflectance) without the colours of vertices and graphs.
    #[inline(always)]
    pub fn textured(&self, scene: &Scene, material: &Material) -> Vec3 {
        self.textured_beside(scene, material, &mut LastDensity::default())
    }

    /// [`textured`](Self::textured), for places of which many are on the triangle of the `last` one.
    #[inline(always)]
    pub fn textured_beside(&self, scene: &Scene, material: &Material, last: &mut LastDensity<'a>) -> Vec3 {
        match material.diffuse_map {
            Some(map) => material.painted() * self.texture_color(&scene.textures[map as usize], last),
            None => material.painted(),
        }
    }

    /// Colour of a texture. Not inlined: surfaces without one would have to jump over it.
    #[inline(never)]
    fn texture_color(&self, texture: &Texture, last: &mut LastDensity<'a>) -> Vec3 {
        texture.color(self.uv_of(texture.mapping.uvs), self.level_beside(texture, last))
    }

    /// Level of `texture` in which a texel is as large as the place.
    #[inline]
    pub(super) fn level(&self, texture: &Texture) -> u32 {
        self.level_beside(texture, &mut LastDensity::default())
    }

    /// [`level`](Self::level), for places of which many are on the triangle of the `last` one.
    #[inline]
    fn level_beside(&self, texture: &Texture, last: &mut LastDensity<'a>) -> u32 {
        if self.width > 0.0 {
            let set = texture.mapping.uvs;
            let density = last.of(self, set).unwrap_or_else(|| {
                let density = self.uv_density(set);
                last.note(self, set, density);
                density
            });
            texture.level_of(self.width * self.width * density)
        } else {
            0
        }
    }

    /// Area in the plane of a set of texture coordinates for each unit of area on the surface, object space; 0 where there is none.
    fn uv_density(&self, set: UvSet) -> f32 {
        let ([a, b, c], [at_a, at_b, at_c]) = (self.corners(), self.uvs_of_corners(set));
        let on_surface = (b - a).cross(c - a).length();
        let density = (at_b - at_a).perp_dot(at_c - at_a).abs() / on_surface;
        if density.is_finite() { density } else { 0.0 }
    }

    /// Colour that the vertices have; white without any.
    pub(super) fn vertex_color(&self) -> Vec3 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let colors = &mesh.details.colors;
        if colors.is_empty() {
            return Vec3::ONE;
        }
        let color = |corner: u32| Vec3::from(colors[corner as usize].map(f32::from));
        let triangles = match &mesh.geometry {
            Geometry::Triangles(triangles) => triangles,
            Geometry::Curved(curved) => {
                let Some(([from, to], share)) = curved.vertices(primitive, [u, v]) else { return Vec3::ONE };
                return color(from).lerp(color(to), share);
            }
        };
        let [a, b, c] = triangles.corners[primitive as usize].map(color);
        a * (1.0 - u - v) + b * u + c * v
    }

    /// Normal as the place's material bends it, by a normal map or by heights; `normal` itself without either. `corners`: of the triangle,
    /// in the space and the shape of `normal`, which has unit length and is on the outside.
    pub fn bent_normal(&self, scene: &Scene, normal: Vec3, corners: [Vec3; 3]) -> Vec3 {
        let normal = self.mapped_normal(scene, normal, corners);
        match &scene.materials[usize::from(self.material())].bump {
            Some(bump) => self.raised(bump, heights(&[*self], scene, bump)[0], normal, corners),
            None => normal,
        }
    }

    /// Normal as the normal map of the place's material bends it; `normal` itself without one: see [`bent_normal`](Self::bent_normal).
    /// [`raised`](Self::raised) is what heights make of it.
    pub fn mapped_normal(&self, scene: &Scene, normal: Vec3, corners: [Vec3; 3]) -> Vec3 {
        let material = &scene.materials[usize::from(self.material())];
        let bent = || {
            let map = material.normal_map?;
            let tangents = self.mesh.details.tangents.get(self.primitive as usize)?;
            let [a, b, c] = corners;
            let [along, up] = tangents.axes(self.weights, [b - a, c - a], normal)?;
            let texture = &scene.textures[map.map as usize];
            let Vec3 { x, y, z } = texture.vector(self.uv_of(texture.mapping.uvs), self.level(texture));
            // what points into the surface comes from wrong or enlarged pictures
            let out = z.max(LEAST_OUT);
            (along * (x * map.slope) + up * (y * map.slope) + normal * out).try_normalize()
        };
        bent().unwrap_or(normal)
    }
}

/// Density of texture coordinates on the triangle where it was found last: neighbours mostly lie on one.
#[derive(Debug, Default)]
pub struct LastDensity<'a>(Option<(&'a Mesh, u32, UvSet, f32)>);

impl<'a> LastDensity<'a> {
    /// The density at a place, if that is on the same triangle.
    #[inline(always)]
    fn of(&self, place: &OnMesh, of_set: UvSet) -> Option<f32> {
        let (mesh, primitive, set, density) = self.0?;
        let is_same = std::ptr::eq(mesh, place.mesh) && primitive == place.primitive && set == of_set;
        is_same.then_some(density)
    }

    /// Notes the density at a place. On curved primitives it is another one in each place.
    #[inline(always)]
    fn note(&mut self, place: &OnMesh<'a>, set: UvSet, density: f32) {
        if !place.mesh.is_curved() {
            self.0 = Some((place.mesh, place.primitive, set, density));
        }
    }
}

/// Step of a curved primitive's weights between the places that tell how its texture coordinates lie on it.
const STEP: f32 = 1.0 / 1024.0;

/// Least part of a normal map's vector that points out of the surface.
const LEAST_OUT: f32 = 0.01;
