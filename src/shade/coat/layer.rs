//! The layer of one surface, as one ray sees it.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;

use super::albedos::{Albedos, LEAST_COSINE, Shares, VALUES};
use crate::scene::look::Varied;
use crate::scene::material::{LEAST_ALPHA, MetalRough};
use crate::shade::fresnel::{Fresnel, dielectric};
use crate::shade::ggx;
use crate::shade::sampling::orthonormal;

/// Least albedo; anything below it is taken for black.
pub const LEAST_ALBEDO: f32 = 1e-6;

/// Least alpha that paths see which have been scattered before.
pub const LEAST_ALPHA_OF_PATHS: f32 = 0.1;

/// Layer of a material.
#[derive(Debug, Clone)]
pub struct Coat {
    pub alpha: f32,
    /// Share of metal, from 0 to 1.
    pub metallic: f32,
    /// Reflectance of the metal at right angles: this, and `metal_of_kept` for each unit of the reflectance
    /// that samples store.
    pub metal: Vec3,
    pub metal_of_kept: Vec3,
    /// Index of refraction of the part that is not metal, 1 or more; it lets light through.
    pub index: f32,
    /// Share of light that does not pass straight through.
    pub solid: f32,
    /// Emission (`Ke`), which the layer does not dim.
    pub emission: Vec3,
    pub albedos: Arc<Albedos>,
    /// Alpha as paths see it that have been scattered before.
    pub alpha_of_paths: f32,
    pub albedos_of_paths: Arc<Albedos>,
    /// What of it varies, if anything does.
    pub varying: Option<VaryingCoat>,
}

/// Alpha that paths see (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 2023, "path
/// regularization").
pub fn regularized(alpha: f32) -> f32 {
    const ROUGH_ENOUGH: f32 = 0.3;
    if alpha < ROUGH_ENOUGH { (2.0 * alpha).clamp(LEAST_ALPHA_OF_PATHS, ROUGH_ENOUGH) } else { alpha }
}

/// Alpha that paths see of a layer; rays through rough glass bend by microfacets of its own width.
pub fn alpha_of_paths(alpha: f32, is_glass: bool) -> f32 {
    if is_glass { alpha } else { regularized(alpha) }
}

/// Kind of ray that sees a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenBy {
    /// A ray that has been mirrored at most since it left the eye.
    Eye,
    /// A path that has been scattered before. Smooth surfaces focus lights and the sun; few paths find such
    /// light, each of which is a spark. To paths these surfaces are rougher.
    Path,
}

impl Coat {
    /// The layer where these parameters are what varies of it.
    #[inline(always)]
    pub fn at(&self, varied: Varied) -> CoatAt<'_> {
        match &self.varying {
            None => self.at_rest(),
            Some(varying) => self.varied_at(varying, varied),
        }
    }

    /// Not inlined: most layers are the same all over.
    #[inline(never)]
    fn varied_at<'a>(&'a self, varying: &'a VaryingCoat, varied: Varied) -> CoatAt<'a> {
        let VaryingCoat { layer, is_glass, .. } = varying;
        let here = layer.at(varied);
        let MetalRough { metallic, solid, .. } = here;
        let plain = CoatAt { metallic, solid, emission: varied.light_of(self.emission), ..self.at_rest() };
        let Some(tables) = &varying.by_roughness else { return plain };
        let (alpha, share) = (here.alpha(), varied.of_roughness());
        CoatAt {
            alpha,
            albedos: Between::of(tables.each_ref().map(|[eye, _]| &**eye), share),
            alpha_of_paths: alpha_of_paths(alpha, *is_glass),
            albedos_of_paths: Between::of(tables.each_ref().map(|[_, paths]| &**paths), share),
            ..plain
        }
    }

    /// The layer with the material's own parameters.
    #[inline(always)]
    fn at_rest(&self) -> CoatAt<'_> {
        CoatAt {
            coat: self,
            alpha: self.alpha,
            metallic: self.metallic,
            solid: self.solid,
            emission: self.emission,
            albedos: Between::one(&self.albedos),
            alpha_of_paths: self.alpha_of_paths,
            albedos_of_paths: Between::one(&self.albedos_of_paths),
        }
    }
}

/// What varies of a layer from place to place.
#[derive(Debug, Clone)]
pub struct VaryingCoat {
    /// The layer where all factors are 1.
    pub layer: MetalRough,
    /// True if it is rough glass.
    pub is_glass: bool,
    /// Light as the eye and as paths see it, for even steps of the roughness up to that, if it varies.
    pub by_roughness: Option<Box<[[Arc<Albedos>; 2]; ROUGHNESS_STEPS + 1]>>,
}

/// Steps of a roughness that varies between which light is interpolated.
pub const ROUGHNESS_STEPS: usize = 32;

/// A layer at one place.
#[derive(Debug, Clone, Copy)]
pub struct CoatAt<'a> {
    /// What it has all over.
    pub coat: &'a Coat,
    /// Width of its lobe.
    pub alpha: f32,
    /// Share of metal.
    pub metallic: f32,
    /// Share of light that does not pass straight through.
    pub solid: f32,
    /// Emission, which the layer does not dim.
    pub emission: Vec3,
    /// Light that it reflects.
    pub albedos: Between<'a>,
    alpha_of_paths: f32,
    albedos_of_paths: Between<'a>,
}

/// Light of a layer between two that are known.
#[derive(Debug, Clone, Copy)]
pub struct Between<'a> {
    low: &'a Albedos,
    high: &'a Albedos,
    /// Way from one to the other, from 0 to 1.
    rest: f32,
}

impl<'a> Between<'a> {
    #[inline(always)]
    fn one(albedos: &'a Albedos) -> Self {
        Self { low: albedos, high: albedos, rest: 0.0 }
    }

    /// At a share, from 0 to 1, of the way through even steps.
    fn of(steps: [&'a Albedos; ROUGHNESS_STEPS + 1], share: f32) -> Self {
        let at = share * ROUGHNESS_STEPS as f32;
        let low = (at as usize).min(ROUGHNESS_STEPS - 1);
        Self { low: steps[low], high: steps[low + 1], rest: at - low as f32 }
    }

    /// See [`Albedos::at`].
    #[inline(always)]
    pub fn at(&self, cos: f32) -> [f32; VALUES] {
        let low = self.low.at(cos);
        if self.rest == 0.0 {
            return low;
        }
        let high = self.high.at(cos);
        std::array::from_fn(|of| low[of] + (high[of] - low[of]) * self.rest)
    }
}

impl CoatAt<'_> {
    /// Returns true if the layer is as good as a mirror.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// Reflectance of its microfacets; `reflectance` is what samples store.
    fn fresnel(&self, reflectance: Vec3) -> Fresnel<f32> {
        let metal = (self.coat.metal + self.coat.metal_of_kept * reflectance).min(Vec3::ONE);
        Fresnel { metal: metal.to_array(), metallic: self.metallic, index: self.coat.index }
    }

    /// Albedo at normal incidence, with that of the surface beneath, which is `diffuse`, as far as the layer lets light through.
    pub fn head_on_over(&self, reflectance: Vec3, diffuse: Vec3) -> Vec3 {
        let through = 1.0 - dielectric(self.coat.index, 1.0);
        Vec3::from(self.fresnel(reflectance).at(1.0)) * self.solid + diffuse * through
    }

    /// Layer as a ray sees it: see [`Coats::seen`](super::Coats::seen).
    pub fn seen(
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
        // an eye in the surface sees it from no direction: treated as if above
        let to_eye = to_eye.try_normalize().unwrap_or(Vec3::Z);
        let fresnel = self.fresnel(reflectance);
        let shares = Shares::new(albedos.at(to_eye.z));
        let [once, albedo] = [shares.once(&fresnel), shares.in_all(&fresnel)].map(Vec3::from);
        // a surface that reflects nothing needs no factor
        let gain = Vec3::select(once.cmpgt(Vec3::splat(LEAST_ALBEDO)), albedo / once, Vec3::ONE);
        let through = (1.0 - shares.clear).clamp(0.0, 1.0);
        SeenCoat {
            axes,
            to_eye,
            alpha,
            fresnel,
            gain: gain * self.solid,
            albedo: albedo * self.solid,
            through,
            added: self.emission * (1.0 - through),
        }
    }
}

/// Normal about which a surface reflects to the eye: the interpolated one, unless it would send the mirrored
/// direction below the triangle.
#[inline]
pub fn facing(normal: Vec3, geometric_normal: Vec3, to_eye: Vec3) -> Vec3 {
    let cos = normal.dot(to_eye);
    let mirrored = normal * (2.0 * cos) - to_eye;
    if cos > 0.0 && mirrored.dot(geometric_normal) > 0.0 { normal } else { geometric_normal }
}

/// Layer of a surface as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCoat {
    /// Axes of the surface's space, in world space; the last is the normal.
    axes: [Vec3; 3],
    /// Direction to the eye in the surface's space.
    to_eye: Vec3,
    pub(super) alpha: f32,
    pub(super) fresnel: Fresnel<f32>,
    /// Factor for the light that microfacets reflect once.
    pub(super) gain: Vec3,
    /// Share of light from all around that is reflected to the eye.
    pub albedo: Vec3,
    /// Share of scattered light that the layer lets through to the eye.
    pub through: f32,
    /// Light to be added where `through` has dimmed emission.
    added: Vec3,
}

/// Direction in which the layer reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflected {
    /// Direction, world space, unit length.
    pub direction: Vec3,
    /// Factor for the light that a ray in this direction brings.
    pub weight: Vec3,
    /// Density with which the direction was chosen, in solid angle; `None` for the one direction of a mirror.
    pub density: Option<f32>,
}

impl SeenCoat {
    /// Returns true if the layer is as good as a mirror: one ray shows its reflection.
    pub fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// Samples a direction by two numbers from 0 to below 1, unless it leads into the surface.
    pub fn reflect(&self, random: [f32; 2]) -> Option<Reflected> {
        if self.is_smooth() {
            let Vec3 { x, y, z } = self.to_eye;
            let weight = Vec3::from(self.fresnel.at(z)) * self.gain;
            return Some(Reflected { direction: self.to_world(Vec3::new(-x, -y, z)), weight, density: None });
        }
        let to_light = ggx::sample(self.alpha, self.to_eye, random);
        if to_light.z <= 0.0 {
            return None;
        }
        Some(Reflected {
            direction: self.to_world(to_light),
            weight: ggx::sample_weight(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain,
            density: Some(ggx::density(self.alpha, self.to_eye, to_light)),
        })
    }

    /// Reflectance for light from `direction` (world space, unit length), times the cosine; and the density
    /// with which [`reflect`](Self::reflect) samples that direction. Both are for surfaces that are not
    /// smooth.
    pub fn towards(&self, direction: Vec3) -> (Vec3, f32) {
        let to_light = self.to_local(direction);
        let reflected = ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
        (reflected, ggx::density(self.alpha, self.to_eye, to_light))
    }

    /// Dims scattered light by the layer; `light` includes emission, which stays as it is.
    pub fn show(&self, light: Vec3) -> Vec3 {
        light * self.through + self.added
    }

    /// Highlight of a light that sends `irradiance` from `direction` (unit length), in the units in which a
    /// white surface reflects as much as it gets; and the density with which [`reflect`](Self::reflect)
    /// samples that direction.
    pub fn highlight(&self, direction: Vec3, irradiance: Vec3) -> (Vec3, f32) {
        let (reflected, density) = self.towards(direction);
        (reflected * irradiance * PI, density)
    }

    /// Density with which [`reflect`](Self::reflect) samples `direction` (world space, unit length).
    pub fn density(&self, direction: Vec3) -> f32 {
        ggx::density(self.alpha, self.to_eye, self.to_local(direction))
    }

    /// Returns true if the lobe is so narrow that what it shows is seen as in a mirror. Paths see no narrower
    /// one, but for glass.
    pub fn is_narrow(&self) -> bool {
        self.alpha < LEAST_ALPHA_OF_PATHS
    }

    fn to_local(self, direction: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(direction)))
    }

    fn to_world(self, direction: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        (x * direction.x + y * direction.y + z * direction.z).normalize_or(z)
    }
}
