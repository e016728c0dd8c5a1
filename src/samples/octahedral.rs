//! Unit vectors in four bytes.

use glam::Vec3;
use wide::u32x8;

use crate::lanes::{F32x8, LANES, Vec3x8, signed};

/// A unit vector, folded onto an octahedron and flattened to a square of 65535 x 65535 steps: wrong by
/// less than 7e-5 radians (Cigolle et al., "A Survey of Efficient Representations for Independent Unit
/// Vectors", JCGT 2014, `oct32`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Octahedral(u32);

/// Number of steps from the centre of the square to its edge.
const STEPS: f32 = 32767.0;

impl Octahedral {
    /// Folds `unit`. A vector of zero length becomes +Z.
    pub fn fold(unit: Vec3) -> Self {
        Self::fold_lanes(Vec3x8::splat(unit))[0]
    }

    /// Converts the vector to a word.
    pub fn to_bits(self) -> u32 {
        self.0
    }

    /// Inverse of [`to_bits`](Self::to_bits); any other word is some vector, too.
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// Folds eight vectors.
    #[inline(always)]
    pub fn fold_lanes(unit: Vec3x8) -> [Self; LANES] {
        let one = F32x8::splat(1.0);
        let length = unit.x.abs() + unit.y.abs() + unit.z.abs();
        let scale = length.gt(F32x8::ZERO).select(one / length, F32x8::ZERO);
        let (x, y) = (unit.x * scale, unit.y * scale);
        let below = unit.z.lt(F32x8::ZERO);
        let (across, down) = ((one - y.abs()).with_sign_of(x), (one - x.abs()).with_sign_of(y));
        // the float to which a small number is added so that it is rounded and stands in the low bits
        const ROUND: f32 = 12_582_912.0;
        let steps = |value: F32x8| (value * F32x8::splat(STEPS) + F32x8::splat(ROUND)).to_bits();
        let (x, y) = (steps(below.select(across, x)), steps(below.select(down, y)));
        ((x & u32x8::splat(0xffff)) | (y << 16_u32)).to_array().map(Self)
    }

    /// Converts to a vector of unit length.
    pub fn unfold(self) -> Vec3 {
        Self::unfold_lanes([self; LANES]).lane(0)
    }

    /// Converts to eight vectors of unit length.
    #[inline(always)]
    pub fn unfold_lanes(eight: [Self; LANES]) -> Vec3x8 {
        Self::directions(eight).normalize()
    }

    /// Converts to eight vectors of any length.
    #[inline(always)]
    pub fn directions(eight: [Self; LANES]) -> Vec3x8 {
        let bits = u32x8::new(std::array::from_fn(|lane| eight[lane].0));
        let [x, y] = [bits << 16_u32, bits].map(|bits| F32x8::from_whole(signed(bits) >> 16));
        let step = F32x8::splat(1.0 / STEPS);
        let (x, y) = (x * step, y * step);
        let z = F32x8::splat(1.0) - x.abs() - y.abs();
        let fold = (-z).max(F32x8::ZERO);
        Vec3x8 { x: x - fold.with_sign_of(x), y: y - fold.with_sign_of(y), z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_within_the_stated_angle() {
        let mut worst = 0.0_f32;
        for i in 0..20_000 {
            // a spiral over the sphere, both poles included
            let z = 1.0 - 2.0 * i as f32 / 19_999.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - z * z).max(0.0).sqrt();
            let unit = Vec3::new(ring * cos, ring * sin, z).normalize();
            worst = worst.max(unit.cross(Octahedral::fold(unit).unfold()).length());
        }
        assert!(worst < 7e-5, "{worst}");
    }

    #[test]
    fn axes_are_exact() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert_eq!(Octahedral::fold(axis).unfold(), axis);
        }
    }
}
