//! Hashes of whole numbers and of the bits of floats, as the texture nodes of Blender use them.
//!
//! [`jenkins`] is lookup3 of Bob Jenkins (2006). [`cell`] is the PCG hash of Jarzynski and Olano, "Hash
//! Functions for GPU Rendering" (JCGT 2020), on signed numbers.

use std::array;

use glam::{Vec2, Vec3};
use wide::u32x8;

/// A word of 32 bits, or eight of them; sums wrap around.
trait Word: Copy {
    fn all(value: u32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn xor(self, other: Self) -> Self;
    fn turned(self, bits: u32) -> Self;
}

impl Word for u32 {
    #[inline(always)]
    fn all(value: u32) -> Self {
        value
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.wrapping_add(other)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.wrapping_sub(other)
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self ^ other
    }

    #[inline(always)]
    fn turned(self, bits: u32) -> Self {
        self.rotate_left(bits)
    }
}

impl Word for u32x8 {
    #[inline(always)]
    fn all(value: u32) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn xor(self, other: Self) -> Self {
        self ^ other
    }

    #[inline(always)]
    fn turned(self, bits: u32) -> Self {
        self << bits | self >> (32 - bits)
    }
}

/// The hash of one to four words: `hashword` of lookup3 with 13 as the initial value.
pub fn jenkins<const N: usize>(key: [u32; N]) -> u32 {
    hashed(key)
}

/// [`jenkins`] of eight keys.
#[inline(always)]
pub fn jenkins8<const N: usize>(key: [u32x8; N]) -> u32x8 {
    hashed(key)
}

#[inline(always)]
fn hashed<W: Word, const N: usize>(key: [W; N]) -> W {
    const { assert!(N >= 1 && N <= 4) };
    let length = (N as u32) << 2;
    let mut state = [W::all(0xdead_beef_u32.wrapping_add(length).wrapping_add(13)); 3];
    for (part, word) in state.iter_mut().zip(key) {
        *part = part.plus(word);
    }
    if N == 4 {
        state = stirred(state);
        state[0] = state[0].plus(key[N - 1]);
    }
    closed(state)
}

/// The `mix` step of lookup3, between blocks of three words.
#[inline(always)]
fn stirred<W: Word>([mut a, mut b, mut c]: [W; 3]) -> [W; 3] {
    let fold = |value: W, other: W, bits| value.minus(other).xor(other.turned(bits));
    for (first, second, third) in [(4, 6, 8), (16, 19, 4)] {
        a = fold(a, c, first);
        c = c.plus(b);
        b = fold(b, a, second);
        a = a.plus(c);
        c = fold(c, b, third);
        b = b.plus(a);
    }
    [a, b, c]
}

/// The `final` step of lookup3.
#[inline(always)]
fn closed<W: Word>([mut a, mut b, mut c]: [W; 3]) -> W {
    let fold = |value: W, other: W, bits| value.xor(other).minus(other.turned(bits));
    c = fold(c, b, 14);
    a = fold(a, c, 11);
    b = fold(b, a, 25);
    c = fold(c, b, 16);
    a = fold(a, c, 4);
    b = fold(b, a, 14);
    fold(c, b, 24)
}

/// The hash of the bits of floats, 0 to 1. The two zeros have different bits.
pub fn unit<const N: usize>(key: [f32; N]) -> f32 {
    // The divisor is 2^32 - 1, which is 2^32 as a float: the largest hashes give 1.
    jenkins(key.map(f32::to_bits)) as f32 * (1.0 / u32::MAX as f32)
}

/// Three hashes of one float, each 0 to 1.
pub fn unit3_of1(key: f32) -> Vec3 {
    Vec3::new(unit([key]), unit([key, 1.0]), unit([key, 2.0]))
}

/// Three hashes of two floats, each 0 to 1.
pub fn unit3_of2([x, y]: [f32; 2]) -> Vec3 {
    Vec3::new(unit([x, y]), unit([x, y, 1.0]), unit([x, y, 2.0]))
}

/// Three hashes of three floats, each 0 to 1.
pub fn unit3_of3([x, y, z]: [f32; 3]) -> Vec3 {
    Vec3::new(unit([x, y, z]), unit([x, y, z, 1.0]), unit([x, y, z, 2.0]))
}

/// Three hashes of four floats, each 0 to 1.
pub fn unit3_of4([x, y, z, w]: [f32; 4]) -> Vec3 {
    Vec3::new(unit([x, y, z, w]), unit([z, x, w, y]), unit([w, z, y, x]))
}

/// Two hashes of three floats, each 0 to 1.
pub fn unit2_of3([x, y, z]: [f32; 3]) -> Vec2 {
    Vec2::new(unit([x, y, z]), unit([z, x, y]))
}

/// Two hashes of four floats, each 0 to 1.
pub fn unit2_of4([x, y, z, w]: [f32; 4]) -> Vec2 {
    Vec2::new(unit([x, y, z, w]), unit([z, x, w, y]))
}

/// The hash of a cell of two, three, or four axes, each part 0 to 1.
pub fn cell<const N: usize>(cell: [i32; N]) -> [f32; N] {
    let mut state = cell.map(|part| part.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    spread(&mut state);
    // The shift keeps the sign.
    state = state.map(|part| part ^ (part >> 16));
    spread(&mut state);
    array::from_fn(|axis| (state[axis] & i32::MAX) as f32 * (1.0 / i32::MAX as f32))
}

/// Each part takes in a product of others.
#[inline(always)]
fn spread(state: &mut [i32]) {
    // The part that is changed, and those that are multiplied; 2D multiplies by a constant instead.
    let steps: &[[usize; 3]] = match state.len() {
        3 => &[[0, 1, 2], [1, 2, 0], [2, 0, 1]],
        4 => &[[0, 1, 3], [1, 2, 0], [2, 0, 1], [3, 1, 2]],
        _ => &[],
    };
    for [part, first, second] in steps {
        state[*part] = state[*part].wrapping_add(state[*first].wrapping_mul(state[*second]));
    }
    if let [x, y] = state {
        *x = x.wrapping_add(y.wrapping_mul(1_664_525));
        *y = y.wrapping_add(x.wrapping_mul(1_664_525));
    }
}
