//! White noise: Blender's White Noise Texture node. Each place has its own random number.

use glam::Vec3;

use super::{Dimensions, hash, place_of};

/// Options of the White Noise Texture node. It has no inputs but the place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct WhiteNoise {
    /// Axes on which it depends.
    pub dimensions: Dimensions,
}

impl WhiteNoise {
    /// The output Value, 0 to 1: the hash of the bits of the place.
    pub fn value(&self, vector: Vec3, w: f32) -> f32 {
        match self.dimensions {
            Dimensions::One => hash::unit(place_of::<1>(vector, w)),
            Dimensions::Two => hash::unit(place_of::<2>(vector, w)),
            Dimensions::Three => hash::unit(place_of::<3>(vector, w)),
            Dimensions::Four => hash::unit(place_of::<4>(vector, w)),
        }
    }

    /// The output Color, 0 to 1. Its first part is [`Self::value`].
    pub fn color(&self, vector: Vec3, w: f32) -> Vec3 {
        match self.dimensions {
            Dimensions::One => hash::unit3_of1(w),
            Dimensions::Two => hash::unit3_of2(place_of(vector, w)),
            Dimensions::Three => hash::unit3_of3(place_of(vector, w)),
            Dimensions::Four => hash::unit3_of4(place_of(vector, w)),
        }
    }
}
