//! The layer of one surface, as one ray sees it.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::Vec3;

use super::albedos::{Albedos, LEAST_ALBEDO, LEAST_COSINE, Shares, VALUES};
use super::coat::{BelowCoat, CoatLayer, SeenCoat};
use super::seen_by::{LEAST_ALPHA_OF_PATHS, SeenBy, alpha_of_paths};
use crate::scene::look::Varied;
use crate::scene::material::{LEAST_ALPHA, MetalRough};
use crate::shade::bsdf::fresnel::{Fresnel, dielectric};
use crate::shade::bsdf::ggx;
use crate::shade::sampling::orthonormal;

/// What a material reflects beside diffuse light: its layer, and the coat above that.
#[derive(Debug, Clone)]
pub struct Bsdf {
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
    pub varying: Option<VaryingBsdf>,
    /// Clear coat above all of that.
    pub coat: Option<CoatLayer>,
}

impl Bsdf {
    /// The layer where these parameters are what varies of it.
    #[inline(always)]
    pub fn at(&self, varied: Varied) -> BsdfAt<'_> {
        match &self.varying {
            None => self.at_rest(),
            Some(varying) => self.varied_at(varying, varied),
        }
    }

    /// Not inlined: most layers are the same all over.
    #[inline(never)]
    fn varied_at<'a>(&'a self, varying: &'a VaryingBsdf, varied: Varied) -> BsdfAt<'a> {
        let VaryingBsdf { layer, is_glass, .. } = varying;
        let here = layer.at(varied);
        let MetalRough { metallic, solid, .. } = here;
        let plain = BsdfAt { metallic, solid, emission: varied.light_of(self.emission), ..self.at_rest() };
        let Some(tables) = &varying.by_roughness else { return plain };
        let (alpha, share) = (here.alpha(), varied.of_roughness());
        BsdfAt {
            alpha,
            albedos: Between::of(tables.each_ref().map(|[eye, _]| &**eye), share),
            alpha_of_paths: alpha_of_paths(alpha, *is_glass),
            albedos_of_paths: Between::of(tables.each_ref().map(|[_, paths]| &**paths), share),
            ..plain
        }
    }

    /// The layer with the material's own parameters.
    #[inline(always)]
    fn at_rest(&self) -> BsdfAt<'_> {
        BsdfAt {
            bsdf: self,
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
pub struct VaryingBsdf {
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
pub struct BsdfAt<'a> {
    /// What it has all over.
    pub bsdf: &'a Bsdf,
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

impl BsdfAt<'_> {
    /// Width of the narrowest of its lobes that are not as good as mirrors, if there is one.
    #[inline(always)]
    pub fn alpha_of_rough(&self) -> Option<f32> {
        let own = Some(self.alpha).filter(|alpha| *alpha > LEAST_ALPHA);
        let Some(coat) = &self.bsdf.coat else { return own };
        let of_coat = Some(coat.alpha()).filter(|alpha| *alpha > LEAST_ALPHA);
        own.into_iter().chain(of_coat).reduce(f32::min)
    }

    /// What is below its coat, where the layer reflects and lets through so much.
    pub fn below_coat(&self, reflectance: Vec3, albedo: Vec3, through: f32) -> BelowCoat {
        let Bsdf { metal_of_kept, .. } = *self.bsdf;
        let diffuse = match metal_of_kept {
            Vec3::ZERO => reflectance,
            _ => reflectance * metal_of_kept * (1.0 - self.metallic),
        };
        // what is no metal is matt for the most part
        let roughness = 1.0 - self.metallic * (1.0 - self.alpha.sqrt());
        BelowCoat { albedo: albedo + diffuse * through, roughness }
    }

    /// Reflectance of its microfacets; `reflectance` is what samples store.
    fn fresnel(&self, reflectance: Vec3) -> Fresnel<f32> {
        let metal = (self.bsdf.metal + self.bsdf.metal_of_kept * reflectance).min(Vec3::ONE);
        Fresnel { metal: metal.to_array(), metallic: self.metallic, index: self.bsdf.index }
    }

    /// Returns true if the layer is as good as a mirror.
    fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// Albedo at normal incidence of what is rough, with that of the surface beneath, which is `diffuse`, as far as the layer lets light through.
    pub fn head_on_over(&self, reflectance: Vec3, diffuse: Vec3) -> Vec3 {
        let through = 1.0 - dielectric(self.bsdf.index, 1.0);
        let layer = Vec3::from(self.fresnel(reflectance).at(1.0)) * self.solid;
        let Some(coat) = &self.bsdf.coat else { return layer + diffuse * through };
        let coat =
            coat.seen(1.0, self.below_coat(reflectance, layer, through), SeenBy::Eye).in_part(self.solid);
        // of mirrors rays bring what they show
        let layer = if self.is_smooth() { Vec3::ZERO } else { layer };
        let of_coat = if coat.is_smooth() { 0.0 } else { coat.albedo };
        (layer + diffuse * through) * coat.lets_through + of_coat
    }

    /// Layer as a ray sees it: see [`Bsdfs::seen`](super::Bsdfs::seen).
    pub fn seen(
        &self,
        reflectance: Vec3,
        [normal, geometric_normal]: [Vec3; 2],
        incoming: Vec3,
        seen_by: SeenBy,
    ) -> SeenBsdf {
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
        let seen = SeenBsdf {
            axes,
            to_eye,
            alpha,
            fresnel,
            gain: gain * self.solid,
            albedo: albedo * self.solid,
            through: Vec3::splat(through),
            added: self.emission * (1.0 - through),
            coat: None,
        };
        match &self.bsdf.coat {
            None => seen,
            Some(coat) => {
                let below = self.below_coat(reflectance, seen.albedo, through);
                seen.below(coat.seen(to_eye.z, below, seen_by).in_part(self.solid), self.emission)
            }
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

/// What a surface reflects beside diffuse light, as one ray sees it: off its layer, and off the coat above that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenBsdf {
    /// Axes of the surface's space, in world space; the last is the normal.
    axes: [Vec3; 3],
    /// Direction to the eye in the surface's space.
    to_eye: Vec3,
    pub(super) alpha: f32,
    pub(super) fresnel: Fresnel<f32>,
    /// Factor for the light that microfacets of the layer reflect once.
    pub(super) gain: Vec3,
    /// Share of light from all around that is reflected to the eye, by all that reflects.
    pub albedo: Vec3,
    /// Share of scattered light that is let through to the eye.
    pub through: Vec3,
    /// Light to be added where `through` has dimmed emission.
    added: Vec3,
    /// Coat above the layer.
    coat: Option<CoatAbove>,
}

/// A coat above a layer, as one ray sees both.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CoatAbove {
    seen: SeenCoat,
    /// Chance with which a direction is sampled by its lobe, and not by that of the layer.
    chance: f32,
}

/// Direction in which a surface reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reflected {
    /// Direction, world space, unit length.
    pub direction: Vec3,
    /// Factor for the light that a ray in this direction brings.
    pub weight: Vec3,
    /// Density with which the direction was chosen, in solid angle; `None` for the one direction of a mirror.
    pub density: Option<f32>,
}

/// Chance with which a direction is sampled by the lobe of a coat, where these are the albedos of coat and layer.
#[inline]
pub fn chance_of_coat(coat: f32, layer: Vec3) -> f32 {
    let sum = coat + layer.max_element();
    if sum > 0.0 { coat / sum } else { 0.0 }
}

impl SeenBsdf {
    /// The same, below a coat. `emission`: that of the surface.
    fn below(self, coat: SeenCoat, emission: Vec3) -> Self {
        let albedo = self.albedo * coat.lets_through;
        let through = self.through * coat.lets_through;
        Self {
            gain: self.gain * coat.lets_through,
            albedo: albedo + coat.albedo,
            through,
            added: emission * (1.0 - through),
            coat: Some(CoatAbove { chance: chance_of_coat(coat.albedo, albedo), seen: coat }),
            ..self
        }
    }

    /// Albedo of the layer, without that of its coat.
    fn albedo_of_layer(&self) -> Vec3 {
        self.coat.map_or(self.albedo, |coat| self.albedo - coat.seen.albedo)
    }

    /// Returns true if the layer is as good as a mirror.
    fn is_layer_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// What of it reflects as a mirror does: one ray shows that. `None` if nothing does.
    pub fn smooth(self) -> Option<Self> {
        let Some(coat) = self.coat else { return Some(self).filter(Self::is_layer_smooth) };
        self.part(self.is_layer_smooth(), coat.seen.is_smooth())
    }

    /// What of it reflects and is rough: paths show that. `None` if nothing is.
    pub fn rough(self) -> Option<Self> {
        let Some(coat) = self.coat else { return Some(self).filter(|seen| !seen.is_layer_smooth()) };
        self.part(!self.is_layer_smooth(), !coat.seen.is_smooth())
    }

    /// The layer and the coat, either of them, or none.
    fn part(self, has_layer: bool, has_coat: bool) -> Option<Self> {
        let coat = self.coat?;
        let (of_layer, of_coat) = (self.albedo_of_layer(), Vec3::splat(coat.seen.albedo));
        let nothing = SeenCoat { gain: 0.0, albedo: 0.0, ..coat.seen };
        match [has_layer, has_coat] {
            [true, true] => Some(self),
            [true, false] => {
                Some(Self { albedo: of_layer, coat: Some(CoatAbove { seen: nothing, chance: 0.0 }), ..self })
            }
            [false, true] => {
                let coat = Some(CoatAbove { chance: 1.0, ..coat });
                Some(Self { albedo: of_coat, gain: Vec3::ZERO, coat, ..self })
            }
            [false, false] => None,
        }
    }

    /// Samples a direction by two numbers from 0 to below 1, unless it leads into the surface.
    pub fn reflect(&self, random: [f32; 2]) -> Option<Reflected> {
        match self.coat {
            None => self.reflect_off_layer(random),
            Some(coat) => self.reflect_off_either(&coat, random),
        }
    }

    fn reflect_off_layer(&self, random: [f32; 2]) -> Option<Reflected> {
        if self.is_layer_smooth() {
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

    /// Samples a direction by one of the lobes; what is not a mirror is weighted by the density of both.
    fn reflect_off_either(&self, coat: &CoatAbove, [first, second]: [f32; 2]) -> Option<Reflected> {
        let CoatAbove { seen, chance } = *coat;
        let by_coat = first < chance;
        let (alpha, is_smooth) =
            if by_coat { (seen.alpha, seen.is_smooth()) } else { (self.alpha, self.is_layer_smooth()) };
        if is_smooth {
            // where both are mirrors, one direction shows both
            return Some(self.mirrored(
                [seen.is_smooth(), self.is_layer_smooth()],
                if by_coat { chance } else { 1.0 - chance },
            ));
        }
        // the rest of the number that has chosen is as even as it was
        let rest = if by_coat { first / chance } else { (first - chance) / (1.0 - chance) };
        let to_light = ggx::sample(alpha, self.to_eye, [rest.min(MOST_RANDOM), second]);
        if to_light.z <= 0.0 {
            return None;
        }
        let direction = self.to_world(to_light);
        let (reflected, density) = self.towards(direction);
        (density > 0.0).then(|| Reflected { direction, weight: reflected / density, density: Some(density) })
    }

    /// The mirrored direction, with the light of what is a mirror, where one of them was chosen with this `chance`.
    fn mirrored(&self, [coat_is_smooth, layer_is_smooth]: [bool; 2], chance: f32) -> Reflected {
        let Vec3 { x, y, z } = self.to_eye;
        let coat = self
            .coat
            .filter(|_| coat_is_smooth)
            .map_or(Vec3::ZERO, |coat| Vec3::from(coat.seen.fresnel().at(z)) * coat.seen.gain);
        let layer = if layer_is_smooth { Vec3::from(self.fresnel.at(z)) * self.gain } else { Vec3::ZERO };
        let chance = if coat_is_smooth && layer_is_smooth { 1.0 } else { chance };
        Reflected {
            direction: self.to_world(Vec3::new(-x, -y, z)),
            weight: (coat + layer) / chance,
            density: None,
        }
    }

    /// Reflectance for light from `direction` (world space, unit length), times the cosine; and the density
    /// with which [`reflect`](Self::reflect) samples that direction. Both are of what is not a mirror.
    pub fn towards(&self, direction: Vec3) -> (Vec3, f32) {
        let to_light = self.to_local(direction);
        let Some(CoatAbove { seen, chance }) = self.coat else {
            let reflected = ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
            return (reflected, ggx::density(self.alpha, self.to_eye, to_light));
        };
        let (mut reflected, mut density) = (Vec3::ZERO, 0.0);
        if !self.is_layer_smooth() {
            reflected = ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
            density = (1.0 - chance) * ggx::density(self.alpha, self.to_eye, to_light);
        }
        if !seen.is_smooth() {
            reflected += ggx::reflected(seen.alpha, &seen.fresnel(), self.to_eye, to_light) * seen.gain;
            density += chance * ggx::density(seen.alpha, self.to_eye, to_light);
        }
        (reflected, density)
    }

    /// Dims scattered light by what is above it; `light` includes emission, which stays as it is.
    pub fn show(&self, light: Vec3) -> Vec3 {
        light * self.through + self.added
    }

    /// Highlight of a light that sends `irradiance` from `direction` (unit length), in the units in which a
    /// white surface reflects as much as it gets; and the density with which [`reflect`](Self::reflect)
    /// samples that direction. `met`: paths meet the light, which mirrors show by them alone.
    pub fn highlight(&self, direction: Vec3, irradiance: Vec3, met: bool) -> (Vec3, f32) {
        let (mut reflected, density) = self.towards(direction);
        if let (Some(CoatAbove { seen, .. }), false) = (self.coat, met) {
            let to_light = self.to_local(direction);
            if self.is_layer_smooth() {
                reflected += ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
            }
            if seen.is_smooth() {
                reflected += ggx::reflected(seen.alpha, &seen.fresnel(), self.to_eye, to_light) * seen.gain;
            }
        }
        if self.coat.is_none() && met && self.is_layer_smooth() {
            reflected = Vec3::ZERO;
        }
        (reflected * irradiance * PI, density)
    }

    /// Density with which [`reflect`](Self::reflect) samples `direction` (world space, unit length).
    pub fn density(&self, direction: Vec3) -> f32 {
        match self.coat {
            None => ggx::density(self.alpha, self.to_eye, self.to_local(direction)),
            Some(_) => self.towards(direction).1,
        }
    }

    /// Returns true if all lobes are so narrow that what they show is seen as in a mirror. Paths see no narrower
    /// one, but for glass.
    pub fn is_narrow(&self) -> bool {
        let is_narrow = |alpha: f32| alpha < LEAST_ALPHA_OF_PATHS;
        is_narrow(self.alpha) && self.coat.is_none_or(|coat| is_narrow(coat.seen.alpha))
    }

    fn to_local(self, direction: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(direction)))
    }

    fn to_world(self, direction: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        (x * direction.x + y * direction.y + z * direction.z).normalize_or(z)
    }
}

/// Greatest random number below 1.
const MOST_RANDOM: f32 = 1.0 - f32::EPSILON / 2.0;
