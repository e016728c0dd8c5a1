//! Eight or sixteen lanes, a bit each.

use crate::lanes::{LANES, Mask};
use crate::samples::{EMPTY, Status};

/// Bit mask of those of eight cells that hold a surface.
#[inline(always)]
pub fn surface_bits(models: &[u32]) -> u8 {
    Mask::less(models, EMPTY).bits()
}

/// Bit mask of those of eight cells whose status is `wanted`.
#[inline(always)]
pub fn status_bits(status: &[Status], wanted: impl Fn(Status) -> bool) -> u8 {
    Mask::new(|lane| wanted(status[lane])).bits()
}

/// Bit mask of those of eight cells for whose model `holds` returns true. Neighbours mostly show the same
/// model: then `holds` is called once.
#[inline(always)]
pub fn bits_of_models(models: &[u32], holds: impl Fn(u32) -> bool) -> u8 {
    if Mask::equal(models, models[0]).bits() == u8::MAX {
        return if holds(models[0]) { u8::MAX } else { 0 };
    }
    models.iter().enumerate().fold(0, |bits, (lane, model)| bits | u8::from(holds(*model)) << lane)
}

/// Iterates over the numbers of the bits that are set, lowest first. Mostly there is none.
#[inline(always)]
pub fn set_bits(bits: impl Into<u64>) -> impl Iterator<Item = usize> {
    let mut bits = bits.into();
    std::iter::from_fn(move || {
        let lowest = (bits != 0).then(|| bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(lowest)
    })
}

/// Adds 1 to those of eight counts whose bit is set.
#[inline(always)]
pub fn count_bits(bits: u8, counts: &mut [u16]) {
    for (lane, count) in counts[..LANES].iter_mut().enumerate() {
        *count += u16::from(bits >> lane & 1);
    }
}

/// Returns true if bit number `ray` of `bits` is set.
#[inline]
pub fn bit(bits: &[u16], ray: usize) -> bool {
    bits[ray / 16] >> (ray % 16) & 1 != 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::BACKGROUND;

    #[test]
    fn bits_say_what_lanes_say() {
        for bits in 0..=u8::MAX {
            let lanes: Vec<usize> = (0..LANES).filter(|lane| bits >> lane & 1 != 0).collect();
            assert_eq!(set_bits(bits).collect::<Vec<_>>(), lanes);
        }
        let is_odd = |model: u32| model % 2 == 1;
        for models in [
            [7; LANES],
            [4; LANES],
            [EMPTY; LANES],
            [BACKGROUND; LANES],
            [4, 7, 7, EMPTY, 5, 4, BACKGROUND, 7],
        ] {
            let bits_of = |holds: fn(u32) -> bool| {
                (0..LANES).fold(0, |bits, lane| bits | u8::from(holds(models[lane])) << lane)
            };
            assert_eq!(bits_of_models(&models, is_odd), bits_of(is_odd), "{models:?}");
            assert_eq!(surface_bits(&models), bits_of(|model| model < EMPTY), "{models:?}");
        }
        let status = [Status::Good, Status::Missed, Status::Overlapped, Status::Outside];
        assert_eq!(status_bits(&[status, status].concat(), Status::is_reused), 0b0101_0101);
    }
}
