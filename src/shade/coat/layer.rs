//! The layer of one surface, as one ray sees it.

use std::f32::consts::PI;

use glam::Vec3;

use crate::scene::material::LEAST_ALPHA;
use crate::shade::ggx;
use crate::shade::sampling::{PathRandom, orthonormal};

/// Least cosine to the eye that is used in formulas: below it, a direction counts as lying in the surface.
pub const LEAST_COSINE: f32 = 1e-4;

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
    /// Reflectance, at right angles, of the part that is not metal; it lets light through.
    pub clear: f32,
    /// Share of light that does not pass straight through.
    pub solid: f32,
    /// Emission (`Ke`), which the layer does not dim.
    pub emission: Vec3,
    pub albedos: Albedos,
    /// Alpha as paths see it that have been scattered before.
    pub alpha_of_paths: f32,
    pub albedos_of_paths: Albedos,
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

/// Reflection of light from all around by microfacets of one roughness, by the cosine to the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Albedos {
    /// Albedos in even steps of the cosine from 0 to 1: the share that white microfacets reflect, and the
    /// part of it that is white in Schlick's formula.
    pub steps: [[f32; 2]; Albedos::STEPS + 1],
}

impl Albedos {
    /// Number of steps: with 64, lines are within 1e-3 of the fifth power in Schlick's formula.
    const STEPS: usize = 64;

    /// Number of directions by which each is measured: the error of an evenly spread sequence is below 1e-3.
    const SAMPLES: u32 = 1024;

    pub fn new(alpha: f32) -> Self {
        let random = |index| {
            let [along, above, ..] = PathRandom::new(0, index).four(0);
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

    /// Interpolates both between the steps.
    #[inline]
    pub fn at(&self, cos: f32) -> [f32; 2] {
        let at = cos.clamp(0.0, 1.0) * Self::STEPS as f32;
        let step = (at as usize).min(Self::STEPS - 1);
        let rest = at - step as f32;
        let [low, high] = [self.steps[step], self.steps[step + 1]];
        [0, 1].map(|of| low[of] + (high[of] - low[of]) * rest)
    }
}

/// Share of light from all around that microfacets reflect once.
#[inline]
pub fn reflected_once(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    head_on * all + (Vec3::ONE - head_on) * white
}

/// Share of light from all around that microfacets reflect once or several times.
#[inline]
pub fn albedo(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    let several_times = head_on * ((1.0 - all).max(0.0) / all);
    reflected_once(head_on, [all, white]) * (Vec3::ONE + several_times)
}

impl Coat {
    /// Returns true if the layer is as good as a mirror.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
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
        let (clear, metallic) = (Vec3::splat(self.clear), self.metallic);
        let metal = (self.metal + self.metal_of_kept * reflectance).min(Vec3::ONE);
        let head_on = clear + (metal - clear) * metallic;
        let albedos = albedos.at(to_eye.z);
        let [of_clear, of_metal] = [clear, metal].map(|head_on| albedo(head_on, albedos));
        let albedo = of_clear + (of_metal - of_clear) * metallic;
        let once = reflected_once(head_on, albedos);
        // a surface that reflects nothing needs no factor
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
    pub(super) head_on: Vec3,
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

    /// Reflectance for light from `direction` (world space, unit length), times the cosine; and the density
    /// with which [`reflect`](Self::reflect) samples that direction. Both are for surfaces that are not
    /// smooth.
    pub fn towards(&self, direction: Vec3) -> (Vec3, f32) {
        let to_light = self.to_local(direction);
        let reflected = ggx::reflected(self.alpha, self.head_on, self.to_eye, to_light) * self.gain;
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
    /// one.
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
