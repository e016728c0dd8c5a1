//! A logarithm that is the same on every machine.

/// Logarithm to the base 2, to a tenth: straight between powers of two. Of 0 it is -127; of NaN and infinity at least 128.
#[inline]
pub fn rough_log2(value: f32) -> f32 {
    value.to_bits() as f32 / (1 << 23) as f32 - 127.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_exact_for_powers_of_two_and_near_between_them() {
        assert_eq!([0.25, 1.0, 8.0].map(rough_log2), [-2.0, 0.0, 3.0]);
        assert!(
            (1..1000).map(|i| i as f32 * 0.37).all(|value| (rough_log2(value) - value.log2()).abs() < 0.1)
        );
        assert_eq!(rough_log2(0.0), -127.0);
    }
}
