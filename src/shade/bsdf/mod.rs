//! The reflecting layer of metal-rough surfaces, as rays see it: [microfacets](ggx), with the light
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
mod chi_squared;
mod coat;
pub mod fresnel;
#[cfg(test)]
mod furnace;
mod fuzz;
pub mod ggx;
mod hair;
mod lanes;
pub mod mis;
mod of_material;
pub mod palette;
pub mod phong;
mod rough_diffuse;
mod seen;
mod seen_by;
mod seen_lanes;
mod stretched;
#[cfg(test)]
mod tests;
mod upper;
#[cfg(test)]
mod walk;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use albedos::{Albedos, Layer};
use coat::CoatLayer;
use hair::HairLobes;
pub use hair::log_of_color as log_of_hair_color;
use lanes::BsdfLanes;
use of_material::{Bsdf, BsdfAt, ROUGHNESS_STEPS, VaryingBsdf};
pub use seen::{Reflected, SeenBsdf, SurfaceAxes};
pub use seen_by::SeenBy;
use seen_by::alpha_of_paths;
pub use seen_lanes::{LayerRays, SeenBsdfs};
use stretched::Stretch;

use crate::lanes::{LANES, Vec3x8};
use crate::scene::Material;
use crate::scene::look::Look;
use crate::scene::material::MetalRough;

/// Layers of a scene's materials.
#[derive(Debug, Clone, Default)]
pub struct Bsdfs {
    /// Layer of each material, if it has one.
    bsdfs: Vec<Option<Bsdf>>,
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

impl Bsdfs {
    /// Creates the layers of all `materials`.
    pub fn new(materials: &[Material]) -> Self {
        // most materials share their tables with others
        let key = |layer: &Layer| [layer.alpha.to_bits(), layer.index.to_bits(), layer.is_glass.into()];
        let varying = materials.iter().flat_map(varying_layers);
        let coats = materials.iter().filter_map(|material| material.coat.as_ref().map(coat::layers));
        let all = materials.iter().filter_map(layers).chain(varying).chain(coats).flatten();
        let distinct: BTreeMap<[u32; 3], Layer> = all.map(|layer| (key(&layer), layer)).collect();
        let tables: BTreeMap<[u32; 3], Arc<Albedos>> =
            distinct.into_par_iter().map(|(key, layer)| (key, Arc::new(Albedos::new(layer)))).collect();
        let bsdfs = materials.iter().map(|material| {
            let table = |layer: Layer| Arc::clone(&tables[&key(&layer)]);
            let own = layers(material)?.map(|layer| (layer, table(layer)));
            let by_roughness = varying_layers(material).into_iter().map(|pair| pair.map(table)).collect();
            let coat = material.coat.map(|coat| CoatLayer::new(coat, coat::layers(&coat).map(table)));
            Some(Bsdf { coat, ..bsdf(material, material.metal_rough.as_ref()?, own, by_roughness) })
        });
        let bsdfs: Vec<Option<Bsdf>> = bsdfs.collect();
        let mut has: Vec<bool> = bsdfs.iter().map(Option::is_some).collect();
        if !has.contains(&true) {
            has.clear();
        }
        Self { bsdfs, has }
    }

    #[inline(always)]
    fn get(&self, look: Look) -> Option<BsdfAt<'_>> {
        if !self.has(look.material) {
            return None;
        }
        Some(self.bsdfs.get(usize::from(look.material))?.as_ref()?.at(look.varied))
    }

    #[inline(always)]
    fn has(&self, material: u16) -> bool {
        self.has.get(usize::from(material)) == Some(&true)
    }

    /// Returns true if a material reflects by anything that is not a mirror.
    #[inline(always)]
    pub fn is_rough(&self, look: Look) -> bool {
        self.alpha_of_rough(look).is_some()
    }

    /// Width of the narrowest lobe by which a material reflects that is not a mirror, if there is one.
    #[inline(always)]
    pub fn alpha_of_rough(&self, look: Look) -> Option<f32> {
        self.get(look)?.alpha_of_rough()
    }

    /// Returns true if any of these surfaces has a layer.
    #[inline(always)]
    pub fn any(&self, looks: &[Look]) -> bool {
        !self.has.is_empty() && looks.iter().any(|look| self.has(look.material))
    }

    /// Layer of a surface with these [directions](SurfaceAxes) that is seen along `incoming` (unit length), if it has one.
    #[inline(always)]
    pub fn seen(
        &self,
        look: Look,
        reflectance: Vec3,
        axes: SurfaceAxes<Vec3>,
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> Option<SeenBsdf> {
        // most surfaces have none, and this is called for all
        self.get(look).map(|bsdf| bsdf.seen(reflectance, axes, incoming, seen_by))
    }

    /// Albedo at normal incidence of eight surfaces whose diffuse albedo is `diffuse`, with that of their layers where these are rough.
    pub fn rough_over(&self, looks: &[Look; LANES], reflectance: Vec3x8, diffuse: Vec3x8) -> Vec3x8 {
        let mut albedo = diffuse;
        if self.any(looks) {
            for (lane, look) in looks.iter().enumerate() {
                if let Some(bsdf) = self.get(*look).filter(|bsdf| bsdf.alpha_of_rough().is_some()) {
                    albedo.set_lane(lane, bsdf.head_on_over(reflectance.lane(lane), diffuse.lane(lane)));
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
        axes: SurfaceAxes<Vec3x8>,
        incoming: Vec3x8,
        rays: Option<LayerRays>,
    ) -> Option<SeenBsdfs> {
        if !self.any(looks) {
            return None;
        }
        let lanes = BsdfLanes::new(|look| self.get(look), looks);
        let mut all = lanes.seen(reflectance, axes, incoming);
        if let Some(rays) = rays {
            lanes.follow(&mut all, reflectance, axes, rays);
        }
        Some(all)
    }
}

fn bsdf(
    material: &Material,
    metal_rough: &MetalRough,
    [(layer, albedos), (layer_of_paths, albedos_of_paths)]: [(Layer, Arc<Albedos>); 2],
    by_roughness: Vec<[Arc<Albedos>; 2]>,
) -> Bsdf {
    let MetalRough { base, metallic, solid, .. } = *metal_rough;
    let (metal, metal_of_kept) = if material.is_painted() {
        // what paints it colours the metal, which is computed from the reflectance that samples store
        (Vec3::ZERO, base / material.painted().max(Vec3::splat(f32::MIN_POSITIVE)))
    } else {
        (base, Vec3::ZERO)
    };
    Bsdf {
        alpha: layer.alpha,
        metallic,
        metal,
        metal_of_kept,
        edge: material.metal_edge,
        index: layer.index,
        solid,
        emission: material.emission,
        albedos,
        alpha_of_paths: layer_of_paths.alpha,
        albedos_of_paths,
        varying: material.varies().then(|| VaryingBsdf {
            layer: *metal_rough,
            is_glass: material.is_rough_glass(),
            // none if it does not vary
            by_roughness: by_roughness.try_into().ok(),
        }),
        coat: None,
        fuzz: material.fuzz,
        hair: material.hair.as_ref().map(HairLobes::new),
        diffuse_roughness: material.diffuse_roughness,
        stretch: material.anisotropy.as_ref().map(Stretch::of),
    }
}
