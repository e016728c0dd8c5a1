//! The layer of metal-rough surfaces that reflects, as rays see it: [microfacets](super::ggx), with the light that is
//! reflected between them, above a surface that scatters what the layer lets through.
//!
//! - *Light reflected several times* between microfacets is added in the colour of the first reflection, so that a white metal
//!   reflects all light however rough it is: Turquin, "Practical multiple scattering compensation for microfacet models",
//!   2019.
//! - *The surface beneath* scatters what the layer does not reflect: one less the layer's albedo in the direction of the ray
//!   (albedo scaling, as the OpenPBR and MaterialX specifications have it). It is a factor for all light that was
//!   scattered, wherever that came from. So the light that samples keep does not depend on the eye, and the factor is applied
//!   when it is shown.

#[cfg(test)]
mod furnace;
mod lanes;

use std::f32::consts::PI;

use glam::Vec3;

use lanes::CoatLanes;
pub use lanes::SeenCoats;

use super::ggx::{self, LEAST_ALPHA};
use super::sampling::{PathRandom, orthonormal};
use crate::lanes::{LANES, Vec3x8};
use crate::scene::Material;
use crate::scene::material::MetalRough;

/// The least cosine to the eye that is reckoned with: below it, a direction lies in the surface.
const LEAST_COSINE: f32 = 1e-4;

/// An albedo that is taken for black.
const LEAST_ALBEDO: f32 = 1e-6;

/// The layers of a scene's materials.
#[derive(Debug, Clone, Default)]
pub struct Coats {
    /// By material.
    coats: Vec<Option<Coat>>,
    /// Whether each material has one; nothing where none has. All surfaces are asked, and most have none.
    has: Vec<bool>,
}

/// The layer of a material.
#[derive(Debug, Clone)]
struct Coat {
    alpha: f32,
    /// From 0 to 1.
    metallic: f32,
    /// What the metal reflects at right angles: this, and this for each unit of the reflectance that is kept.
    metal: Vec3,
    metal_of_kept: Vec3,
    /// What the rest reflects at right angles; it lets light through.
    clear: f32,
    /// The share of light that does not pass straight through.
    solid: f32,
    /// Ke, which the layer does not dim.
    emission: Vec3,
    albedos: Albedos,
    /// The same as paths find it, which have been scattered before.
    alpha_of_paths: f32,
    albedos_of_paths: Albedos,
}

/// By how many rays what a layer reflects is followed, by lane.
pub type CountRays<'a> = &'a dyn Fn(usize, &SeenCoat) -> u32;

/// How a surface is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenBy {
    /// By a ray that has been mirrored at most since it left the eye.
    Eye,
    /// By a path that has been scattered before. What is smooth focuses lights and the sun, which few paths find, each of them a
    /// spark: to paths it is rougher.
    Path,
}

/// The alpha that paths find (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 2023, "path
/// regularization").
fn regularized(alpha: f32) -> f32 {
    const ROUGH_ENOUGH: f32 = 0.3;
    if alpha < ROUGH_ENOUGH { (2.0 * alpha).clamp(0.1, ROUGH_ENOUGH) } else { alpha }
}

/// What microfacets of one roughness reflect of light from all around, by the cosine to the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Albedos {
    /// In even steps from 0 to 1: reflected by white microfacets; and of that, what Schlick's formula calls white.
    steps: [[f32; 2]; Albedos::STEPS + 1],
}

impl Albedos {
    /// With 64 steps lines are within 1e-3 of the fifth power in Schlick's formula.
    const STEPS: usize = 64;

    /// Directions by which each is measured: the error of an evenly spread sequence is below 1e-3.
    const SAMPLES: u32 = 1024;

    fn of(alpha: f32) -> Self {
        let random = |index| {
            let [along, above, ..] = PathRandom { seed: 0, index }.four(0);
            [along, above]
        };
        let randoms: Vec<[f32; 2]> = (0..Self::SAMPLES).map(random).collect();
        let steps = std::array::from_fn(|step| {
            let cos = (step as f32 / Self::STEPS as f32).max(LEAST_COSINE);
            let to_eye = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
            let (mut all, mut white) = (0.0, 0.0);
            for random in &randoms {
                let to_light = ggx::sample(alpha, to_eye, *random);
                let weight = ggx::sample_weight(alpha, Vec3::ONE, to_eye, to_light).x;
                all += weight;
                white += weight * ggx::grazing((to_eye + to_light).normalize().dot(to_eye));
            }
            [all, white].map(|sum| sum / Self::SAMPLES as f32)
        });
        Self { steps }
    }

    /// Of both, between the steps.
    #[inline]
    fn at(&self, cos: f32) -> [f32; 2] {
        let at = cos.clamp(0.0, 1.0) * Self::STEPS as f32;
        let step = (at as usize).min(Self::STEPS - 1);
        let rest = at - step as f32;
        let [low, high] = [self.steps[step], self.steps[step + 1]];
        [0, 1].map(|of| low[of] + (high[of] - low[of]) * rest)
    }
}

/// What microfacets reflect once of light from all around.
#[inline]
fn reflected_once(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    head_on * all + (Vec3::ONE - head_on) * white
}

/// What they reflect once or several times.
#[inline]
fn albedo(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    let several_times = head_on * ((1.0 - all).max(0.0) / all);
    reflected_once(head_on, [all, white]) * (Vec3::ONE + several_times)
}

impl Coat {
    /// As [`Coats::seen`].
    fn seen(
        &self,
        reflectance: Vec3,
        [normal, geometric_normal]: [Vec3; 2],
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> SeenCoat {
        let (alpha, albedos) = match seen_by {
            SeenBy::Eye => (self.alpha, &self.albedos),
            SeenBy::Path => (self.alpha_of_paths, &self.albedos_of_paths),
        };
        let normal = facing(normal, geometric_normal, -incoming);
        let [x, y] = orthonormal(normal);
        let axes = [x, y, normal];
        let to_eye = axes.map(|axis| -axis.dot(incoming));
        let to_eye = Vec3::new(to_eye[0], to_eye[1], to_eye[2].max(LEAST_COSINE));
        // an eye in the surface sees it from no direction: as from above
        let to_eye = to_eye.try_normalize().unwrap_or(Vec3::Z);
        let (clear, metallic) = (Vec3::splat(self.clear), self.metallic);
        let metal = (self.metal + self.metal_of_kept * reflectance).min(Vec3::ONE);
        let head_on = clear + (metal - clear) * metallic;
        let albedos = albedos.at(to_eye.z);
        let [of_clear, of_metal] = [clear, metal].map(|head_on| albedo(head_on, albedos));
        let albedo = of_clear + (of_metal - of_clear) * metallic;
        let once = reflected_once(head_on, albedos);
        // what reflects nothing needs no factor
        let gain = Vec3::select(once.cmpgt(Vec3::splat(LEAST_ALBEDO)), albedo / once, Vec3::ONE);
        let through = (1.0 - of_clear.x).clamp(0.0, 1.0);
        SeenCoat {
            axes,
            to_eye,
            alpha,
            head_on,
            gain: gain * self.solid,
            albedo: albedo * self.solid,
            through,
            added: self.emission * (1.0 - through),
        }
    }
}

impl Coats {
    /// Of all `materials`.
    pub fn of(materials: &[Material]) -> Self {
        let mut known: Vec<(f32, Albedos)> = Vec::new();
        let coats = materials.iter().map(|material| {
            let metal_rough = material.metal_rough.as_ref()?;
            let alpha = ggx::alpha_of(metal_rough.roughness);
            let [of_eye, of_paths] = [alpha, regularized(alpha)].map(|alpha| {
                let found = known.iter().find(|(known, _)| *known == alpha).map(|(_, albedos)| *albedos);
                let albedos = found.unwrap_or_else(|| {
                    let albedos = Albedos::of(alpha);
                    known.push((alpha, albedos));
                    albedos
                });
                (alpha, albedos)
            });
            Some(coat(material, metal_rough, of_eye, of_paths))
        });
        let coats: Vec<Option<Coat>> = coats.collect();
        let mut has: Vec<bool> = coats.iter().map(Option::is_some).collect();
        if !has.contains(&true) {
            has.clear();
        }
        Self { coats, has }
    }

    #[inline(always)]
    fn get(&self, material: u16) -> Option<&Coat> {
        if !self.has(material) {
            return None;
        }
        self.coats.get(usize::from(material))?.as_ref()
    }

    #[inline(always)]
    fn has(&self, material: u16) -> bool {
        self.has.get(usize::from(material)) == Some(&true)
    }

    /// Whether a material has one that is no mirror.
    pub fn is_rough(&self, material: u16) -> bool {
        self.get(material).is_some_and(|coat| coat.alpha > LEAST_ALPHA)
    }

    /// Whether any of these materials has one.
    #[inline(always)]
    pub fn any(&self, materials: &[u16]) -> bool {
        !self.has.is_empty() && materials.iter().any(|material| self.has(*material))
    }

    /// The layer of a surface with these normals (world space) that is seen along `incoming` (unit length), if it has one.
    #[inline(always)]
    pub fn seen(
        &self,
        material: u16,
        reflectance: Vec3,
        normals: [Vec3; 2],
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> Option<SeenCoat> {
        // most surfaces have none, and all are asked
        self.get(material).map(|coat| coat.seen(reflectance, normals, incoming, seen_by))
    }

    /// The layers of eight surfaces that are seen along `incoming`, if any has one. `rays`: by how many rays what each of them
    /// reflects is followed as well, where any are.
    pub fn seen_lanes(
        &self,
        materials: &[u16; LANES],
        reflectance: Vec3x8,
        normals: [Vec3x8; 2],
        incoming: Vec3x8,
        rays: Option<CountRays>,
    ) -> Option<SeenCoats> {
        if !self.any(materials) {
            return None;
        }
        let mut all = CoatLanes::of(self, materials).seen(reflectance, normals, incoming);
        if let Some(rays) = rays {
            for (lane, material) in materials.iter().enumerate() {
                // one by one, as those that cast them see the layers: a count must not differ by what is rounded
                let normals = normals.map(|normals| normals.lane(lane));
                let (reflectance, incoming) = (reflectance.lane(lane), incoming.lane(lane));
                let seen = self.seen(*material, reflectance, normals, incoming, SeenBy::Eye);
                let Some(seen) = seen else { continue };
                match rays(lane, &seen) {
                    0 => {}
                    _ if seen.is_smooth() => all.is_followed_alone.set(lane),
                    rays => all.rays.set_lane(lane, rays as f32),
                }
            }
        }
        Some(all)
    }
}

fn coat(
    material: &Material,
    metal_rough: &MetalRough,
    (alpha, albedos): (f32, Albedos),
    (alpha_of_paths, albedos_of_paths): (f32, Albedos),
) -> Coat {
    let MetalRough { base, metallic, head_on: clear, solid, .. } = *metal_rough;
    let (metal, metal_of_kept) = match material.diffuse_map {
        // the texture colours the metal, and is known by what is kept of it
        Some(_) => (Vec3::ZERO, base / material.painted().max(Vec3::splat(f32::MIN_POSITIVE))),
        None => (base, Vec3::ZERO),
    };
    Coat {
        alpha,
        metallic,
        metal,
        metal_of_kept,
        clear,
        solid,
        emission: material.emission,
        albedos,
        alpha_of_paths,
        albedos_of_paths,
    }
}

/// The normal about which a surface reflects to the eye: an interpolated one, unless it would send the mirrored direction below
/// the triangle.
#[inline]
fn facing(normal: Vec3, geometric_normal: Vec3, to_eye: Vec3) -> Vec3 {
    let cos = normal.dot(to_eye);
    let mirrored = normal * (2.0 * cos) - to_eye;
    if cos > 0.0 && mirrored.dot(geometric_normal) > 0.0 { normal } else { geometric_normal }
}

/// The layer of a surface as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCoat {
    /// From the surface's space to world space; the last is the normal.
    axes: [Vec3; 3],
    /// In the surface's space.
    to_eye: Vec3,
    alpha: f32,
    head_on: Vec3,
    /// Of what microfacets reflect once.
    gain: Vec3,
    /// What is reflected to the eye of light from all around.
    pub albedo: Vec3,
    /// The share of scattered light that the layer lets through to the eye.
    pub through: f32,
    /// What is missing of the emission then.
    added: Vec3,
}

/// A direction in which the layer reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflected {
    /// World space, unit length.
    pub direction: Vec3,
    /// What a ray in this direction brings is multiplied with this.
    pub weight: Vec3,
    /// With which the direction was chosen, in solid angle; none for the one direction of a mirror.
    pub density: Option<f32>,
}

impl SeenCoat {
    /// Whether it is as good as a mirror: one ray shows what it reflects.
    pub fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// A direction that two numbers from 0 to below 1 choose, if it does not lead into the surface.
    pub fn reflect(&self, random: [f32; 2]) -> Option<Reflected> {
        if self.is_smooth() {
            let Vec3 { x, y, z } = self.to_eye;
            let weight = ggx::schlick(self.head_on, z) * self.gain;
            return Some(Reflected { direction: self.to_world(Vec3::new(-x, -y, z)), weight, density: None });
        }
        let to_light = ggx::sample(self.alpha, self.to_eye, random);
        if to_light.z <= 0.0 {
            return None;
        }
        Some(Reflected {
            direction: self.to_world(to_light),
            weight: ggx::sample_weight(self.alpha, self.head_on, self.to_eye, to_light) * self.gain,
            density: Some(ggx::density(self.alpha, self.to_eye, to_light)),
        })
    }

    /// What is reflected of light from `direction` (world space, unit length), times the cosine; and the density with which
    /// [`reflect`](Self::reflect) gives it. Both are for surfaces that are not smooth.
    pub fn towards(&self, direction: Vec3) -> (Vec3, f32) {
        let to_light = Vec3::from(self.axes.map(|axis| axis.dot(direction)));
        let reflected = ggx::reflected(self.alpha, self.head_on, self.to_eye, to_light) * self.gain;
        (reflected, ggx::density(self.alpha, self.to_eye, to_light))
    }

    /// What is seen of scattered and emitted `light`.
    pub fn show(&self, light: Vec3) -> Vec3 {
        light * self.through + self.added
    }

    /// The highlight of a light that sends `irradiance` from `direction` (unit length), by which a white surface reflects as
    /// much; and the density with which [`reflect`](Self::reflect) gives that direction.
    pub fn highlight(&self, direction: Vec3, irradiance: Vec3) -> (Vec3, f32) {
        let (reflected, density) = self.towards(direction);
        (reflected * irradiance * PI, density)
    }

    fn to_world(self, direction: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        (x * direction.x + y * direction.y + z * direction.z).normalize_or(z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn material(roughness: f32, metallic: f32, base: f32) -> Material {
        let base = Vec3::splat(base);
        let metal_rough = MetalRough { base, roughness, metallic, head_on: 0.04, solid: 1.0 };
        Material { diffuse: base * (1.0 - metallic), metal_rough: Some(metal_rough), ..Material::fallback() }
    }

    pub(super) fn at(cos: f32) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos)
    }

    pub(super) fn seen(material: &Material, cos: f32) -> SeenCoat {
        let coats = Coats::of(std::slice::from_ref(material));
        coats.seen(0, material.painted(), [Vec3::Z; 2], -at(cos), SeenBy::Eye).expect("it has a layer")
    }

    /// What a white surface shows in a white furnace: what it reflects, by sampled directions, and what it scatters.
    fn in_a_furnace(material: &Material, cos: f32) -> Vec3 {
        const COUNT: u32 = 4096;
        let seen = seen(material, cos);
        let random = |index| {
            let [along, above, ..] = PathRandom { seed: 99, index }.four(0);
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
    fn a_texture_colours_metal() {
        let mut textured = material(0.4, 1.0, 0.5);
        (textured.diffuse_map, textured.ambient) = (Some(0), Vec3::ZERO);
        let texel = Vec3::new(1.0, 0.5, 0.0);
        let coats = Coats::of(std::slice::from_ref(&textured));
        let of_texture = coats.seen(0, textured.painted() * texel, [Vec3::Z; 2], -at(0.8), SeenBy::Eye);
        assert_eq!(of_texture.expect("it has one").head_on, texel * 0.5);
        let dark = coats.seen(0, Vec3::ZERO, [Vec3::Z; 2], -at(0.8), SeenBy::Eye).expect("it has one");
        assert_eq!(dark.head_on, Vec3::ZERO);
    }

    #[test]
    fn paths_find_smooth_surfaces_rougher_and_no_darker() {
        for (roughness, alpha) in [(0.0, 0.1), (0.25, 0.125), (0.5, 0.3), (0.8, 0.64)] {
            let coats = Coats::of(&[material(roughness, 1.0, 1.0)]);
            let seen = coats.seen(0, Vec3::ONE, [Vec3::Z; 2], -at(0.6), SeenBy::Path).expect("it has one");
            assert!((seen.alpha - alpha).abs() < 1e-6 && (seen.albedo.x - 1.0).abs() < 1e-3, "{seen:?}");
        }
    }

    /// Where an interpolated normal would send light below the triangle, the triangle's own reflects it.
    #[test]
    fn nothing_is_mirrored_below_the_triangle() {
        let coats = Coats::of(&[material(0.0, 1.0, 1.0)]);
        let leaning = Vec3::new(0.9, 0.0, 0.1).normalize();
        for incoming in [-at(0.3), Vec3::new(0.95, 0.0, -0.3).normalize()] {
            let seen =
                coats.seen(0, Vec3::ONE, [leaning, Vec3::Z], incoming, SeenBy::Eye).expect("it has one");
            let ray = seen.reflect([0.5; 2]).expect("a mirror always reflects");
            assert!(ray.direction.z > 0.0 && ray.density.is_none(), "{}", ray.direction);
        }
    }
}
