//! Materials whose parameters a picture gives: roughness, metal, emission, highlights.
//!
//! Such a material has variants: materials of its own for all values that its pictures hold, of which each texel names one. A
//! surface is of one variant at each place, and everything that knows materials by their number need not know of pictures: what
//! samples keep is the number of the variant. Between texels one of the nearest four is chosen by the place, each as often as
//! interpolation would weigh it.

use std::sync::Arc;

use glam::Vec2;

use super::texture::{Placement, UvSet};
use crate::scrambled::scrambled;

/// Variants of a material: one of them for each texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Variants {
    /// Index of the first variant in [`Scene::materials`](super::Scene::materials); the others follow it.
    pub first: u16,
    /// Numbers of the variants.
    pub numbers: TexelNumbers,
    /// Numbers to be added, if pictures take both sets of texture coordinates: those of the pictures in the other set.
    pub added: Option<TexelNumbers>,
}

/// Number of each texel.
#[derive(Debug, Clone, PartialEq)]
pub struct TexelNumbers {
    /// Numbers, rows from the top.
    pub of_texel: Arc<[u16]>,
    /// Place of the texels on surfaces.
    pub placement: Placement,
}

impl TexelNumbers {
    /// Number at the texture coordinates of a place, which `uv` looks up.
    #[inline]
    fn at(&self, uv: impl Fn(UvSet) -> Vec2) -> u16 {
        let uv = uv(self.placement.mapping.uvs);
        self.of_texel[self.placement.between(uv).chosen(random_of(uv))]
    }
}

impl Variants {
    /// Index of the material at a place, of which `uv` looks up the texture coordinates. It depends on nothing else, and not on the
    /// primitive: of surfaces in the same place either may be met.
    #[inline]
    pub fn at(&self, uv: impl Fn(UvSet) -> Vec2) -> u16 {
        let number = self.first + self.numbers.at(&uv);
        match &self.added {
            None => number,
            Some(added) => number + added.at(uv),
        }
    }
}

/// Two numbers from 0 to below 1 that are different at each place.
fn random_of(uv: Vec2) -> [f32; 2] {
    // no zero is negative
    let bits = uv.to_array().map(|coordinate| (coordinate + 0.0).to_bits());
    let hash = bits.into_iter().fold(0x9e37_79b9, |hash, bits| scrambled(hash ^ bits));
    [hash, scrambled(hash ^ 0x85eb_ca6b)].map(|bits| (bits >> 8) as f32 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::scene::texture::Mapping;

    fn variants() -> Variants {
        let placement = Placement { width: 2, height: 1, mapping: Mapping::default() };
        Variants { first: 7, numbers: TexelNumbers { of_texel: Arc::from([0, 1]), placement }, added: None }
    }

    #[test]
    fn texels_are_chosen_as_interpolation_weighs_them() {
        let variants = variants();
        assert_eq!(variants.at(|_| Vec2::new(0.25, 0.5)), 7, "the centre of a texel");
        // three quarters of the way from the first centre to the second
        let (count, u) = (10_000_u16, 0.25 + 0.375);
        let second = (0..count).filter(|i| variants.at(|_| Vec2::new(u, f32::from(*i) / 1e5)) == 8).count();
        assert!((7300..7700).contains(&second), "{second}");
    }

    #[test]
    fn a_place_has_one_variant() {
        let variants = variants();
        let at = |u: f32, v: f32| variants.at(|_| Vec2::new(u, v));
        let places = || (0..100_u8).map(|i| f32::from(i) / 100.0);
        assert!(places().all(|u| at(u, 0.0) == at(u, -0.0)));
        let both: BTreeSet<u16> = places().map(|v| at(0.5, v)).collect();
        assert_eq!(both.len(), 2, "other places have others");
    }

    /// Pictures in both sets: the numbers of both add up.
    #[test]
    fn each_picture_takes_its_own_texture_coordinates() {
        let mapping = Mapping { uvs: UvSet::Second, ..Mapping::default() };
        let placement = Placement { width: 2, height: 1, mapping };
        let added = TexelNumbers { of_texel: Arc::from([0, 2]), placement };
        let variants = Variants { added: Some(added), ..variants() };
        let [left, right] = [0.25, 0.75].map(|u| Vec2::new(u, 0.5));
        for (uvs, number) in [([left, left], 7), ([right, left], 8), ([left, right], 9), ([right, right], 10)]
        {
            let uv = |set| if set == UvSet::First { uvs[0] } else { uvs[1] };
            assert_eq!(variants.at(uv), number);
        }
    }
}
