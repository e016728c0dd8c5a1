//! What graphs compute of places on meshes: colours, parameters that vary, heights.

use glam::{Affine3A, Vec2, Vec3};

use super::OnMesh;
use crate::graph::{Place, UvSet};
use crate::scene::cutout::ALL_BUT_OPAQUE;
use crate::scene::look::Varied;
use crate::scene::material::{Bump, Computed, Computes};
use crate::scene::shared_exponent::SharedExponent;
use crate::scene::{Material, Scene, Texture};

impl OnMesh<'_> {
    /// Reflectance of `material`, with its texture, its graph and the colours of vertices as factors; its diffuse and ambient reflectances
    /// are shares of it. Then the parameters of the material that vary, there.
    #[inline]
    pub fn appearance(&self, scene: &Scene, material: &Material) -> (Vec3, Varied) {
        let textured = self.textured(scene, material);
        let painted = if material.has_vertex_colors { textured * self.vertex_color() } else { textured };
        match &material.computed {
            Some(computed) => self.computed(scene, computed, painted),
            None => (painted, Varied::NONE),
        }
    }

    /// Reflectance alone: see [`appearance`](Self::appearance).
    pub fn reflectance(&self, scene: &Scene, material: &Material) -> Vec3 {
        self.appearance(scene, material).0
    }

    /// What graphs make of the place, of which `painted` is the reflectance otherwise. Not inlined: most surfaces have none.
    #[inline(never)]
    fn computed(&self, scene: &Scene, computed: &Computed, painted: Vec3) -> (Vec3, Varied) {
        let values = computed.program.values(&PlaceOfGraph { on: self, textures: &scene.textures });
        let value = |of| computed.numbers[of].map(|number| values[number]);
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
        (painted * color, varied)
    }

    /// Normal of a surface with these heights (J. Blinn, "Simulation of wrinkled surfaces", 1978; by the gradient on the surface, as in M.
    /// Mikkelsen, "Bump mapping unparametrized surfaces on the GPU", 2010, and in Cycles): that of the surface, less the gradient of the
    /// heights along it. `None` if the triangle has no area or heights bend nothing of this mesh.
    pub(super) fn raised(
        &self,
        scene: &Scene,
        bump: &Bump,
        normal: Vec3,
        [a, b, c]: [Vec3; 3],
    ) -> Option<Vec3> {
        let (mesh, [u, v]) = (self.mesh, self.weights);
        let space = mesh.space_of_heights()?;
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

/// A place on a mesh, and the pictures of the shot, as graphs see them.
#[derive(Debug)]
pub struct PlaceOfGraph<'a> {
    /// The place.
    pub on: &'a OnMesh<'a>,
    /// Pictures of the shot.
    pub textures: &'a [Texture],
}

impl PlaceOfGraph<'_> {
    /// The place in the space of the mesh's positions, at rest.
    pub fn position(&self) -> Vec3 {
        let OnMesh { mesh, primitive, weights: [u, v], .. } = *self.on;
        if let Some(quadric) = &mesh.quadric {
            return quadric.point(primitive, [u, v]);
        }
        let [a, b, c] = self.corners();
        a * (1.0 - u - v) + b * u + c * v
    }

    fn corners(&self) -> [Vec3; 3] {
        let positions = self.on.mesh.positions.as_slice();
        self.on.mesh.triangles[self.on.primitive as usize]
            .map(|corner| Vec3::from(positions[corner as usize]))
    }
}

impl Place for PlaceOfGraph<'_> {
    fn uv(&self, set: UvSet) -> Vec2 {
        self.on.uv_of(set)
    }

    fn point(&self) -> Vec3 {
        let position = self.position();
        self.on.mesh.details.space.map_or(position, |space| space.to_object.transform_point3(position))
    }

    fn generated(&self) -> Vec3 {
        let point = self.point();
        self.on.mesh.details.space.map_or(point, |space| (point - space.low) / space.size)
    }

    fn normal(&self) -> Vec3 {
        let OnMesh { mesh, primitive, weights: [u, v], .. } = *self.on;
        let normal = match &mesh.quadric {
            Some(quadric) => quadric.normal(primitive, [u, v]),
            None => {
                let [a, b, c] = self.corners();
                let of_face = (b - a).cross(c - a);
                let corner = |corner: u32| mesh.normals.get(corner as usize).copied().unwrap_or_default();
                let [a, b, c] = mesh.triangles[primitive as usize].map(corner);
                let smooth = a * (1.0 - u - v) + b * u + c * v;
                if smooth == Vec3::ZERO { of_face } else { smooth }
            }
        };
        // normals are mapped by the transposed inverse, which the map to object space is that of the map into the world
        let normal = match mesh.details.space {
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
