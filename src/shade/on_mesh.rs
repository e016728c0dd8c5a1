//! Attributes of a place on a mesh, by pictures and vertices: texture coordinates, material, reflectance, bent normals.

use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use super::look::Varied;
use super::place_of_graph::PlaceOfGraph;
use crate::graph::Program;
use crate::scene::material::{Bump, Varying};
use crate::scene::texture::UvSet;
use crate::scene::{Material, Mesh, Model, Scene, Texture};

/// A place on a primitive of a mesh.
#[derive(Debug, Clone, Copy)]
pub struct OnMesh<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Number of the triangle, or of the piece of a quadric.
    pub primitive: u32,
    /// Weights of the second and third corner.
    pub weights: [f32; 2],
    /// Map to the world of files of the model that it is on: see [`Model::to_world`].
    pub to_world: Option<&'a Affine3A>,
    /// Width of the part of the surface over which textures are filtered, object space; 0: they are shown texel by texel.
    pub width: f32,
}

impl<'a> OnMesh<'a> {
    /// Creates the place with these weights.
    pub fn new(mesh: &'a Mesh, primitive: u32, weights: [f32; 2]) -> Self {
        Self { mesh, primitive, weights, to_world: None, width: 0.0 }
    }

    /// Creates the place with these weights on the mesh of a model.
    pub fn on(model: &'a Model, primitive: u32, weights: [f32; 2]) -> Self {
        Self { to_world: model.to_world.as_ref(), ..Self::new(&model.mesh, primitive, weights) }
    }

    /// This place, with textures filtered over a part of the surface that is `width` wide.
    pub fn with_width(self, width: f32) -> Self {
        Self { width, ..self }
    }

    /// Texture coordinates; zero if the mesh has none.
    #[inline]
    pub fn uv(&self) -> Vec2 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        if let Some(quadric) = &mesh.quadric {
            return quadric.uv(primitive, [u, v]);
        }
        let [a, b, c] = mesh.triangles[primitive as usize].map(|corner| corner as usize);
        match mesh.uvs.as_slice() {
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
        let [a, b, c] = mesh.triangles[primitive as usize].map(uv);
        a * (1.0 - u - v) + b * u + c * v
    }

    /// Index of the material, variants told apart.
    #[inline]
    pub fn material(&self, scene: &Scene) -> u16 {
        let number = self.mesh.material_of[self.primitive as usize];
        match &scene.materials[usize::from(number)].variants {
            None => number,
            Some(variants) => variants.at(|set| self.uv_of(set)),
        }
    }

    /// Reflectance of `material`, with its texture and the colours of vertices as factors; its diffuse and ambient reflectances
    /// are shares of it.
    #[inline]
    pub fn reflectance(&self, scene: &Scene, material: &Material) -> Vec3 {
        let textured = self.textured(scene, material);
        let painted = if material.has_vertex_colors { textured * self.vertex_color() } else { textured };
        match &material.graph {
            Some(graph) => painted * self.computed(scene, graph),
            None => painted,
        }
    }

    /// [`reflectance`](Self::reflectance) without the colours of vertices.
    #[inline(always)]
    pub fn textured(&self, scene: &Scene, material: &Material) -> Vec3 {
        match material.diffuse_map {
            Some(map) => material.painted() * self.texture_color(&scene.textures[map as usize]),
            None => material.painted(),
        }
    }

    /// What a graph makes of the place, from 0 to 1. Not inlined: most surfaces have none.
    #[inline(never)]
    fn computed(&self, scene: &Scene, graph: &Program) -> Vec3 {
        graph.value(&PlaceOfGraph { on: self, textures: &scene.textures }).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// Parameters of `material` that vary over it.
    #[inline]
    pub fn varied(&self, scene: &Scene, material: &Material) -> Varied {
        match &material.varying {
            None => Varied::NONE,
            Some(varying) => self.parameters(scene, varying),
        }
    }

    /// Not inlined: most surfaces have none.
    #[inline(never)]
    fn parameters(&self, scene: &Scene, varying: &Varying) -> Varied {
        let factor = |graph: &Option<Arc<Program>>| {
            let place = PlaceOfGraph { on: self, textures: &scene.textures };
            graph.as_ref().map_or(u8::MAX, |graph| Varied::rounded(graph.value(&place).x))
        };
        Varied { roughness: factor(&varying.roughness), metalness: factor(&varying.metalness) }
    }

    /// Colour of a texture. Not inlined: surfaces without one would have to jump over it.
    #[inline(never)]
    fn texture_color(&self, texture: &Texture) -> Vec3 {
        texture.color(self.uv_of(texture.mapping.uvs), self.level(texture))
    }

    /// Level of `texture` in which a texel is as large as the place.
    #[inline]
    pub(super) fn level(&self, texture: &Texture) -> u32 {
        if self.width > 0.0 {
            texture.level_of(self.width * self.width * self.uv_density(texture.mapping.uvs))
        } else {
            0
        }
    }

    /// Area in the plane of a set of texture coordinates for each unit of area on the surface, object space; 0 where there is none.
    fn uv_density(&self, set: UvSet) -> f32 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        let ([a, b, c], [at_a, at_b, at_c]) = match &mesh.quadric {
            Some(quadric) => {
                let corners = [[u, v], [u + STEP, v], [u, v + STEP]];
                (corners.map(|at| quadric.point(primitive, at)), corners.map(|at| quadric.uv(primitive, at)))
            }
            None => {
                let corners = mesh.triangles[primitive as usize].map(|corner| corner as usize);
                let positions = mesh.positions.as_slice();
                let uvs = mesh.uvs_of(set);
                let uv = |corner: usize| uvs.get(corner).copied().unwrap_or_default();
                (corners.map(|corner| Vec3::from_array(positions[corner])), corners.map(uv))
            }
        };
        let on_surface = (b - a).cross(c - a).length();
        let density = (at_b - at_a).perp_dot(at_c - at_a).abs() / on_surface;
        if density.is_finite() { density } else { 0.0 }
    }

    /// Colour that the vertices have; white without any.
    pub(super) fn vertex_color(&self) -> Vec3 {
        let Self { mesh, primitive, weights: [u, v], .. } = *self;
        if mesh.details.colors.is_empty() {
            return Vec3::ONE;
        }
        let color = |corner: u32| Vec3::from(mesh.details.colors[corner as usize].map(f32::from));
        let [a, b, c] = mesh.triangles[primitive as usize].map(color);
        a * (1.0 - u - v) + b * u + c * v
    }

    /// Normal as the place's material bends it, by a normal map or by heights; `normal` itself without either. `corners`: of the triangle,
    /// in the space and the shape of `normal`, which has unit length and is on the outside.
    pub fn bent_normal(&self, scene: &Scene, normal: Vec3, corners: [Vec3; 3]) -> Vec3 {
        let material = &scene.materials[usize::from(self.mesh.material_of[self.primitive as usize])];
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
        let bent = bent().unwrap_or(normal);
        match &material.bump {
            Some(bump) => self.raised(scene, bump, bent, corners).unwrap_or(bent),
            None => bent,
        }
    }

    /// Normal of a surface with these heights (J. Blinn, "Simulation of wrinkled surfaces", 1978; by the gradient on the surface, as in M.
    /// Mikkelsen, "Bump mapping unparametrized surfaces on the GPU", 2010, and in Cycles): that of the surface, less the gradient of the
    /// heights along it. `None` if the triangle has no area.
    fn raised(&self, scene: &Scene, bump: &Bump, normal: Vec3, [a, b, c]: [Vec3; 3]) -> Option<Vec3> {
        let (mesh, [u, v]) = (self.mesh, self.weights);
        let space = mesh.details.space?;
        // two steps of one length at a right angle, in the triangle at rest
        let corners = mesh.triangles[self.primitive as usize].map(|corner| corner as usize);
        let [at_a, at_b, at_c] = corners.map(|corner| Vec3::from(mesh.positions.as_slice()[corner]));
        let (first, second) = (at_b - at_a, at_c - at_a);
        let along = first.try_normalize()?;
        let across = (second - along * along.dot(second)).try_normalize()?;
        let step = space.step();
        let of_second = step / across.dot(second);
        let steps =
            [[step / first.length(), 0.0], [-of_second * along.dot(second) / first.length(), of_second]];
        let height = |[by_u, by_v]: [f32; 2]| {
            let on = Self { weights: [u + by_u, v + by_v], ..*self };
            bump.height.value(&PlaceOfGraph { on: &on, textures: &scene.textures }).x
        };
        let here = height([0.0; 2]);
        let [by_first, by_second] =
            steps.map(|step| (height(step) - here) * bump.distance * space.size_of_unit());
        // the same steps where the triangle is now
        let [to_first, to_second] = steps.map(|[by_u, by_v]| (b - a) * by_u + (c - a) * by_v);
        let (across_second, across_first) = (to_second.cross(normal), normal.cross(to_first));
        let area = to_first.dot(across_second);
        let gradient = across_second * by_first + across_first * by_second;
        let raised = (normal * area.abs() - gradient * area.signum()).try_normalize()?;
        normal.lerp(raised, bump.strength).try_normalize()
    }
}

/// Step of a quadric's weights between the places that tell how dense its texture coordinates are.
const STEP: f32 = 1.0 / 1024.0;

/// Least part of a normal map's vector that points out of the surface.
const LEAST_OUT: f32 = 0.01;
