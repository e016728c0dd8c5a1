//! A distribution over numbered steps, sampled by one random number.

/// The largest float below 1.
pub const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A cumulative distribution in steps.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Steps {
    /// Probability of each step and all before it; the last is exactly 1.
    ends: Vec<f32>,
    /// First step that ends above each of evenly spread numbers, from 0 to below 1: a search begins there (Chen
    /// and Asau, "On Generating Random Variates from an Empirical Distribution", 1974). The length is a power
    /// of two: a random number times that power is not rounded.
    guide: Vec<u32>,
}

/// Result of a search in [`Steps`].
pub struct Step {
    pub index: usize,
    /// Position within the step: 0 to 1.
    pub within: f32,
}

impl Steps {
    /// Creates a distribution in proportion to `weights`, of which each above 0 is raised by `even_share`
    /// times the mean weight. It is uniform if all weights are 0. Returns also the sum of the weights.
    pub fn new(weights: &[f64], even_share: f64) -> (Self, f64) {
        let sum: f64 = weights.iter().sum();
        let even = if sum == 0.0 { 1.0 } else { even_share * sum / weights.len() as f64 };
        let raised = |weight: f64| if weight > 0.0 || sum == 0.0 { weight + even } else { 0.0 };
        // summed in the same order as below: the last quotient is that of equal numbers
        let total = weights.iter().fold(0.0, |total, weight| total + raised(*weight));
        let below = weights.iter().scan(0.0, |below, weight| {
            *below += raised(*weight);
            Some((*below / total) as f32)
        });
        (Self::ending(below.collect()), sum)
    }

    fn ending(ends: Vec<f32>) -> Self {
        // for two steps one, which costs an eighth of what the steps and texels take
        let parts = (ends.len().next_power_of_two() / 2).max(1);
        let mut first = 0;
        let guide = (0..parts).map(|part| {
            let above = part as f32 / parts as f32;
            while first + 1 < ends.len() && ends[first] <= above {
                first += 1;
            }
            first as u32
        });
        let guide = guide.collect();
        Self { ends, guide }
    }

    fn view(&self) -> StepsView<'_> {
        StepsView { ends: &self.ends, guide: &self.guide }
    }

    /// Finds the step that `random` falls into: one of positive probability, whatever `random` is.
    pub fn find(&self, random: f32) -> Step {
        self.view().find(random)
    }

    /// Probability of step `index`.
    pub fn probability(&self, index: usize) -> f32 {
        self.view().probability(index)
    }
}

/// Many distributions of as many steps each, beside each other in memory: who searches one of them waits for its numbers, and not for a
/// pointer to them before.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepRows {
    ends: Vec<f32>,
    guides: Vec<u32>,
    /// Steps of a row.
    steps: usize,
    /// Length of the guide of a row.
    guide: usize,
}

impl StepRows {
    /// Puts `rows`, which have as many steps each, beside each other.
    pub fn new(rows: &[Steps]) -> Self {
        let (steps, guide) = rows.first().map_or((0, 0), |row| (row.ends.len(), row.guide.len()));
        debug_assert!(rows.iter().all(|row| row.ends.len() == steps));
        Self {
            ends: rows.iter().flat_map(|row| &row.ends).copied().collect(),
            guides: rows.iter().flat_map(|row| &row.guide).copied().collect(),
            steps,
            guide,
        }
    }

    fn row(&self, row: usize) -> StepsView<'_> {
        StepsView {
            ends: &self.ends[row * self.steps..][..self.steps],
            guide: &self.guides[row * self.guide..][..self.guide],
        }
    }

    /// Finds the step of row number `row` that `random` falls into, as [`Steps::find`] does.
    pub fn find(&self, row: usize, random: f32) -> Step {
        self.row(row).find(random)
    }

    /// Number of steps of each row.
    pub fn count(&self) -> usize {
        self.steps
    }

    /// Probability of step `index` of row number `row`.
    pub fn probability(&self, row: usize, index: usize) -> f32 {
        self.row(row).probability(index)
    }
}

/// The numbers of [`Steps`], wherever they are.
#[derive(Clone, Copy)]
struct StepsView<'a> {
    ends: &'a [f32],
    guide: &'a [u32],
}

impl StepsView<'_> {
    #[inline]
    fn find(self, random: f32) -> Step {
        // 0 for NaN
        let random = if random > 0.0 { random.min(BELOW_ONE) } else { 0.0 };
        let part = (random * self.guide.len() as f32) as usize;
        // mostly one of three steps: the processor cannot foresee which, and need not for the first two. The last one ends at 1
        let mut index = self.guide[part] as usize;
        for _ in 0..2 {
            index += usize::from(self.ends[index] <= random);
        }
        while self.ends[index] <= random {
            index += 1;
        }
        Step { index, within: (random - self.begin(index)) / self.probability(index) }
    }

    /// Probability of all steps before step `index`.
    #[inline]
    fn begin(self, index: usize) -> f32 {
        if index == 0 { 0.0 } else { self.ends[index - 1] }
    }

    #[inline]
    fn probability(self, index: usize) -> f32 {
        self.ends[index] - self.begin(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even share, as for an environment map.
    const EVEN_SHARE: f64 = 1.0 / 64.0;

    #[test]
    fn cumulative_distributions_end_at_one_and_keep_what_is_dim() {
        let mut dim = vec![1e-30; 32_768];
        dim[7] = 1e30;
        dim[9] = 0.0;
        let (steps, _) = Steps::new(&dim, EVEN_SHARE);
        assert_eq!(steps.ends.last(), Some(&1.0));
        for index in (0..dim.len()).filter(|index| *index != 9) {
            assert!(steps.probability(index) > 0.0, "{index}");
        }
        assert_eq!(steps.probability(9), 0.0);
        assert!(steps.probability(7) > 0.97);

        for (weights, ends) in
            [(vec![0.0, 3.0, 0.0], [0.0, 1.0, 1.0]), (vec![0.0; 3], [1.0 / 3.0, 2.0 / 3.0, 1.0])]
        {
            assert_eq!(Steps::new(&weights, EVEN_SHARE).0.ends, ends);
        }
    }

    #[test]
    fn any_random_number_finds_a_step_that_is_there() {
        let steps = Steps::ending(vec![0.0, 0.25, 0.25, 1.0, 1.0]);
        for (random, index) in [
            (0.0, 1),
            (0.249, 1),
            (0.25, 3),
            (BELOW_ONE, 3),
            (1.0, 3),
            (7.0, 3),
            (-1.0, 1),
            (f32::NAN, 1),
            (f32::INFINITY, 3),
        ] {
            let found = steps.find(random);
            assert_eq!(found.index, index, "{random}");
            assert!(steps.probability(index) > 0.0 && (0.0..=1.0).contains(&found.within), "{random}");
        }
        assert_eq!(steps.find(0.125).within, 0.5);
    }

    #[test]
    fn a_guided_search_finds_what_a_search_through_all_finds() {
        for count in [1, 2, 3, 7, 64, 100] {
            for power in [1, 9] {
                let weights: Vec<f64> = (0..count).map(|at| f64::from((at * 37) % 11).powi(power)).collect();
                let (steps, _) = Steps::new(&weights, EVEN_SHARE);
                for random in
                    (0..4096).map(|at| at as f32 / 4096.0).chain(steps.ends.iter().map(|end| end * BELOW_ONE))
                {
                    let of_all = steps.ends.partition_point(|end| *end <= random);
                    assert_eq!(steps.find(random).index, of_all, "{count} {power} {random}");
                }
            }
        }
    }
}
