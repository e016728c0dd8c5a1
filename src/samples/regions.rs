//! Regions of space in which proofs hold that samples are seen ([`clear`](crate::clear)). A sample keeps the number of a region, and that
//! is true for all eyes in it; the store keeps the regions.

use glam::Vec3;

use crate::geometry::Bounds;

/// Eyes for which proofs hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClearRegion {
    /// Places of eyes, world space.
    pub eyes: Bounds,
    /// Largest width of a cell at a right angle to its line of sight, for each unit of distance.
    pub spread: f32,
    /// Largest distance from an eye of what the picture shows, for each unit of depth along the view axis.
    pub slant: f32,
    /// How far apart the eyes of one exposure see a point.
    pub apart: Apart,
}

/// How far apart, at most, the cameras of an exposure see one point in their pictures: `turn + way |1 / depth - focus|`, as lengths at depth 1,
/// for a point at this depth along the view axis. Lines of sight through one cell leave places that are `way` apart and cross at depth
/// `1 / focus`, but for what they `turn`. (Cameras that turn about the eye have a turn alone, and lenses all but that.)
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Apart {
    /// Lengths at depth 1.
    pub turn: f32,
    /// World units.
    pub way: f32,
    /// Reciprocal of a depth.
    pub focus: f32,
}

impl Apart {
    /// The greatest value for any point between two depths; the second one may be infinite.
    pub fn between(&self, [near, far]: [f32; 2]) -> f32 {
        let off = |depth: f32| (depth.recip() - self.focus).abs();
        if self.way == 0.0 { self.turn } else { self.turn + self.way * off(near).max(off(far)) }
    }

    /// Returns true if `other` is nowhere greater.
    pub fn holds(&self, other: &Self) -> bool {
        self.way >= other.way && self.turn >= other.turn + other.way * (other.focus - self.focus).abs()
    }
}

impl ClearRegion {
    /// Returns true if all that is in `other` is in it.
    pub fn holds(&self, other: &Self) -> bool {
        self.eyes.low.cmple(other.eyes.low).all()
            && self.eyes.high.cmpge(other.eyes.high).all()
            && self.spread >= other.spread
            && self.slant >= other.slant
            && self.apart.holds(&other.apart)
    }
}

/// A region as it is saved.
pub type RegionNumbers = [f32; 11];

/// The regions of a store, by number: the first has number 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClearRegions([Option<ClearRegion>; Self::MOST]);

impl ClearRegions {
    /// Regions at most: a number has four bits in the [flags](super::Flags) of a sample.
    pub const MOST: usize = 15;

    /// The regions that hold `now`, which is a place of the eye. No sample may keep the number of another one from then on.
    #[must_use]
    pub fn that_hold(&self, now: &ClearRegion) -> Self {
        Self(self.0.map(|region| region.filter(|region| region.holds(now))))
    }

    /// Region by number.
    pub fn get(&self, number: u8) -> Option<&ClearRegion> {
        self.0.get(usize::from(number).wrapping_sub(1))?.as_ref()
    }

    /// Converts the regions to numbers, to be saved: of each its number, the least and the greatest coordinates, and all else in its order.
    pub fn to_numbers(self) -> Vec<(u8, RegionNumbers)> {
        let numbers = |ClearRegion { eyes: Bounds { low, high }, spread, slant, apart }: ClearRegion| {
            let Apart { turn, way, focus } = apart;
            [low.x, low.y, low.z, high.x, high.y, high.z, spread, slant, turn, way, focus]
        };
        (1..).zip(self.0).filter_map(|(number, region)| Some((number, numbers(region?)))).collect()
    }

    /// Inverse of [`to_numbers`](Self::to_numbers); `None` for other numbers.
    pub fn from_numbers(all: &[(u8, RegionNumbers)]) -> Option<Self> {
        let mut regions = Self::default();
        for (number, numbers) in all {
            let place = regions.0.get_mut(usize::from(*number).wrapping_sub(1))?;
            let [low, high] = [0, 3].map(|first| Vec3::from_slice(&numbers[first..first + 3]));
            let [.., spread, slant, turn, way, focus] = *numbers;
            let apart = Apart { turn, way, focus };
            *place = Some(ClearRegion { eyes: Bounds { low, high }, spread, slant, apart });
        }
        all.iter().flat_map(|(_, numbers)| numbers).all(|number| number.is_finite()).then_some(regions)
    }

    /// Bit mask of the numbers that have a region; bit 0 is none's.
    pub fn numbers(&self) -> u16 {
        (1..).zip(&self.0).fold(0, |bits, (number, region)| bits | u16::from(region.is_some()) << number)
    }

    /// Number of a region that holds all of `needed`, if there is one.
    pub fn that_holds(&self, needed: &ClearRegion) -> Option<u8> {
        (1..)
            .zip(&self.0)
            .find(|(_, region)| region.is_some_and(|region| region.holds(needed)))
            .map(|(number, _)| number)
    }

    /// Adds a region, under a number that none of the regions `before` has: samples that were not looked at yet may keep that. Returns its
    /// number; `None` if there are enough.
    pub fn add(&mut self, region: ClearRegion, before: &Self) -> Option<u8> {
        let places = (1..).zip(&mut self.0).zip(&before.0);
        let ((number, free), _) =
            places.into_iter().find(|((_, now), before)| now.is_none() && before.is_none())?;
        *free = Some(region);
        Some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::Flags;

    fn region(low: f32, high: f32, spread: f32) -> ClearRegion {
        let apart = Apart { turn: 0.25 * spread, way: 0.5 * spread, focus: 0.125 };
        let eyes = Bounds { low: Vec3::splat(low), high: Vec3::splat(high) };
        ClearRegion { eyes, spread, slant: 1.5, apart }
    }

    #[test]
    fn a_bound_holds_those_that_are_nowhere_greater() {
        let apart = Apart { turn: 0.5, way: 2.0, focus: 0.25 };
        assert_eq!(
            [[4.0, 4.0], [4.0, 8.0], [2.0, f32::INFINITY]].map(|depths| apart.between(depths)),
            [0.5, 0.75, 1.0]
        );
        let table =
            [(0.5, 2.0, 0.25, true), (0.4, 1.0, 0.3, true), (0.5, 2.0, 0.3, false), (0.5, 2.1, 0.25, false)];
        for (turn, way, focus, holds) in table {
            let other = Apart { turn, way, focus };
            assert_eq!(apart.holds(&other), holds, "{other:?}");
            let is_greater = |depth: f32| other.between([depth; 2]) > apart.between([depth; 2]);
            assert!(!holds || !(1..100).any(|depth| is_greater(depth as f32 * 0.25)), "{other:?}");
        }
        assert_eq!(Apart::default().between([0.0, f32::INFINITY]), 0.0);
    }

    #[test]
    fn numbers_are_used_again_when_no_eye_can_be_in_their_region() {
        let mut regions = ClearRegions::default();
        for number in 1..=ClearRegions::MOST as u8 {
            let at = f32::from(number);
            let before = regions;
            assert_eq!(regions.add(region(at, at + 1.0, 0.1), &before), Some(number));
        }
        let before = regions;
        assert_eq!(regions.add(region(0.0, 1.0, 0.1), &before), None);
        assert_eq!(regions.that_holds(&region(4.2, 4.5, 0.1)), Some(4));
        assert_eq!(regions.that_holds(&region(4.2, 5.5, 0.1)), None, "no region has all of it");
        assert_eq!(regions.that_holds(&region(4.2, 4.5, 0.2)), None, "cells are larger");
        let mut left = regions.that_hold(&region(4.5, 4.5, 0.05));
        assert_eq!(left.numbers(), 1 << 4);
        let before = left;
        assert_eq!(left.add(region(0.0, 1.0, 0.1), &regions), None, "samples may still keep all numbers");
        assert_eq!(left.add(region(0.0, 1.0, 0.1), &before), Some(1));
        assert_eq!(left.get(1), Some(&region(0.0, 1.0, 0.1)));
        assert_eq!((left.get(0), left.get(2)), (None, None));
        assert_eq!(ClearRegions::from_numbers(&left.to_numbers()), Some(left));
        assert_eq!(ClearRegions::from_numbers(&[(0, [1.0; 11])]), None);
        assert_eq!(ClearRegions::from_numbers(&[(1, [f32::NAN; 11])]), None);
    }

    #[test]
    fn flags_keep_a_proof_beside_them() {
        let flags = Flags::STALE.with(Flags::FROM_BEHIND);
        for proof in (1..=ClearRegions::MOST as u8).flat_map(|region| [(region, false), (region, true)]) {
            let kept = flags.with_proof(Some(proof));
            assert_eq!(kept.proof(), Some(proof));
            assert!(kept.has(flags) && !kept.has(Flags::UNSEEN));
            assert_eq!(Flags::from_bits(kept.to_bits()), Some(kept));
            assert_eq!(kept.with_proof(None), flags);
        }
        assert_eq!(Flags::from_bits(0x80), None, "there is no region");
    }
}
