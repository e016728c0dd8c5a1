//! Importance sampling of directions: a density that is constant in each cell of a latitude-longitude grid.

use std::f64::consts::{PI, TAU};

use glam::Vec3;
use rayon::prelude::*;

use crate::cumulative::{StepRows, Steps};
use crate::geometry::angle;

/// Share of the samples that is spread evenly over all cells that are not black. It keeps each step of a
/// cumulative distribution larger than the rounding of a float near 1, up to 32768 steps: nothing that shines
/// is missed.
const EVEN_SHARE: f64 = 1.0 / 64.0;

/// Maximum number of texels along each edge of a cell, a power of two.
const LARGEST_BLOCK: usize = 16;

/// Number of cells below which they are not merged further: so few stay within the first caches, and larger
/// cells would gain nothing.
const FEW_CELLS: usize = 4096;

/// Relative amount by which larger cells may raise the second moment of a sample's contribution. The variance
/// is a part of that moment.
const RISE: f64 = 0.01;

/// A density over the sphere. Its space is the grid's: rows from +Y down to -Y, columns as in [`Grid`](super::grid::Grid).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Distribution {
    rows: Steps,
    /// Distribution of the columns within each row.
    columns: StepRows,
    /// Cosines of the angles to +Y of the rows' edges, from 1 to -1: one more than there are rows.
    edges: Vec<f64>,
    /// Density in solid angle for each row, over the probability of the column: that of the row over a cell's solid angle.
    densities: Vec<f64>,
    /// Number of texels along each edge of a cell, as a power of two.
    block_bits: u32,
    /// Integral over the sphere of the function that the density follows.
    integral: f64,
}

impl Distribution {
    /// Creates a density in proportion to a function that is not negative, given by its mean in each texel of
    /// a grid with this many columns and rows: `means` writes those of a row. Cells are the largest that
    /// follow the texels well enough: where neighbours are alike, one cell for all of them is found sooner.
    pub fn new([width, height]: [usize; 2], means: &(impl Fn(usize, &mut Vec<f64>) + Sync)) -> Self {
        let block = largest_block([width, height], means);
        let texel_edges = edges(height);
        let (columns, sums): (Vec<Steps>, Vec<f64>) = (0..height / block)
            .into_par_iter()
            .map_init(Default::default, |(texels, weights), row| {
                block_means(means, &texel_edges, block, texels, weights, row);
                Steps::new(weights, EVEN_SHARE)
            })
            .unzip();
        let columns = StepRows::new(&columns);
        let edges = edges(height / block);
        let areas = edges.windows(2).map(|edges| (edges[0] - edges[1]) * TAU / (width / block) as f64);
        let mut weights: Vec<f64> = sums.iter().zip(areas.clone()).map(|(sum, area)| sum * area).collect();
        let integral = weights.iter().sum();
        let mut even_share = EVEN_SHARE;
        if integral == 0.0 {
            // black: sampled evenly over the sphere
            (weights, even_share) = (areas.collect(), 0.0);
        }
        let (rows, _) = Steps::new(&weights, even_share);
        let density = |(row, edges): (usize, &[f64])| {
            let solid_angle = (edges[0] - edges[1]) * TAU / columns.count() as f64;
            f64::from(rows.probability(row)) / solid_angle
        };
        let densities = edges.windows(2).enumerate().map(density).collect();
        Self { densities, rows, columns, edges, block_bits: block.trailing_zeros(), integral }
    }

    /// Integral over the sphere of the function that the density follows.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// Samples a direction (unit length). `random`: two numbers from 0 to 1; the first picks the column, the
    /// second the row.
    pub fn sample(&self, random: [f32; 2]) -> Vec3 {
        let row = self.rows.find(random[1]);
        let column = self.columns.find(row.index, random[0]);
        // in doubles: near a pole the cosine is too close to 1 for floats
        let [top, bottom] = [self.edges[row.index], self.edges[row.index + 1]];
        let y = top + (bottom - top) * f64::from(row.within);
        let radius = ((1.0 - y) * (1.0 + y)).max(0.0).sqrt();
        let u = (column.index as f64 + f64::from(column.within)) / self.columns.count() as f64;
        let [sin, cos] = angle::turned((u - 0.5) as f32);
        let radius = radius as f32;
        Vec3::new(radius * sin, y as f32, -radius * cos)
    }

    /// Density in solid angle with which [`Self::sample`] returns the directions of the texel in this column
    /// and row.
    pub fn pdf(&self, column: usize, row: usize) -> f32 {
        let (column, row) = (column >> self.block_bits, row >> self.block_bits);
        (self.densities[row] * f64::from(self.columns.probability(row, column))) as f32
    }
}

/// Computes the cosines of the angles to +Y at the edges of `rows` rows.
fn edges(rows: usize) -> Vec<f64> {
    (0..=rows).map(|edge| (PI * edge as f64 / rows as f64).cos()).collect()
}

/// Finds the largest cells that raise the second moment by no more than [`RISE`]: their size in texels along
/// an edge.
fn largest_block([width, height]: [usize; 2], means: &(impl Fn(usize, &mut Vec<f64>) + Sync)) -> usize {
    let blocks =
        std::iter::successors(Some(LARGEST_BLOCK), |block| Some(block / 2)).take_while(|block| *block > 1);
    let fits = |block: &usize| width % block == 0 && height % block == 0;
    let mut worth = blocks.filter(|block| fits(block) && width * height / (block * block) >= FEW_CELLS);
    worth.find(|block| second_moment([width, height], means, *block) <= 1.0 + RISE).unwrap_or(1)
}

/// Ratio of the mean square of a sample's contribution with cells of `block` texels along each edge to that
/// with one cell for each texel: the mean of the square of both densities' quotient. 1 for black.
fn second_moment(
    [width, height]: [usize; 2],
    means: &(impl Fn(usize, &mut Vec<f64>) + Sync),
    block: usize,
) -> f64 {
    let edges = edges(height);
    let of_row = |scratch: &mut Vec<f64>, row: usize| {
        let mut cells = vec![[0.0; 2]; width / block];
        for row in row * block..(row + 1) * block {
            let area = edges[row] - edges[row + 1];
            means(row, scratch);
            for ([sum, squares], texels) in cells.iter_mut().zip(scratch.chunks_exact(block)) {
                *sum += area * texels.iter().sum::<f64>();
                *squares += area * texels.iter().map(|mean| mean * mean).sum::<f64>();
            }
        }
        let area = (edges[row * block] - edges[(row + 1) * block]) * block as f64;
        let shining = cells.iter().filter(|[sum, _]| *sum > 0.0);
        shining.fold([0.0; 2], |[sums, moments], [sum, squares]| [sums + sum, moments + squares * area / sum])
    };
    let rows: Vec<[f64; 2]> = (0..height / block).into_par_iter().map_init(Vec::new, of_row).collect();
    let [sum, moment] = rows.iter().fold([0.0; 2], |all, row| [all[0] + row[0], all[1] + row[1]]);
    if sum > 0.0 { moment / sum } else { 1.0 }
}

/// Writes into `weights` the means over the cells of a row of cells, weighted by the solid angle of their
/// texels. `edges`: those of the texels' rows.
fn block_means(
    means: &(impl Fn(usize, &mut Vec<f64>) + Sync),
    edges: &[f64],
    block: usize,
    texels: &mut Vec<f64>,
    weights: &mut Vec<f64>,
    row: usize,
) {
    if block == 1 {
        return means(row, weights);
    }
    let rows = row * block..(row + 1) * block;
    let area = (edges[rows.start] - edges[rows.end]) * block as f64;
    weights.clear();
    for row in rows {
        let share = (edges[row] - edges[row + 1]) / area;
        means(row, texels);
        weights.resize(texels.len() / block, 0.0);
        for (weight, texels) in weights.iter_mut().zip(texels.chunks_exact(block)) {
            *weight += share * texels.iter().sum::<f64>();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a bell about the horizon, `narrow` times as narrow as the sphere is high, and as dark above
    /// and below.
    fn bell(height: usize, narrow: f64) -> impl Fn(usize, &mut Vec<f64>) + Sync {
        move |row, means| {
            let from_horizon = (row as f64 + 0.5) / height as f64 - 0.5;
            means.clear();
            means.resize(2 * height, 1e-3 + (-(narrow * from_horizon).powi(2)).exp());
        }
    }

    #[test]
    fn cells_are_as_large_as_what_they_follow_is_smooth() {
        let size = [1024, 512];
        for (narrow, bits) in [(1.0, 3), (20.0, 2), (40.0, 1), (300.0, 0)] {
            assert_eq!(Distribution::new(size, &bell(512, narrow)).block_bits, bits, "{narrow}");
        }
        // an odd number of columns: no larger cells
        let even = |_: usize, means: &mut Vec<f64>| {
            means.clear();
            means.resize(1023, 1.0);
        };
        assert_eq!(Distribution::new([1023, 512], &even).block_bits, 0);
    }

    #[test]
    fn larger_cells_hold_as_much_as_their_texels() {
        let (size, means) = ([1024, 512], bell(512, 20.0));
        let distribution = Distribution::new(size, &means);
        let edges = edges(512);
        let mut row_means = Vec::new();
        let (mut integral, mut total) = (0.0, 0.0);
        for row in 0..512 {
            let area = (edges[row] - edges[row + 1]) * TAU / 1024.0;
            means(row, &mut row_means);
            integral += row_means.iter().sum::<f64>() * area;
            total += (0..1024).map(|column| f64::from(distribution.pdf(column, row))).sum::<f64>() * area;
        }
        assert!(
            (distribution.integral() / integral - 1.0).abs() < 1e-9,
            "{} {integral}",
            distribution.integral()
        );
        assert!((total - 1.0).abs() < 1e-4, "{total}");
    }
}
