//! Radiance on a latitude-longitude grid, and the distributions that sample it by importance.
//!
//! A grid has a space of its own: that of the environment before it is rotated. Rows go from +Y down to -Y, columns
//! from +Z over -X, -Z (the middle) and +X back to +Z:
//! `u = 1/2 + atan2(x, -z) / 2π` and `v = atan2(√(x² + z²), y) / π`.

use std::fmt;

use glam::{Vec2, Vec3};

use super::distribution::Distribution;
use super::light_from::LightFrom;
use super::picture_error::PictureError;
use crate::geometry::angle;

/// Texels of linear RGB, interpolated bilinearly. Columns wrap; beyond the rows at the poles they are repeated.
#[derive(Clone, PartialEq)]
pub(super) struct Grid {
    width: usize,
    height: usize,
    /// Texels: three values each, row by row from the top.
    texels: Vec<f32>,
}

impl Grid {
    /// Creates a grid from `texels`: red, green and blue of each texel, row by row from the top.
    ///
    /// # Errors A side of 0, another number of values than the size says, a negative value, NaN or infinity.
    pub fn new(width: u32, height: u32, texels: Vec<f32>) -> Result<Self, PictureError> {
        check(width, height, &texels)?;
        let (width, height) = (width as usize, height as usize);
        Ok(Self { width, height, texels })
    }

    /// A density that follows the mean over red, green and blue of the interpolated radiance in each texel. It is positive
    /// wherever the radiance is, because interpolation mixes into a texel what lies beside it, and the density counts the same.
    pub fn distribution(&self) -> Distribution {
        Distribution::new(self.size(), &|row, means: &mut Vec<f64>| self.means(row, means))
    }

    /// A density that follows by how much that mean is above `level`.
    pub fn distribution_above(&self, level: f64) -> Distribution {
        let above = |row: usize, means: &mut Vec<f64>| {
            self.means(row, means);
            means.iter_mut().for_each(|mean| *mean = (*mean - level).max(0.0));
        };
        Distribution::new(self.size(), &above)
    }

    /// Numbers of columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Interpolates the radiance at a place, in texels from the left and from the top.
    fn radiance_at(&self, [x, y]: [f32; 2]) -> Vec3 {
        let (x, y) = (x - 0.5, y - 0.5);
        let (left, top) = (x.floor(), y.floor());
        // from -1 to the width, and never beyond: no division
        let last = self.width - 1;
        let column = |column: f32| match column {
            ..0.0 => last,
            _ if column as usize > last => 0,
            _ => column as usize,
        };
        let row = |row: f32| (row.max(0.0) as usize).min(self.height - 1);
        let (left, right, across) = (column(left), column(left + 1.0), x - left);
        let (above, below, down) = (row(top), row(top + 1.0), y - top);
        let upper = self.texel(left, above).lerp(self.texel(right, above), across);
        let lower = self.texel(left, below).lerp(self.texel(right, below), across);
        // a blend of the largest floats may be rounded to infinity
        upper.lerp(lower, down).min(Vec3::MAX)
    }

    /// Radiance from `direction`, and the probability density in solid angle with which `distribution`, one of this
    /// grid, returns it.
    pub fn light(&self, distribution: &Distribution, direction: Vec3) -> LightFrom {
        let [x, y] = self.place(direction);
        // the last column ends where the first one begins
        let (column, row) = (x as usize, (y as usize).min(self.height - 1));
        let column = if column < self.width { column } else { 0 };
        LightFrom { radiance: self.radiance_at([x, y]), pdf: distribution.pdf(column, row) }
    }

    /// Position of `direction` (any length) on the grid, in texels from the left and from the top.
    fn place(&self, direction: Vec3) -> [f32; 2] {
        use std::f32::consts::{FRAC_1_PI, TAU};
        let u = 0.5 + angle::of(direction.x, -direction.z) / TAU;
        // Not the arc cosine of y, which knows no small angles; and not `hypot` (see clippy.toml).
        let aside = Vec2::new(direction.x, direction.z).as_dvec2().length() as f32;
        let v = angle::of(aside, direction.y) * FRAC_1_PI;
        [u * self.width as f32, v * self.height as f32]
    }

    fn texel(&self, column: usize, row: usize) -> Vec3 {
        Vec3::from_slice(&self.texels[3 * (row * self.width + column)..])
    }

    /// Writes into `means` the average over each texel of `row` of the mean of red, green and blue, interpolated
    /// bilinearly: along each axis three quarters of the texel's own and an eighth of each neighbour's.
    fn means(&self, row: usize, means: &mut Vec<f64>) {
        const OWN: f64 = 0.75;
        const BESIDE: f64 = 0.125;
        let Self { width, height, ref texels } = *self;
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
}

/// Prints the size alone: nobody wants to read all texels.
impl fmt::Debug for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Grid({}x{})", self.width, self.height)
    }
}

/// Checks that there are as many values as there should be, all finite and not negative.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
    use std::f64::consts::{PI, TAU};

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
    fn the_weight_of_a_cell_is_the_mean_of_what_is_interpolated_in_it() {
        let texels: Vec<f32> = (0..3 * 5 * 4).map(|at| ((at * 37) % 11) as f32).collect();
        let grid = Grid::new(5, 4, texels).unwrap();
        let (distribution, mut means) = (grid.distribution(), Vec::new());
        for row in 0..4 {
            grid.means(row, &mut means);
            for (column, mean) in means.iter().enumerate() {
                let n = 64;
                let places = (0..n * n).map(|i| [(i % n) as f64 + 0.5, (i / n) as f64 + 0.5]);
                let sum: f64 = places
                    .map(|[x, y]| {
                        let phi = TAU * ((column as f64 + x / n as f64) / 5.0 - 0.5);
                        let theta = PI * (row as f64 + y / n as f64) / 4.0;
                        let (sin, cos) = theta.sin_cos();
                        let direction = glam::DVec3::new(sin * phi.sin(), cos, -sin * phi.cos()).as_vec3();
                        f64::from(grid.light(&distribution, direction).radiance.element_sum()) / 3.0
                    })
                    .sum();
                let numeric = sum / f64::from(n * n);
                assert!((numeric - mean).abs() < 1e-3 * mean.max(1.0), "{row} {column}: {numeric} {mean}");
            }
        }
    }
}
