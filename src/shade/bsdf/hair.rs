//! Fibres of hair, as one ray sees them: Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model for Production
//! Path Tracing", 2016, which goes back to Marschner and others, "Light Scattering from Human Hair Fibers", 2003.
//!
//! A fibre is a cylinder of coloured glass with a rough surface whose scales are tilted. Light leaves it off its surface (R), through it (TT), after
//! a reflection within (TRT), or after more of them, which is counted as one lobe without a direction around the fibre. Each lobe is the
//! product of its attenuation, of the distribution of angles to the fibre's normal plane (M, a von Mises distribution on the sphere) and of
//! that around the fibre (N, a logistic distribution of the deviation from the smooth cylinder's angle). All integrate to 1, so that a
//! fibre that absorbs nothing sends on all of the light.
//!
//! Directions are given by their components along the fibre, and along two axes across it. *Offset*: where across its width the fibre is
//! seen, from -1 to 1. Colours are those that Chiang's fit (equation 9) has for the light that hair of this absorption sends on in the end.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;

use super::fresnel::dielectric;
use crate::geometry::angle;
use crate::scene::material::Hair;

/// Lobes of a fibre: R, TT, TRT and what is left.
const LOBES: usize = 4;

/// What all fibres of a material have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairLobes {
    /// Variances of the angles to the normal plane: of R, and of light that was within (TT has a quarter of it, the others four times as much).
    variances: [f32; 2],
    /// Scale of the logistic distribution around the fibre.
    scale: f32,
    /// Sine and cosine of the tilt of the scales, and of twice and four times that.
    tilts: [[f32; 2]; 3],
    index: f32,
    /// Factor of the logarithm of the colour.
    of_color: f32,
}

/// A fibre as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenHair {
    variances: [f32; LOBES],
    scale: f32,
    /// Share of the light that each lobe sends on.
    attenuations: [Vec3; LOBES],
    /// Chance with which directions are sampled by each lobe.
    chances: [f32; LOBES],
    /// Sine and cosine of the angle to the normal plane under which each lobe sees the eye, with the tilt of the scales.
    to_eye: [[f32; 2]; LOBES],
    /// Angle around the fibre that lies in the middle of each lobe.
    middles: [f32; LOBES - 1],
}

/// Least roughness: narrower lobes are lost to rounding.
const LEAST_ROUGHNESS: f32 = 0.02;

/// Least colour: its logarithm counts.
const LEAST_COLOR: f32 = 1e-5;

/// Colour that hair has in the end, from the square root of its absorption, and back: the factor of its logarithm (Chiang and others,
/// equation 9).
pub fn log_of_color(radial_roughness: f32) -> f32 {
    [0.245, 5.574, -10.73, 2.532, -0.215, 5.969]
        .into_iter()
        .fold(0.0, |sum, factor| sum * radial_roughness + factor)
}

impl HairLobes {
    pub fn new(hair: &Hair) -> Self {
        let variance = |roughness: f32| {
            let roughness = roughness.clamp(LEAST_ROUGHNESS, 1.0);
            (0.726 * roughness + 0.812 * roughness * roughness + 3.7 * roughness.powi(20)).powi(2)
        };
        let radial = hair.radial_roughness.clamp(LEAST_ROUGHNESS, 1.0);
        let scale = (PI / 8.0).sqrt() * (0.265 * radial + 1.194 * radial * radial + 5.372 * radial.powi(22));
        Self {
            variances: [variance(hair.roughness * (1.0 - hair.coat)), variance(hair.roughness)],
            scale,
            tilts: [1.0, 2.0, 4.0]
                .map(|times: f32| [(times * hair.offset).sin(), (times * hair.offset).cos()]),
            index: hair.index,
            of_color: log_of_color(radial),
        }
    }

    /// Width of the narrowest lobe in which light is seen, as that of a layer is measured.
    pub fn alpha(&self) -> f32 {
        let [first, within] = self.variances;
        first.min(0.25 * within).sqrt().clamp(0.01, 1.0)
    }

    /// Absorption across a fibre's radius, of hair of this colour.
    fn absorption(&self, color: Vec3) -> Vec3 {
        let of_channel = |share: f32| (share.clamp(LEAST_COLOR, 1.0).ln() / self.of_color).powi(2);
        Vec3::from(color.to_array().map(of_channel))
    }

    /// A fibre of this colour whose eye is in the direction `to_eye`, of unit length, and which is seen at this offset.
    pub fn seen(&self, color: Vec3, to_eye: Vec3, offset: f32) -> SeenHair {
        let (sin, index) = (to_eye.x.clamp(-1.0, 1.0), self.index);
        let cos = cosine(sin);
        let offset = offset.clamp(-1.0, 1.0);
        // the fibre that is cut by the plane of the ray has another index
        let within =
            (offset * cos / (index * index - sin * sin).max(f32::MIN_POSITIVE).sqrt()).clamp(-1.0, 1.0);
        let [outer, inner] = [offset, within].map(f32::asin);
        let cos_within = cosine(sin / index).max(f32::MIN_POSITIVE);
        let passed = (-self.absorption(color) * (2.0 * cosine(within) / cos_within)).exp();
        let reflected = dielectric(index, cos * cosine(offset)).clamp(0.0, 1.0);
        let through = passed * (1.0 - reflected) * (1.0 - reflected);
        let again = passed * reflected;
        let rest = through * again * again / (Vec3::ONE - again).max(Vec3::splat(f32::MIN_POSITIVE));
        let attenuations = [Vec3::splat(reflected), through, through * again, rest];
        let weights = attenuations.map(|share| share.dot(LUMINANCE));
        let sum: f32 = weights.iter().sum();
        let chances = if sum > 0.0 { weights.map(|weight| weight / sum) } else { [1.0, 0.0, 0.0, 0.0] };
        let [[sin1, cos1], [sin2, cos2], [sin4, cos4]] = self.tilts;
        let turned =
            |[sin_by, cos_by]: [f32; 2]| [sin * cos_by + cos * sin_by, (cos * cos_by - sin * sin_by).abs()];
        let [first, variance] = self.variances;
        SeenHair {
            variances: [first, 0.25 * variance, 4.0 * variance, 4.0 * variance],
            scale: self.scale,
            attenuations,
            chances,
            // scales are tilted towards the root: what they reflect goes there
            to_eye: [turned([sin2, cos2]), turned([-sin1, cos1]), turned([-sin4, cos4]), [sin, cos]],
            middles: [0.0, 1.0, 2.0].map(|passes: f32| 2.0 * passes * inner - 2.0 * outer + passes * PI),
        }
    }
}

/// Shares of the channels in luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

impl SeenHair {
    /// Share of the light from all around that is sent on to the eye.
    pub fn albedo(&self) -> Vec3 {
        self.attenuations.iter().sum()
    }

    /// What is sent on of light from `to_light`, times the cosine, and the density with which [`sample`](Self::sample) chooses that
    /// direction. `to_eye` is the direction for which it was made.
    pub fn towards(&self, to_eye: Vec3, to_light: Vec3) -> (Vec3, f32) {
        let sin = to_light.x.clamp(-1.0, 1.0);
        let cos = cosine(sin);
        let around = angle::of(to_light.z, to_light.y) - angle::of(to_eye.z, to_eye.y);
        let (mut reflected, mut density) = (Vec3::ZERO, 0.0);
        for lobe in 0..LOBES {
            let along = along([sin, cos], self.to_eye[lobe], self.variances[lobe]);
            let across = match self.middles.get(lobe) {
                Some(middle) => logistic(wrapped(around - middle), self.scale),
                None => 0.5 * FRAC_1_PI,
            };
            reflected += self.attenuations[lobe] * (along * across);
            density += self.chances[lobe] * (along * across);
        }
        (reflected, density)
    }

    /// Samples a direction to light by two numbers from 0 to below 1.
    pub fn sample(&self, to_eye: Vec3, [first, second]: [f32; 2]) -> Vec3 {
        let (mut lobe, mut rest) = (0, first);
        while lobe < LOBES - 1 && rest >= self.chances[lobe] {
            rest -= self.chances[lobe];
            lobe += 1;
        }
        let across = (rest / self.chances[lobe].max(f32::MIN_POSITIVE)).clamp(0.0, MOST_RANDOM);
        // one number is made two: its upper half is as even as it is, and so is its lower one
        let high = (second * HALF).floor();
        let (along, turn) = ((high + 0.5) / HALF, (second * HALF - high).clamp(0.0, MOST_RANDOM));
        let variance = self.variances[lobe];
        let [sin_eye, cos_eye] = self.to_eye[lobe];
        let up = 1.0 + variance * (along + (1.0 - along) * (-2.0 / variance).exp()).ln();
        let [_, turned] = angle::turned(turn);
        let sin = (-up * sin_eye + cosine(up) * turned * cos_eye).clamp(-1.0, 1.0);
        let cos = cosine(sin);
        let around = angle::of(to_eye.z, to_eye.y)
            + match self.middles.get(lobe) {
                Some(middle) => middle + sampled_logistic(across, self.scale),
                None => TAU * across,
            };
        let [sin_around, cos_around] = angle::turned(around / TAU);
        Vec3::new(sin, cos * cos_around, cos * sin_around)
    }
}

/// Steps in which a random number is divided into two.
const HALF: f32 = 4096.0;

/// Greatest random number below 1.
const MOST_RANDOM: f32 = 1.0 - f32::EPSILON / 2.0;

/// Cosine of an angle up to a right one, from its sine; or the other way round.
fn cosine(sine: f32) -> f32 {
    (1.0 - sine * sine).max(0.0).sqrt()
}

fn wrapped(angle: f32) -> f32 {
    angle - TAU * (angle / TAU).round_ties_even()
}

/// Density of angles to the normal plane (M): for each unit of the angle's sine. Given by the sines and cosines to the light and to the eye.
fn along([sin_light, cos_light]: [f32; 2], [sin_eye, cos_eye]: [f32; 2], variance: f32) -> f32 {
    let (across, along) = (cos_light * cos_eye / variance, sin_light * sin_eye / variance);
    // the Bessel function and its normalization, both without what grows as an exponential
    let exponent = across - along - 1.0 / variance;
    bessel(across) * exponent.exp() / (variance * (1.0 - (-2.0 / variance).exp()))
}

/// Modified Bessel function of the first kind and order 0 of a number that is not below 0, over its exponential (M. Abramowitz and I. Stegun,
/// "Handbook of Mathematical Functions", 1964, 9.8.1 and 9.8.2).
fn bessel(x: f32) -> f32 {
    const LOW: [f32; 7] = [1.0, 3.515_623, 3.089_942_5, 1.206_749_2, 0.265_973_2, 0.036_076_8, 0.004_581_3];
    const HIGH: [f32; 9] = [
        0.398_942_3,
        0.013_285_92,
        0.002_253_19,
        -0.001_575_65,
        0.009_162_81,
        -0.020_577_06,
        0.026_355_37,
        -0.016_476_33,
        0.003_923_77,
    ];
    let sum = |factors: &[f32], x: f32| factors.iter().rev().fold(0.0, |sum, factor| sum * x + factor);
    if x < 3.75 {
        let t = x / 3.75;
        return sum(&LOW, t * t) * (-x).exp();
    }
    sum(&HIGH, 3.75 / x) / x.sqrt()
}

/// Share of a logistic distribution below -π.
fn below(scale: f32) -> f32 {
    1.0 / (1.0 + (PI / scale).min(80.0).exp())
}

/// Density of a logistic distribution that ends at -π and π.
fn logistic(angle: f32, scale: f32) -> f32 {
    let part = (-angle.abs() / scale).exp();
    part / (scale * (1.0 + part) * (1.0 + part)) / (1.0 - 2.0 * below(scale))
}

fn sampled_logistic(random: f32, scale: f32) -> f32 {
    let least = below(scale);
    let share = (least + random * (1.0 - 2.0 * least)).clamp(1e-7, 1.0 - 1e-7);
    (-scale * (1.0 / share - 1.0).ln()).clamp(-PI, PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shade::sampling::PathRandom;

    fn hair(roughness: f32, radial_roughness: f32, coat: f32) -> Hair {
        Hair { roughness, radial_roughness, coat, index: 1.55, offset: 2.0_f32.to_radians() }
    }

    fn on_sphere([up, turn]: [f32; 2]) -> Vec3 {
        let z = 2.0 * up - 1.0;
        let [sin, cos] = angle::turned(turn);
        Vec3::new(z, cosine(z) * cos, cosine(z) * sin)
    }

    const KINDS: [[f32; 3]; 4] = [[0.3, 0.3, 0.0], [0.6, 0.8, 0.5], [1.0, 1.0, 0.0], [0.15, 0.2, 0.0]];

    /// A fibre that absorbs nothing sends on all light, and its density is one, in whichever direction and wherever it is seen.
    #[test]
    fn white_hair_loses_no_light() {
        const STEPS: i32 = 700;
        for kind in KINDS {
            let lobes = HairLobes::new(&hair(kind[0], kind[1], kind[2]));
            for (sin, offset) in [(0.0, 0.0), (0.5, 0.7), (-0.8, -0.4), (0.95, 0.95)] {
                let to_eye = Vec3::new(sin, 0.6 * cosine(sin), 0.8 * cosine(sin));
                let seen = lobes.seen(Vec3::ONE, to_eye, offset);
                let (mut light, mut density) = (0.0_f64, 0.0_f64);
                for up in 0..STEPS {
                    for turn in 0..STEPS {
                        let of = |step: i32| (step as f32 + 0.5) / STEPS as f32;
                        let (reflected, pdf) = seen.towards(to_eye, on_sphere([of(up), of(turn)]));
                        light += f64::from(reflected.x);
                        density += f64::from(pdf);
                    }
                }
                let area = 4.0 * std::f64::consts::PI / f64::from(STEPS * STEPS);
                let (light, density) = (light * area, density * area);
                assert!((seen.albedo().x - 1.0).abs() < 1e-4, "{kind:?} {sin} {offset}: {}", seen.albedo());
                assert!((light - 1.0).abs() < 0.01, "{kind:?} {sin} {offset}: {light}");
                assert!((density - 1.0).abs() < 0.01, "{kind:?} {sin} {offset}: {density}");
            }
        }
    }

    /// Cells of the sphere: by the sine of the angle to the normal plane, and around.
    const CELLS: [usize; 2] = [12, 24];

    fn cell_of(direction: Vec3) -> usize {
        let [up, around] = CELLS;
        let part = |share: f32, cells: usize| ((share * cells as f32) as usize).min(cells - 1);
        let turn = 0.5 + angle::of(direction.z, direction.y) / TAU;
        part(0.5 + 0.5 * direction.x, up) * around + part(turn, around)
    }

    /// Directions are sampled with the density that is stated (chi-squared), and what they bring is the albedo in the mean.
    #[test]
    fn directions_are_as_dense_as_stated() {
        const COUNT: u32 = 60_000;
        const FINE: usize = 40;
        for (number, kind) in KINDS.into_iter().enumerate() {
            let lobes = HairLobes::new(&hair(kind[0], kind[1], kind[2]));
            let to_eye = Vec3::new(0.4, 0.6 * cosine(0.4), -0.8 * cosine(0.4));
            let seen = lobes.seen(Vec3::new(0.8, 0.5, 0.2), to_eye, 0.5);
            let [up, around] = CELLS;
            let (mut found, mut expected) = (vec![0.0_f64; up * around], vec![0.0_f64; up * around]);
            for cell_up in 0..up * FINE {
                for cell_around in 0..around * FINE {
                    let of = |step: usize, all: usize| (step as f32 + 0.5) / all as f32;
                    let direction = on_sphere([of(cell_up, up * FINE), of(cell_around, around * FINE)]);
                    expected[cell_of(direction)] += f64::from(seen.towards(to_eye, direction).1);
                }
            }
            let area = 4.0 * std::f64::consts::PI / (up * around * FINE * FINE) as f64;
            let mut whole = Vec3::ZERO;
            for index in 0..COUNT {
                let [a, b, ..] = PathRandom::new(index, number as u32).four(0);
                let direction = seen.sample(to_eye, [a, b]);
                assert!((direction.length() - 1.0).abs() < 1e-4);
                let (reflected, density) = seen.towards(to_eye, direction);
                assert!(density > 0.0);
                whole += reflected / density;
                found[cell_of(direction)] += 1.0;
            }
            let off = whole / COUNT as f32 - seen.albedo();
            assert!(off.abs().max_element() < 0.01, "{kind:?}: {off}");
            let (mut sum, mut cells) = (0.0, 0.0_f64);
            for (expected, found) in expected.into_iter().zip(found) {
                let expected = expected * area * f64::from(COUNT);
                if expected >= 10.0 {
                    sum += (found - expected).powi(2) / expected;
                    cells += 1.0;
                }
            }
            // five standard deviations
            let most = cells + 5.0 * (2.0 * cells).sqrt();
            assert!(cells > 30.0 && sum < most, "{kind:?}: {sum} of {most}");
        }
    }

    #[test]
    fn colours_are_what_absorption_makes_of_them() {
        let lobes = HairLobes::new(&hair(0.3, 0.3, 0.0));
        let color = Vec3::new(0.7, 0.4, 0.1);
        let back = (-lobes.absorption(color).powf(0.5) * lobes.of_color).exp();
        assert!((back - color).abs().max_element() < 1e-4, "{back}");
        let seen = |color: Vec3| lobes.seen(color, Vec3::Y, 0.3).albedo();
        // the colour is that of many fibres: a single one lets more through
        let (light, dark) = (seen(Vec3::ONE), seen(Vec3::splat(0.01)));
        assert!(dark.x < 0.5 * light.x && dark.x > 0.0, "{dark}");
    }

    #[test]
    fn the_bessel_function_is_that_of_the_tables() {
        // over their exponentials: Abramowitz and Stegun, table 9.8
        for (x, wanted) in
            [(0.0, 1.0), (1.0, 0.465_759_6), (3.0, 0.243_000_36), (5.0, 0.183_540_8), (10.0, 0.127_833_3)]
        {
            assert!((bessel(x) - wanted).abs() < 2e-6, "{x}: {}", bessel(x));
        }
    }
}
