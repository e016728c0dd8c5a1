//! Angles, fast: each ray to the sky asks two, each corner of a face that deforms one. The system's library takes several times as
//! long, for digits that neither needs.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Coefficients of the arc tangent over its argument, in squares of that (Abramowitz and Stegun, "Handbook of Mathematical
/// Functions", 1964, 4.4.49): with exact numbers wrong by 2e-8 at most, from 0 to 1.
const ARC_TANGENT: [f32; 9] = [
    1.0,
    -0.333_331_45,
    0.199_935_51,
    -0.142_089,
    0.106_562_64,
    -0.075_289_64,
    0.042_909_61,
    -0.016_165_737,
    0.002_866_225_7,
];

/// Angle of a direction in a plane, from -π to π: 0 along x, positive towards y; 0 for no direction. Wrong by 3e-7 at most, and by that share of
/// angles that are small.
pub fn of(y: f32, x: f32) -> f32 {
    let (wide, high) = (x.abs(), y.abs());
    let (less, more) = (high.min(wide), high.max(wide));
    let t = if more > 0.0 { less / more } else { 0.0 };
    let z = t * t;
    // by pairs, so that no step waits for all others
    let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = ARC_TANGENT;
    let (z2, low, middle) = (z * z, z.mul_add(c1, c0), z.mul_add(c3, c2));
    let z4 = z2 * z2;
    let (upper, top) = (z2.mul_add(z.mul_add(c7, c6), z.mul_add(c5, c4)), z4 * c8);
    let angle = t * z4.mul_add(upper + top, z2.mul_add(middle, low));
    let angle = if high > wide { FRAC_PI_2 - angle } else { angle };
    (if x < 0.0 { PI - angle } else { angle }).copysign(y)
}

/// Coefficients of the sine over its argument and of the cosine, in squares of that (Moshier, "Cephes Mathematical Library", 1992):
/// with exact numbers wrong by 1e-8 at most, up to an eighth of a turn.
const SINE: [f32; 4] = [1.0, -0.166_666_55, 8.332_161e-3, -1.951_529_6e-4];
const COSINE: [f32; 5] = [1.0, -0.5, 0.041_666_646, -1.388_731_6e-3, 2.443_315_7e-5];

/// Sine and cosine of an angle in turns: 1 is all around. Wrong by 2e-7 at most, of angles within 1,000 turns.
#[inline]
pub fn turned(turns: f32) -> [f32; 2] {
    let quarters = (4.0 * turns).round_ties_even();
    // exact: both have the same exponent, or a smaller one
    let x = (turns - 0.25 * quarters) * TAU;
    let z = x * x;
    let [s0, s1, s2, s3] = SINE;
    let sine = x * z.mul_add(z.mul_add(z.mul_add(s3, s2), s1), s0);
    let [c0, c1, c2, c3, c4] = COSINE;
    let cosine = z.mul_add(z.mul_add(z.mul_add(z.mul_add(c4, c3), c2), c1), c0);
    // by bits: a choice between floats becomes a branch, and no processor foresees in which quarter a random angle is
    let quarter = quarters as i32 as u32;
    let [sine, cosine] = [sine, cosine].map(f32::to_bits);
    let swapped = (sine ^ cosine) & (quarter & 1).wrapping_neg();
    let signed = |value: u32, quarter: u32| f32::from_bits(value ^ (quarter & 2) << 30);
    [signed(sine ^ swapped, quarter), signed(cosine ^ swapped, quarter.wrapping_add(1))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_are_those_of_doubles() {
        let mut worst: f64 = 0.0;
        for i in -300_000..300_000 {
            let turns = i as f32 / 100_003.0;
            let (sine, cosine) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            let [own_sine, own_cosine] = turned(turns).map(f64::from);
            worst = worst.max((own_sine - sine).abs()).max((own_cosine - cosine).abs());
        }
        assert!(worst < 2e-7, "{worst}");
        let quarters = [0.0, 0.25, 0.5, 0.75, 1.0, -0.25].map(turned);
        assert_eq!(quarters, [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]);
    }

    #[test]
    fn angles_are_those_of_doubles() {
        let mut worst: f64 = 0.0;
        for i in 0..400_000 {
            let exact = (f64::from(i) / 200_000.0 - 1.0) * std::f64::consts::PI;
            let length = f64::from(1 + i % 7);
            let (y, x) = ((length * exact.sin()) as f32, (length * exact.cos()) as f32);
            let difference = f64::from(of(y, x)) - f64::from(y).atan2(f64::from(x));
            worst = worst.max(difference.abs());
        }
        assert!(worst < 3e-7, "{worst}");
        for small in [1e-3_f32, 1e-12, 1e-30] {
            assert!((of(small, 1.0) / small - 1.0).abs() < 1e-6, "{small}");
            assert!((of(1.0, -small) - FRAC_PI_2 - small).abs() < 1e-6, "{small}");
        }
        assert_eq!((of(0.0, 0.0), of(0.0, 1.0), of(0.0, -1.0), of(-0.0, -1.0)), (0.0, 0.0, PI, -PI));
    }
}
