//! Perlin noise in one to four dimensions: Perlin, "Improving Noise" (SIGGRAPH 2002), with the hash, the
//! gradients, and the scales of Blender's nodes, which have them from Open Shading Language.

use std::array;

use glam::Vec3;
use wide::u32x8;

use super::hash::jenkins8;
use crate::lanes::{self, F32x8};

/// Coordinates repeat after so much on each axis: floats are too coarse for noise farther from the origin.
const PERIOD: f32 = 100_000.0;

/// From here on half a cell is added to a coordinate: floats are so coarse that it would always lie on a
/// lattice plane, where noise is zero.
const COARSE: f32 = 1_000_000.0;

/// What the largest sums of gradients need to come near to 1, in 1 to 4 dimensions, as measured by the makers of that library.
const SCALES: [f32; 4] = [0.25, 0.6616, 0.982, 0.8344];

/// Noise of 1, 2, 3, or 4 dimensions (`N`), about -1 to 1 and never far outside; 0 on the lattice of whole
/// numbers.
pub fn signed<const N: usize>(place: [f32; N]) -> f32 {
    const { assert!(N >= 1 && N <= 4) };
    SCALES[N - 1] * unscaled(place.map(wrapped))
}

/// Three numbers of noise of 2 or 3 dimensions (`N`), each as [`signed`] gives one: as Open Shading Language has them, of the first,
/// second and third byte of the corners' hashes.
pub fn signed3<const N: usize>(place: [f32; N]) -> Vec3 {
    const { assert!(N == 2 || N == 3) };
    let (cell, local) = in_cell(place.map(wrapped));
    let (hashes, towards) = corners(cell, local, 0);
    let of_byte = |byte: u32| SCALES[N - 1] * between(slopes::<N>(hashes >> (8 * byte), towards), local);
    Vec3::new(of_byte(0), of_byte(1), of_byte(2))
}

/// Noise of 1, 2, 3, or 4 dimensions (`N`), about 0 to 1 and never far outside.
pub fn unsigned<const N: usize>(place: [f32; N]) -> f32 {
    0.5 * signed(place) + 0.5
}

#[inline(always)]
fn wrapped(value: f32) -> f32 {
    if value.abs() < PERIOD {
        return value;
    }
    let value = super::finite(value);
    value % PERIOD + if value.abs() >= COARSE { 0.5 } else { 0.0 }
}

/// Perlin's ease curve, 0 to 1, without first and second derivative at both ends.
#[inline(always)]
fn ease(share: f32) -> f32 {
    share * share * share * (share * (share * 6.0 - 15.0) + 10.0)
}

/// Noise of the gradients, from the corners of the place's cell.
#[inline(always)]
fn unscaled<const N: usize>(place: [f32; N]) -> f32 {
    let (cell, local) = in_cell(place);
    if N < 4 {
        return blended(cell, local, 0);
    }
    super::mix(blended(cell, local, 0), blended(cell, local, 1), ease(local[N - 1]))
}

/// The cell of a place, and where in it the place is.
#[inline(always)]
fn in_cell<const N: usize>(place: [f32; N]) -> ([i32; N], [f32; N]) {
    let floor = place.map(f32::floor);
    (floor.map(|value| value as i32), array::from_fn(|axis| place[axis] - floor[axis]))
}

/// What eight corners give, blended along the first three axes; along the fourth they lie on `side`, 0 or 1.
#[inline(always)]
fn blended<const N: usize>(cell: [i32; N], local: [f32; N], side: u32) -> f32 {
    let (hashes, towards) = corners(cell, local, side);
    between(slopes::<N>(hashes, towards), local)
}

/// The hashes of eight corners, and the vectors from them to the place; along the fourth axis they lie on `side`, 0 or 1.
///
/// Bits of a lane's number say whether its corner is the farther one along an axis, the highest bit that of the first axis: then the
/// lanes of either side lie together. With less than three axes the last lanes repeat the first.
#[inline(always)]
fn corners<const N: usize>(cell: [i32; N], local: [f32; N], side: u32) -> (u32x8, [F32x8; N]) {
    let axes = N.min(3);
    let steps: [u32x8; N] = array::from_fn(|axis| {
        let step = |lane: u32| if axis < axes { lane >> (axes - 1 - axis) & 1 } else { side };
        u32x8::new([0, 1, 2, 3, 4, 5, 6, 7].map(step))
    });
    let hashes = jenkins8::<N>(array::from_fn(|axis| u32x8::splat(cell[axis] as u32) + steps[axis]));
    let towards =
        array::from_fn(|axis| F32x8::splat(local[axis]) - F32x8::from_whole(lanes::signed(steps[axis])));
    (hashes, towards)
}

/// What eight corners have, blended along the first three axes by the place in the cell.
#[inline(always)]
fn between<const N: usize>(of_corners: F32x8, local: [f32; N]) -> f32 {
    let axes = N.min(3);
    let mut values = *of_corners.values();
    for (axis, share) in local.map(ease).into_iter().enumerate().take(axes) {
        let (near, far) = values.split_at_mut(1 << (axes - 1 - axis));
        for (value, far) in near.iter_mut().zip(far) {
            *value = super::mix(*value, *far, share);
        }
    }
    values[0]
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
