//! Multiple importance sampling: light that can be found in several ways counts once.

use std::ops::{Add, Div};

/// Weight, by the balance heuristic (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995,
/// equation 8), of light found in one way of two. `own` and `other`: number of rays times density of the direction, in the same measure, of
/// the way that found it and of the other one; `own` is above 0.
///
/// Where the estimate of one ray is divided by its own density, the two cancel: `f * mis_weight(own, other) / own` is `f / (own + other)`,
/// and written so.
#[inline(always)]
pub fn mis_weight<T: Copy + Add<Output = T> + Div<Output = T>>(own: T, other: T) -> T {
    own / (own + other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_both_ways_add_up_to_one() {
        for (one, other) in [(1.0, 0.0), (1.0, 3.0), (1e-6, 1e6), (0.25, 0.25)] {
            let sum: f32 = mis_weight(one, other) + if other > 0.0 { mis_weight(other, one) } else { 0.0 };
            assert!((sum - 1.0).abs() < 1e-6, "{one} {other}");
        }
        assert_eq!(mis_weight(1.0, 3.0), 0.25);
    }
}
