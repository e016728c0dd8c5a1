//! White noise: Blender's White Noise Texture node. Each place has its own random number.

use super::hash::unit8;
use super::{Dimensions, place_of};
use crate::lanes::{F32x8, Vec3x8};

/// Options of the White Noise Texture node. It has no inputs but the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct WhiteNoise {
    /// Axes on which it depends.
    pub dimensions: Dimensions,
}

impl WhiteNoise {
    /// The output Value, 0 to 1: the hash of the bits of the place.
    pub fn value(&self, vector: Vec3x8, w: F32x8) -> F32x8 {
        match self.dimensions {
            Dimensions::One => unit8(place_of::<1>(vector, w)),
            Dimensions::Two => unit8(place_of::<2>(vector, w)),
            Dimensions::Three => unit8(place_of::<3>(vector, w)),
            Dimensions::Four => unit8(place_of::<4>(vector, w)),
        }
    }

    /// The output Color, 0 to 1. Its first part is [`Self::value`].
    pub fn color(&self, vector: Vec3x8, w: F32x8) -> Vec3x8 {
        let Vec3x8 { x, y, z } = vector;
        let [one, two] = [1.0, 2.0].map(F32x8::splat);
        let [second, third] = match self.dimensions {
            Dimensions::One => [unit8([w, one]), unit8([w, two])],
            Dimensions::Two => [unit8([x, y, one]), unit8([x, y, two])],
            Dimensions::Three => [unit8([x, y, z, one]), unit8([x, y, z, two])],
            Dimensions::Four => [unit8([z, x, w, y]), unit8([w, z, y, x])],
        };
        Vec3x8::from([self.value(vector, w), second, third])
    }
}
