//! Perlin noise in one to four dimensions: Perlin, "Improving Noise" (SIGGRAPH 2002), with the hash, the
//! gradients, and the scales of Blender's nodes, which have them from Open Shading Language.

use std::array;

use super::hash::jenkins_lanes;

/// Coordinates repeat after so much on each axis: floats are too coarse for noise farther from the origin.
const PERIOD: f32 = 100_000.0;

/// From here on half a cell is added to a coordinate: floats are so coarse that it would always lie on a
/// lattice plane, where noise is zero.
const COARSE: f32 = 1_000_000.0;

/// Noise of 1, 2, 3, or 4 dimensions (`N`), about -1 to 1 and never far outside; 0 on the lattice of whole
/// numbers.
pub fn signed<const N: usize>(place: [f32; N]) -> f32 {
    const { assert!(N >= 1 && N <= 4) };
    // What the largest sums of gradients need to come near to 1, as measured by the makers of that library.
    let scale = [0.25, 0.6616, 0.982, 0.8344][N - 1];
    let place = place.map(wrapped);
    scale
        * match N {
            1 => unscaled::<N, 2>(place),
            2 => unscaled::<N, 4>(place),
            3 => unscaled::<N, 8>(place),
            _ => unscaled::<N, 16>(place),
        }
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

/// Noise of the gradients, from the `CORNERS` (2 to the power of `N`) of the place's cell.
///
/// Bit `axis` of a corner's index says whether it is the farther one along that axis.
#[inline(always)]
fn unscaled<const N: usize, const CORNERS: usize>(place: [f32; N]) -> f32 {
    let floor = place.map(f32::floor);
    let cell = floor.map(|value| value as i32);
    let local: [f32; N] = array::from_fn(|axis| place[axis] - floor[axis]);
    let step = |corner: usize, axis: usize| corner >> axis & 1;
    let keys = array::from_fn(|axis| {
        array::from_fn(|corner| cell[axis].wrapping_add(step(corner, axis) as i32) as u32)
    });
    let hashes: [u32; CORNERS] = jenkins_lanes::<N, CORNERS>(keys);
    let mut values: [f32; CORNERS] = array::from_fn(|corner| {
        slope::<N>(hashes[corner], array::from_fn(|axis| local[axis] - step(corner, axis) as f32))
    });
    for (axis, share) in local.map(ease).into_iter().enumerate() {
        for index in 0..1 << (N - 1 - axis) {
            values[index] = super::mix(values[2 * index], values[2 * index + 1], share);
        }
    }
    values[0]
}

/// The dot product of a corner's gradient, which the hash chooses, and the vector from the corner.
#[inline(always)]
fn slope<const N: usize>(hash: u32, towards: [f32; N]) -> f32 {
    let signed = |value: f32, bit: u32| f32::from_bits(value.to_bits() ^ (hash >> bit & 1) << 31);
    let part = |axis: usize| towards[axis];
    match N {
        1 => signed(1.0 + (hash & 7) as f32, 3) * part(0),
        2 => {
            let is_low = hash & 7 < 4;
            let (first, second) = (pick(is_low, part(0), part(1)), pick(is_low, part(1), part(0)));
            signed(first, 0) + signed(2.0 * second, 1)
        }
        3 => {
            let choice = hash & 15;
            let last = pick(choice & 13 == 12, part(0), part(2));
            let second = pick(choice < 4, part(1), last);
            signed(pick(choice < 8, part(0), part(1)), 0) + signed(second, 1)
        }
        _ => {
            let choice = hash & 31;
            let first = pick(choice < 24, part(0), part(1));
            let second = pick(choice < 16, part(1), part(2));
            signed(first, 0) + signed(second, 1) + signed(pick(choice < 8, part(2), part(3)), 2)
        }
    }
}

/// The first number if `is_first`, the second else, without a branch: which it is, no processor can guess.
#[inline(always)]
fn pick(is_first: bool, first: f32, second: f32) -> f32 {
    let mask = u32::from(is_first).wrapping_neg();
    f32::from_bits(first.to_bits() & mask | second.to_bits() & !mask)
}
