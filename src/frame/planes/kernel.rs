//! Filters wider than a pixel: a sample's weight in a pixel is the product of the weights of their distances
//! across and down.

use std::f32::consts::PI;

use crate::lanes::F32x8;
use crate::settings::Filter;

/// Largest number of pixels in a row that a filter reaches.
pub const MOST_TAPS: usize = 2 * Filter::LARGEST_RADIUS as usize;

/// A filter with its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    shape: Filter,
    /// Radius, in pixels; beyond it a sample has no weight.
    radius: f32,
    /// Shift of the samples' window, to the right and down, in pixels: half of one at most.
    pub shift: [f32; 2],
}

impl Kernel {
    /// Creates the kernel of a filter with that radius, in pixels. `None` for the box filter, which takes a
    /// pixel's own samples alone.
    pub fn new(filter: Filter, radius: f32) -> Option<Self> {
        (filter != Filter::Box).then_some(Self { shape: filter, radius, shift: [0.0; 2] })
    }

    /// The kernel for samples whose window is shifted, as if it were not. Areas stay those in the pixels of the window.
    pub fn shifted(self, shift: [f32; 2]) -> Self {
        if self.is_by_area() { self } else { Self { shift, ..self } }
    }

    /// Number of pixels that a sample reaches beyond its own, or that of the window.
    pub fn halo(&self) -> u32 {
        self.taps() as u32 / 2 + self.margin()
    }

    /// Number of pixels in a row that a sample reaches.
    pub fn taps(&self) -> usize {
        2 * self.radius.ceil() as usize
    }

    /// Number of pixels by which a sample may lie beside its own.
    pub fn margin(&self) -> u32 {
        u32::from(self.shift != [0.0; 2])
    }

    /// Returns true if samples weigh by their [areas](crate::frame::film::areas::Areas).
    pub fn is_by_area(&self) -> bool {
        self.shape == Filter::Area
    }

    /// Weights of samples in the `N` pixels of a row around them. The samples lie `beyond` (0 to 1) the
    /// centre of pixel N/2 - 1 of these. N: see [`taps`](Self::taps). All 0 where samples weigh [by area](Self::is_by_area).
    #[inline(always)]
    pub fn weights<const N: usize>(&self, beyond: F32x8) -> [F32x8; N] {
        let at = |pixel: usize| {
            let center = F32x8::splat(pixel as f32 - (N / 2 - 1) as f32);
            (beyond - center).abs()
        };
        match self.shape {
            // written out: with its usual radius each weight is one known piece of the cubic
            Filter::Mitchell if self.radius == 2.0 && N == 4 => {
                let of = mitchell_of_four(beyond);
                std::array::from_fn(|pixel| of[pixel])
            }
            Filter::Mitchell => self.within(at, |x| mitchell(x * F32x8::splat(2.0 / self.radius))),
            Filter::Box | Filter::Area => [F32x8::ZERO; N],
            Filter::Tent => self.within(at, |x| F32x8::ONE - x * F32x8::splat(self.radius.recip())),
            Filter::Gaussian => self.within(at, |x| gaussian(x, self.radius)),
            Filter::BlackmanHarris => {
                self.within(at, |x| blackman_harris(x * F32x8::splat(self.radius.recip())))
            }
            Filter::Lanczos => self.within(at, |x| lanczos(x, self.radius)),
        }
    }

    /// Evaluates `weight` at distances below the radius; 0 beyond.
    #[inline(always)]
    fn within<const N: usize>(
        &self,
        at: impl Fn(usize) -> F32x8,
        weight: impl Fn(F32x8) -> F32x8,
    ) -> [F32x8; N] {
        std::array::from_fn(|pixel| {
            let distance = at(pixel);
            distance.lt(F32x8::splat(self.radius)).select(weight(distance), F32x8::ZERO)
        })
    }
}

const B: f32 = 1.0 / 3.0;
const C: f32 = 1.0 / 3.0;
const NEAR: [f32; 4] = [12.0 - 9.0 * B - 6.0 * C, -18.0 + 12.0 * B + 6.0 * C, 0.0, 6.0 - 2.0 * B];
const FAR: [f32; 4] = [-B - 6.0 * C, 6.0 * B + 30.0 * C, -12.0 * B - 48.0 * C, 8.0 * B + 24.0 * C];

#[inline(always)]
fn cubic(terms: [f32; 4], x: F32x8) -> F32x8 {
    let sum = terms.into_iter().fold(F32x8::ZERO, |sum, term| sum * x + F32x8::splat(term));
    sum / F32x8::splat(6.0)
}

/// The cubic with B = C = 1/3 (Mitchell and Netravali, "Reconstruction Filters in Computer Graphics",
/// SIGGRAPH 1988, equation 8), of distances from 0 to 2.
#[inline(always)]
fn mitchell(x: F32x8) -> F32x8 {
    x.lt(F32x8::ONE).select(cubic(NEAR, x), cubic(FAR, x))
}

/// [`mitchell`] for the four pixels around samples `beyond` the centre of the second.
#[inline(always)]
fn mitchell_of_four(beyond: F32x8) -> [F32x8; 4] {
    let [one, two] = [1.0, 2.0].map(F32x8::splat);
    [cubic(FAR, one + beyond), cubic(NEAR, beyond), cubic(NEAR, one - beyond), cubic(FAR, two - beyond)]
}

/// A normal distribution whose standard deviation is a third of the radius, lowered so that it ends in 0.
#[inline(always)]
fn gaussian(x: F32x8, radius: f32) -> F32x8 {
    const AT_RADIUS: f32 = 4.5; // half the square of three deviations
    let of = |square: F32x8| F32x8::splat((-AT_RADIUS).exp()).power(square);
    let scaled = x * F32x8::splat(radius.recip());
    of(scaled * scaled) - of(F32x8::ONE)
}

/// The window of four terms (Harris, "On the Use of Windows for Harmonic Analysis with the Discrete Fourier
/// Transform", 1978, table 1: 92 dB) of a share of the radius.
#[inline(always)]
fn blackman_harris(x: F32x8) -> F32x8 {
    // coefficients of powers of the cosine, by Chebyshev's polynomials, instead of cosines of multiples of
    // the angle
    const TERMS: [f32; 4] = [4.0 * 0.01168, 2.0 * 0.14128, 0.48829 - 3.0 * 0.01168, 0.35875 - 0.14128];
    let cos = (x * F32x8::splat(PI)).cos();
    TERMS.into_iter().fold(F32x8::ZERO, |sum, term| sum * cos + F32x8::splat(term))
}

/// The ideal filter for pixels, windowed by its own main lobe stretched to the radius (Duchon, "Lanczos
/// Filtering in One and Two Dimensions", 1979).
#[inline(always)]
fn lanczos(x: F32x8, radius: f32) -> F32x8 {
    let sinc = |x: F32x8| {
        let angle = x * F32x8::splat(PI);
        x.lt(F32x8::splat(1e-4)).select(F32x8::ONE, angle.sin() / angle)
    };
    sinc(x) * sinc(x * F32x8::splat(radius.recip()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn weights(filter: Filter, radius: f32, beyond: f32) -> Vec<f32> {
        let kernel = Kernel::new(filter, radius).expect("it is wide");
        let lane = |weights: &[F32x8]| weights.iter().map(|weight| weight.lane(3)).collect();
        let beyond = F32x8::splat(beyond);
        match kernel.halo() {
            1 => lane(&kernel.weights::<2>(beyond)),
            2 => lane(&kernel.weights::<4>(beyond)),
            3 => lane(&kernel.weights::<6>(beyond)),
            _ => lane(&kernel.weights::<8>(beyond)),
        }
    }

    #[test]
    fn cubics_and_tents_add_up_to_one_wherever_the_sample_is() {
        for step in 0..=20 {
            let beyond = step as f32 / 20.0;
            for (filter, radius) in [(Filter::Mitchell, 2.0), (Filter::Tent, 1.0)] {
                let sum: f32 = weights(filter, radius, beyond).iter().sum();
                assert!((sum - 1.0).abs() < 1e-6, "{filter:?}, {beyond}: {sum}");
            }
            // as it is with any other radius
            let stretched = weights(Filter::Mitchell, 2.0 - 1e-6, beyond);
            let usual = weights(Filter::Mitchell, 2.0, beyond);
            assert!(stretched.iter().zip(usual).all(|(a, b)| (a - b).abs() < 1e-5));
        }
        let on_a_centre = weights(Filter::Mitchell, 2.0, 0.0);
        let wanted = [1.0 / 18.0, 8.0 / 9.0, 1.0 / 18.0, 0.0];
        assert!(on_a_centre.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{on_a_centre:?}");
    }

    #[test]
    fn weights_fall_from_the_centre_are_the_same_on_both_sides_and_end_at_the_radius() {
        for (filter, radius) in Filter::WIDE
            .into_iter()
            .filter(|f| !f.is_of_one_pixel())
            .flat_map(|f| [0.5, 1.0, 1.5, 2.7, 4.0].map(|r| (f, r)))
        {
            for step in 0..=8 {
                let beyond = step as f32 / 8.0;
                let (left, mut right) =
                    (weights(filter, radius, beyond), weights(filter, radius, 1.0 - beyond));
                right.reverse();
                let off = left.iter().zip(&right).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 1e-5, "{filter:?}, {radius}, {beyond}: {off}");
                let middle = left.len() / 2 - 1;
                for (pixel, weight) in left.iter().enumerate() {
                    let distance = (beyond - (pixel as f32 - middle as f32)).abs();
                    assert!(distance < radius || *weight == 0.0, "{filter:?}, {radius}: {distance}");
                    assert!(*weight <= weights(filter, radius, 0.0)[middle] + 1e-6);
                }
            }
        }
    }

    #[test]
    fn values_are_those_of_the_formulas() {
        let at = |filter, radius, distance: f32| {
            weights(filter, radius, distance)[Kernel::new(filter, radius).expect("wide").halo() as usize - 1]
        };
        for (filter, radius, distance, wanted) in [
            (Filter::Tent, 1.0, 0.25, 0.75),
            (Filter::Gaussian, 1.5, 0.5, (-0.5_f32).exp() - (-4.5_f32).exp()),
            (Filter::BlackmanHarris, 1.5, 0.0, 1.0),
            (Filter::BlackmanHarris, 1.5, 0.75, 0.21747),
            (Filter::Lanczos, 3.0, 0.5, 0.607_927_1),
            (Filter::Lanczos, 3.0, 1.0, 0.0),
        ] {
            let got = at(filter, radius, distance);
            assert!((got - wanted).abs() < 2e-5, "{filter:?} at {distance}: {got}, not {wanted}");
        }
        assert!(weights(Filter::Lanczos, 3.0, 0.5)[1] < -0.1, "its second lobe is negative");
    }
}
