//! The two ways in which directions to an environment are sampled.

use std::f64::consts::PI;

use super::distribution::Distribution;
use super::grid::Grid;
use super::sun::Sun;

/// Density with which directions to an environment are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SkyDensity {
    /// In proportion to the light: for a surface from which no path goes on.
    Whole,
    /// In proportion to what of the light is above its mean, the sun included: for a surface from which a path goes on by the
    /// cosine law or a lobe, too. The balance heuristic leaves to that path what no ray asks for, and the path finds an even light
    /// with less noise, because it follows the cosine (Karlík et al., "MIS Compensation: Optimizing Sampling Techniques in
    /// Multiple Importance Sampling", 2019).
    Peaks,
}

/// Share of an environment's light that must be above the mean for rays to ask for it: chosen, not measured. Where the sky is in
/// sight a gradient is worth asking; an even map whose texels are rounded is not.
const LEAST_PEAKS: f64 = 0.05;

/// Minimum share of the samples of the [whole](SkyDensity::Whole) for the sun and for the grid, if both shine.
const LEAST_SHARE: f64 = 0.1;

/// Distributions of an environment.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Samplers {
    whole: Sampler,
    /// `None` if the light is so even that a ray to its peaks is not worth its cost.
    peaks: Option<Sampler>,
}

/// Distribution over the grid and the sun of an environment.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sampler {
    pub grid: Distribution,
    /// Probability of sampling the sun rather than the grid.
    pub sun_share: f32,
}

impl Samplers {
    pub fn new(grid: &Grid, sun: Option<&Sun>) -> Self {
        let of_sun = sun.map_or(0.0, |sun| f64::from(sun.radiance.element_sum() / 3.0 * sun.solid_angle()));
        let whole = Sampler::new(grid.distribution(), of_sun, LEAST_SHARE);
        let mean = whole.grid.integral() / (4.0 * PI);
        let peaks = Sampler::new(grid.distribution_above(mean), of_sun, 0.0);
        let is_worth = peaks.grid.integral() + of_sun > LEAST_PEAKS * (whole.grid.integral() + of_sun);
        Self { whole, peaks: Some(peaks).filter(|_| is_worth) }
    }

    pub fn have_peaks(&self) -> bool {
        self.peaks.is_some()
    }

    pub fn is_grid_black(&self) -> bool {
        self.whole.grid.integral() == 0.0
    }

    /// Distribution of this density: that of the whole where there are no peaks.
    pub fn of(&self, density: SkyDensity) -> &Sampler {
        match density {
            SkyDensity::Whole => &self.whole,
            SkyDensity::Peaks => self.peaks.as_ref().unwrap_or(&self.whole),
        }
    }
}

impl Sampler {
    fn new(grid: Distribution, of_sun: f64, least: f64) -> Self {
        let sun_share = if of_sun == 0.0 {
            0.0
        } else {
            let least = if grid.integral() > 0.0 { least } else { 0.0 };
            (of_sun / (of_sun + grid.integral())).clamp(least, 1.0 - least)
        };
        Self { grid, sun_share: sun_share as f32 }
    }
}
