//! Light of the sky, for rays that leave the scene, and sampling of directions by it.

use glam::Vec3;

use crate::scene::{Background, Environment, LightFrom, Scene, SkyDensity};

/// The sky of a scene: its environment, or else its background.
#[derive(Debug, Clone)]
pub struct SkyLight {
    background: Background,
    environment: Option<Environment>,
    /// Distribution to sample directions from: the environment, or one made of the background. `None` if the
    /// sky is black.
    sampled: Option<Environment>,
    /// True if all of it is dark, though directions are sampled as if it were not.
    is_dark: bool,
}

impl SkyLight {
    /// Creates the sky of `scene`.
    pub fn new(scene: &Scene) -> Self {
        let (background, environment) = (scene.background, scene.environment.clone());
        let sampled = environment.clone().unwrap_or_else(|| Environment::from_background(&background));
        Self { background, environment, sampled: Some(sampled).filter(|sky| !sky.is_black()), is_dark: false }
    }

    /// Takes its light away, if that is wanted: directions are sampled as before.
    #[must_use]
    pub fn dark_if(self, is_dark: bool) -> Self {
        Self { is_dark, ..self }
    }

    /// Radiance from `direction` (world space, unit length) that lights surfaces and that mirrors show.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        if self.is_dark {
            return Vec3::ZERO;
        }
        match &self.environment {
            Some(environment) => environment.radiance(direction),
            None => self.background.radiance(direction),
        }
    }

    /// Radiance from `direction` (world space, unit length) as the eye sees it.
    #[inline]
    pub fn seen(&self, direction: Vec3) -> Vec3 {
        if self.is_dark {
            return Vec3::ZERO;
        }
        match &self.environment {
            Some(environment) if environment.visible => environment.radiance(direction),
            _ => self.background.radiance(direction),
        }
    }

    /// Returns true if there is light in the sky.
    pub fn shines(&self) -> bool {
        self.sampled.is_some()
    }

    /// Returns true if directions are worth sampling where paths leave by the cosine law in any case. A
    /// gradient without an environment counts as even.
    pub fn is_uneven(&self) -> bool {
        self.samples() > 0
    }

    /// Number of rays to the sky at the start of a path.
    pub fn samples(&self) -> u32 {
        let asked = self.environment.as_ref().filter(|environment| self.shines() && environment.has_peaks());
        asked.map_or(0, |environment| environment.samples)
    }

    /// Samples a direction (world space, unit length) with this density.
    #[inline]
    pub fn sample(&self, density: SkyDensity, random: [f32; 2]) -> Vec3 {
        self.sampled.as_ref().map_or(Vec3::Y, |sky| sky.sample(density, random))
    }

    /// Radiance from `direction`, and the density with which [`sample`](Self::sample) chooses it.
    #[inline]
    pub fn light(&self, density: SkyDensity, direction: Vec3) -> LightFrom {
        let light = self.sampled.as_ref().map_or(LightFrom::NONE, |sky| sky.light(density, direction));
        match &self.environment {
            _ if self.is_dark => LightFrom { radiance: Vec3::ZERO, ..light },
            Some(_) => light,
            None => LightFrom { radiance: self.background.radiance(direction), ..light },
        }
    }
}
