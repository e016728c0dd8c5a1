//! Hashes of whole numbers and of the bits of floats, as the texture nodes of Blender use them.
//!
//! [`jenkins`] is lookup3 of Bob Jenkins (2006). [`CellHash`] is the PCG hash of Jarzynski and Olano, "Hash
//! Functions for GPU Rendering" (JCGT 2020), on signed numbers.

use std::array;

use glam::{Vec2, Vec3};
use wide::{i32x8, u32x8};

use crate::lanes::F32x8;

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

/// [`unit()`] of eight keys.
#[inline(always)]
pub fn unit8<const N: usize>(key: [F32x8; N]) -> F32x8 {
    F32x8::from_unsigned(jenkins8(key.map(F32x8::to_bits))) * (1.0 / u32::MAX as f32)
}

/// A cell of two, three, or four axes in each lane, and those about it: their hashes.
#[derive(Debug, Clone, Copy)]
pub struct CellHash<const N: usize> {
    /// Each axis after the first step, which can be made for the cells about it by a sum.
    mixed: [i32x8; N],
}

/// Factor of the hash.
const FACTOR: i32 = 1_664_525;

/// How far cells are away along each axis, as the hash takes it.
#[derive(Debug, Clone, Copy)]
pub struct CellOffset<const N: usize>([i32x8; N]);

impl<const N: usize> CellOffset<N> {
    /// The same in all lanes.
    #[inline(always)]
    pub fn all(offset: [i32; N]) -> Self {
        Self(offset.map(|part| i32x8::splat(part.wrapping_mul(FACTOR))))
    }

    /// Another one in each lane.
    #[inline(always)]
    pub fn each(offset: [i32x8; N]) -> Self {
        Self(offset.map(|part| part * i32x8::splat(FACTOR)))
    }
}

impl<const N: usize> CellHash<N> {
    /// Creates the hash of cells.
    #[inline(always)]
    pub fn new(cell: [i32x8; N]) -> Self {
        Self { mixed: cell.map(|part| part * i32x8::splat(FACTOR) + i32x8::splat(1_013_904_223)) }
    }

    /// The hash of the cell so far away, each part 0 to 1.
    #[inline(always)]
    pub fn at(&self, offset: CellOffset<N>) -> [F32x8; N] {
        self.with_axes(offset)
    }

    /// The hash of the cell with `M` axes, of which those that are missing are 0, that is so far away.
    #[inline(always)]
    pub fn with_axes<const M: usize>(&self, offset: CellOffset<N>) -> [F32x8; M] {
        let zero = Self::new([i32x8::splat(0); N]).mixed[0];
        let part = |axis: usize| self.mixed[axis] + offset.0[axis];
        hashed_cell(array::from_fn(|axis| if axis < N { part(axis) } else { zero }))
    }
}

/// The steps after the first one.
#[inline(always)]
fn hashed_cell<const N: usize>(mut state: [i32x8; N]) -> [F32x8; N] {
    spread(&mut state);
    // The shift keeps the sign.
    state = state.map(|part| part ^ (part >> 16));
    spread(&mut state);
    state.map(|part| F32x8::from_whole(part & i32x8::splat(i32::MAX)) * (1.0 / i32::MAX as f32))
}

/// Each part takes in a product of others.
#[inline(always)]
fn spread(state: &mut [i32x8]) {
    // The part that is changed, and those that are multiplied; 2D multiplies by a constant instead.
    let steps: &[[usize; 3]] = match state.len() {
        3 => &[[0, 1, 2], [1, 2, 0], [2, 0, 1]],
        4 => &[[0, 1, 3], [1, 2, 0], [2, 0, 1], [3, 1, 2]],
        _ => &[],
    };
    for [part, first, second] in steps {
        state[*part] += state[*first] * state[*second];
    }
    if let [x, y] = state {
        *x += *y * i32x8::splat(FACTOR);
        *y += *x * i32x8::splat(FACTOR);
    }
}
