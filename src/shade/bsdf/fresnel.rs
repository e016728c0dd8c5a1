//! Share of light that a smooth place of a surface reflects, by the angle.
//!
//! - A dielectric: Fresnel's equations for unpolarised light, as Cook and Torrance write them, "A Reflectance
//!   Model for Computer Graphics", 1982.
//! - A metal: Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994. Its colour at right
//!   angles is all that files say of it.

use glam::Vec3;

use crate::lanes::Real;
use crate::scene::material;

/// Largest index of refraction here: so large a one reflects 99.8 % at right angles.
const GREATEST_INDEX: f32 = 1000.0;

/// Least cosine that is used in formulas, so that an index of 1 divides nothing by zero.
const LEAST_COSINE: f32 = 1e-4;

/// Index of refraction, from 1 on, of a dielectric that reflects this share of light at right angles.
pub fn index_of(head_on: f32) -> f32 {
    material::index_of(head_on.clamp(0.0, 1.0)).min(GREATEST_INDEX)
}

/// Share of unpolarised light that a dielectric of this index of refraction, 1 or more, reflects; seen from
/// outside at this cosine.
#[inline(always)]
pub fn dielectric<T: Real>(index: T, cos: T) -> T {
    let one = T::of(1.0);
    let cos = cos.max(T::of(LEAST_COSINE)).min(one);
    // the cosine inside, times the index
    let inside = (index * index - one + cos * cos).sqrt();
    let (sum, difference) = (inside + cos, inside - cos);
    let across = difference / sum;
    let along_over_across = (cos * sum - one) / (cos * difference + one);
    T::of(0.5) * across * across * (one + along_over_across * along_over_across)
}

/// Schlick's formula for one channel: reflectance `head_on` at right angles, up to white at grazing angles.
/// `cos` is the cosine between the normal of the place and the direction.
#[inline(always)]
pub fn schlick<T: Real>(head_on: T, cos: T) -> T {
    toward_white(head_on, grazing(cos))
}

/// Share of white in Schlick's formula.
#[inline(always)]
pub fn grazing<T: Real>(cos: T) -> T {
    let rest = (T::of(1.0) - cos).max(T::of(0.0)).min(T::of(1.0));
    let square = rest * rest;
    square * square * rest
}

#[inline(always)]
fn toward_white<T: Real>(head_on: T, white: T) -> T {
    head_on + (T::of(1.0) - head_on) * white
}

/// Reflectance of a surface that is a metal, a dielectric, or a mixture of both; of one surface or of eight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fresnel<T> {
    /// Reflectance of the metal at right angles, for red, green and blue.
    pub metal: [T; 3],
    /// How white it is at grazing angles, from 0 (as at right angles) to 1.
    pub edge: T,
    /// Share of metal, from 0 to 1.
    pub metallic: T,
    /// Index of refraction of the rest, 1 or more.
    pub index: T,
}

impl Fresnel<f32> {
    /// Bare metal that reflects `head_on` at right angles.
    pub fn of_metal(head_on: Vec3) -> Self {
        Self { metal: head_on.to_array(), edge: 1.0, metallic: 1.0, index: 1.0 }
    }
}

impl<T: Real> Fresnel<T> {
    /// Reflectance where the normal of a smooth place and the direction have this cosine.
    #[inline(always)]
    pub fn at(&self, cos: T) -> [T; 3] {
        let (clear, white) = (dielectric(self.index, cos), grazing(cos) * self.edge);
        self.metal.map(|metal| self.mixed(clear, toward_white(metal, white)))
    }

    /// Mixture of what the dielectric reflects and of what the metal does.
    #[inline(always)]
    pub fn mixed(&self, clear: T, metal: T) -> T {
        clear + (metal - clear) * self.metallic
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::F32x8;
    use crate::scene::material::head_on;

    const INDICES: [f64; 5] = [1.1, 1.33, 1.5, 2.2, 4.0];

    /// The amplitudes of both polarisations, by the angles on both sides (Snell).
    fn by_angles(index: f64, cos: f64) -> f64 {
        let outside = cos.acos();
        let inside = (outside.sin() / index).asin();
        let across = (outside - inside).sin() / (outside + inside).sin();
        let along = (outside - inside).tan() / (outside + inside).tan();
        0.5 * (across * across + along * along)
    }

    #[test]
    fn a_dielectric_reflects_what_fresnels_equations_say() {
        for index in INDICES {
            for step in 1..100 {
                let cos = f64::from(step) / 100.0;
                let (got, wanted) = (dielectric(index as f32, cos as f32), by_angles(index, cos));
                assert!(
                    (f64::from(got) - wanted).abs() < 1e-5,
                    "index {index}, cosine {cos}: {got}, {wanted}"
                );
            }
        }
    }

    #[test]
    fn the_index_is_that_of_the_reflectance_at_right_angles() {
        for index in INDICES {
            let found = index_of(head_on(index) as f32);
            assert!((f64::from(found) - index).abs() < 1e-4 * index, "{index}: {found}");
            assert!((dielectric(found, 1.0) - head_on(index) as f32).abs() < 1e-6);
        }
        assert_eq!(index_of(0.0), 1.0);
        assert!(dielectric(index_of(1.0), 0.3) > 0.99);
    }

    #[test]
    fn what_bends_no_light_reflects_none_and_what_is_grazed_reflects_all() {
        for cos in [0.0, 1e-5, 0.01, 0.5, 1.0] {
            assert!(dielectric(1.0_f32, cos) < 1e-6, "{cos}: {}", dielectric(1.0_f32, cos));
        }
        for index in INDICES {
            assert!(dielectric(index as f32, 0.0) > 0.995, "{index}");
        }
    }

    #[test]
    fn eight_at_once_are_as_one_by_one_to_the_bit() {
        for index in INDICES {
            for step in 0..=20 {
                let cos = step as f32 / 20.0;
                let one = Fresnel { metal: [0.9, 0.5, 0.04], edge: 0.7, metallic: 0.3, index: index as f32 };
                let eight = Fresnel {
                    metal: one.metal.map(F32x8::splat),
                    edge: F32x8::splat(one.edge),
                    metallic: F32x8::splat(one.metallic),
                    index: F32x8::splat(one.index),
                };
                assert_eq!(eight.at(F32x8::splat(cos)).map(|channel| channel.lane(3)), one.at(cos));
            }
        }
    }
}
