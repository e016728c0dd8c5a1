//! Materials whose parameters a picture gives: roughness, metal, emission, highlights.
//!
//! Such a material has variants: materials of its own for all values that its pictures hold, of which each texel names one. A
//! surface is of one variant at each place, and everything that knows materials by their number need not know of pictures: what
//! samples keep is the number of the variant. Between texels one of the nearest four is chosen by the place, each as often as
//! interpolation would weigh it.

use std::sync::Arc;

use glam::Vec2;

use super::texture::Placement;

/// Variants of a material: one of them for each texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Variants {
    /// Index of the first variant in [`Scene::materials`](super::Scene::materials); the others follow it.
    pub first: u16,
    /// Number of the variant by texel, rows from the top.
    pub of_texel: Arc<[u16]>,
    /// Place of the texels on surfaces.
    pub placement: Placement,
}

/// Place on a primitive: its number, and the weights of its second and third corner.
pub type OnPrimitive = (u32, [f32; 2]);

impl Variants {
    /// Index of the material at the texture coordinates `uv` of a place. It depends on nothing else: the same place has the same
    /// variant in all frames.
    #[inline]
    pub fn at(&self, uv: Vec2, place: OnPrimitive) -> u16 {
        let between = self.placement.between(uv);
        self.first + self.of_texel[between.chosen(random_of(place))]
    }
}

/// Two numbers from 0 to below 1 that are different for each place.
fn random_of((primitive, [u, v]): OnPrimitive) -> [f32; 2] {
    // no zero is negative
    let mut hash = primitive.wrapping_mul(0x9e37_79b9);
    for bits in [u, v].map(|weight| (weight + 0.0).to_bits()) {
        hash = mixed(hash ^ bits);
    }
    [hash, mixed(hash ^ 0x85eb_ca6b)].map(|bits| (bits >> 8) as f32 / (1 << 24) as f32)
}

/// Mixes the bits of a word, so that each depends on all (Chris Wellons, "Prospecting for Hash Functions", 2018, `lowbias32`).
pub(crate) fn mixed(mut bits: u32) -> u32 {
    bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
    bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variants() -> Variants {
        let placement = Placement { width: 2, height: 1, scale: Vec2::ONE, offset: Vec2::ZERO, clamp: false };
        Variants { first: 7, of_texel: Arc::from([0, 1]), placement }
    }

    #[test]
    fn texels_are_chosen_as_interpolation_weighs_them() {
        let variants = variants();
        assert_eq!((variants.at(Vec2::new(0.25, 0.5), (0, [0.3, 0.2])), 7), (7, 7), "the centre of a texel");
        // three quarters of the way from the first centre to the second
        let (count, uv) = (10_000_u16, Vec2::new(0.25 + 0.375, 0.5));
        let second = (0..count).filter(|i| variants.at(uv, (3, [f32::from(*i) / 1e5, 0.1])) == 8).count();
        assert!((7300..7700).contains(&second), "{second}");
    }

    #[test]
    fn a_place_has_one_variant() {
        let uv = Vec2::new(0.5, 0.5);
        let at = |place| variants().at(uv, place);
        assert!((0..100).all(|i| at((i, [0.0, 0.5])) == at((i, [-0.0, 0.5]))));
        let both = (0..100).map(|i| at((i, [0.2, 0.5]))).collect::<std::collections::BTreeSet<_>>();
        assert_eq!(both.len(), 2, "other places have others");
    }
}
