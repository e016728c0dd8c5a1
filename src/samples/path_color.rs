//! Colours in four bytes: what paths have brought.

use glam::Vec3;

/// A colour with an exponent that its channels share, and a bit beside it. Linear RGB, not negative.
///
/// Red and green have nine bits, blue has eight, and all are rounded to the nearest step: by at most a
/// thousandth of the largest channel, blue by two. A sample shows the mean of several of these.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PathColor(u32);

/// Largest value; larger ones are cut. Below the largest that could be kept, so that no colour is
/// [`UNKNOWN`](PathColor::UNKNOWN).
const MOST: f32 = 65000.0;

/// Exponent, as kept, of steps of size 1.
const EXPONENT_OF_ONE: i32 = 24;

const MOST_EXPONENT: i32 = 31;
const FLAG: u32 = 1 << 31;

impl PathColor {
    /// No colour: nothing is known.
    pub const UNKNOWN: Self = Self(u32::MAX);

    /// Rounds a colour. A NaN becomes 0.
    pub fn new(color: Vec3, flag: bool) -> Self {
        let [r, g, b] = color.max(Vec3::ZERO).min(Vec3::splat(MOST)).to_array();
        let most = r.max(g).max(b);
        // nine bits hold what is below two to the power of this, if it is not rounded up to it
        let above = (most.to_bits() >> 23) as i32 - 127 + 1;
        let exponent = (above - 9 + EXPONENT_OF_ONE).clamp(0, MOST_EXPONENT);
        let bits = Self::steps([r, g, b], exponent)
            .or_else(|| Self::steps([r, g, b], exponent + 1))
            .unwrap_or_default();
        Self(bits | if flag { FLAG } else { 0 })
    }

    /// Channels in steps of this exponent, and the exponent, if all have room.
    fn steps(channels: [f32; 3], exponent: i32) -> Option<u32> {
        let [r, g, b] = channels.map(|channel| channel / step(exponent));
        let [r, g, b] = [r, g, b * 0.5].map(|steps| (steps + 0.5) as u32);
        (r < 512 && g < 512 && b < 256).then_some((exponent as u32) << 26 | r << 17 | g << 8 | b)
    }

    /// The colour.
    pub fn color(self) -> Vec3 {
        let Self(bits) = self;
        let step = step((bits >> 26 & 31) as i32);
        Vec3::new((bits >> 17 & 511) as f32, (bits >> 8 & 511) as f32, ((bits & 255) * 2) as f32) * step
    }

    /// The bit beside it.
    pub fn flag(self) -> bool {
        self.0 & FLAG != 0
    }

    /// Converts to bits, to be stored.
    pub fn to_bits(self) -> u32 {
        self.0
    }

    /// Inverse of [`to_bits`](Self::to_bits); any other word is some colour, too.
    pub fn from_bits(bits: u32) -> Self {
        Self(bits)
    }
}

/// Size of a step: a power of two.
fn step(exponent: i32) -> f32 {
    f32::from_bits(((exponent - EXPONENT_OF_ONE + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    #[test]
    fn colors_are_rounded_to_the_nearest_step() {
        let mut sums = [Vec3::ZERO; 2];
        for index in 0..20_000 {
            let [r, g, b, power] = PathRandom::new(5, index).four(0);
            let color = Vec3::new(r, g, b) * (power * 24.0 - 10.0).exp2();
            let kept = PathColor::new(color, index % 2 == 0);
            assert_eq!((kept.flag(), kept != PathColor::UNKNOWN), (index % 2 == 0, true));
            let (off, most) = ((kept.color() - color).abs(), color.max_element());
            let slack = 2.0_f32.powi(-25);
            assert!(off.x.max(off.y) <= most / 512.0 + slack, "{color}: {}", kept.color());
            assert!(off.z <= most / 256.0 + 2.0 * slack, "{color}: {}", kept.color());
            assert_eq!(PathColor::from_bits(kept.to_bits()), kept);
            sums[0] += color / most;
            sums[1] += kept.color() / most;
        }
        let ratio = sums[1] / sums[0];
        assert!((ratio - Vec3::ONE).abs().max_element() < 1e-3, "no channel is favoured: {ratio}");
    }

    #[test]
    fn extremes_are_kept_as_far_as_they_go() {
        let of = |color: [f32; 3]| PathColor::new(Vec3::from(color), true);
        assert_eq!(of([0.0; 3]).color(), Vec3::ZERO);
        assert_eq!(of([-1.0, f32::NAN, 0.0]).color(), Vec3::ZERO);
        assert_eq!(of([1.0, 0.5, 0.25]).color(), Vec3::new(1.0, 0.5, 0.25));
        // rounding up to the next power of two
        assert_eq!(of([0.9999, 0.0, 0.0]).color(), Vec3::X);
        assert_eq!(of([0.0, 0.0, 511.9]).color(), Vec3::Z * 512.0);
        for bright in [65000.0, 1e9, f32::INFINITY] {
            let kept = of([bright; 3]);
            assert!(kept != PathColor::UNKNOWN && kept.color().min_element() > 64_800.0);
        }
    }
}
