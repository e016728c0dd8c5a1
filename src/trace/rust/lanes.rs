//! Eight floats at once, in safe Rust.
//!
//! The program is usually built for AVX2, but may be built for any x86-64 (see `.cargo/config.toml`), so the
//! processor's features are detected at run time, once a batch: [`dispatch`] runs work compiled for AVX2 and
//! FMA where they are present, and the same work on plain arrays elsewhere. Every function between
//! [`Work::run`] and an operation on lanes must be inlined into it (`#[inline(always)]`), or it is compiled
//! for the target of the build, and in a plain build with a call for each operation. So no closure may have
//! one in it: those are inlined if the compiler likes to. (Calls of the standard library's for arrays and
//! iterators are not always inlined either, so that code which runs once a packet has loops.)

#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::__m256;

/// Number of floats.
pub const WIDTH: usize = 8;

/// Operations on eight floats, lane by lane.
pub trait F32x8: Copy {
    /// Eight floats.
    type F: Copy;
    /// Eight booleans.
    type M: Copy;

    /// Sets all lanes to the same value.
    fn splat(self, value: f32) -> Self::F;
    /// Loads from memory.
    fn load(self, values: &[f32; WIDTH]) -> Self::F;
    /// Stores to memory.
    fn store(self, a: Self::F) -> [f32; WIDTH];
    /// Returns a + b.
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a - b.
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a b.
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a / b.
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns c - a b; rounded once or twice, as the processor does it, but always in the same way.
    fn sub_product(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// Returns a b + c; rounded like [`sub_product`](Self::sub_product).
    fn add_product(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// Returns the lesser.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns the greater.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// Returns a < b; false for NaN.
    fn less(self, a: Self::F, b: Self::F) -> Self::M;
    /// Returns a <= b; false for NaN.
    fn at_most(self, a: Self::F, b: Self::F) -> Self::M;
    /// Returns true where both are.
    fn and(self, a: Self::M, b: Self::M) -> Self::M;
    /// Returns true where either is.
    fn or(self, a: Self::M, b: Self::M) -> Self::M;
    /// Converts to bits: bit i for lane i.
    fn bits(self, mask: Self::M) -> u32;

    /// Returns a == b; false for NaN.
    #[inline(always)]
    fn equal(self, a: Self::F, b: Self::F) -> Self::M {
        self.and(self.at_most(a, b), self.at_most(b, a))
    }

    /// Inverse of [`bits`](Self::bits).
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        let mut set = [0.0; WIDTH];
        for (lane, set) in set.iter_mut().enumerate() {
            *set = (bits >> lane & 1) as f32;
        }
        self.less(self.splat(0.0), self.load(&set))
    }
}

/// Work to be compiled for several kinds of processors.
pub trait Work {
    /// Does the work. Must be `#[inline(always)]`.
    fn run<L: F32x8>(self, lanes: L);
}

/// Runs `work` with the widest lanes that this processor has.
pub fn dispatch<W: Work>(work: W) {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(avx2, OnAvx2(avx2, work));
    }
    work.run(Plain);
}

#[cfg(target_arch = "x86_64")]
struct OnAvx2<W>(pulp::x86::V3, W);

#[cfg(target_arch = "x86_64")]
impl<W: Work> pulp::NullaryFnOnce for OnAvx2<W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.1.run(self.0);
    }
}

#[cfg(target_arch = "x86_64")]
impl F32x8 for pulp::x86::V3 {
    type F = __m256;
    type M = __m256;

    #[inline(always)]
    fn splat(self, value: f32) -> __m256 {
        self.avx._mm256_set1_ps(value)
    }
    #[inline(always)]
    fn load(self, values: &[f32; WIDTH]) -> __m256 {
        pulp::cast(*values)
    }
    #[inline(always)]
    fn store(self, a: __m256) -> [f32; WIDTH] {
        pulp::cast(a)
    }
    #[inline(always)]
    fn add(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_add_ps(a, b)
    }
    #[inline(always)]
    fn sub(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_sub_ps(a, b)
    }
    #[inline(always)]
    fn mul(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_mul_ps(a, b)
    }
    #[inline(always)]
    fn div(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_div_ps(a, b)
    }
    #[inline(always)]
    fn sub_product(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.fma._mm256_fnmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn add_product(self, a: __m256, b: __m256, c: __m256) -> __m256 {
        self.fma._mm256_fmadd_ps(a, b, c)
    }
    #[inline(always)]
    fn min(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_min_ps(a, b)
    }
    #[inline(always)]
    fn max(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_max_ps(a, b)
    }
    #[inline(always)]
    fn less(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_cmp_ps::<{ core::arch::x86_64::_CMP_LT_OQ }>(a, b)
    }
    #[inline(always)]
    fn at_most(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_cmp_ps::<{ core::arch::x86_64::_CMP_LE_OQ }>(a, b)
    }
    #[inline(always)]
    fn and(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_and_ps(a, b)
    }
    #[inline(always)]
    fn or(self, a: __m256, b: __m256) -> __m256 {
        self.avx._mm256_or_ps(a, b)
    }
    #[inline(always)]
    fn bits(self, mask: __m256) -> u32 {
        self.avx._mm256_movemask_ps(mask) as u32
    }
}

/// Lanes as plain arrays, for processors without AVX2.
#[derive(Clone, Copy)]
struct Plain;

#[inline(always)]
fn zip(a: [f32; WIDTH], b: [f32; WIDTH], f: impl Fn(f32, f32) -> f32) -> [f32; WIDTH] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

#[inline(always)]
fn ask(a: [f32; WIDTH], b: [f32; WIDTH], f: impl Fn(f32, f32) -> bool) -> [bool; WIDTH] {
    std::array::from_fn(|i| f(a[i], b[i]))
}

impl F32x8 for Plain {
    type F = [f32; WIDTH];
    type M = [bool; WIDTH];

    #[inline(always)]
    fn splat(self, value: f32) -> Self::F {
        [value; WIDTH]
    }
    #[inline(always)]
    fn load(self, values: &[f32; WIDTH]) -> Self::F {
        *values
    }
    #[inline(always)]
    fn store(self, a: Self::F) -> [f32; WIDTH] {
        a
    }
    #[inline(always)]
    fn add(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| a / b)
    }
    #[inline(always)]
    fn sub_product(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        self.sub(c, self.mul(a, b))
    }
    #[inline(always)]
    fn add_product(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F {
        self.add(c, self.mul(a, b))
    }
    // a comparison and a choice are one instruction; `f32::min` is more, because of NaN
    #[inline(always)]
    fn min(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: Self::F, b: Self::F) -> Self::F {
        zip(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn less(self, a: Self::F, b: Self::F) -> Self::M {
        ask(a, b, |a, b| a < b)
    }
    #[inline(always)]
    fn at_most(self, a: Self::F, b: Self::F) -> Self::M {
        ask(a, b, |a, b| a <= b)
    }
    #[inline(always)]
    fn and(self, a: Self::M, b: Self::M) -> Self::M {
        std::array::from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn or(self, a: Self::M, b: Self::M) -> Self::M {
        std::array::from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn bits(self, mask: Self::M) -> u32 {
        mask.iter().enumerate().fold(0, |bits, (i, on)| bits | u32::from(*on) << i)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: [f32; WIDTH] = [0.0, -1.0, 2.0, f32::NAN, f32::INFINITY, 6.0, -0.0, 8.0];
    const B: [f32; WIDTH] = [1.0, -2.0, 2.0, 4.0, 5.0, f32::NEG_INFINITY, 0.0, 8.5];

    struct Check;

    impl Work for Check {
        #[inline(always)]
        fn run<L: F32x8>(self, lanes: L) {
            let (a, b) = (lanes.load(&A), lanes.load(&B));
            let (less, at_most) = (lanes.less(a, b), lanes.at_most(a, b));
            assert_eq!((lanes.bits(less), lanes.bits(at_most)), (0b1000_0001, 0b1100_0101));
            assert_eq!(lanes.bits(lanes.and(less, at_most)), 0b1000_0001);
            assert_eq!(lanes.bits(lanes.or(less, at_most)), 0b1100_0101);
            assert_eq!(lanes.bits(lanes.equal(a, b)), 0b0100_0100);
            assert_eq!(lanes.bits(lanes.mask(0b1010_0110)), 0b1010_0110);
            assert_eq!(lanes.store(lanes.add_product(b, b, b))[..3], [2.0, 2.0, 6.0]);
            assert_eq!(lanes.store(lanes.sub_product(b, b, b))[..3], [0.0, -6.0, -2.0]);
            assert_eq!(lanes.store(lanes.min(a, b))[..3], [0.0, -2.0, 2.0]);
            assert_eq!(lanes.store(lanes.max(a, lanes.splat(1.0)))[..3], [1.0, 1.0, 2.0]);
            assert_eq!(lanes.store(lanes.div(lanes.sub(a, b), b))[..3], [-1.0, -0.5, 0.0]);
        }
    }

    #[test]
    fn plain_arrays_and_the_processor_agree() {
        Check.run(Plain);
        dispatch(Check);
    }
}
