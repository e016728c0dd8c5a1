//! Eight values at a time: arithmetic on small arrays that compilers turn into vector instructions.
//!
//! Only what shading needs, and no fused multiply-add: the same operations in the same order give the same
//! bits on every processor. Nothing here branches; a choice is a [`Mask`] and [`Mask::select`].

use std::f32::consts::LN_2;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::Vec3;

/// How many.
pub const LANES: usize = 8;

/// Eight floats.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f32; LANES]);

/// Eight answers: all bits set for yes, none for no.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct Mask(pub [u32; LANES]);

/// Eight vectors, or eight colours.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "coordinates")]
pub struct Lanes3 {
    pub x: Lanes,
    pub y: Lanes,
    pub z: Lanes,
}

/// One array from one or two others, lane by lane.
macro_rules! each {
    ($start:expr, $lane:ident => $value:expr) => {{
        let mut out = [$start; LANES];
        for $lane in 0..LANES {
            out[$lane] = $value;
        }
        out
    }};
}

impl Lanes {
    /// Eight zeros.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Eight times the same.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    /// The eight values of `column` from `first` on.
    #[inline(always)]
    pub fn load(column: &[f32], first: usize) -> Self {
        let eight = &column[first..first + LANES];
        Self(each!(0.0, i => eight[i]))
    }

    /// Writes the eight values to `column` from `first` on.
    #[inline(always)]
    pub fn store(self, column: &mut [f32], first: usize) {
        column[first..first + LANES].copy_from_slice(&self.0);
    }

    /// The smaller of the two; the other one where one is not a number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(each!(0.0, i => if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }

    /// The greater of the two; `other` where one is not a number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(each!(0.0, i => if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }

    /// Without signs.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(each!(0.0, i => self.0[i].abs()))
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(each!(0.0, i => self.0[i].sqrt()))
    }

    /// These values with the signs of `other`.
    #[inline(always)]
    pub fn with_sign_of(self, other: Self) -> Self {
        Self(each!(0.0, i => self.0[i].copysign(other.0[i])))
    }

    /// These values, negated where `other` has a sign.
    #[inline(always)]
    pub fn with_sign_changed_by(self, other: Self) -> Self {
        Self(each!(0.0, i => f32::from_bits(self.0[i].to_bits() ^ (other.0[i].to_bits() & (1 << 31)))))
    }

    /// The greatest whole numbers that are not greater, for numbers in 0 .. 2^22.
    #[inline(always)]
    pub fn floor(self) -> Self {
        // adding and taking away 2^23 rounds to a whole number
        const ROUND: f32 = 8_388_608.0;
        let nearest = (self + Self::splat(ROUND)) - Self::splat(ROUND);
        nearest - nearest.gt(self).select(Self::splat(1.0), Self::ZERO)
    }

    /// Whole numbers in 0 .. 2^22 as such.
    #[inline(always)]
    pub fn to_whole(self) -> [u32; LANES] {
        const BASE: f32 = 8_388_608.0;
        // bits of 2^23 + whole count up by whole
        (self + Self::splat(BASE)).0.map(|sum| sum.to_bits().wrapping_sub(BASE.to_bits()))
    }

    /// Where this is less. No for what is not a number.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask {
        Mask(each!(0, i => u32::from(self.0[i] < other.0[i]).wrapping_neg()))
    }

    /// Where this is not greater. No for what is not a number.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask {
        Mask(each!(0, i => u32::from(self.0[i] <= other.0[i]).wrapping_neg()))
    }

    /// Where this is greater. No for what is not a number.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask {
        other.lt(self)
    }

    /// `self` to the power of `exponent`, for `self` in 0..=1 and a positive exponent: 2^(e log2 b). Wrong by
    /// less than 1e-6 and 2e-6 of the result, whichever is more.
    #[inline(always)]
    pub fn power(self, exponent: Self) -> Self {
        let none = self.lt(Self::splat(f32::MIN_POSITIVE));
        // the end of the range is far below what a half float can tell from zero
        let log = (self.log2() * exponent).max(Self::splat(-100.0));
        none.select(Self::ZERO, log.exp2())
    }

    /// Logarithms to base 2 of positive normal numbers: exponent plus the series of the inverse hyperbolic
    /// tangent for a mantissa between the roots of 1/2 and 2.
    #[inline(always)]
    fn log2(self) -> Self {
        const ROOT_HALF: u32 = 0x3f35_04f3;
        let mut mantissa = [0.0; LANES];
        let mut exponent = [0.0; LANES];
        for i in 0..LANES {
            let beyond = self.0[i].to_bits().wrapping_sub(ROOT_HALF) as i32;
            exponent[i] = (beyond >> 23) as f32;
            mantissa[i] = f32::from_bits(((beyond & 0x007f_ffff) as u32).wrapping_add(ROOT_HALF));
        }
        let (mantissa, exponent) = (Self(mantissa), Self(exponent));
        let s = (mantissa - Self::splat(1.0)) / (mantissa + Self::splat(1.0));
        let s2 = s * s;
        // 2 / ln 2 times 1, 1/3, 1/5, 1/7, 1/9
        let series = [0.320_598_9, 0.412_198_58, 0.577_078, 0.961_796_7, 2.885_39];
        let sum = series.into_iter().fold(Self::ZERO, |sum, term| sum * s2 + Self::splat(term));
        exponent + s * sum
    }

    /// 2 to the power of numbers in -100..=100: the whole part as an exponent, Taylor's series for the rest.
    #[inline(always)]
    fn exp2(self) -> Self {
        // adding and taking away 1.5 * 2^23 rounds to a whole number
        const ROUND: f32 = 12_582_912.0;
        let whole = (self + Self::splat(ROUND)) - Self::splat(ROUND);
        let rest = self - whole;
        // (ln 2)^n / n! for n = 6 .. 0
        let series = [1.540_353e-4, 1.333_356e-3, 9.618_129e-3, 5.550_411e-2, 0.240_226_5, LN_2, 1.0];
        let sum = series.into_iter().fold(Self::ZERO, |sum, term| sum * rest + Self::splat(term));
        sum * Self(each!(0.0, i => {
            // bits of 1.5 * 2^23 + whole count up by whole
            let steps = (whole.0[i] + ROUND).to_bits().wrapping_sub(ROUND.to_bits());
            f32::from_bits(steps.wrapping_add(127) << 23)
        }))
    }
}

macro_rules! lane_by_lane {
    ($($op:ident $name:ident $sign:tt),+) => {$(
        impl $op for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(each!(0.0, i => self.0[i] $sign other.0[i]))
            }
        }
        impl $op for Lanes3 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self { x: self.x $sign other.x, y: self.y $sign other.y, z: self.z $sign other.z }
            }
        }
        impl $op<Lanes> for Lanes3 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Lanes) -> Self {
                Self { x: self.x $sign other, y: self.y $sign other, z: self.z $sign other }
            }
        }
    )+};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each!(0.0, i => -self.0[i]))
    }
}

impl Mask {
    /// Yes throughout.
    pub const ALL: Self = Self([u32::MAX; LANES]);
    /// No throughout.
    pub const NONE: Self = Self([0; LANES]);

    /// Yes where `holds(lane)`.
    #[inline(always)]
    pub fn of(mut holds: impl FnMut(usize) -> bool) -> Self {
        Self(each!(0, i => u32::from(holds(i)).wrapping_neg()))
    }

    /// Whether any answer is yes.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    /// Bit `i` is answer `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        let mut bits = 0;
        for i in 0..LANES {
            bits |= ((self.0[i] >> 31) as u8) << i;
        }
        bits
    }

    /// `yes` where the answer is yes, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: Lanes, no: Lanes) -> Lanes {
        Lanes(each!(0.0, i => {
            f32::from_bits((yes.0[i].to_bits() & self.0[i]) | (no.0[i].to_bits() & !self.0[i]))
        }))
    }

    /// `yes` where the answer is yes, `no` elsewhere.
    #[inline(always)]
    pub fn select3(self, yes: Lanes3, no: Lanes3) -> Lanes3 {
        Lanes3 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }
}

impl BitAnd for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(each!(0, i => self.0[i] & other.0[i]))
    }
}

impl BitOr for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(each!(0, i => self.0[i] | other.0[i]))
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(each!(0, i => !self.0[i]))
    }
}

impl Lanes3 {
    /// Eight zeros.
    pub const ZERO: Self = Self { x: Lanes::ZERO, y: Lanes::ZERO, z: Lanes::ZERO };

    /// Eight times the same.
    #[inline(always)]
    pub fn splat(value: Vec3) -> Self {
        Self { x: Lanes::splat(value.x), y: Lanes::splat(value.y), z: Lanes::splat(value.z) }
    }

    /// Eight vectors of columns of coordinates, from `first` on.
    #[inline(always)]
    pub fn load([x, y, z]: [&[f32]; 3], first: usize) -> Self {
        Self { x: Lanes::load(x, first), y: Lanes::load(y, first), z: Lanes::load(z, first) }
    }

    /// Writes the eight vectors to columns of coordinates, from `first` on.
    #[inline(always)]
    pub fn store(self, [x, y, z]: [&mut [f32]; 3], first: usize) {
        self.x.store(x, first);
        self.y.store(y, first);
        self.z.store(z, first);
    }

    /// One of the eight.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.0[lane], self.y.0[lane], self.z.0[lane])
    }

    /// Writes one of the eight.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, value: Vec3) {
        [self.x.0[lane], self.y.0[lane], self.z.0[lane]] = value.to_array();
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// The smaller of each two coordinates.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// The greater of each two coordinates.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// To unit length. Not a number where there is no length.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (Lanes::splat(1.0) / self.dot(self).sqrt())
    }

    /// Where any coordinate is not zero.
    #[inline(always)]
    pub fn is_some(self) -> Mask {
        let zero = Lanes::ZERO;
        let differs = |a: Lanes| Mask(each!(0, i => u32::from(a.0[i] != zero.0[i]).wrapping_neg()));
        differs(self.x) | differs(self.y) | differs(self.z)
    }
}

impl Neg for Lanes3 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_as_exact_as_stated() {
        let bases = (0..=2000).map(|i| i as f32 / 2000.0).chain([0.999_999, 1e-30, 1.0 - f32::EPSILON]);
        for base in bases {
            for exponent in [0.5, 1.0, 2.0, 10.0, 96.078_43, 1000.0] {
                let got = f64::from(Lanes::splat(base).power(Lanes::splat(exponent)).0[3]);
                let wanted = f64::from(base).powf(f64::from(exponent));
                assert!(
                    (got - wanted).abs() <= 1e-6 + 2e-6 * wanted,
                    "{base}^{exponent}: {got}, not {wanted}"
                );
            }
        }
    }

    #[test]
    fn masks_choose_lane_by_lane() {
        let count = Lanes([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, f32::NAN]);
        let few = count.lt(Lanes::splat(3.0));
        assert_eq!((few.bits(), (!few).bits()), (0b0000_0111, 0b1111_1000));
        assert_eq!(few.select(count, Lanes::ZERO).0, [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(Mask::of(|lane| lane == 7).bits(), 0b1000_0000);
        assert!((few | !few).bits() == Mask::ALL.bits() && !(few & !few).any());
    }

    #[test]
    fn vectors_are_those_of_each_lane() {
        let (a, b) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.5, 4.0, -1.0));
        let (x, y) = (Lanes3::splat(a), Lanes3::splat(b));
        assert_eq!(x.cross(y).lane(5), a.cross(b));
        assert_eq!(x.dot(y).0[2], a.dot(b));
        assert!((x.normalize().lane(0) - a.normalize()).length() < 1e-6);
    }
}
