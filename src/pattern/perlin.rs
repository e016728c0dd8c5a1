//! Perlin noise in one to four dimensions: Perlin, "Improving Noise" (SIGGRAPH 2002), with the hash, the
//! gradients, and the scales of Blender's nodes, which have them from Open Shading Language.
//!
//! There are two ways to compute it, with the same operations and so the same bits: eight places at once, corner by corner; and place
//! by place, eight corners at once, where there are few of them.

use std::array;

use wide::u32x8;

use super::hash::jenkins8;
use super::mix;
use crate::lanes::{self, F32x8, Real, Vec3x8};

/// Coordinates repeat after so much on each axis: floats are too coarse for noise farther from the origin.
const PERIOD: f32 = 100_000.0;

/// From here on half a cell is added to a coordinate: floats are so coarse that it would always lie on a
/// lattice plane, where noise is zero.
const COARSE: f32 = 1_000_000.0;

/// What the largest sums of gradients need to come near to 1, in 1 to 4 dimensions, as measured by the makers of that library.
const SCALES: [f32; 4] = [0.25, 0.6616, 0.982, 0.8344];

/// Number of places, by dimensions, up to which one after the other is faster than all at once.
const FEW: [usize; 4] = [1, 2, 3, 3];

/// Noise of 1, 2, 3, or 4 dimensions (`N`), about -1 to 1 and never far outside; 0 on the lattice of whole
/// numbers. Of the first `lanes` places, at least.
#[inline(never)]
pub fn signed<const N: usize>(place: [F32x8; N], lanes: usize) -> F32x8 {
    const { assert!(N >= 1 && N <= 4) };
    let [number] = numbers(place, lanes);
    number
}

/// Three numbers of noise of 2 or 3 dimensions (`N`), each as [`signed`] gives one: as Open Shading Language has them, of the first,
/// second and third byte of the corners' hashes.
#[inline(never)]
pub fn signed3<const N: usize>(place: [F32x8; N], lanes: usize) -> Vec3x8 {
    const { assert!(N == 2 || N == 3) };
    numbers::<N, 3>(place, lanes).into()
}

/// So many numbers (`M`) of noise, one of each byte of the corners' hashes.
#[inline(always)]
fn numbers<const N: usize, const M: usize>(place: [F32x8; N], lanes: usize) -> [F32x8; M] {
    let place = place.map(wrapped);
    let unscaled = if lanes <= FEW[N - 1] { one_by_one(place, lanes) } else { at_once(place) };
    unscaled.map(|number| number * SCALES[N - 1])
}

/// The coordinates within the period.
#[inline(always)]
fn wrapped(values: F32x8) -> F32x8 {
    match values.abs().lt(F32x8::splat(PERIOD)).bits() {
        u8::MAX => values,
        _ => wrapped_from_afar(values),
    }
}

/// The coordinates within the period. Not inlined: hardly any are farther away.
#[cold]
#[inline(never)]
fn wrapped_from_afar(values: F32x8) -> F32x8 {
    values.each(|value| {
        if value.abs() < PERIOD {
            return value;
        }
        let value = super::finite(value);
        value % PERIOD + if value.abs() >= COARSE { 0.5 } else { 0.0 }
    })
}

/// Perlin's ease curve, 0 to 1, without first and second derivative at both ends.
#[inline(always)]
fn ease(share: F32x8) -> F32x8 {
    share * share * share * (share * (share * 6.0 - 15.0) + 10.0)
}

/// Noise of the gradients at eight places, from the corners of their cells.
#[inline(always)]
fn at_once<const N: usize, const M: usize>(place: [F32x8; N]) -> [F32x8; M] {
    let floor = place.map(F32x8::floor);
    let local: [F32x8; N] = array::from_fn(|axis| place[axis] - floor[axis]);
    let keys: [[u32x8; 2]; N] = floor.map(|floor| {
        let near = lanes::unsigned(floor.to_whole());
        [near, near + u32x8::splat(1)]
    });
    let towards: [[F32x8; 2]; N] = local.map(|near| [near, near - 1.0]);
    let shares = array::from_fn(|axis| local.get(axis).map_or(F32x8::ZERO, |local| ease(*local)));
    let corners = Corners { keys, towards, shares };
    if N < 4 { corners.cube(0) } else { mixed(corners.cube(0), corners.cube(1), shares[3]) }
}

/// Corners of eight cells, of which each lies on either side (0 or 1) along each axis.
struct Corners<const N: usize> {
    /// Coordinates of either side, as whole numbers.
    keys: [[u32x8; 2]; N],
    /// The places as seen from either side.
    towards: [[F32x8; 2]; N],
    /// How much the farther side counts.
    shares: [F32x8; 4],
}

impl<const N: usize> Corners<N> {
    /// What a corner gives.
    #[inline(always)]
    fn corner<const M: usize>(&self, sides: [usize; 4]) -> [F32x8; M] {
        let hashes = jenkins8::<N>(array::from_fn(|axis| self.keys[axis][sides[axis]]));
        of_bytes::<N, M>(hashes, array::from_fn(|axis| self.towards[axis][sides[axis]]))
    }

    /// What is blended along the first axis, on these sides of the others.
    #[inline(always)]
    fn line<const M: usize>(&self, y: usize, z: usize, w: usize) -> [F32x8; M] {
        mixed(self.corner([0, y, z, w]), self.corner([1, y, z, w]), self.shares[0])
    }

    /// What is blended along the first two axes.
    #[inline(always)]
    fn plane<const M: usize>(&self, z: usize, w: usize) -> [F32x8; M] {
        if N < 2 { self.line(0, z, w) } else { mixed(self.line(0, z, w), self.line(1, z, w), self.shares[1]) }
    }

    /// What is blended along the first three axes.
    #[inline(always)]
    fn cube<const M: usize>(&self, w: usize) -> [F32x8; M] {
        if N < 3 { self.plane(0, w) } else { mixed(self.plane(0, w), self.plane(1, w), self.shares[2]) }
    }
}

/// Between each two of some numbers.
#[inline(always)]
fn mixed<T: Real, const M: usize>(first: [T; M], second: [T; M], share: T) -> [T; M] {
    array::from_fn(|number| mix(first[number], second[number], share))
}

/// Noise of the gradients at the first `lanes` places; the lanes beyond have that of the first.
#[inline(always)]
fn one_by_one<const N: usize, const M: usize>(place: [F32x8; N], lanes: usize) -> [F32x8; M] {
    let mut values = [F32x8::ZERO; M];
    for lane in 0..lanes {
        let of_lane: [f32; M] = at_one(place.map(|axis| axis.lane(lane)));
        for (values, value) in values.iter_mut().zip(of_lane) {
            match lane {
                0 => *values = F32x8::splat(value),
                _ => values.set_lane(lane, value),
            }
        }
    }
    values
}

/// Noise of the gradients at a place.
#[inline(always)]
fn at_one<const N: usize, const M: usize>(place: [f32; N]) -> [f32; M] {
    let floor = place.map(f32::floor);
    let cell = floor.map(|value| value as i32);
    let local: [f32; N] = array::from_fn(|axis| place[axis] - floor[axis]);
    let mut shares = F32x8::ZERO;
    local.into_iter().enumerate().for_each(|(axis, local)| shares.set_lane(axis, local));
    let shares = *ease(shares).values();
    if N < 4 {
        return blended(cell, local, &shares, 0);
    }
    mixed(blended(cell, local, &shares, 0), blended(cell, local, &shares, 1), shares[N - 1])
}

/// What eight corners give, blended along the first three axes; along the fourth they lie on `side`, 0 or 1.
///
/// Bits of a lane's number say whether its corner is the farther one along an axis, the highest bit that of the first axis: then the
/// lanes of either side lie together. With less than three axes the last lanes repeat the first.
#[inline(always)]
fn blended<const N: usize, const M: usize>(
    cell: [i32; N],
    local: [f32; N],
    shares: &[f32; 8],
    side: u32,
) -> [f32; M] {
    let axes = N.min(3);
    let steps: [u32x8; N] = array::from_fn(|axis| {
        let step = |lane: u32| if axis < axes { lane >> (axes - 1 - axis) & 1 } else { side };
        u32x8::new([0, 1, 2, 3, 4, 5, 6, 7].map(step))
    });
    let hashes = jenkins8::<N>(array::from_fn(|axis| u32x8::splat(cell[axis] as u32) + steps[axis]));
    let towards =
        array::from_fn(|axis| F32x8::splat(local[axis]) - F32x8::from_whole(lanes::signed(steps[axis])));
    of_bytes::<N, M>(hashes, towards).map(|of_corners| {
        let mut values = *of_corners.values();
        for (axis, share) in shares.iter().enumerate().take(axes) {
            let (near, far) = values.split_at_mut(1 << (axes - 1 - axis));
            for (value, far) in near.iter_mut().zip(far) {
                *value = mix(*value, *far, *share);
            }
        }
        values[0]
    })
}

/// The [`slopes`] of so many bytes of hashes.
#[inline(always)]
fn of_bytes<const N: usize, const M: usize>(hashes: u32x8, towards: [F32x8; N]) -> [F32x8; M] {
    array::from_fn(|byte| slopes(hashes >> (8 * byte as u32), towards))
}

/// The dot products of gradients, which the hashes of corners choose, and the vectors from the corners.
#[inline(always)]
fn slopes<const N: usize>(hashes: u32x8, towards: [F32x8; N]) -> F32x8 {
    let has = |bits: u32, wanted: u32| (hashes & u32x8::splat(bits)).cmp_eq(u32x8::splat(wanted));
    let signed = |value: F32x8, bit: i32| {
        F32x8::from_bits(value.to_bits() ^ ((hashes << (31 - bit)) & u32x8::splat(1 << 31)))
    };
    let pick = |mask: u32x8, first: F32x8, second: F32x8| {
        F32x8::from_bits(mask.blend(first.to_bits(), second.to_bits()))
    };
    let part = |axis: usize| towards[axis];
    match N {
        1 => {
            let length = F32x8::ONE + F32x8::from_whole(lanes::signed(hashes & u32x8::splat(7)));
            signed(length, 3) * part(0)
        }
        2 => {
            let is_low = has(4, 0);
            let (first, second) = (pick(is_low, part(0), part(1)), pick(is_low, part(1), part(0)));
            signed(first, 0) + signed(F32x8::splat(2.0) * second, 1)
        }
        3 => {
            let last = pick(has(13, 12), part(0), part(2));
            let second = pick(has(12, 0), part(1), last);
            signed(pick(has(8, 0), part(0), part(1)), 0) + signed(second, 1)
        }
        _ => {
            // a number below 32: less than 24, than 16, than 8
            let first = pick(has(24, 24), part(1), part(0));
            let second = pick(has(16, 0), part(1), part(2));
            signed(first, 0) + signed(second, 1) + signed(pick(has(24, 0), part(2), part(3)), 2)
        }
    }
}
