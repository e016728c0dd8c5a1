//! Variance of pixels, estimated from their own samples. For denoisers, which should leave alone what is
//! known well.

use crate::frame::grid::Grid;
use crate::frame::surface::radiance::{Light, Radiance};
use crate::samples::Column;

/// Variance of pixels with too few samples for an estimate.
pub const UNKNOWN: f32 = 1e18;

/// Limit to which brighter samples are lowered, so that no square is infinite. Half floats end at 65504.
pub const MOST_LIGHT: f32 = 1e8;

/// Writes, for each cell of a pixel, the variance of the pixel's mean, averaged over the three channels, in
/// units of radiance squared.
///
/// The variance `s²` of a sample is half the mean square difference of samples that are neighbours in their
/// pixel: noise differs from one to the next as much as from any other, and edges and textures, which samples
/// side by side in a grid show rather exactly, differ less. That of the mean of `n` samples is taken from
/// Student's t, `s² / n * (n - 1) / (n - 3)`: few samples know little of `s²`, either.
pub fn pixel_variances(grid: &Grid, radiance: &Radiance, variance: &mut Column<f32>) {
    let count = grid.samples_of_pixel();
    if count <= 3 {
        variance.fill(UNKNOWN);
        return;
    }
    variance.fill(0.0); // tiles may have cells that are in no pixel
    let side = grid.samples as usize;
    let n = count as f32;
    let pairs = (2 * side * (side - 1)) as f32;
    let scale = 0.5 / (3.0 * pairs) / n * (n - 1.0) / (n - 3.0);
    let Radiance { diffuse, specular, reflection, refraction, has_specular, has_secondary, .. } = radiance;
    let layers = [
        (diffuse, true),
        (specular, *has_specular),
        (reflection, *has_secondary),
        (refraction, *has_secondary),
    ];
    let mut light = Vec::with_capacity(count);
    for cells in grid.cells_of_pixels.chunks_exact(count) {
        let mut squares = 0.0;
        for channel in 0..3 {
            light.clear();
            light.extend(cells.iter().map(|cell| shown(&layers, channel, usize::from(*cell))));
            squares += differences(&light, side);
        }
        cells.iter().for_each(|cell| variance[usize::from(*cell)] = squares * scale);
    }
}

/// Value of the sample in `cell` in a channel: the sum of those layers that are present.
fn shown(layers: &[(&Light, bool)], channel: usize, cell: usize) -> f32 {
    let layers = layers.iter().filter(|(_, is_some)| *is_some);
    layers.map(|(light, _)| light[channel][cell]).sum::<f32>().min(MOST_LIGHT)
}

/// Sum of the squared differences of neighbours in a square of values, in rows and in columns.
fn differences(values: &[f32], side: usize) -> f32 {
    let square = |(a, b): (&f32, &f32)| (a - b).powi(2);
    let in_rows =
        values.chunks_exact(side).flat_map(|row| row.iter().zip(&row[1..])).map(square).sum::<f32>();
    in_rows + values.iter().zip(&values[side..]).map(square).sum::<f32>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::grid::tests::settings;
    use crate::samples::CELLS;

    /// Variance of a tile whose samples are given by their numbers within their pixels.
    fn variance_of(samples: u32, diffuse: impl Fn(usize) -> f32, shine: Option<f32>) -> f32 {
        let grid = Grid::new(&settings(64, 64, samples));
        let mut radiance = Radiance { has_specular: shine.is_some(), ..Radiance::default() };
        for cells in grid.cells_of_pixels.chunks_exact(grid.samples_of_pixel()) {
            for (number, cell) in cells.iter().enumerate() {
                radiance.diffuse.iter_mut().for_each(|column| column[usize::from(*cell)] = diffuse(number));
                radiance.specular[0][usize::from(*cell)] = shine.unwrap_or(1e20) * (number % 2) as f32;
            }
        }
        let mut variance = [-1.0; CELLS];
        pixel_variances(&grid, &radiance, &mut variance);
        let at = |pixel: usize| variance[usize::from(grid.cells_of_pixel(pixel)[0])];
        assert_eq!(at(0), at(5));
        assert!(variance.iter().all(|value| *value >= 0.0 && value.is_finite()));
        at(5)
    }

    #[test]
    fn the_mean_of_many_samples_is_known_better() {
        for samples in [2, 3, 4, 8] {
            let (side, n) = (samples as usize, (samples * samples) as f32);
            // half a square in each step of a row, and none from one row to the next
            let columns = |number: usize| (number % side % 2) as f32;
            let expected = 0.5 * 0.5 / n * (n - 1.0) / (n - 3.0);
            let found = variance_of(samples, columns, None);
            assert!((found / expected - 1.0).abs() < 1e-5, "{samples}: {found}");
            assert_eq!(variance_of(samples, |_| 0.7, None), 0.0);
            // an edge through the middle tells less, the more samples there are
            if samples == 8 {
                let edge = variance_of(samples, |number| if number % 8 < 4 { 1.0 } else { 0.0 }, None);
                assert!((edge / expected - 1.0 / 7.0).abs() < 1e-5, "{edge}");
            }
        }
    }

    #[test]
    fn highlights_count_as_well() {
        let columns = |number: usize| (number % 2) as f32;
        let [without, with] = [None, Some(1.0)].map(|shine| variance_of(4, columns, shine));
        // one channel of three differs twice as much
        assert!((with / without - 6.0 / 3.0).abs() < 1e-5, "{with} {without}");
    }

    #[test]
    fn one_sample_tells_nothing_and_the_brightest_is_finite() {
        assert_eq!(variance_of(1, |_| 0.5, None), UNKNOWN);
        assert!(variance_of(2, |number| 1e30 * number as f32, None) < UNKNOWN);
    }
}
