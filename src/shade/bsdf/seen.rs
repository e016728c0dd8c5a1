//! What one surface reflects beside diffuse light, as one ray sees it.

use std::f32::consts::PI;

use glam::Vec3;

use super::coat::SeenCoat;
use super::fresnel::Fresnel;
use super::ggx;
use super::hair::SeenHair;
use super::seen_by::LEAST_ALPHA_OF_PATHS;
use super::stretched::Widths;
use super::upper::{Chances, Lobe, Upper};
use crate::scene::material::LEAST_ALPHA;

/// Directions of a surface, world space, on the side from which it is seen.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceAxes<V> {
    /// Shading normal, unit length.
    pub normal: V,
    /// Normal of the triangle, unit length.
    pub geometric_normal: V,
    /// Tangent, of any length; zero if it has none, or nothing asks for it.
    pub tangent: V,
}

impl<V: Default> SurfaceAxes<V> {
    /// Those of a surface without a tangent.
    pub fn of_normals([normal, geometric_normal]: [V; 2]) -> Self {
        Self { normal, geometric_normal, tangent: V::default() }
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

/// What a surface reflects beside diffuse light, as one ray sees it: off its layer, and off what is above that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenBsdf {
    /// Axes of the surface's space, in world space; the last is the normal.
    pub(super) axes: [Vec3; 3],
    /// Direction to the eye in the surface's space.
    pub(super) to_eye: Vec3,
    pub(super) alpha: f32,
    pub(super) fresnel: Fresnel<f32>,
    /// Factor for the light that microfacets of the layer reflect once.
    pub(super) gain: Vec3,
    /// Share of light from all around that is reflected to the eye, by all that reflects.
    pub albedo: Vec3,
    /// Share of scattered light that is let through to the eye.
    pub through: Vec3,
    /// Light to be added where `through` has dimmed emission.
    pub(super) added: Vec3,
    /// What is above the layer.
    pub(super) upper: Option<Upper>,
    /// Widths of the layer's lobe along both axes, if it is not round.
    pub(super) widths: Option<Widths<f32>>,
    /// The fibre in place of all of that.
    pub(super) hair: Option<SeenHair>,
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

impl SeenBsdf {
    /// The same, below other layers, and above what is matt, of whose light this share is `shown`. `emission`: that of the surface.
    pub(super) fn with(self, upper: Upper, shown: Vec3, emission: Vec3) -> Self {
        let albedo = self.albedo * upper.lets_through;
        let through = self.through * upper.lets_through * shown;
        Self {
            gain: self.gain * upper.lets_through,
            albedo: albedo + upper.albedo(),
            through,
            added: emission * (1.0 - through),
            upper: Some(upper),
            ..self
        }
    }

    /// Albedo of the layer, without that of what is above it.
    fn albedo_of_layer(&self) -> Vec3 {
        self.upper.map_or(self.albedo, |upper| self.albedo - upper.albedo())
    }

    /// Returns true if the layer is as good as a mirror.
    fn is_layer_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }

    /// What of it reflects as a mirror does: one ray shows that. `None` if nothing does.
    pub fn smooth(self) -> Option<Self> {
        if self.hair.is_some() {
            return None;
        }
        let Some(upper) = self.upper else { return Some(self).filter(Self::is_layer_smooth) };
        self.part(self.is_layer_smooth(), upper.smooth())
    }

    /// What of it reflects and is rough: paths show that. `None` if nothing is.
    pub fn rough(self) -> Option<Self> {
        if self.hair.is_some() {
            return Some(self);
        }
        let Some(upper) = self.upper else { return Some(self).filter(|seen| !seen.is_layer_smooth()) };
        self.part(!self.is_layer_smooth(), upper.rough())
    }

    /// Returns true if anything of it [is rough](Self::rough).
    pub fn is_rough(&self) -> bool {
        match &self.upper {
            None if self.hair.is_some() => true,
            None => !self.is_layer_smooth(),
            Some(upper) => {
                let of_layer = if self.is_layer_smooth() { Vec3::ZERO } else { self.albedo_of_layer() };
                (of_layer + upper.rough().albedo()).max_element() > 0.0
            }
        }
    }

    /// The layer, if it `has` it, below these others. `None` if nothing reflects.
    fn part(self, has_layer: bool, upper: Upper) -> Option<Self> {
        let of_layer = if has_layer { self.albedo_of_layer() } else { Vec3::ZERO };
        let gain = if has_layer { self.gain } else { Vec3::ZERO };
        let albedo = of_layer + upper.albedo();
        let upper = Some(Upper { chances: upper.chances_above(of_layer), ..upper });
        (albedo.max_element() > 0.0).then_some(Self { gain, albedo, upper, ..self })
    }

    /// Samples a direction by two numbers from 0 to below 1, unless it leads into the surface.
    pub fn reflect(&self, random: [f32; 2]) -> Option<Reflected> {
        if let Some(hair) = &self.hair {
            let to_light = hair.sample(self.to_eye, random);
            let (reflected, density) = hair.towards(self.to_eye, to_light);
            let direction = self.to_world(to_light);
            let weight = reflected / density;
            return (density > 0.0).then_some(Reflected { direction, weight, density: Some(density) });
        }
        match &self.upper {
            None => self.reflect_off_layer(random),
            Some(upper) => self.reflect_off_any(upper, random),
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

    /// Samples a direction by one of the lobes; what is not a mirror is weighted by the density of all of them.
    fn reflect_off_any(&self, upper: &Upper, [first, second]: [f32; 2]) -> Option<Reflected> {
        let Upper { coat, fuzz, chances, .. } = upper;
        let (lobe, rest) = chances.choose(first);
        let random = [rest, second];
        let mirrors = [coat.is_smooth(), self.is_layer_smooth()];
        let to_light = match lobe {
            // where both are mirrors, one direction shows both
            Lobe::Coat if coat.is_smooth() => return Some(self.mirrored(coat, mirrors, chances.coat)),
            Lobe::Layer if self.is_layer_smooth() => {
                return Some(self.mirrored(coat, mirrors, chances.layer()));
            }
            Lobe::Fuzz => fuzz.lobe.sample(self.to_eye, random),
            Lobe::Coat => ggx::sample(coat.alpha, self.to_eye, random),
            Lobe::Layer => self.sample_layer(random),
        };
        if to_light.z <= 0.0 {
            return None;
        }
        let direction = self.to_world(to_light);
        let (reflected, density) = self.towards(direction);
        (density > 0.0).then(|| Reflected { direction, weight: reflected / density, density: Some(density) })
    }

    /// Samples a direction by the layer's lobe, which may lead into the surface.
    fn sample_layer(&self, random: [f32; 2]) -> Vec3 {
        match &self.widths {
            None => ggx::sample(self.alpha, self.to_eye, random),
            Some(widths) => widths.sample(self.to_eye, random),
        }
    }

    /// What the layer, which is rough, reflects from a direction in the surface's space, times the cosine, and the density with which its lobe
    /// is sampled there.
    fn layer_towards(&self, to_light: Vec3) -> (Vec3, f32) {
        match &self.widths {
            None => {
                let reflected = ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
                (reflected, ggx::density(self.alpha, self.to_eye, to_light))
            }
            Some(widths) => match widths.towards(self.to_eye, to_light) {
                Some(([shape, density], cos)) => {
                    (Vec3::from(self.fresnel.at(cos)) * (shape * self.gain), density)
                }
                None => (Vec3::ZERO, 0.0),
            },
        }
    }

    /// The mirrored direction, with the light of what is a mirror, where one of them was chosen with this `chance`.
    fn mirrored(
        &self,
        coat: &SeenCoat,
        [coat_is_smooth, layer_is_smooth]: [bool; 2],
        chance: f32,
    ) -> Reflected {
        let Vec3 { x, y, z } = self.to_eye;
        let chances = self.upper.map_or(Chances::LAYER, |upper| upper.chances);
        let of_coat = if coat_is_smooth { Vec3::from(coat.fresnel().at(z)) * coat.gain } else { Vec3::ZERO };
        let of_layer = if layer_is_smooth { Vec3::from(self.fresnel.at(z)) * self.gain } else { Vec3::ZERO };
        let chance = if coat_is_smooth && layer_is_smooth { 1.0 - chances.fuzz } else { chance };
        Reflected {
            direction: self.to_world(Vec3::new(-x, -y, z)),
            weight: (of_coat + of_layer) / chance,
            density: None,
        }
    }

    /// Reflectance for light from `direction` (world space, unit length), times the cosine; and the density
    /// with which [`reflect`](Self::reflect) samples that direction. Both are of what is not a mirror.
    pub fn towards(&self, direction: Vec3) -> (Vec3, f32) {
        let to_light = self.to_local(direction);
        if let Some(hair) = &self.hair {
            return hair.towards(self.to_eye, to_light);
        }
        let Some(Upper { coat, fuzz, chances, .. }) = &self.upper else {
            let reflected = ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
            return (reflected, ggx::density(self.alpha, self.to_eye, to_light));
        };
        let (mut reflected, mut density) = (Vec3::ZERO, 0.0);
        if !self.is_layer_smooth() {
            let (of_layer, of_lobe) = self.layer_towards(to_light);
            (reflected, density) = (of_layer, chances.layer() * of_lobe);
        }
        if !coat.is_smooth() {
            reflected += ggx::reflected(coat.alpha, &coat.fresnel(), self.to_eye, to_light) * coat.gain;
            density += chances.coat * ggx::density(coat.alpha, self.to_eye, to_light);
        }
        if fuzz.albedo != Vec3::ZERO {
            let of_fuzz = fuzz.lobe.density_of(self.to_eye, to_light);
            reflected += fuzz.albedo * of_fuzz;
            density += chances.fuzz * of_fuzz;
        }
        (reflected, density)
    }

    /// What microfacets of its layer reflect once of light from `direction` (world space, unit length), times the cosine.
    #[cfg(test)]
    pub fn once_towards(&self, direction: Vec3) -> Vec3 {
        ggx::reflected(self.alpha, &self.fresnel, self.to_eye, self.to_local(direction))
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
        if let (Some(Upper { coat, .. }), false) = (&self.upper, met) {
            let to_light = self.to_local(direction);
            if self.is_layer_smooth() {
                reflected += ggx::reflected(self.alpha, &self.fresnel, self.to_eye, to_light) * self.gain;
            }
            if coat.is_smooth() {
                reflected += ggx::reflected(coat.alpha, &coat.fresnel(), self.to_eye, to_light) * coat.gain;
            }
        }
        if self.upper.is_none() && met && self.is_layer_smooth() && self.hair.is_none() {
            reflected = Vec3::ZERO;
        }
        (reflected * irradiance * PI, density)
    }

    /// Density with which [`reflect`](Self::reflect) samples `direction` (world space, unit length).
    pub fn density(&self, direction: Vec3) -> f32 {
        match self.upper {
            None if self.hair.is_none() => ggx::density(self.alpha, self.to_eye, self.to_local(direction)),
            _ => self.towards(direction).1,
        }
    }

    /// Returns true if all lobes are so narrow that what they show is seen as in a mirror. Paths see no narrower
    /// one, but for glass.
    pub fn is_narrow(&self) -> bool {
        let is_narrow = |alpha: f32| alpha < LEAST_ALPHA_OF_PATHS;
        let is_upper_narrow = |upper: &Upper| is_narrow(upper.coat.alpha) && upper.fuzz.albedo == Vec3::ZERO;
        is_narrow(self.alpha) && self.upper.as_ref().is_none_or(is_upper_narrow)
    }

    fn to_local(self, direction: Vec3) -> Vec3 {
        Vec3::from(self.axes.map(|axis| axis.dot(direction)))
    }

    fn to_world(self, direction: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        (x * direction.x + y * direction.y + z * direction.z).normalize_or(z)
    }
}
