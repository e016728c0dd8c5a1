//! Radiance on a latitude-longitude grid, and the distribution that samples it by importance.
//!
//! A grid has a space of its own: that of the environment before it is rotated. Rows go from +Y down to -Y, columns
//! from +Z over -X, -Z (the middle) and +X back to +Z:
//! `u = 1/2 + atan2(x, -z) / 2π` and `v = atan2(√(x² + z²), y) / π`.

use std::f64::consts::{PI, TAU};
use std::fmt;

use glam::Vec3;
use rayon::prelude::*;

use super::light_from::LightFrom;
use super::picture_error::PictureError;

/// Of all samples, about this share is spread evenly over what is not black. So a step of a cumulative distribution
/// is larger than the rounding of a float near 1, up to 32768 steps: whatever shines can be found.
const EVEN_SHARE: f64 = 1.0 / 64.0;

/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Texels of linear RGB, interpolated bilinearly. Columns wrap; beyond the rows at the poles they are repeated.
///
/// Each texel has a cell of the sphere, and the density is constant in a cell: proportional to the mean of the
/// interpolated radiance in it. That is positive wherever the radiance is, because interpolation mixes into a cell
/// what lies beside it, and the density counts the same.
#[derive(Clone, PartialEq)]
pub(super) struct Grid {
    width: usize,
    height: usize,
    /// Three values each, row by row from the top.
    texels: Vec<f32>,
    /// Of the rows.
    rows: Steps,
    /// Of the columns within each row.
    columns: Vec<Steps>,
    /// Cosines of the angles to +Y of the edges of rows, from 1 to -1: one more than there are rows.
    edges: Vec<f64>,
    /// Integral over the sphere of the mean of red, green and blue.
    power: f64,
}

/// A cumulative distribution in steps.
#[derive(Clone, PartialEq)]
struct Steps {
    /// Probability of each step and all before it; the last is exactly 1.
    ends: Vec<f32>,
    /// The first step that ends above each of evenly spread numbers, from 0 up to 1: a search begins and ends there (Chen and
    /// Asau, "On Generating Random Variates from an Empirical Distribution", 1974). A power of two of them, and one: a
    /// random number times that power is not rounded.
    guide: Vec<u32>,
}

/// What was found in it.
struct Step {
    index: usize,
    /// Where in the step: 0 to 1.
    within: f32,
}

impl Grid {
    /// `texels`: red, green and blue of each texel, row by row from the top.
    ///
    /// # Errors
    /// A side of 0, another number of values than the size says, a negative value, NaN or infinity.
    pub fn new(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, PictureError> {
        check(width, height, &texels)?;
        let (width, height) = (width as usize, height as usize);
        let edges: Vec<f64> = (0..=height).map(|edge| (PI * edge as f64 / height as f64).cos()).collect();
        let (columns, sums): (Vec<Steps>, Vec<f64>) = (0..height)
            .into_par_iter()
            .map_init(Vec::new, |weights, row| {
                interpolated_means(&texels, width, row, height, weights);
                Steps::of(weights, EVEN_SHARE)
            })
            .unzip();
        let areas = edges.windows(2).map(|edges| (edges[0] - edges[1]) * TAU / width as f64);
        let mut weights: Vec<f64> = sums.iter().zip(areas.clone()).map(|(sum, area)| sum * area).collect();
        let power = weights.iter().sum();
        let mut even_share = EVEN_SHARE;
        if power == 0.0 {
            // a black grid is sampled evenly over the sphere
            (weights, even_share) = (areas.collect(), 0.0);
        }
        let (rows, _) = Steps::of(&weights, even_share);
        Ok(Self { width, height, texels, rows, columns, edges, power })
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Integral over the sphere of the mean of red, green and blue.
    pub fn power(&self) -> f64 {
        self.power
    }

    /// Radiance from a place, in texels from the left and from the top.
    fn radiance_at(&self, [x, y]: [f32; 2]) -> Vec3 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let column = |column: f32| (column as i64).rem_euclid(self.width as i64) as usize;
        let row = |row: f32| (row.max(0.0) as usize).min(self.height - 1);
        let (left, right, across) = (column(left), column(left + 1.0), x - left);
        let (above, below, down) = (row(top), row(top + 1.0), y - top);
        let upper = self.texel(left, above).lerp(self.texel(right, above), across);
        let lower = self.texel(left, below).lerp(self.texel(right, below), across);
        // a blend of the largest floats may be rounded to infinity
        upper.lerp(lower, down).min(Vec3::MAX)
    }

    /// A direction (unit length). `random`: two numbers from 0 to 1; the first picks the column, the second the row.
    pub fn sample(&self, random: [f32; 2]) -> Vec3 {
        let row = self.rows.find(random[1]);
        let column = self.columns[row.index].find(random[0]);
        // in doubles: near a pole the cosine is too close to 1 for floats
        let [top, bottom] = [self.edges[row.index], self.edges[row.index + 1]];
        let y = top + (bottom - top) * f64::from(row.within);
        let radius = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let u = (column.index as f64 + f64::from(column.within)) / self.width as f64;
        let (sin, cos) = ((TAU * (u - 0.5)) as f32).sin_cos();
        let radius = radius as f32;
        Vec3::new(radius * sin, y as f32, -radius * cos)
    }

    /// Radiance from `direction`, and the probability density with which [`Self::sample`] gives it, in solid angle.
    pub fn light(&self, direction: Vec3) -> LightFrom {
        let place = self.place(direction);
        LightFrom { radiance: self.radiance_at(place), pdf: self.pdf_at(place) }
    }

    /// Density of the direction to a place, in texels from the left and from the top.
    fn pdf_at(&self, [x, y]: [f32; 2]) -> f32 {
        let (column, row) = ((x as usize) % self.width, (y as usize).min(self.height - 1));
        let of_cell =
            f64::from(self.rows.probability(row)) * f64::from(self.columns[row].probability(column));
        let solid_angle = (self.edges[row] - self.edges[row + 1]) * TAU / self.width as f64;
        (of_cell / solid_angle) as f32
    }

    /// Where `direction` (any length) falls, in texels from the left and from the top.
    fn place(&self, direction: Vec3) -> [f32; 2] {
        use std::f32::consts::{FRAC_1_PI, TAU};
        let u = 0.5 + direction.x.atan2(-direction.z) / TAU;
        // not the arc cosine of y, which knows no small angles
        let v = direction.x.hypot(direction.z).atan2(direction.y) * FRAC_1_PI;
        [u * self.width as f32, v * self.height as f32]
    }

    fn texel(&self, column: usize, row: usize) -> Vec3 {
        Vec3::from_slice(&self.texels[3 * (row * self.width + column)..])
    }
}

/// The size alone: nobody wants to read all texels.
impl fmt::Debug for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Grid({}x{})", self.width, self.height)
    }
}

/// That the values are as many as they should be, finite, and not negative.
fn check(width: u32, height: u32, texels: &[f32]) -> Result<(), PictureError> {
    let values = (u64::from(width) * u64::from(height)).saturating_mul(3);
    if values == 0 || values != texels.len() as u64 {
        return Err(PictureError::Size { width, height, values: texels.len() });
    }
    match texels.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
        None => Ok(()),
        Some(at) => {
            let (pixel, width) = (at / 3, width as usize);
            let pixel = [(pixel % width) as u32, (pixel / width) as u32];
            Err(PictureError::Value { pixel, channel: ['R', 'G', 'B'][at % 3], value: texels[at] })
        }
    }
}

/// Makes `means` what the mean of red, green and blue is on average in each cell of `row`, interpolated bilinearly:
/// along each axis three quarters of the texel's own and an eighth of each neighbour's.
fn interpolated_means(texels: &[f32], width: usize, row: usize, height: usize, means: &mut Vec<f64>) {
    const OWN: f64 = 0.75;
    const BESIDE: f64 = 0.125;
    let row_of = |row: usize| texels[3 * row * width..].chunks_exact(3).take(width);
    let mean = |rgb: &[f32]| rgb.iter().map(|value| f64::from(*value)).sum::<f64>() / 3.0;
    let three = row_of(row.saturating_sub(1)).zip(row_of(row)).zip(row_of((row + 1).min(height - 1)));
    let down = three.map(|((above, own), below)| BESIDE * (mean(above) + mean(below)) + OWN * mean(own));
    let down: Vec<f64> = down.collect();
    means.clear();
    means.extend((0..width).map(|column| {
        let (left, right) = (down[(column + width - 1) % width], down[(column + 1) % width]);
        BESIDE * (left + right) + OWN * down[column]
    }));
}

impl Steps {
    /// The distribution that is proportional to `weights`, but for `even_share` that all which are not 0 have alike; an even one
    /// if all are 0. With the sum of the weights.
    fn of(weights: &[f64], even_share: f64) -> (Self, f64) {
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
        let guide = (0..=parts).map(|part| {
            let above = part as f32 / parts as f32;
            while first + 1 < ends.len() && ends[first] <= above {
                first += 1;
            }
            first as u32
        });
        let guide = guide.collect();
        Self { ends, guide }
    }

    /// The step that `random` falls into: one of positive probability, whatever `random` is.
    fn find(&self, random: f32) -> Step {
        // 0 for NaN
        let random = if random > 0.0 { random.min(BELOW_ONE) } else { 0.0 };
        let part = (random * (self.guide.len() - 1) as f32) as usize;
        let [first, last] = [self.guide[part], self.guide[part + 1]].map(|step| step as usize);
        // exists: the last step ends at 1
        let index = first + self.ends[first..=last].partition_point(|end| *end <= random);
        Step { index, within: (random - self.begin(index)) / self.probability(index) }
    }

    /// Probability of all before step `index`.
    fn begin(&self, index: usize) -> f32 {
        if index == 0 { 0.0 } else { self.ends[index - 1] }
    }

    /// Of step `index`.
    fn probability(&self, index: usize) -> f32 {
        self.ends[index] - self.begin(index)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use super::*;

    #[test]
    fn directions_fall_where_the_mapping_says() {
        let grid = Grid::new(8, 4, vec![1.0; 96]).unwrap();
        for (direction, expected) in [
            (Vec3::NEG_Z, [4.0, 2.0]),
            (Vec3::X, [6.0, 2.0]),
            (Vec3::NEG_X, [2.0, 2.0]),
            (Vec3::new(1e-6, 0.0, 1.0), [8.0, 2.0]),
            (Vec3::new(-1e-6, 0.0, 1.0), [0.0, 2.0]),
            (Vec3::new(0.0, 1.0, -1.0), [4.0, 1.0]),
            (Vec3::new(0.0, 1.0, -1e-6), [4.0, 0.0]),
            (Vec3::new(0.0, -1.0, -1e-6), [4.0, 4.0]),
        ] {
            let place = grid.place(direction);
            assert!(place.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{direction}: {place:?}");
        }
    }

    #[test]
    fn cumulative_distributions_end_at_one_and_keep_what_is_dim() {
        let mut dim = vec![1e-30; 32_768];
        dim[7] = 1e30;
        dim[9] = 0.0;
        let (steps, _) = Steps::of(&dim, EVEN_SHARE);
        assert_eq!(steps.ends.last(), Some(&1.0));
        for index in (0..dim.len()).filter(|index| *index != 9) {
            assert!(steps.probability(index) > 0.0, "{index}");
        }
        assert_eq!(steps.probability(9), 0.0);
        assert!(steps.probability(7) > 0.97);

        for (weights, ends) in
            [(vec![0.0, 3.0, 0.0], [0.0, 1.0, 1.0]), (vec![0.0; 3], [1.0 / 3.0, 2.0 / 3.0, 1.0])]
        {
            assert_eq!(Steps::of(&weights, EVEN_SHARE).0.ends, ends);
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
                let (steps, _) = Steps::of(&weights, EVEN_SHARE);
                for random in
                    (0..4096).map(|at| at as f32 / 4096.0).chain(steps.ends.iter().map(|end| end * BELOW_ONE))
                {
                    let of_all = steps.ends.partition_point(|end| *end <= random);
                    assert_eq!(steps.find(random).index, of_all, "{count} {power} {random}");
                }
            }
        }
    }

    #[test]
    fn the_weight_of_a_cell_is_the_mean_of_what_is_interpolated_in_it() {
        let texels: Vec<f32> = (0..3 * 5 * 4).map(|at| ((at * 37) % 11) as f32).collect();
        let grid = Grid::new(5, 4, texels.clone()).unwrap();
        let mut means = Vec::new();
        for row in 0..4 {
            interpolated_means(&texels, 5, row, 4, &mut means);
            for (column, mean) in means.iter().enumerate() {
                let n = 64;
                let places = (0..n * n).map(|i| [(i % n) as f64 + 0.5, (i / n) as f64 + 0.5]);
                let sum: f64 = places
                    .map(|[x, y]| {
                        let phi = TAU * ((column as f64 + x / n as f64) / 5.0 - 0.5);
                        let theta = PI * (row as f64 + y / n as f64) / 4.0;
                        let (sin, cos) = theta.sin_cos();
                        let direction = glam::DVec3::new(sin * phi.sin(), cos, -sin * phi.cos()).as_vec3();
                        f64::from(grid.light(direction).radiance.element_sum()) / 3.0
                    })
                    .sum();
                let numeric = sum / f64::from(n * n);
                assert!((numeric - mean).abs() < 1e-3 * mean.max(1.0), "{row} {column}: {numeric} {mean}");
            }
        }
    }
}
