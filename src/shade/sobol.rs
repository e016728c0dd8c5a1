//! Points of an Owen-scrambled Sobol sequence, four dimensions at a time.
//!
//! The same numbers as those of the crate `sobol_burley`, to the bit. The crate goes from bit to bit of an index, eight of them on average
//! at places that no processor foresees; here four tables are asked, which the crate's own functions have filled: paths ask for numbers
//! at each of their ends.

use std::sync::LazyLock;

use sobol_burley::parts::{hash, owen_scramble_rev, sobol_int4_rev, u32_to_f32_norm};

/// Number of sets of four dimensions that the sequence has.
pub const SETS: u32 = sobol_burley::NUM_DIMENSION_SETS_4D;

/// Bits of an index that a table is asked for.
const PART_BITS: usize = 4;

/// Number of an index' parts: it has 16 bits, the uppermost ones of a reversed word.
const PARTS: usize = 16 / PART_BITS;

/// Constants by which the crate tells the four dimensions of a set apart.
const DIMENSIONS: [u32; 4] = [0x912f_69ba, 0x174f_18ab, 0x691e_72ca, 0xb40c_c1b8];

/// Numbers of a set for each part of a reversed index, by its value. Those of an index are the exclusive or of those of its parts: the
/// sequence is linear over bits.
type Table = [[[u32; 4]; 1 << PART_BITS]; PARTS];

/// A KiB for each set.
static TABLES: LazyLock<Vec<Table>> = LazyLock::new(|| {
    let numbers = |set: u32, part: usize, value: usize| {
        let index = (value as u32) << shift_of(part);
        sobol_int4_rev(index, set).into()
    };
    let table = |set: u32| std::array::from_fn(|part| std::array::from_fn(|value| numbers(set, part, value)));
    (0..SETS).map(table).collect()
});

/// Place of a part's lowest bit in a reversed index.
const fn shift_of(part: usize) -> usize {
    u32::BITS as usize - PART_BITS * (part + 1)
}

/// Place of point `index`, below 65,536, in the sequence with this `seed`, with its bits reversed: the same for all sets.
#[inline]
pub fn shuffled(index: u32, seed: u32) -> u32 {
    owen_scramble_rev(index.reverse_bits(), hash(seed ^ 0x79c6_8e4a))
}

/// Four numbers from 0 to below 1: dimensions of set `set`, below [`SETS`], of the point at `place` as [`shuffled`] gives it, of the
/// sequence with this `seed`.
#[inline]
pub fn four(place: u32, set: u32, seed: u32) -> [f32; 4] {
    let mut numbers = [0; 4];
    for (part, table) in TABLES[set as usize].iter().enumerate() {
        let of_part = table[(place >> shift_of(part)) as usize % (1 << PART_BITS)];
        numbers = std::array::from_fn(|dimension| numbers[dimension] ^ of_part[dimension]);
    }
    let of_set = seed.wrapping_mul(0x9c8f_2d3b) ^ set;
    std::array::from_fn(|dimension| {
        let scramble = hash(of_set ^ DIMENSIONS[dimension]);
        u32_to_f32_norm(owen_scramble_rev(numbers[dimension], scramble).reverse_bits())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_the_crate() {
        for i in 0..20_000_u32 {
            let (index, set, seed) = (i.wrapping_mul(40_503) % (1 << 16), i % SETS, hash(i));
            let ours = four(shuffled(index, seed), set, seed).map(f32::to_bits);
            assert_eq!(
                ours,
                sobol_burley::sample_4d(index, set, seed).map(f32::to_bits),
                "{index} {set} {seed}"
            );
        }
    }
}
