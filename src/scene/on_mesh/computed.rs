//! What graphs compute of places on meshes: colours, parameters that vary, heights.

use std::array;

use glam::{Affine3A, Vec2, Vec3};

use super::{LastDensity, OnMesh};
use crate::graph::{Place, Places, Program, UvSet};
use crate::lanes::{LANES, Vec3x8};
use crate::scene::cutout::ALL_BUT_OPAQUE;
use crate::scene::look::Varied;
use crate::scene::material::{Bump, Computed, Computes};
use crate::scene::shared_exponent::SharedExponent;
use crate::scene::{Material, Scene, Texture};

impl<'a> OnMesh<'a> {
    /// Reflectance of `material`, with its texture, its graph and the colours of vertices as factors; its diffuse and ambient reflectances
    /// are shares of it. Then the parameters of the material that vary, there.
    #[inline]
    pub fn appearance(&self, scene: &Scene, material: &Material) -> (Vec3, Varied) {
        let painted = self.painted(scene, material);
        match &material.computed {
            Some(computed) => {
                let [(factor, varied), ..] = appearances(&[*self], scene, computed);
                (painted * factor, varied)
            }
            None => (painted, Varied::NONE),
        }
    }

    /// Reflectance alone: see [`appearance`](Self::appearance).
    pub fn reflectance(&self, scene: &Scene, material: &Material) -> Vec3 {
        self.appearance(scene, material).0
    }

    /// Reflectance without what graphs compute.
    #[inline]
    pub fn painted(&self, scene: &Scene, material: &Material) -> Vec3 {
        self.painted_beside(scene, material, &mut LastDensity::default())
    }

    /// [`painted`](Self::painted), for places of which many are on the triangle of the `last` one.
    #[inline]
    pub fn painted_beside(&self, scene: &Scene, material: &Material, last: &mut LastDensity<'a>) -> Vec3 {
        let textured = self.textured_beside(scene, material, last);
        if material.has_vertex_colors { textured * self.vertex_color() } else { textured }
    }

    /// This place, with its weights moved.
    fn moved(&self, [by_u, by_v]: [f32; 2]) -> Self {
        let [u, v] = self.weights;
        Self { weights: [u + by_u, v + by_v], ..*self }
    }

    /// Two steps of one length at a right angle, in the triangle at rest, as weights of its second and third corner. `None` if it has no
    /// area or heights bend nothing of this mesh.
    fn steps(&self) -> Option<[[f32; 2]; 2]> {
        let space = self.mesh.space_of_heights()?;
        let [at_a, at_b, at_c] = self.corners();
        let (first, second) = (at_b - at_a, at_c - at_a);
        let along = first.try_normalize()?;
        let across = (second - along * along.dot(second)).try_normalize()?;
        let step = space.step();
        let of_second = step / across.dot(second);
        Some([[step / first.length(), 0.0], [-of_second * along.dot(second) / first.length(), of_second]])
    }

    /// Normal of a surface with these [`heights`] (J. Blinn, "Simulation of wrinkled surfaces", 1978; by the gradient on the surface, as in
    /// M. Mikkelsen, "Bump mapping unparametrized surfaces on the GPU", 2010, and in Cycles): that of the surface, less the gradient of the
    /// heights along it. `normal` itself if the triangle has no area or heights bend nothing of this mesh. `corners`: see
    /// [`bent_normal`](Self::bent_normal).
    pub fn raised(&self, bump: &Bump, heights: [f32; 3], normal: Vec3, corners: [Vec3; 3]) -> Vec3 {
        self.try_raised(bump, heights, normal, corners).unwrap_or(normal)
    }

    fn try_raised(
        &self,
        bump: &Bump,
        [here, first, second]: [f32; 3],
        normal: Vec3,
        [a, b, c]: [Vec3; 3],
    ) -> Option<Vec3> {
        let (steps, space) = (self.steps()?, self.mesh.space_of_heights()?);
        let [by_first, by_second] =
            [first, second].map(|height| (height - here) * bump.distance * space.size_of_unit());
        // the same steps where the triangle is now
        let [to_first, to_second] = steps.map(|[by_u, by_v]| (b - a) * by_u + (c - a) * by_v);
        let (across_second, across_first) = (to_second.cross(normal), normal.cross(to_first));
        let area = to_first.dot(across_second);
        let gradient = across_second * by_first + across_first * by_second;
        let raised = (normal * area.abs() - gradient * area.signum()).try_normalize()?;
        normal.lerp(raised, bump.strength).try_normalize()
    }
}

/// What graphs make of up to eight places of one material, one for each lane: factors of their reflectances otherwise, and parameters that
/// vary. Not inlined: most surfaces have none.
#[inline(never)]
pub fn appearances(places: &[OnMesh], scene: &Scene, computed: &Computed) -> [(Vec3, Varied); LANES] {
    let values = values(&computed.program, places, &scene.textures);
    array::from_fn(|lane| {
        let value = |of| computed.numbers[of].map(|number| values[number].lane(lane));
        let share = |of| value(of).map_or(1.0, |value| value.x);
        let opacity = Some(share(Computes::Opacity)).filter(|share| *share < ALL_BUT_OPAQUE).unwrap_or(1.0);
        let highlight = value(Computes::Highlight).map(Varied::rounded_highlight);
        let varied = Varied {
            roughness: Varied::rounded(share(Computes::Roughness)),
            metalness: Varied::rounded(share(Computes::Metalness)),
            opacity: Varied::rounded(opacity),
            highlight: highlight.unwrap_or(Varied::NONE.highlight),
            emission: value(Computes::Emission).map_or(Varied::NONE.emission, SharedExponent::new),
        };
        let color = value(Computes::Color).map_or(Vec3::ONE, |color| color.clamp(Vec3::ZERO, Vec3::ONE));
        (color, varied)
    })
}

/// Values of a program at up to eight places, one for each lane.
fn values(program: &Program, places: &[OnMesh], textures: &[Texture]) -> [Vec3x8; Program::MOST_VALUES] {
    let Some(first) = places.first() else { return [Vec3x8::ZERO; Program::MOST_VALUES] };
    let of_graph: [PlaceOfGraph; LANES] =
        array::from_fn(|lane| PlaceOfGraph { on: places.get(lane).unwrap_or(first), textures });
    let of_graph = of_graph.each_ref().map(|place| place as &dyn Place);
    program.values(Places::new(&of_graph[..places.len().min(LANES)]))
}

/// Heights at up to eight places of one material, and after each of their two steps.
pub fn heights(places: &[OnMesh], scene: &Scene, bump: &Bump) -> [[f32; 3]; LANES] {
    let mut heights = [[0.0; 3]; LANES];
    let Some(first) = places.first() else { return heights };
    let mut all = [*first; 3 * LANES];
    for (at, place) in all.chunks_exact_mut(3).zip(places) {
        let [first, second] = place.steps().unwrap_or_default();
        at.copy_from_slice(&[[0.0; 2], first, second].map(|step| place.moved(step)));
    }
    let asked = &all[..3 * places.len().min(LANES)];
    for (heights, places) in heights.as_flattened_mut().chunks_exact_mut(LANES).zip(asked.chunks(LANES)) {
        heights.copy_from_slice(values(&bump.height, places, &scene.textures)[0].x.values());
    }
    heights
}

/// What a program gives at up to eight places.
pub fn displacements(places: &[OnMesh], textures: &[Texture], program: &Program) -> [Vec3; LANES] {
    let [given, ..] = values(program, places, textures);
    array::from_fn(|lane| given.lane(lane))
}

/// A place on a mesh, and the pictures of the shot, as graphs see them.
#[derive(Debug)]
pub struct PlaceOfGraph<'a> {
    /// The place.
    pub on: &'a OnMesh<'a>,
    /// Pictures of the shot.
    pub textures: &'a [Texture],
}

impl Place for PlaceOfGraph<'_> {
    fn uv(&self, set: UvSet) -> Vec2 {
        self.on.uv_of(set)
    }

    fn point(&self) -> Vec3 {
        let position = self.on.position();
        self.on.mesh.details.space.map_or(position, |space| space.to_object.transform_point3(position))
    }

    fn generated(&self) -> Vec3 {
        let point = self.point();
        self.on.mesh.details.space.map_or(point, |space| (point - space.low) / space.size)
    }

    fn normal(&self) -> Vec3 {
        let normal = self.on.normal();
        // normals are mapped by the transposed inverse, which the map to object space is that of the map into the world
        let normal = match self.on.mesh.details.space {
            Some(space) => space.to_object.matrix3.inverse().transpose() * normal,
            None => normal,
        };
        normal.normalize_or(Vec3::Z)
    }

    fn world_point(&self) -> Vec3 {
        let point = self.point();
        self.on.to_world.map_or(point, |map| map.transform_point3(point))
    }

    fn world_normal(&self) -> Vec3 {
        let normal = self.normal();
        let in_world = |map: &Affine3A| (map.matrix3.inverse().transpose() * normal).normalize_or(normal);
        self.on.to_world.map_or(normal, in_world)
    }

    fn model_place(&self) -> Vec3 {
        self.on.to_world.map_or(Vec3::ZERO, |map| map.translation.into())
    }

    fn model_random(&self) -> f32 {
        self.on.random
    }

    fn vertex_color(&self) -> Vec3 {
        self.on.vertex_color()
    }

    fn facing(&self) -> f32 {
        self.on.facing
    }

    fn picture(&self, number: u32, at: Option<Vec2>) -> [f32; 4] {
        let Some(texture) = self.textures.get(number as usize) else { return [0.0; 4] };
        let (uv, level) = match at {
            None => (self.on.uv_of(texture.mapping.uvs), self.on.level(texture)),
            Some(uv) => (uv, 0),
        };
        let Vec3 { x, y, z } = texture.value(uv, level);
        [x, y, z, texture.alpha_between(&texture.between(uv))]
    }
}
