//! Functions of eight numbers that patterns and graphs need: rounding, comparisons, and what processors have for one number only.
//!
//! What a lane gives depends on that lane alone, to the bit.

use wide::{CmpEq, CmpGe, u32x8};

use super::{F32x8, Mask, signed};

impl F32x8 {
    /// Greatest whole numbers that are not above.
    #[inline(always)]
    pub fn floor(self) -> Self {
        // without AVX `wide` rounds by way of whole numbers, which have no room for large floats
        match cfg!(target_feature = "avx") {
            true => Self(self.0.floor()),
            false => Self::new(self.values().map(f32::floor)),
        }
    }

    /// Smallest whole numbers that are not below.
    #[inline(always)]
    pub fn ceil(self) -> Self {
        -(-self).floor()
    }

    /// Whole parts, towards zero.
    #[inline(always)]
    pub fn truncated(self) -> Self {
        self.abs().floor().with_sign_of(self)
    }

    /// True where both are the same number: zeros are, whatever their signs. False for NaN.
    #[inline(always)]
    pub fn equals(self, other: Self) -> Mask {
        Mask(self.0.cmp_eq(other.0))
    }

    /// True where this is zero.
    #[inline(always)]
    pub fn is_zero(self) -> Mask {
        self.equals(Self::ZERO)
    }

    /// True where this is greater or equal. False for NaN.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask {
        Mask(self.0.cmp_ge(other.0))
    }

    /// Brings numbers into a range, as [`f32::clamp`] does: a NaN stays one.
    #[inline(always)]
    pub fn clamp(self, low: f32, high: f32) -> Self {
        Self::splat(high).min(Self::splat(low).max(self))
    }

    /// The numbers, with 0 for those that are infinite or NaN.
    #[inline(always)]
    pub fn finite_or_zero(self) -> Self {
        self.abs().lt(Self::splat(f32::INFINITY)).select(self, Self::ZERO)
    }

    /// The first of them.
    #[inline(always)]
    pub fn first(self) -> f32 {
        self.0.to_array()[0]
    }

    /// Returns true if all have the same bits.
    #[inline(always)]
    pub fn is_same(self) -> bool {
        Mask::of_equal(self.to_bits(), u32x8::splat(self.first().to_bits())).bits() == u8::MAX
    }

    /// A function that is computed for one number after the other; for one alone where all are the same.
    #[inline]
    pub fn each(self, of: impl Fn(f32) -> f32) -> Self {
        if self.is_same() {
            return Self::splat(of(self.first()));
        }
        Self::new(self.values().map(of))
    }

    /// A function of two numbers: see [`each`](Self::each).
    #[inline]
    pub fn each_with(self, other: Self, of: impl Fn(f32, f32) -> f32) -> Self {
        if self.is_same() && other.is_same() {
            return Self::splat(of(self.first(), other.first()));
        }
        Self::new(std::array::from_fn(|lane| of(self.lane(lane), other.lane(lane))))
    }

    /// Converts whole numbers without a sign to floats, rounded to the nearest.
    #[inline(always)]
    pub fn from_unsigned(whole: u32x8) -> Self {
        // both halves are exact, so that the sum is rounded once
        let half = |bits: u32x8| Self::from_whole(signed(bits));
        half(whole >> 16) * 65_536.0 + half(whole & u32x8::splat(0xffff))
    }
}

impl Mask {
    /// True where a number of the one is the number of the other.
    #[inline(always)]
    pub fn of_equal(a: u32x8, b: u32x8) -> Self {
        Self::of_bits(a.cmp_eq(b))
    }

    /// Returns true if one of the first `lanes` lanes is true.
    #[inline(always)]
    pub fn any_of(self, lanes: usize) -> bool {
        u32::from(self.bits()) << (32 - lanes) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::super::LANES;
    use super::*;

    const NUMBERS: [[f32; LANES]; 3] = [
        [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.75, -2.75],
        [1e20, -1e20, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, 8_388_607.5, -8_388_607.5],
        [1e-42, -1e-42, 3e9, -3e9, 16_777_216.0, 0.999_999_9, -0.999_999_9, 41.5],
    ];

    fn bits(values: &[f32; LANES]) -> [u32; LANES] {
        values.map(f32::to_bits)
    }

    #[test]
    fn rounding_is_that_of_one_number() {
        for numbers in NUMBERS {
            let eight = F32x8::new(numbers);
            assert_eq!(bits(eight.floor().values()), bits(&numbers.map(f32::floor)));
            assert_eq!(bits(eight.ceil().values()), bits(&numbers.map(f32::ceil)));
            assert_eq!(bits(eight.truncated().values()), bits(&numbers.map(f32::trunc)));
            let clamped = numbers.map(|number| number.clamp(0.0, 1.0));
            assert_eq!(bits(eight.clamp(0.0, 1.0).values()), bits(&clamped));
        }
        let none = F32x8::splat(f32::NAN);
        for value in [none.floor(), none.ceil(), none.truncated(), none.clamp(0.0, 1.0)] {
            assert!(value.lane(3).is_nan());
        }
        assert_eq!(none.finite_or_zero().lane(0), 0.0);
    }

    #[test]
    fn whole_numbers_become_the_nearest_floats() {
        let numbers = [0, 1, 16_777_217, 16_777_219, u32::MAX, u32::MAX - 128, 0x8000_0081, 0xffff_ff7f];
        let floats = F32x8::from_unsigned(u32x8::new(numbers));
        assert_eq!(*floats.values(), numbers.map(|number| number as f32));
    }

    #[test]
    fn functions_of_one_number_are_those_of_each_lane() {
        let sines = F32x8::new(NUMBERS[0]).each(f32::sin);
        assert_eq!(bits(sines.values()), bits(&NUMBERS[0].map(f32::sin)));
        assert_eq!(F32x8::splat(0.3).each(f32::sin).lane(7), 0.3_f32.sin());
        let powers = F32x8::new(NUMBERS[0]).each_with(F32x8::splat(2.0), f32::powf);
        assert_eq!(bits(powers.values()), bits(&NUMBERS[0].map(|number| number.powf(2.0))));
        assert!(Mask::new(|lane| lane == 4).any_of(5) && !Mask::new(|lane| lane == 4).any_of(4));
    }
}
