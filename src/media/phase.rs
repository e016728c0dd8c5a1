//! Henyey and Greenstein's phase function: where a medium scatters light to.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::Vec3;

use crate::shade::sampling::orthonormal;

/// Largest anisotropy: beyond it light goes straight on for all that single floats can tell.
pub const MOST_ANISOTROPY: f32 = 0.999;

/// Density, in solid angle, of directions at this cosine to the one that light comes along.
pub fn density(anisotropy: f32, cos: f32) -> f32 {
    let g = anisotropy;
    let base = (1.0 + g * g - 2.0 * g * cos).max(f32::MIN_POSITIVE);
    0.25 * FRAC_1_PI * (1.0 - g * g) / (base * base.sqrt())
}

/// Direction in which light goes on that comes along `incoming` (unit length), drawn with that density by two random numbers.
pub fn sample(anisotropy: f32, incoming: Vec3, [along, around]: [f32; 2]) -> Vec3 {
    /// Least anisotropy that is one: below it the formula divides rounding by rounding.
    const LEAST: f32 = 1e-3;
    let g = anisotropy;
    let cos = if g.abs() < LEAST {
        1.0 - 2.0 * along
    } else {
        let share = (1.0 - g * g) / (1.0 - g + 2.0 * g * along);
        ((1.0 + g * g - share * share) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    let across = (1.0 - cos * cos).max(0.0).sqrt();
    let (sin_around, cos_around) = (TAU * around).sin_cos();
    let [x, y] = orthonormal(incoming);
    (x * (across * cos_around) + y * (across * sin_around) + incoming * cos).normalize_or(incoming)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions are drawn with the density that is said of them, and their mean cosine is the anisotropy.
    #[test]
    fn directions_are_as_dense_as_is_said() {
        for anisotropy in [-0.7, 0.0, 5e-4, 0.3, 0.9_f32] {
            const BINS: usize = 16;
            let count = 1 << 16;
            let (mut found, mut mean) = ([0.0_f64; BINS], 0.0_f64);
            for number in 0..count {
                let along = (number as f32 + 0.5) / count as f32;
                let cos = sample(anisotropy, Vec3::Z, [along, 0.3]).z;
                found[(((cos + 1.0) * 0.5 * BINS as f32) as usize).min(BINS - 1)] += 1.0 / f64::from(count);
                mean += f64::from(cos) / f64::from(count);
            }
            assert!((mean - f64::from(anisotropy)).abs() < 2e-3, "{anisotropy}: {mean}");
            for (bin, found) in found.into_iter().enumerate() {
                const STEPS: usize = 200;
                let at = |step: usize| {
                    -1.0 + 2.0 * (bin as f32 + (step as f32 + 0.5) / STEPS as f32) / BINS as f32
                };
                let sum: f64 = (0..STEPS).map(|step| f64::from(density(anisotropy, at(step)))).sum();
                let wanted = sum * std::f64::consts::TAU * 2.0 / (BINS * STEPS) as f64;
                assert!((found - wanted).abs() < 2e-3, "{anisotropy} {bin}: {found} for {wanted}");
            }
        }
    }
}
