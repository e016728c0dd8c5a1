//! The layer of one surface, as one ray sees it.

use std::f32::consts::PI;

use glam::Vec3;

use crate::shade::ggx::{self, LEAST_ALPHA};
use crate::shade::sampling::{PathRandom, orthonormal};

/// The least cosine to the eye that is reckoned with: below it, a direction lies in the surface.
pub const LEAST_COSINE: f32 = 1e-4;

/// An albedo that is taken for black.
pub const LEAST_ALBEDO: f32 = 1e-6;

/// The layer of a material.
#[derive(Debug, Clone)]
pub struct Coat {
    pub alpha: f32,
    /// From 0 to 1.
    pub metallic: f32,
    /// What the metal reflects at right angles: this, and this for each unit of the reflectance that is kept.
    pub metal: Vec3,
    pub metal_of_kept: Vec3,
    /// What the rest reflects at right angles; it lets light through.
    pub clear: f32,
    /// The share of light that does not pass straight through.
    pub solid: f32,
    /// Ke, which the layer does not dim.
    pub emission: Vec3,
    pub albedos: Albedos,
    /// The same as paths find it, which have been scattered before.
    pub alpha_of_paths: f32,
    pub albedos_of_paths: Albedos,
}

/// How a surface is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenBy {
    /// By a ray that has been mirrored at most since it left the eye.
    Eye,
    /// By a path that has been scattered before. What is smooth focuses lights and the sun, which few paths find, each of them a
    /// spark: to paths it is rougher.
    Path,
}

/// What microfacets of one roughness reflect of light from all around, by the cosine to the eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Albedos {
    /// In even steps from 0 to 1: reflected by white microfacets; and of that, what Schlick's formula calls white.
    pub steps: [[f32; 2]; Albedos::STEPS + 1],
}

impl Albedos {
    /// With 64 steps lines are within 1e-3 of the fifth power in Schlick's formula.
    const STEPS: usize = 64;

    /// Directions by which each is measured: the error of an evenly spread sequence is below 1e-3.
    const SAMPLES: u32 = 1024;

    pub fn of(alpha: f32) -> Self {
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
    pub fn at(&self, cos: f32) -> [f32; 2] {
        let at = cos.clamp(0.0, 1.0) * Self::STEPS as f32;
        let step = (at as usize).min(Self::STEPS - 1);
        let rest = at - step as f32;
        let [low, high] = [self.steps[step], self.steps[step + 1]];
        [0, 1].map(|of| low[of] + (high[of] - low[of]) * rest)
    }
}

/// What microfacets reflect once of light from all around.
#[inline]
pub fn reflected_once(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    head_on * all + (Vec3::ONE - head_on) * white
}

/// What they reflect once or several times.
#[inline]
pub fn albedo(head_on: Vec3, [all, white]: [f32; 2]) -> Vec3 {
    let several_times = head_on * ((1.0 - all).max(0.0) / all);
    reflected_once(head_on, [all, white]) * (Vec3::ONE + several_times)
}

impl Coat {
    /// As [`Coats::seen`](super::Coats::seen).
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

/// The normal about which a surface reflects to the eye: an interpolated one, unless it would send the mirrored direction below
/// the triangle.
#[inline]
pub fn facing(normal: Vec3, geometric_normal: Vec3, to_eye: Vec3) -> Vec3 {
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
    pub(super) alpha: f32,
    pub(super) head_on: Vec3,
    /// Of what microfacets reflect once.
    pub(super) gain: Vec3,
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
