//! Light from all around that a rough layer reflects, by the cosine to the eye: tables, computed when a shot is
//! loaded.
//!
//! Light that another microfacet takes on its way out is reflected once more, or several times, each time in
//! the colour of the surface: light that a metal reflects so has a deeper colour. Of that light a share
//! `leaves` gets away from each further microfacet, and each has the mean reflectance f, so that
//!
//! > f² leaves / (1 - f (1 - leaves))
//!
//! of it comes back: a geometric series, as that of Kulla and Conty, "Revisiting Physically Based Shading at
//! Imageworks", 2017. They take one mean for all directions; here both are those of the direction to the eye,
//! from the microfacets of the first two reflections. A random walk over microfacets (Heitz et al.,
//! "Multiple-Scattering Microfacet BSDFs with the Smith Model", 2016) says how good that is: `walk.rs`.

use glam::Vec3;

use crate::lanes::Real;
use crate::shade::bsdf::fresnel::{Fresnel, dielectric, grazing};
use crate::shade::bsdf::ggx;
use crate::shade::sampling::PathRandom;

/// Least albedo; anything below it is taken for black.
pub const LEAST_ALBEDO: f32 = 1e-6;

/// Least cosine to the eye that is used in formulas: below it, a direction counts as lying in the surface.
pub const LEAST_COSINE: f32 = 1e-4;

/// Exponent by which the share of light that gets away from further microfacets follows from the share that
/// gets away from the first one: it is larger, as light that was reflected upwards is higher up. Fitted to
/// random walks.
const LATER_LEAVES: f32 = 0.62;

/// Divisor of the number of directions that are followed to a second microfacet, the first ones: little light goes there.
const EACH_LATER: usize = 4;

/// Surface whose light is tabulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Width of its lobe (alpha of GGX).
    pub alpha: f32,
    /// Index of refraction of the part that is no metal, 1 or more.
    pub index: f32,
    /// True if the rest goes on through the surface as rays of its own, with the light that other microfacets
    /// take on its way out: none of it is reflected several times by the layer.
    pub is_glass: bool,
}

/// Light of one layer in even steps of the cosine to the eye from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Albedos {
    steps: [[f32; VALUES]; Self::STEPS + 1],
}

/// Number of [`Shares`].
pub const VALUES: usize = 6;

/// Shares of light from all around; of one surface or of eight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares<T> {
    /// What white microfacets reflect once.
    pub white: T,
    /// The part of it that is white in Schlick's formula.
    pub grazing: T,
    /// Mean share of white in Schlick's formula at the microfacets by which light goes that is reflected several
    /// times.
    pub later_grazing: T,
    /// Share of such light that gets away from each further microfacet.
    pub leaves: T,
    /// What the part that is no metal reflects once.
    pub clear_once: T,
    /// What it reflects in all.
    pub clear: T,
}

impl Albedos {
    /// Number of steps: with 64, lines are within 1e-3 of the curves of smooth surfaces.
    const STEPS: usize = 64;

    /// Number of directions by which each is measured: the error of an evenly spread sequence is below 1e-3.
    const SAMPLES: u32 = 1024;

    pub fn new(layer: Layer) -> Self {
        let randoms: Vec<[f32; 4]> =
            (0..Self::SAMPLES).map(|index| PathRandom::new(0, index).four(0)).collect();
        let steps = std::array::from_fn(|step| {
            let cos = (step as f32 / Self::STEPS as f32).max(LEAST_COSINE);
            let to_eye = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
            measured(layer, to_eye, &randoms).values()
        });
        Self { steps }
    }

    /// Interpolates between the steps.
    #[inline(always)]
    pub fn at(&self, cos: f32) -> [f32; VALUES] {
        let at = cos.clamp(0.0, 1.0) * Self::STEPS as f32;
        let step = (at as usize).min(Self::STEPS - 1);
        let rest = at - step as f32;
        let [low, high] = [&self.steps[step], &self.steps[step + 1]];
        std::array::from_fn(|of| low[of] + (high[of] - low[of]) * rest)
    }
}

/// Measures what is seen from one direction, by as many sampled microfacets as there are random numbers.
fn measured(layer: Layer, to_eye: Vec3, randoms: &[[f32; 4]]) -> Shares<f32> {
    let Layer { alpha, index, is_glass } = layer;
    let of_normal = |cos: f32| [grazing(cos), dielectric(index, cos)];
    let (mut white, mut once) = (0.0, [0.0; 2]);
    // both for the light that goes on to a second microfacet
    let (mut rest, mut later) = (0.0, [0.0; 2]);
    for (number, [along, above, along_second, above_second]) in randoms.iter().enumerate() {
        let first = ggx::visible_normal(alpha, to_eye, [*along, *above]);
        let cos = first.dot(to_eye);
        let way = first * (2.0 * cos) - to_eye;
        let leaves = if way.z > 0.0 { ggx::unmasked(alpha, to_eye.z, way.z) } else { 0.0 };
        let by_first = of_normal(cos);
        white += leaves;
        once.iter_mut().zip(by_first).for_each(|(sum, reflected)| *sum += leaves * reflected);
        if number < randoms.len() / EACH_LATER {
            let goes_on = 1.0 - leaves;
            // which microfacet is next does not depend on where the first one is
            let second = ggx::visible_normal(alpha, -way, [*along_second, *above_second]);
            let by_second = of_normal(-second.dot(way));
            rest += goes_on;
            for (sum, (first, second)) in later.iter_mut().zip(by_first.into_iter().zip(by_second)) {
                *sum += goes_on * 0.5 * (first + second);
            }
        }
    }
    let count = randoms.len() as f32;
    let [once, later] = [(once, count), (later, rest.max(f32::MIN_POSITIVE))]
        .map(|(sums, count)| sums.map(|sum: f32| sum / count));
    let white = white / count;
    let leaves = white.powf(LATER_LEAVES);
    let [grazing, clear_once] = once;
    let clear_later = if is_glass { 0.0 } else { (1.0 - white) * several_times(later[1], leaves) };
    Shares { white, grazing, later_grazing: later[0], leaves, clear_once, clear: clear_once + clear_later }
}

/// Share of the light that the first microfacet did not let away which comes back after more than one
/// reflection, each of which reflects this `mean`.
#[inline(always)]
fn several_times<T: Real>(mean: T, leaves: T) -> T {
    let one = T::of(1.0);
    mean * mean * leaves / (one - mean * (one - leaves))
}

impl<T> Shares<T> {
    /// Shares of a table's values.
    #[inline(always)]
    pub fn new([white, grazing, later_grazing, leaves, clear_once, clear]: [T; VALUES]) -> Self {
        Self { white, grazing, later_grazing, leaves, clear_once, clear }
    }

    fn values(self) -> [T; VALUES] {
        [self.white, self.grazing, self.later_grazing, self.leaves, self.clear_once, self.clear]
    }
}

impl<T: Real> Shares<T> {
    /// Shares of a surface that has no layer.
    #[inline(always)]
    pub fn none() -> [T; VALUES] {
        [1.0, 0.0, 0.0, 1.0, 0.0, 0.0].map(T::of)
    }

    /// Light that is reflected once, where each microfacet reflects as much as `fresnel` says.
    #[inline(always)]
    pub fn once(&self, fresnel: &Fresnel<T>) -> [T; 3] {
        fresnel.metal.map(|metal| fresnel.mixed(self.clear_once, self.metal_once(metal, fresnel.edge)))
    }

    /// Light that is reflected once or several times.
    #[inline(always)]
    pub fn in_all(&self, fresnel: &Fresnel<T>) -> [T; 3] {
        fresnel.metal.map(|metal| fresnel.mixed(self.clear, self.metal(metal, fresnel.edge)))
    }

    #[inline(always)]
    fn metal_once(&self, head_on: T, edge: T) -> T {
        head_on * self.white + (T::of(1.0) - head_on) * (self.grazing * edge)
    }

    #[inline(always)]
    fn metal(&self, head_on: T, edge: T) -> T {
        let one = T::of(1.0);
        let mean = head_on + (one - head_on) * (self.later_grazing * edge);
        let rest = (one - self.white).max(T::of(0.0));
        self.metal_once(head_on, edge) + rest * several_times(mean, self.leaves)
    }
}
