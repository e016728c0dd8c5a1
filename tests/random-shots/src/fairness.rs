//! Whether frames that are inferred are as bright as those in full, over many shots.
//!
//! One shot tells little: its light is a sampling, and so is that in full. But both are fair samplings of the same picture, and as many
//! shots are a little brighter as are a little darker. Whatever takes light away, however little of each shot, shows in the mean of many.

/// How often a run may be told to be unfair by chance.
const FALSE_ALARM: f64 = 1e-6;

/// How much brighter a frame is than the same one in full, relative to both: from -1 to 1; none if both are black, or where filters with
/// negative weights leave less than nothing.
pub fn relative_difference([inferred, full]: [f64; 2]) -> Option<f64> {
    let sum = inferred + full;
    (sum > 0.0 && inferred >= 0.0 && full >= 0.0).then(|| (inferred - full) / sum)
}

/// What shots say, each with one number from -1 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fairness {
    shots: u64,
    sum: f64,
    squares: f64,
}

impl Fairness {
    /// Adds a shot.
    pub fn add(&mut self, brighter: f64) {
        self.shots += 1;
        self.sum += brighter;
        self.squares += brighter * brighter;
    }

    /// Mean of the shots.
    pub fn mean(&self) -> f64 {
        self.sum / self.shots.max(1) as f64
    }

    /// How far the mean of as many shots may be from 0 by chance.
    ///
    /// Shots are independent: each is made of a number. Of n independent values in a range of width r, whose variance in the sample is v,
    /// the mean is further than sqrt(2 v ln(4 / d) / n) + 7 r ln(4 / d) / (3 (n - 1)) from its expectation, to either side, with a
    /// probability of at most d (A. Maurer and M. Pontil, "Empirical Bernstein Bounds and Sample-Variance Penalization", 2009,
    /// theorem 4). The expectation is not quite 0, though both lights have the same one, m: a quotient is not linear. The
    /// difference over 2 m has none, and dividing by the sum instead changes it by no more than the variances of both, v.
    pub fn allowed(&self) -> f64 {
        if self.shots < 2 {
            return 1.0;
        }
        let shots = self.shots as f64;
        let variance = (self.squares - self.sum * self.mean()) / (shots - 1.0);
        let chance = (4.0 / FALSE_ALARM).ln();
        (2.0 * variance * chance / shots).sqrt() + 7.0 * 2.0 * chance / (3.0 * (shots - 1.0)) + variance
    }

    /// Returns true if the shots are as bright as in full, for all that they say.
    pub fn is_fair(&self) -> bool {
        self.mean().abs() <= self.allowed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dice::Dice;

    #[test]
    fn light_that_every_shot_loses_shows_in_the_mean() {
        let mut dice = Dice::new(3);
        let mut noise = || dice.between(-0.1, 0.1);
        let of = |shots: usize, noise: &mut dyn FnMut() -> f64| {
            let mut fairness = Fairness::default();
            (0..shots).for_each(|_| fairness.add(noise()));
            fairness
        };
        assert!(of(1000, &mut noise).is_fair());
        assert!(!of(1000, &mut || noise() - 0.12).is_fair());
        assert!(!of(20_000, &mut || noise() - 0.02).is_fair());
        assert!(of(1, &mut || 1.0).is_fair(), "one shot says nothing");
    }

    #[test]
    fn what_is_black_says_nothing() {
        assert_eq!(relative_difference([0.0, 0.0]), None);
        assert_eq!(relative_difference([0.0, 2.0]), Some(-1.0));
        assert_eq!(relative_difference([-1.0, 2.0]), None);
    }
}
