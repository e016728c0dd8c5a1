//! Keeps pixels that are known better than a denoiser guesses them.
//!
//! A denoiser is wrong by what it blurs away, however many samples there are: small highlights, fine textures. A picture is
//! wrong by its noise, of which its samples tell ([`variance`](crate::frame)). Be `c` the picture, `d` what the denoiser makes
//! of it, and `v` the variance of `c`. The mean of `(c - d)²` is about `v` and the square of the denoiser's own error
//! together, so that `1 - v / (c - d)²` is the weight of `c` by which both together are wrong least (Stein's estimator
//! shrinks as much: James and Stein, "Estimation with Quadratic Loss", 1961). Of single pixels neither is known well. They
//! are averaged over neighbours, and the variance counts more than once: where in doubt, the denoiser is right.

use rayon::prelude::*;

use crate::film::Values;

/// Factor on the variance. Errors are least from 2 to 4 (docs/experiments.md).
const CAUTION: f32 = 3.0;

/// Weights of neighbours, from two pixels before to two behind: binomial, one pixel of standard deviation.
const NEIGHBOURS: [f32; 5] = [1.0 / 16.0, 4.0 / 16.0, 6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Light below this counts as dark: differences are counted as shares of more than this.
const LEAST_LIGHT: f32 = 1e-6;

/// Blends pictures with their denoised versions, and keeps its memory. Per pixel, as shares of its light: the
/// mean square difference between picture and guess, and the variance of the picture.
#[derive(Debug, Default)]
pub struct Blend {
    pixels: Vec<[f32; 2]>,
    in_rows: Vec<[f32; 2]>,
}

impl Blend {
    /// Brings `denoised` nearer to the picture `raw`, as far as that is known by the `variance` of its pixels: radiance
    /// squared, a mean over channels. All are rows of pixels; `size` is columns and rows.
    pub fn keep_known(
        &mut self,
        size: [usize; 2],
        raw: &[[f32; 3]],
        variance: &Values,
        denoised: &mut [[f32; 3]],
    ) {
        let Self { pixels, in_rows } = self;
        let width = size[0].max(1);
        for all in [&mut *pixels, &mut *in_rows] {
            all.resize(raw.len(), [0.0; 2]);
        }
        pixels.par_chunks_mut(width).enumerate().for_each(|(row, pixels)| {
            let first = row * width;
            for (at, pixel) in (first..).zip(pixels) {
                *pixel = shares(raw[at], denoised[at], variance.get(at));
            }
        });
        in_rows.par_chunks_mut(width).zip(pixels.par_chunks(width)).for_each(|(to, from)| {
            for (x, to) in to.iter_mut().enumerate() {
                *to = blurred(x, from.len(), |x| from[x]);
            }
        });
        let in_rows = &*in_rows;
        denoised.par_chunks_mut(width).enumerate().for_each(|(y, denoised)| {
            for (x, (denoised, raw)) in denoised.iter_mut().zip(&raw[y * width..]).enumerate() {
                let [difference, variance] = blurred(y, size[1], |y| in_rows[y * width + x]);
                let weight = weight(difference, variance);
                for (denoised, raw) in denoised.iter_mut().zip(raw) {
                    *denoised += weight * (raw - *denoised);
                }
            }
        });
    }
}

/// The mean square difference of two colours and the `variance` of the first one, over the square of the brighter one: so
/// what is bright does not decide of dark pixels beside it.
fn shares(raw: [f32; 3], denoised: [f32; 3], variance: f32) -> [f32; 2] {
    let brightness = |color: [f32; 3]| color.iter().sum::<f32>() / 3.0;
    let light = brightness(raw).max(brightness(denoised)).max(LEAST_LIGHT);
    let squares: f32 = raw.iter().zip(denoised).map(|(raw, denoised)| (raw - denoised).powi(2)).sum();
    [squares / 3.0, variance].map(|square| square / light.powi(2))
}

/// The mean of the values around number `at` of `count`; the first and the last one stand for those beyond them.
fn blurred(at: usize, count: usize, value: impl Fn(usize) -> [f32; 2]) -> [f32; 2] {
    let mut sum = [0.0; 2];
    for (step, weight) in NEIGHBOURS.into_iter().enumerate() {
        let neighbour = (at + step).saturating_sub(NEIGHBOURS.len() / 2).min(count - 1);
        sum.iter_mut().zip(value(neighbour)).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

/// Weight of the picture, 0 to 1.
fn weight(difference: f32, variance: f32) -> f32 {
    // neither is negative; where both are nothing, the colours are one
    if difference > 0.0 { (1.0 - CAUTION * variance / difference).max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::PlaneKind;

    const SIZE: [usize; 2] = [7, 5];

    /// Blends an even guess of a denoiser with the picture `raw`.
    fn blend(raw: &[[f32; 3]], guess: f32, variance: &[f32]) -> Vec<[f32; 3]> {
        let mut denoised = vec![[guess; 3]; raw.len()];
        let variance = Values::of(PlaneKind::Float, variance);
        Blend::default().keep_known(SIZE, raw, &variance, &mut denoised);
        denoised
    }

    #[test]
    fn what_is_known_is_kept_and_what_is_noise_goes() {
        let raw = vec![[0.4, 0.5, 0.6]; 35];
        assert!(
            blend(&raw, 0.3, &[0.0; 35])
                .iter()
                .flatten()
                .zip(raw.as_flattened())
                .all(|(a, b)| (a - b).abs() < 1e-6)
        );
        // all of the difference may be noise
        assert_eq!(blend(&raw, 0.3, &[0.03; 35]), vec![[0.3; 3]; 35]);
        assert_eq!(
            blend(&raw, 0.3, &[1e18; 35]),
            vec![[0.3; 3]; 35],
            "and nothing is known of single samples"
        );
        // (0.1² + 0.2² + 0.3²) / 3 is the difference, of which a sixth is noise, counted three times
        let half = blend(&raw, 0.3, &[0.14 / 3.0 / 6.0; 35]);
        for (half, raw) in half.iter().flatten().zip(raw.as_flattened()) {
            assert!((half - (raw + 0.3) / 2.0).abs() < 1e-6, "{half} {raw}");
        }
    }

    #[test]
    fn a_highlight_in_the_dark_stays_and_a_doubtful_one_beside_it_goes() {
        let mut raw = vec![[0.01; 3]; 35];
        let mut variance = [0.0; 35];
        (raw[15], raw[19]) = ([0.2; 3], [0.2; 3]); // both in the middle row
        variance[19] = 0.04; // one sample of many
        let denoised = blend(&raw, 0.01, &variance);
        assert!((denoised[15][0] - 0.2).abs() < 1e-6, "{:?}", denoised[15]);
        assert_eq!(denoised[19], [0.01; 3]);
    }

    #[test]
    fn black_and_the_brightest_light_are_no_difficulty() {
        let raw: Vec<_> = (0..35).map(|i| if i % 2 == 0 { [0.0; 3] } else { [65504.0; 3] }).collect();
        for guess in [0.0, 65504.0] {
            for variance in [0.0, 1e-30, 1e18] {
                let denoised = blend(&raw, guess, &[variance; 35]);
                assert!(
                    denoised.iter().flatten().all(|value| (0.0..=65504.0).contains(value)),
                    "{denoised:?}"
                );
            }
        }
        let mut nothing = Blend::default();
        nothing.keep_known([0, 0], &[], &Values::floats(0), &mut []);
    }
}
