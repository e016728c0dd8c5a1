//! Scrambles numbers for the choices that depend on a place alone.

use wide::u32x8;

/// An integer hash in which each bit of the input changes each bit of the result about as often as not
/// (Wellons' "lowbias32").
#[inline]
pub fn scrambled(bits: u32) -> u32 {
    let bits = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    let bits = (bits ^ (bits >> 15)).wrapping_mul(0x846c_a68b);
    bits ^ (bits >> 16)
}

/// [`scrambled`] of eight numbers.
#[inline(always)]
pub fn scrambled_lanes(bits: u32x8) -> u32x8 {
    let bits = (bits ^ (bits >> 16)) * u32x8::splat(0x7feb_352d);
    let bits = (bits ^ (bits >> 15)) * u32x8::splat(0x846c_a68b);
    bits ^ (bits >> 16)
}
