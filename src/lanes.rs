//! Eight values at a time: arithmetic that becomes vector instructions.
//!
//! It has the operations that shading and the tracer in Rust need. Shading takes no fused multiply-add: the same
//! operations in the same order give the same bits on every processor. Nothing here branches; a choice is a
//! [`Mask`] and [`Mask::select`].

mod functions;
mod vec3;

use std::f32::consts::LN_2;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use wide::{CmpLe, CmpLt, f32x8, i32x8, u32x8};

pub use vec3::Vec3x8;

/// Number of lanes.
pub const LANES: usize = 8;

/// Eight floats.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct F32x8(f32x8);

/// Eight booleans.
#[derive(Debug, Clone, Copy)]
pub struct Mask(f32x8);

impl F32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self::all(0.0);

    /// Eight ones.
    pub const ONE: Self = Self::all(1.0);

    /// Sets all lanes to the same value, as a constant.
    const fn all(value: f32) -> Self {
        Self::new([value; LANES])
    }

    /// Creates eight lanes from these values.
    #[inline(always)]
    pub const fn new(values: [f32; LANES]) -> Self {
        Self(f32x8::new(values))
    }

    /// Sets all lanes to the same value.
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self(f32x8::splat(value))
    }

    /// Loads eight values of `column` from `first` on.
    #[inline(always)]
    pub fn load(column: &[f32], first: usize) -> Self {
        let mut eight = [0.0; LANES];
        eight.copy_from_slice(&column[first..first + LANES]);
        Self::new(eight)
    }

    /// Writes the eight values to `column` from `first` on.
    #[inline(always)]
    pub fn store(self, column: &mut [f32], first: usize) {
        column[first..first + LANES].copy_from_slice(self.values());
    }

    /// All eight values.
    #[inline(always)]
    pub fn values(&self) -> &[f32; LANES] {
        self.0.as_array_ref()
    }

    /// Mutable access to the eight values.
    #[inline(always)]
    pub fn values_mut(&mut self) -> &mut [f32; LANES] {
        self.0.as_array_mut()
    }

    /// Value of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> f32 {
        self.values()[lane]
    }

    /// Sets the value of one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, value: f32) {
        self.values_mut()[lane] = value;
    }

    /// Smaller of the two; `other` where one is a NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        // one instruction where it is the same to the bit, NaN and signs of zeros included
        match cfg!(target_arch = "x86_64") {
            true => Self(self.0.fast_min(other.0)),
            false => self.lt(other).select(self, other),
        }
    }

    /// Greater of the two; `other` where one is a NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        match cfg!(target_arch = "x86_64") {
            true => Self(self.0.fast_max(other.0)),
            false => self.gt(other).select(self, other),
        }
    }

    /// Returns `self` + a b, rounded once or twice, as the build says: for tests whose answers do not depend on it.
    #[inline(always)]
    pub fn add_product(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_add(b.0, self.0))
    }

    /// Returns `self` - a b, rounded like [`add_product`](Self::add_product).
    #[inline(always)]
    pub fn less_product(self, a: Self, b: Self) -> Self {
        Self(a.0.mul_neg_add(b.0, self.0))
    }

    /// Absolute values.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// Square roots.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// These values with the signs of `other`.
    #[inline(always)]
    pub fn with_sign_of(self, other: Self) -> Self {
        Self(self.0.copysign(other.0))
    }

    /// These values, negated where `other` is negative.
    #[inline(always)]
    pub fn with_sign_changed_by(self, other: Self) -> Self {
        Self(self.0.flip_signs(other.0))
    }

    /// Rounds towards zero to whole numbers. Values beyond their range become the last of them, and a NaN
    /// becomes 0.
    #[inline(always)]
    pub fn to_whole(self) -> i32x8 {
        self.0.trunc_int()
    }

    /// Bits of the floats.
    #[inline(always)]
    pub fn to_bits(self) -> u32x8 {
        bytemuck::cast(self.0)
    }

    /// Floats of these bits.
    #[inline(always)]
    pub fn from_bits(bits: u32x8) -> Self {
        Self(bytemuck::cast(bits))
    }

    /// Converts whole numbers with a sign to floats.
    #[inline(always)]
    pub fn from_whole(whole: i32x8) -> Self {
        Self(f32x8::from_i32x8(whole))
    }

    /// True where this is less. False for NaN.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask {
        Mask(self.0.cmp_lt(other.0))
    }

    /// True where this is less or equal. False for NaN.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask {
        Mask(self.0.cmp_le(other.0))
    }

    /// True where this is greater. False for NaN.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask {
        other.lt(self)
    }

    /// Cosines of angles in radians.
    #[inline(always)]
    pub fn cos(self) -> Self {
        Self(self.0.cos())
    }

    /// Sines of angles in radians.
    #[inline(always)]
    pub fn sin(self) -> Self {
        Self(self.0.sin())
    }

    /// Raises `self` to the power of `exponent`, for `self` in 0..=1 and a positive exponent: 2^(e log2 b). The
    /// error is below 1e-6, or below 2e-6 of the result if that is more.
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
        const MANTISSA: u32 = 0x007f_ffff;
        let root = u32x8::splat(ROOT_HALF);
        let beyond = self.to_bits() - root;
        let exponent = Self::from_whole(signed(beyond) >> 23);
        let mantissa = Self::from_bits((beyond & u32x8::splat(MANTISSA)) + root);
        let s = (mantissa - Self::ONE) / (mantissa + Self::ONE);
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
        const BIAS: u32 = 127;
        let whole = (self + Self::splat(ROUND)) - Self::splat(ROUND);
        let rest = self - whole;
        // (ln 2)^n / n! for n = 6 .. 0
        let series = [1.540_353e-4, 1.333_356e-3, 9.618_129e-3, 5.550_411e-2, 0.240_226_5, LN_2, 1.0];
        let sum = series.into_iter().fold(Self::ZERO, |sum, term| sum * rest + Self::splat(term));
        // bits of 1.5 * 2^23 + whole count up by whole
        let steps = (whole + Self::splat(ROUND)).to_bits() - u32x8::splat(ROUND.to_bits());
        sum * Self::from_bits((steps + u32x8::splat(BIAS)) << 23)
    }
}

/// One float, or eight: a formula of such numbers stands once.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// A constant.
    fn of(value: f32) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Smaller of the two.
    fn min(self, other: Self) -> Self;
    /// Greater of the two.
    fn max(self, other: Self) -> Self;
}

macro_rules! real {
    ($type:ty, $of:expr) => {
        impl Real for $type {
            #[inline(always)]
            fn of(value: f32) -> Self {
                $of(value)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                self.min(other)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                self.max(other)
            }
        }
    };
}
real!(f32, std::convert::identity);
real!(f64, f64::from);
real!(F32x8, F32x8::splat);

/// Converts to the same bits with a sign.
#[inline(always)]
pub fn signed(bits: u32x8) -> i32x8 {
    bytemuck::cast(bits)
}

/// Converts to the same bits without a sign.
#[inline(always)]
pub fn unsigned(bits: i32x8) -> u32x8 {
    bytemuck::cast(bits)
}

macro_rules! lane_by_lane {
    ($($op:ident $name:ident $sign:tt),+) => {$(
        impl $op for F32x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(self.0 $sign other.0)
            }
        }
        impl $op<f32> for F32x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f32) -> Self {
                self $sign Self::splat(other)
            }
        }
    )+};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0 ^ f32x8::splat(-0.0))
    }
}

/// Returns true if all of some values, at least one, are the same.
#[inline(always)]
pub fn are_same<T: PartialEq>(values: &[T]) -> bool {
    // no early exit: so many are compared at once
    values.iter().fold(true, |same, value| same & (*value == values[0]))
}

impl Mask {
    /// True in all lanes.
    pub const ALL: Self = Self(f32x8::new([f32::from_bits(u32::MAX); LANES]));
    /// False in all lanes.
    pub const NONE: Self = Self(f32x8::new([0.0; LANES]));

    /// True where `holds(lane)`.
    #[inline(always)]
    pub fn new(mut holds: impl FnMut(usize) -> bool) -> Self {
        Self::of_bits(u32x8::new(std::array::from_fn(|lane| u32::from(holds(lane)).wrapping_neg())))
    }

    /// True where one of eight numbers is `wanted`.
    #[inline(always)]
    pub fn equal(numbers: &[u32], wanted: u32) -> Self {
        Self::of_bits(eight(numbers).cmp_eq(u32x8::splat(wanted)))
    }

    /// True where one of eight numbers is less than `border`.
    #[inline(always)]
    pub fn less(numbers: &[u32], border: u32) -> Self {
        Self::of_bits(eight(numbers).cmp_lt(u32x8::splat(border)))
    }

    /// Inverse of [`bits`](Self::bits).
    #[inline(always)]
    pub fn from_bits(bits: u8) -> Self {
        Self::new(|lane| bits >> lane & 1 != 0)
    }

    #[inline(always)]
    fn of_bits(bits: u32x8) -> Self {
        Self(F32x8::from_bits(bits).0)
    }

    /// Value of lane `lane`.
    #[inline(always)]
    pub fn lane(self, lane: usize) -> bool {
        self.0.as_array_ref()[lane].to_bits() != 0
    }

    /// Sets lane `lane` to true.
    #[inline(always)]
    pub fn set(&mut self, lane: usize) {
        self.0.as_array_mut()[lane] = f32::from_bits(u32::MAX);
    }

    /// Returns true if any lane is true.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    /// Converts to bits: bit `i` is lane `i`.
    #[inline(always)]
    pub fn bits(self) -> u8 {
        self.0.move_mask() as u8
    }

    /// Selects `yes` where the lane is true, `no` elsewhere.
    #[inline(always)]
    pub fn select(self, yes: F32x8, no: F32x8) -> F32x8 {
        F32x8(self.0.blend(yes.0, no.0))
    }
}

/// Loads eight numbers of a column.
#[inline(always)]
fn eight(numbers: &[u32]) -> u32x8 {
    let mut eight = [0; LANES];
    eight.copy_from_slice(numbers);
    u32x8::new(eight)
}

impl BitAnd for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
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
                let got = f64::from(F32x8::splat(base).power(F32x8::splat(exponent)).lane(3));
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
        let count = F32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, f32::NAN]);
        let few = count.lt(F32x8::splat(3.0));
        assert_eq!((few.bits(), (!few).bits()), (0b0000_0111, 0b1111_1000));
        assert_eq!(*few.select(count, F32x8::ZERO).values(), [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(Mask::new(|lane| lane == 7).bits(), 0b1000_0000);
        assert!((few | !few).bits() == Mask::ALL.bits() && !(few & !few).any());
    }

    #[test]
    fn the_lesser_and_the_greater_are_what_a_comparison_says() {
        const A: [f32; LANES] = [0.0, -0.0, f32::NAN, 1.0, f32::INFINITY, -1.0, 2.0, 6.0];
        const B: [f32; LANES] = [-0.0, 0.0, 4.0, f32::NAN, 5.0, f32::NEG_INFINITY, 2.0, 8.5];
        let (lesser, greater) = (F32x8::new(A).min(F32x8::new(B)), F32x8::new(A).max(F32x8::new(B)));
        for (lane, (a, b)) in A.into_iter().zip(B).enumerate() {
            let wanted = [if a < b { a } else { b }, if a > b { a } else { b }].map(f32::to_bits);
            assert_eq!([lesser.lane(lane), greater.lane(lane)].map(f32::to_bits), wanted, "{a} and {b}");
        }
    }

    #[test]
    fn bits_and_products_come_back() {
        assert_eq!(Mask::from_bits(0b1010_0110).bits(), 0b1010_0110);
        let [two, three] = [2.0, 3.0].map(F32x8::splat);
        assert_eq!(*two.add_product(three, three).values(), [11.0; LANES]);
        assert_eq!(*two.less_product(three, three).values(), [-7.0; LANES]);
    }
}
