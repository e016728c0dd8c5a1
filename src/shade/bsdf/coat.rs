//! Clear coats: a dielectric above all else that a surface has, as OpenPBR has it (Academy Software Foundation, "OpenPBR Surface
//! specification", version 1.1, "coat").
//!
//! - It *reflects* by microfacets of its own, as the layer below does ([`ggx`](super::ggx), [`albedos`](super::albedos)).
//! - What is *below* gets the rest: one less the coat's albedo in the direction of the ray (albedo scaling).
//! - It *absorbs* light on its way in and out. Which way light came in is not known where it was scattered below, so that it counts
//!   as long as the way out: the tint, which is that of both ways at right angles, to the power of one over the cosine within the coat.
//! - It *darkens* what is below: light that comes back from there is in part reflected inside, and meets it again. Of the light that leaves
//!   a surface whose albedo is E below a coat that reflects a share K of it back, (1 - K) / (1 - E K) of what it would without
//!   comes out (a geometric series). K is the share of light from all around below what is matt, and Fresnel's of the one direction
//!   below what is a mirror; in between it is mixed by the roughness.
//!
//! Emission is as bright with a coat as without: lights are asked for by what they emit, whoever sees them.

use std::sync::Arc;

use glam::Vec3;

use super::albedos::{Albedos, LEAST_ALBEDO, Layer, Shares};
use super::fresnel::{Fresnel, dielectric};
use super::seen_by::{SeenBy, regularized};
use crate::scene::material::{Coat, LEAST_ALPHA};

/// Coat of a material.
#[derive(Debug, Clone)]
pub struct CoatLayer {
    coat: Coat,
    albedos: Arc<Albedos>,
    albedos_of_paths: Arc<Albedos>,
    /// Share of light from below, from all around, that it reflects back.
    inside: f32,
}

/// What is below a coat, as one ray sees it.
#[derive(Debug, Clone, Copy)]
pub struct BelowCoat {
    /// Share of light from all around that it sends back.
    pub albedo: Vec3,
    /// Roughness on the whole, from 0 (a mirror) to 1 (matt).
    pub roughness: f32,
}

/// A coat as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenCoat {
    /// Width of its lobe.
    pub alpha: f32,
    /// Index of refraction.
    pub index: f32,
    /// Factor for the light that microfacets reflect once.
    pub gain: f32,
    /// Share of light from all around that it reflects.
    pub albedo: f32,
    /// Share of the light of what is below that comes through.
    pub lets_through: Vec3,
}

/// Layers of a coat as the eye and as paths see it.
pub fn layers(coat: &Coat) -> [Layer; 2] {
    [coat.alpha(), regularized(coat.alpha())].map(|alpha| Layer { alpha, index: coat.index, is_glass: false })
}

impl CoatLayer {
    /// Creates the layer of a coat, with the light of its [`layers`].
    pub fn new(coat: Coat, [albedos, albedos_of_paths]: [Arc<Albedos>; 2]) -> Self {
        let square = coat.index * coat.index;
        let inside = 1.0 - (1.0 - from_all_around(coat.index)) / square;
        Self { coat, albedos, albedos_of_paths, inside }
    }

    /// Width of its lobe to the eye.
    pub fn alpha(&self) -> f32 {
        self.coat.alpha()
    }

    /// The coat as a ray sees it at this cosine, with what is `below` it at that angle.
    pub fn seen(&self, cos: f32, below: BelowCoat, seen_by: SeenBy) -> SeenCoat {
        let Coat { weight, index, tint, darkening, .. } = self.coat;
        let (alpha, albedos) = match seen_by {
            SeenBy::Eye => (self.coat.alpha(), &self.albedos),
            SeenBy::Path => (regularized(self.coat.alpha()), &self.albedos_of_paths),
        };
        let shares = Shares::new(albedos.at(cos));
        let gain = if shares.clear_once > LEAST_ALBEDO { shares.clear / shares.clear_once } else { 1.0 };
        let cos_within = (1.0 - (1.0 - cos * cos) / (index * index)).max(0.0).sqrt();
        let BelowCoat { albedo, roughness } = below;
        let mirrored = dielectric(index, cos);
        let inside = mirrored + (self.inside - mirrored) * roughness;
        let comes_out = (1.0 - inside) / (Vec3::ONE - albedo.clamp(Vec3::ZERO, Vec3::ONE) * inside);
        let darkened = Vec3::ONE + (comes_out - 1.0) * darkening;
        let passes = tint.powf(1.0 / cos_within) * darkened * (1.0 - shares.clear).clamp(0.0, 1.0);
        SeenCoat {
            alpha,
            index,
            gain: gain * weight,
            albedo: shares.clear * weight,
            lets_through: Vec3::ONE + (passes - 1.0) * weight,
        }
    }
}

impl SeenCoat {
    /// None at all.
    pub const NONE: Self = Self { alpha: 0.0, index: 1.0, gain: 0.0, albedo: 0.0, lets_through: Vec3::ONE };

    /// The same where this share of what it reflects is seen.
    #[must_use]
    pub fn dimmed(self, share: f32) -> Self {
        Self { gain: self.gain * share, albedo: self.albedo * share, ..self }
    }

    /// Reflectance of its microfacets.
    pub fn fresnel(&self) -> Fresnel<f32> {
        Fresnel { metal: [0.0; 3], edge: 1.0, metallic: 0.0, index: self.index }
    }

    /// The same of a surface of which this share is there: what is below it has its share already.
    pub fn in_part(self, solid: f32) -> Self {
        self.dimmed(solid)
    }

    /// Returns true if it is as good as a mirror.
    pub fn is_smooth(&self) -> bool {
        self.alpha <= LEAST_ALPHA
    }
}

/// Share of light from all around that a dielectric of this index reflects.
fn from_all_around(index: f32) -> f32 {
    const STEPS: u32 = 256;
    let at = |step: u32| (step as f32 + 0.5) / STEPS as f32;
    (0..STEPS).map(|step| 2.0 * at(step) * dielectric(index, at(step))).sum::<f32>() / STEPS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(coat: Coat) -> CoatLayer {
        CoatLayer::new(coat, layers(&coat).map(|layer| Arc::new(Albedos::new(layer))))
    }

    fn matt(albedo: f32) -> BelowCoat {
        BelowCoat { albedo: Vec3::splat(albedo), roughness: 1.0 }
    }

    const CLEAR: Coat = Coat { weight: 1.0, roughness: 0.0, index: 1.5, tint: Vec3::ONE, darkening: 1.0 };

    /// What a coat reflects, it does not let through; and above white it darkens nothing: no light is lost.
    #[test]
    fn white_stays_white_below_a_coat() {
        for roughness in [0.0, 0.3, 0.8] {
            for cos in [1.0, 0.5, 0.1] {
                let seen = layer(Coat { roughness, ..CLEAR }).seen(cos, matt(1.0), SeenBy::Eye);
                let sum = seen.lets_through + seen.albedo;
                assert!((sum - 1.0).abs().max_element() < 1e-5, "{roughness} {cos}: {sum}");
            }
        }
    }

    /// A surface of 18 % grey below a coat of index 1.5, which reflects 60 % of what comes from below back, head-on.
    #[test]
    fn grey_is_darker_below_a_coat() {
        let seen = layer(CLEAR).seen(1.0, matt(0.18), SeenBy::Eye);
        let inside = layer(CLEAR).inside;
        assert!((inside - 0.596).abs() < 2e-3, "{inside}");
        let expected = 0.96 * (1.0 - 0.596) / (1.0 - 0.18 * 0.596);
        assert!((seen.lets_through.x - expected).abs() < 2e-3, "{}", seen.lets_through);
        let plain = layer(Coat { darkening: 0.0, ..CLEAR }).seen(1.0, matt(0.18), SeenBy::Eye);
        assert!((plain.lets_through.x - 0.96).abs() < 1e-3);
    }

    /// The tint is that of light that comes and goes head-on, and deeper aslant; half a coat has half of it.
    #[test]
    fn tints_are_deeper_aslant() {
        let tint = Vec3::new(1.0, 0.5, 0.25);
        let tinted = Coat { tint, darkening: 0.0, ..CLEAR };
        let head_on = layer(tinted).seen(1.0, matt(1.0), SeenBy::Eye).lets_through / 0.96;
        assert!((head_on - tint).abs().max_element() < 2e-3, "{head_on}");
        let aslant = layer(tinted).seen(0.5, matt(1.0), SeenBy::Eye).lets_through;
        assert!((aslant.y / aslant.x - 0.5_f32.powf(1.0 / 0.816_5)).abs() < 1e-3, "{aslant}");
        let half = layer(Coat { weight: 0.5, ..tinted }).seen(1.0, matt(1.0), SeenBy::Eye).lets_through;
        assert!((half - (0.5 + 0.48 * tint)).abs().max_element() < 2e-3, "{half}");
    }
}
