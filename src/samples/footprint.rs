//! Size of the place on a surface that a sample stands for.

use glam::Vec3;
use wide::u32x8;

use crate::lanes::{F32x8, LANES, Vec3x8, unsigned};
use crate::logarithm::rough_log2;
use crate::scrambled::{scrambled, scrambled_lanes};

/// Width, in object space, of the place that a sample stands for: textures are filtered over it. It follows from where the sample is
/// and from how wide its place is now, whoever traced it and when: where the eye comes nearer or goes away, kept samples are
/// looked up anew in their textures, so that they are as sharp as samples that are traced.
///
/// A byte: steps of the square root of 2 from 2^-63 on; 0 for samples of surfaces without textures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Footprint(u8);

/// Byte of the width 1.
const ONE: f32 = 128.0;

/// Steps by which the logarithm to the base 2 is divided.
const STEPS: f32 = 2.0;

/// Bits of a float's exponent: with no others it is the power of 2 below.
const EXPONENT: u32 = 0x7f80_0000;

/// Parts of a place's width, about, in which the same chance decides.
const PARTS: f32 = 8.0;

/// Share of 1 of each step of 24 bits.
const OF_24_BITS: f32 = 1.0 / (1 << 24) as f32;

impl Footprint {
    /// No place: textures are shown texel by texel.
    pub const NONE: Self = Self(0);

    /// Creates the footprint of a width above 0, rounded to one of the nearest steps by chance: so the samples of a surface do not
    /// all change in one frame. Nothing but the `place` of the sample decides, in the space of the width: which cell it was found for
    /// does not matter. Where it lies in a part of the width does not, either: tracers find places that differ in their last bits.
    pub fn new(width: f32, place: Vec3) -> Self {
        let part = (place * (f32::from_bits(width.to_bits() & EXPONENT) / PARTS).recip()).floor();
        let hash = part.to_array().iter().fold(0, |hash, axis| scrambled(hash ^ (*axis as i32) as u32));
        let chance = (hash >> 8) as f32 * OF_24_BITS;
        Self((steps_of(width) + chance).clamp(1.0, 255.0) as u8)
    }

    /// [`new`](Self::new) of eight places, to the bit.
    #[inline(always)]
    pub fn eight(widths: F32x8, places: Vec3x8) -> [Self; LANES] {
        let power = F32x8::from_bits(widths.to_bits() & u32x8::splat(EXPONENT));
        let parts = places * (F32x8::ONE / (power / F32x8::splat(PARTS)));
        let hash = [parts.x, parts.y, parts.z].into_iter().fold(u32x8::splat(0), |hash, axis| {
            let to_zero = F32x8::from_whole(axis.to_whole());
            let floor = to_zero.gt(axis).select(to_zero - F32x8::ONE, to_zero);
            scrambled_lanes(hash ^ unsigned(floor.to_whole()))
        });
        let chances = (hash >> 8_u32).to_array();
        std::array::from_fn(|lane| {
            let chance = chances[lane] as f32 * OF_24_BITS;
            Self((steps_of(widths.lane(lane)) + chance).clamp(1.0, 255.0) as u8)
        })
    }

    /// Width, object space; 0 for none.
    #[inline]
    pub fn width(self) -> f32 {
        if self.0 == 0 {
            return 0.0;
        }
        let of_even = f32::from_bits((u32::from(self.0 / 2) + 127 - 64) << 23);
        if self.0 % 2 == 0 { of_even } else { of_even * std::f32::consts::SQRT_2 }
    }

    /// Returns true if there is a place.
    #[inline]
    pub fn is_some(self) -> bool {
        self.0 != 0
    }

    /// Converts the footprint to a byte, to be saved.
    pub fn to_byte(self) -> u8 {
        self.0
    }

    /// Inverse of [`to_byte`](Self::to_byte).
    pub fn from_byte(byte: u8) -> Self {
        Self(byte)
    }
}

/// Steps up to a width; within the range of bytes, also of widths that are not positive or finite.
#[inline]
fn steps_of(width: f32) -> f32 {
    (ONE + STEPS * rough_log2(width)).clamp(1.0, 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thousand places on a surface, none of them on the border of a part.
    fn places() -> impl Iterator<Item = Vec3> {
        (0..1000)
            .map(|number| Vec3::new(number as f32 * 0.0371 - 18.3, 3.217, number as f32 * 0.0217 + 1.071))
    }

    #[test]
    fn a_footprint_is_one_of_the_steps_beside_its_width() {
        for (number, width) in [1e-6_f32, 0.01, 1.0, 3.7, 1e9].into_iter().enumerate() {
            for place in 0..50 {
                let footprint = Footprint::new(width, Vec3::new(place as f32, number as f32, 0.3) * width);
                let ratio = footprint.width() / width;
                assert!((0.65..1.5).contains(&ratio), "{width}: {ratio}");
            }
        }
    }

    /// Where the eye comes nearer evenly, about as many change in each frame.
    #[test]
    fn samples_of_one_surface_change_one_after_the_other() {
        let widths = (0..=20).map(|step| 1.02 * 2.0_f32.powf(step as f32 / 25.0));
        let of = |width: f32| places().map(|place| Footprint::new(width, place)).collect::<Vec<_>>();
        let all: Vec<_> = widths.map(of).collect();
        for pair in all.windows(2) {
            let changed = pair[0].iter().zip(&pair[1]).filter(|(a, b)| a != b).count();
            assert!((20..180).contains(&changed), "{changed} of a thousand");
        }
    }

    #[test]
    fn eight_at_once_are_what_each_is_alone() {
        let odd = [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-42, 1e30, 3.0, 1e-6];
        let at: Vec<Vec3> = places().collect();
        for (number, places) in at.chunks_exact(LANES).enumerate() {
            let widths = F32x8::new(match number {
                0 => odd,
                _ => std::array::from_fn(|lane| 0.01 * (number * LANES + lane) as f32),
            });
            let mut all = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, places[lane] * 100.0));
            let alone = std::array::from_fn(|lane| Footprint::new(widths.lane(lane), all.lane(lane)));
            assert_eq!(Footprint::eight(widths, all), alone, "{number}");
        }
    }

    /// As those that two tracers find.
    #[test]
    fn places_that_differ_in_their_last_bits_have_the_same_footprint() {
        let next = |number: f32| f32::from_bits(number.to_bits() + 1);
        for width in [0.02, 0.9, 1.3, 7.0] {
            let differ = places()
                .map(|at| at * width)
                .filter(|at| Footprint::new(width, *at) != Footprint::new(next(width), at.map(next)));
            assert_eq!(differ.count(), 0, "{width}");
        }
    }

    #[test]
    fn odd_widths_have_footprints() {
        for width in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::MIN_POSITIVE, 1e-42] {
            let footprint = Footprint::new(width, Vec3::new(7.0, -1e9, f32::NAN));
            assert!(
                footprint.is_some() && footprint.width() > 0.0 && footprint.width().is_finite(),
                "{width}"
            );
        }
        assert_eq!(Footprint::NONE.width(), 0.0);
    }
}
