//! Angles, fast: each ray to the sky asks two, each corner of a face that deforms one. The system's library takes several times as
//! long, for digits that neither needs.

use std::f32::consts::{FRAC_PI_2, PI};

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
    let (less, more) = if high > wide { (wide, high) } else { (high, wide) };
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

#[cfg(test)]
mod tests {
    use super::*;

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
