//! Looks: what a surface is made of at one place.

use glam::Vec3;

use super::shared_exponent::SharedExponent;
use super::texture::{linear, srgb_share};

/// Maximum of a material's colour channels: samples keep them as half floats.
pub const LARGEST_COLOR: f32 = 65504.0;

/// Parameters of a surface that vary from place to place, as samples keep them: rounded once, when a sample is traced. Each is a factor of
/// the material's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(C)]
pub struct Varied {
    /// Roughness of the layer, in 255ths; of a highlight without a layer the exponent.
    pub roughness: u8,
    /// Share of metal, in 255ths.
    pub metalness: u8,
    /// Share of the surface that is there, in 255ths: the rest lets light pass straight through.
    pub opacity: u8,
    /// Colour of highlights, sRGB-encoded.
    pub highlight: [u8; 3],
    /// Emission, linear RGB.
    pub emission: SharedExponent,
}

impl Varied {
    /// All parameters are the material's own.
    pub const NONE: Self = Self {
        roughness: u8::MAX,
        metalness: u8::MAX,
        opacity: u8::MAX,
        highlight: [u8::MAX; 3],
        emission: SharedExponent::ONE,
    };

    /// The factor that a number from 0 to 1 is kept as.
    pub fn rounded(factor: f32) -> u8 {
        // a cast of NaN is 0
        (factor.clamp(0.0, 1.0) * f32::from(u8::MAX) + 0.5) as u8
    }

    /// The factor on highlights that a colour from 0 to 1, linear RGB, is kept as.
    pub fn rounded_highlight(color: Vec3) -> [u8; 3] {
        let encoded = |share: f32| srgb_share(f64::from(share.clamp(0.0, 1.0))) * f64::from(u8::MAX) + 0.5;
        color.to_array().map(|share| encoded(share) as u8)
    }

    /// The factor on the roughness, from 0 to 1.
    #[inline]
    pub fn of_roughness(self) -> f32 {
        f32::from(self.roughness) / f32::from(u8::MAX)
    }

    /// The factor on the share of metal, from 0 to 1.
    #[inline]
    pub fn of_metal(self) -> f32 {
        f32::from(self.metalness) / f32::from(u8::MAX)
    }

    /// The share of the surface that is there, from 0 to 1.
    #[inline]
    pub fn of_opacity(self) -> f32 {
        f32::from(self.opacity) / f32::from(u8::MAX)
    }

    /// The factor on highlights, linear RGB from 0 to 1.
    #[inline]
    pub fn of_highlight(self) -> Vec3 {
        Vec3::from(self.highlight.map(linear))
    }

    /// Light that a surface sends whose material's emission is this: radiance, linear RGB.
    #[inline]
    pub fn light_of(self, emission: Vec3) -> Vec3 {
        (emission * self.emission.color()).min(Vec3::splat(LARGEST_COLOR)) * self.of_opacity()
    }
}

impl Default for Varied {
    fn default() -> Self {
        Self::NONE
    }
}

/// Material of a surface, with its parameters at one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Look {
    /// Index into [`Scene::materials`](crate::scene::Scene::materials).
    pub material: u16,
    /// Parameters there.
    pub varied: Varied,
}

impl Look {
    /// A material whose parameters are its own.
    pub fn plain(material: u16) -> Self {
        Self { material, varied: Varied::NONE }
    }
}
