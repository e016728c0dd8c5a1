//! The reflecting layer of metal-rough surfaces, as rays see it: [microfacets](super::ggx), with the light
//! that is reflected between them, above a surface that scatters the light that the layer lets through.
//!
//! - *Each microfacet* reflects what Fresnel's equations say of a dielectric, or Schlick's formula of a metal:
//!   [`fresnel`].
//! - *Light reflected several times* between microfacets is added to the lobe of the first reflection, as a
//!   factor (Turquin, "Practical multiple scattering compensation for microfacet models", 2019), so that a
//!   white metal reflects all light however rough it is. How much it is of a colour, `albedos.rs` says.
//! - *The surface beneath* scatters the light that the layer does not reflect: one less the layer's albedo in
//!   the direction of the ray (albedo scaling, as the OpenPBR and MaterialX specifications have it). It is a
//!   factor for all light that was scattered, wherever that came from. So the light that samples store does not
//!   depend on the eye, and the factor is applied when it is shown.

mod albedos;
#[cfg(test)]
mod furnace;
mod lanes;
mod layer;
#[cfg(test)]
mod walk;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use albedos::{Albedos, Layer};
use lanes::CoatLanes;
pub use lanes::{LayerRays, SeenCoats};
use layer::{Coat, CoatAt, ROUGHNESS_STEPS, VaryingCoat, alpha_of_paths};
pub use layer::{Reflected, SeenBy, SeenCoat};

use crate::lanes::{LANES, Vec3x8};
use crate::scene::Material;
use crate::scene::look::Look;
use crate::scene::material::MetalRough;
use crate::shade::fresnel;

/// Layers of a scene's materials.
#[derive(Debug, Clone, Default)]
pub struct Coats {
    /// Layer of each material, if it has one.
    coats: Vec<Option<Coat>>,
    /// True for each material with a layer; empty if there is none. It is read for all surfaces, most of
    /// which have no layer.
    has: Vec<bool>,
}

/// Layers of a material as the eye and as paths see it, if it has one.
fn layers(material: &Material) -> Option<[Layer; 2]> {
    let metal_rough = material.metal_rough?;
    Some(pair(material, metal_rough))
}

/// A layer of a material as the eye and as paths see it.
fn pair(material: &Material, layer: MetalRough) -> [Layer; 2] {
    let (alpha, index) = (layer.alpha(), fresnel::index_of(layer.head_on));
    let is_glass = material.is_rough_glass();
    [alpha, alpha_of_paths(alpha, is_glass)].map(|alpha| Layer { alpha, index, is_glass })
}

/// Layers of a material whose roughness varies, as the eye and as paths see them, by even steps of it.
fn varying_layers(material: &Material) -> Vec<[Layer; 2]> {
    let Some(metal_rough) = material.metal_rough.filter(|_| material.varies_in_roughness()) else {
        return Vec::new();
    };
    let of_step = |step: usize| {
        let roughness = metal_rough.roughness * step as f32 / ROUGHNESS_STEPS as f32;
        pair(material, MetalRough { roughness, ..metal_rough })
    };
    (0..=ROUGHNESS_STEPS).map(of_step).collect()
}

impl Coats {
    /// Creates the layers of all `materials`.
    pub fn new(materials: &[Material]) -> Self {
        // most materials share their tables with others
        let key = |layer: &Layer| [layer.alpha.to_bits(), layer.index.to_bits(), layer.is_glass.into()];
        let varying = materials.iter().flat_map(varying_layers);
        let all = materials.iter().filter_map(layers).chain(varying).flatten();
        let distinct: BTreeMap<[u32; 3], Layer> = all.map(|layer| (key(&layer), layer)).collect();
        let tables: BTreeMap<[u32; 3], Arc<Albedos>> =
            distinct.into_par_iter().map(|(key, layer)| (key, Arc::new(Albedos::new(layer)))).collect();
        let coats = materials.iter().map(|material| {
            let table = |layer: Layer| Arc::clone(&tables[&key(&layer)]);
            let own = layers(material)?.map(|layer| (layer, table(layer)));
            let by_roughness = varying_layers(material).into_iter().map(|pair| pair.map(table)).collect();
            Some(coat(material, material.metal_rough.as_ref()?, own, by_roughness))
        });
        let coats: Vec<Option<Coat>> = coats.collect();
        let mut has: Vec<bool> = coats.iter().map(Option::is_some).collect();
        if !has.contains(&true) {
            has.clear();
        }
        Self { coats, has }
    }

    #[inline(always)]
    fn get(&self, look: Look) -> Option<CoatAt<'_>> {
        if !self.has(look.material) {
            return None;
        }
        Some(self.coats.get(usize::from(look.material))?.as_ref()?.at(look.varied))
    }

    #[inline(always)]
    fn has(&self, material: u16) -> bool {
        self.has.get(usize::from(material)) == Some(&true)
    }

    /// Returns true if a material has a layer that is not a mirror.
    #[inline(always)]
    pub fn is_rough(&self, look: Look) -> bool {
        self.get(look).is_some_and(|coat| !coat.is_smooth())
    }

    /// Width of the lobe of a material's layer, if it has one that is not a mirror.
    #[inline(always)]
    pub fn alpha_of_rough(&self, look: Look) -> Option<f32> {
        self.get(look).filter(|coat| !coat.is_smooth()).map(|coat| coat.alpha)
    }

    /// Returns true if any of these surfaces has a layer.
    #[inline(always)]
    pub fn any(&self, looks: &[Look]) -> bool {
        !self.has.is_empty() && looks.iter().any(|look| self.has(look.material))
    }

    /// Layer of a surface with these normals (world space) that is seen along `incoming` (unit length), if it
    /// has one.
    #[inline(always)]
    pub fn seen(
        &self,
        look: Look,
        reflectance: Vec3,
        normals: [Vec3; 2],
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> Option<SeenCoat> {
        // most surfaces have none, and this is called for all
        self.get(look).map(|coat| coat.seen(reflectance, normals, incoming, seen_by))
    }

    /// Albedo at normal incidence of eight surfaces whose diffuse albedo is `diffuse`, with that of their layers where these are rough.
    pub fn rough_over(&self, looks: &[Look; LANES], reflectance: Vec3x8, diffuse: Vec3x8) -> Vec3x8 {
        let mut albedo = diffuse;
        if self.any(looks) {
            for (lane, look) in looks.iter().enumerate() {
                if let Some(coat) = self.get(*look).filter(|coat| !coat.is_smooth()) {
                    albedo.set_lane(lane, coat.head_on_over(reflectance.lane(lane), diffuse.lane(lane)));
                }
            }
        }
        albedo
    }

    /// Layers of eight surfaces that are seen along `incoming`, if any has one. `rays`: the rays by which they
    /// reflect, where any do.
    pub fn seen_lanes(
        &self,
        looks: &[Look; LANES],
        reflectance: Vec3x8,
        normals: [Vec3x8; 2],
        incoming: Vec3x8,
        rays: Option<LayerRays>,
    ) -> Option<SeenCoats> {
        if !self.any(looks) {
            return None;
        }
        let lanes = CoatLanes::new(|look| self.get(look), looks);
        let mut all = lanes.seen(reflectance, normals, incoming);
        if let Some(rays) = rays {
            all.follow(normals, rays, |lane| self.is_rough(looks[lane]));
        }
        Some(all)
    }
}

fn coat(
    material: &Material,
    metal_rough: &MetalRough,
    [(layer, albedos), (layer_of_paths, albedos_of_paths)]: [(Layer, Arc<Albedos>); 2],
    by_roughness: Vec<[Arc<Albedos>; 2]>,
) -> Coat {
    let MetalRough { base, metallic, solid, .. } = *metal_rough;
    let (metal, metal_of_kept) = if material.is_painted() {
        // what paints it colours the metal, which is computed from the reflectance that samples store
        (Vec3::ZERO, base / material.painted().max(Vec3::splat(f32::MIN_POSITIVE)))
    } else {
        (base, Vec3::ZERO)
    };
    Coat {
        alpha: layer.alpha,
        metallic,
        metal,
        metal_of_kept,
        index: layer.index,
        solid,
        emission: material.emission,
        albedos,
        alpha_of_paths: layer_of_paths.alpha,
        albedos_of_paths,
        varying: material.varies().then(|| VaryingCoat {
            layer: *metal_rough,
            is_glass: material.is_rough_glass(),
            // none if it does not vary
            by_roughness: by_roughness.try_into().ok(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Graph, Input, Program};
    use crate::scene::look::Varied;
    use crate::scene::material::{ByParameter, Computed, Computes};
    use crate::shade::sampling::PathRandom;

    pub(super) fn material(roughness: f32, metallic: f32, base: f32) -> Material {
        let base = Vec3::splat(base);
        let metal_rough = MetalRough { base, roughness, metallic, head_on: 0.04, solid: 1.0 };
        Material { diffuse: base * (1.0 - metallic), metal_rough: Some(metal_rough), ..Material::fallback() }
    }

    pub(super) fn at(cos: f32) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    pub(super) fn seen(material: &Material, cos: f32) -> SeenCoat {
        let coats = Coats::new(std::slice::from_ref(material));
        coats
            .seen(Look::plain(0), material.painted(), [Vec3::Z; 2], -at(cos), SeenBy::Eye)
            .expect("it has a layer")
    }

    /// Light of a white surface in a white furnace: reflected light, by sampled directions, and scattered
    /// light.
    fn in_a_furnace(material: &Material, cos: f32) -> Vec3 {
        const COUNT: u32 = 4096;
        let seen = seen(material, cos);
        let random = |index| {
            let [along, above, ..] = PathRandom::new(99, index).four(0);
            [along, above]
        };
        let reflected: Vec3 =
            (0..COUNT).filter_map(|index| seen.reflect(random(index))).map(|ray| ray.weight).sum();
        reflected / COUNT as f32 + material.diffuse * seen.through
    }

    #[test]
    fn a_furnace_is_never_exceeded_and_hardly_darkened() {
        for roughness in [0.0, 0.1, 0.3, 0.5, 0.7, 1.0] {
            for metallic in [0.0, 0.5, 1.0] {
                for cos in [1.0, 0.7, 0.3, 0.1, 0.03] {
                    let shown = in_a_furnace(&material(roughness, metallic, 1.0), cos).x;
                    let name = format!("roughness {roughness}, metal {metallic}, cosine {cos}");
                    assert!(shown < 1.005, "{name}: {shown}");
                    assert!(shown > 0.98, "{name}: {shown}");
                }
            }
        }
    }

    #[test]
    fn the_albedo_is_what_rays_bring() {
        for (roughness, metallic, cos) in
            [(0.2, 0.0, 0.4), (0.5, 1.0, 0.9), (0.9, 1.0, 0.2), (0.05, 0.3, 0.1)]
        {
            let material = material(roughness, metallic, 0.7);
            let seen = seen(&material, cos);
            let reflected = in_a_furnace(&material, cos) - material.diffuse * seen.through;
            assert!((reflected - seen.albedo).abs().max_element() < 4e-3, "{reflected}, {}", seen.albedo);
        }
    }

    #[test]
    fn head_on_rough_layers_add_what_they_reflect_and_dim_what_is_beneath() {
        // metal, plastic, half of both, and a mirror, whose rays bring what they show
        let materials = [(0.5, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 1.0)]
            .map(|(roughness, metallic)| material(roughness, metallic, 0.7));
        let coats = Coats::new(&materials);
        for (number, wanted) in [(0, 0.7), (1, 0.04 + 0.7 * 0.96), (2, 0.02 + 0.35 + 0.35 * 0.96), (3, 0.0)] {
            let diffuse = materials[usize::from(number)].diffuse;
            let all = coats.rough_over(
                &[Look::plain(number); LANES],
                Vec3x8::splat(diffuse),
                Vec3x8::splat(diffuse),
            );
            assert!((all.lane(5) - wanted).abs().max_element() < 1e-5, "{number}: {}", all.lane(5));
        }
        let white =
            coats.rough_over(&[Look::plain(1); LANES], Vec3x8::splat(Vec3::ONE), Vec3x8::splat(Vec3::ONE));
        assert!((white.lane(0) - 1.0).abs().max_element() < 1e-5, "white stays white");
        let none = Coats::new(&[Material::fallback()]).rough_over(
            &[Look::plain(0); LANES],
            Vec3x8::ZERO,
            Vec3x8::splat(Vec3::X),
        );
        assert_eq!(none.lane(7), Vec3::X);
    }

    #[test]
    fn a_texture_colours_metal() {
        let mut textured = material(0.4, 1.0, 0.5);
        (textured.diffuse_map, textured.ambient) = (Some(0), Vec3::ZERO);
        let texel = Vec3::new(1.0, 0.5, 0.0);
        let coats = Coats::new(std::slice::from_ref(&textured));
        let of_texture =
            coats.seen(Look::plain(0), textured.painted() * texel, [Vec3::Z; 2], -at(0.8), SeenBy::Eye);
        assert_eq!(of_texture.expect("it has one").fresnel.metal, (texel * 0.5).to_array());
        let dark =
            coats.seen(Look::plain(0), Vec3::ZERO, [Vec3::Z; 2], -at(0.8), SeenBy::Eye).expect("it has one");
        assert_eq!(dark.fresnel.metal, [0.0; 3]);
    }

    /// What varies is between tables: as near to the layer of that very roughness as these are to the truth.
    #[test]
    fn a_layer_that_varies_is_that_of_its_parameters() {
        let program = Program::new(&Graph::default(), Input::Constant(Vec3::ONE));
        let mut numbers = ByParameter::default();
        for of in [Computes::Roughness, Computes::Metalness, Computes::Opacity] {
            numbers[of] = Some(0);
        }
        let computed = Computed { program, numbers, opacity: None };
        let varied = Material { computed: Some(Arc::new(computed)), ..material(1.0, 1.0, 0.7) };
        let coats = Coats::new(std::slice::from_ref(&varied));
        for (roughness, metalness, opacity) in
            [(255, 255, 255), (200, 0, 102), (128, 51, 255), (64, 255, 51), (0, 0, 255)]
        {
            let share = |byte: u8| f32::from(byte) / 255.0;
            let mut plain = material(share(roughness), share(metalness), 0.7);
            plain.metal_rough.iter_mut().for_each(|layer| layer.solid = share(opacity));
            let plain_coats = Coats::new(std::slice::from_ref(&plain));
            let look = Look { material: 0, varied: Varied { roughness, metalness, opacity, ..Varied::NONE } };
            for (cos, seen_by) in [(0.9, SeenBy::Eye), (0.2, SeenBy::Eye), (0.5, SeenBy::Path)] {
                let kept = Vec3::splat(0.7);
                let [of_varied, of_plain] =
                    [(&coats, look), (&plain_coats, Look::plain(0))].map(|(coats, look)| {
                        coats.seen(look, kept, [Vec3::Z; 2], -at(cos), seen_by).expect("it has a layer")
                    });
                let name = format!("{roughness} {metalness} {opacity} {cos} {seen_by:?}");
                assert!((of_varied.alpha - of_plain.alpha).abs() < 1e-6, "{name}");
                assert!((of_varied.albedo - of_plain.albedo).abs().max_element() < 4e-3, "{name}");
                assert!((of_varied.through - of_plain.through).abs() < 4e-3, "{name}");
            }
            let eight = coats.seen_lanes(
                &[look; LANES],
                Vec3x8::splat(Vec3::splat(0.7)),
                [Vec3x8::splat(Vec3::Z); 2],
                Vec3x8::splat(-at(0.6)),
                None,
            );
            let one = coats.seen(look, Vec3::splat(0.7), [Vec3::Z; 2], -at(0.6), SeenBy::Eye);
            let (eight, one) = (eight.expect("all have one"), one.expect("it has one"));
            assert!((eight.through.lane(3) - one.through).abs() < 1e-5);
        }
    }

    #[test]
    fn paths_find_smooth_surfaces_rougher_and_no_darker() {
        for (roughness, alpha) in [(0.0, 0.1), (0.25, 0.125), (0.5, 0.3), (0.8, 0.64)] {
            let coats = Coats::new(&[material(roughness, 1.0, 1.0)]);
            let seen = coats
                .seen(Look::plain(0), Vec3::ONE, [Vec3::Z; 2], -at(0.6), SeenBy::Path)
                .expect("it has one");
            assert!((seen.alpha - alpha).abs() < 1e-6 && (seen.albedo.x - 1.0).abs() < 1e-3, "{seen:?}");
        }
    }

    /// Checks that the triangle's own normal reflects light where an interpolated one would send it below the
    /// triangle.
    #[test]
    fn nothing_is_mirrored_below_the_triangle() {
        let coats = Coats::new(&[material(0.0, 1.0, 1.0)]);
        let leaning = Vec3::new(0.9, 0.0, 0.1).normalize();
        for incoming in [-at(0.3), Vec3::new(0.95, 0.0, -0.3).normalize()] {
            let seen = coats
                .seen(Look::plain(0), Vec3::ONE, [leaning, Vec3::Z], incoming, SeenBy::Eye)
                .expect("it has one");
            let ray = seen.reflect([0.5; 2]).expect("a mirror always reflects");
            assert!(ray.direction.z > 0.0 && ray.density.is_none(), "{}", ray.direction);
        }
    }
}
