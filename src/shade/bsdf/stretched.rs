//! Microfacets that are rougher across than along: brushed metal, satin, hair that is combed. GGX whose lobe has two widths.
//!
//! - Distribution, masking and shadowing: Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", 2014, with a width
//!   along each axis of the surface.
//! - Widths of an anisotropy: those of OpenPBR, 1.1, "microfacet model": the mean of their squares is that of the lobe that is round.
//! - Light that microfacets reflect several times is as much as that of the round lobe ([`albedos`](super::albedos)).
//!
//! Directions are given by their components along the tangent, across it, and along the normal.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use crate::geometry::angle;
use crate::lanes::{F32x8, Mask, Real, Vec3x8};
use crate::scene::material::{Anisotropy, LEAST_ALPHA};

/// Factors of the round lobe's width, along the tangent and across it, and the turn of the tangent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    along: f32,
    across: f32,
    /// Cosine and sine of the turn about the normal.
    turn: [f32; 2],
}

/// Widths of a lobe (alpha of GGX), along the tangent and across it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Widths<T> {
    pub along: T,
    pub across: T,
}

impl Stretch {
    /// The stretch of an anisotropy, if there is any.
    pub fn of(anisotropy: &Anisotropy) -> Self {
        let rest = 1.0 - anisotropy.amount;
        let along = (2.0 / (1.0 + rest * rest)).sqrt();
        let [sin, cos] = [anisotropy.turn.sin(), anisotropy.turn.cos()];
        Self { along, across: rest * along, turn: [cos, sin] }
    }

    /// Widths of a lobe that would have this one if it were round.
    pub fn widths(&self, alpha: f32) -> Widths<f32> {
        let width = |factor: f32| (alpha * factor).max(LEAST_ALPHA);
        Widths { along: width(self.along), across: width(self.across) }
    }

    /// Tangent and the direction across it on a surface with this `normal` whose own tangent is `tangent`, of any length. `None` if that is
    /// zero, or leads out of the surface.
    pub fn axes(&self, normal: Vec3, tangent: Vec3) -> Option<[Vec3; 2]> {
        let along = (tangent - normal * normal.dot(tangent)).try_normalize()?;
        let across = normal.cross(along);
        let [cos, sin] = self.turn;
        Some([along * cos + across * sin, across * cos - along * sin])
    }
}

impl<T: Real> Widths<T> {
    /// Density of microfacet normals about `half`, for each unit of area and of solid angle.
    #[inline(always)]
    fn distribution(&self, [along, across, up]: [T; 3]) -> T {
        let Self { along: width, across: other, .. } = *self;
        let (along, across) = (along / width, across / other);
        let spread = along * along + across * across + up * up;
        T::of(FRAC_1_PI) / (width * other * spread * spread)
    }

    /// Length of a direction that is stretched by the widths.
    #[inline(always)]
    fn stretched(&self, [along, across, up]: [T; 3]) -> T {
        let (along, across) = (along * self.along, across * self.across);
        (along * along + across * across + up * up).sqrt()
    }

    /// What white microfacets reflect from `to_light` to `to_eye` (BRDF, 1/sr) times the cosine to the light; and the density with which
    /// [`sample`](Widths::sample) chooses `to_light`. Both lie above the surface; `half` is between them, of unit length.
    #[inline(always)]
    pub fn shape(&self, to_eye: [T; 3], to_light: [T; 3], half: [T; 3]) -> [T; 2] {
        let (of_eye, of_light) = (to_eye[2], to_light[2]);
        let [eye, light] = [to_eye, to_light].map(|direction| self.stretched(direction));
        let normals = self.distribution(half);
        let two = T::of(2.0);
        [normals * of_light / (two * (eye * of_light + light * of_eye)), normals / (two * (of_eye + eye))]
    }
}

impl Widths<f32> {
    /// [`shape`](Self::shape) of directions of unit length, and the cosine between either and the normal halfway; `None` if one is not above
    /// the surface.
    pub fn towards(&self, to_eye: Vec3, to_light: Vec3) -> Option<([f32; 2], f32)> {
        if to_eye.z <= 0.0 || to_light.z <= 0.0 {
            return None;
        }
        let half = (to_eye + to_light).normalize();
        let shape = self.shape(to_eye.to_array(), to_light.to_array(), half.to_array());
        Some((shape, half.dot(to_eye)))
    }

    /// Samples a direction in which a microfacet that is seen from `to_eye` reflects, by two numbers from 0 to below 1: as those of a round
    /// lobe are ([`ggx`](super::ggx)), in a space that is stretched twice.
    pub fn sample(&self, to_eye: Vec3, [around, along]: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.along * to_eye.x, self.across * to_eye.y, to_eye.z).normalize();
        let [sin, cos] = angle::turned(around);
        let z = (1.0 - along) * (1.0 + stretched.z) - stretched.z;
        let aside = (1.0 - z * z).max(0.0).sqrt();
        let half = Vec3::new(aside * cos, aside * sin, z) + stretched;
        let normal =
            Vec3::new(self.along * half.x, self.across * half.y, half.z.max(0.0)).normalize_or(Vec3::Z);
        normal * (2.0 * normal.dot(to_eye)) - to_eye
    }
}

/// Lobes of those of eight surfaces that are not round, with their axes.
#[derive(Debug, Clone, Copy)]
pub struct StretchedLanes {
    /// Mask of these surfaces.
    pub is_stretched: Mask,
    widths: Widths<F32x8>,
    /// Tangents, and directions across them, unit length.
    axes: [Vec3x8; 2],
}

impl StretchedLanes {
    /// All are round.
    pub const ROUND: Self = Self {
        is_stretched: Mask::NONE,
        widths: Widths { along: F32x8::ONE, across: F32x8::ONE },
        axes: [Vec3x8::ZERO; 2],
    };

    pub fn set(&mut self, lane: usize, widths: Widths<f32>, axes: [Vec3; 2]) {
        self.is_stretched.set(lane);
        self.widths.along.set_lane(lane, widths.along);
        self.widths.across.set_lane(lane, widths.across);
        self.axes.iter_mut().zip(axes).for_each(|(all, axis)| all.set_lane(lane, axis));
    }

    /// [`Widths::shape`] for surfaces with these normals, world space, and the cosines between the directions and the normals halfway. 0
    /// where one is not above its surface; of round ones it means nothing.
    pub fn towards(&self, normal: Vec3x8, to_eye: Vec3x8, to_light: Vec3x8) -> ([F32x8; 2], F32x8) {
        let [along, across] = self.axes;
        let local = |direction: Vec3x8| [along, across, normal].map(|axis| axis.dot(direction));
        let half = (to_eye + to_light).normalize();
        let (eye, light) = (local(to_eye), local(to_light));
        let shape = self.widths.shape(eye, light, local(half));
        let is_above = eye[2].gt(F32x8::ZERO) & light[2].gt(F32x8::ZERO);
        (shape.map(|value| is_above.select(value, F32x8::ZERO)), half.dot(to_eye))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::at_turn;
    use super::*;
    use crate::shade::bsdf::fresnel::Fresnel;
    use crate::shade::bsdf::ggx;

    /// What is as wide along as across is round.
    #[test]
    fn a_lobe_without_a_stretch_is_round() {
        let fresnel = Fresnel::of_metal(Vec3::ONE);
        for alpha in [0.05, 0.3, 1.0] {
            let widths = Widths { along: alpha, across: alpha };
            for (eye, light) in
                [(at_turn(0.9, 0.3), at_turn(0.2, 2.0)), (at_turn(0.3, 1.0), at_turn(0.4, 4.0))]
            {
                let ([reflected, density], _) = widths.towards(eye, light).expect("both are above");
                let wanted = ggx::reflected(alpha, &fresnel, eye, light).x;
                assert!((reflected - wanted).abs() <= 1e-4 * wanted, "{alpha}: {reflected} {wanted}");
                let wanted = ggx::density(alpha, eye, light);
                assert!((density - wanted).abs() <= 1e-4 * wanted, "{alpha}: {density} {wanted}");
            }
        }
        let round = Stretch::of(&Anisotropy { amount: 0.0, turn: 1.0, around: None });
        assert_eq!(round.widths(0.3), Widths { along: 0.3, across: 0.3 });
    }

    /// Brushed metal spreads light across its grooves: along the tangent it is wide.
    #[test]
    fn light_is_spread_along_the_tangent() {
        let stretch = Stretch::of(&Anisotropy { amount: 0.8, turn: 0.0, around: None });
        let widths = stretch.widths(0.3);
        assert!((widths.across / widths.along - 0.2).abs() < 1e-5, "{widths:?}");
        let mean = 0.5 * (widths.along * widths.along + widths.across * widths.across);
        assert!((mean - 0.09).abs() < 1e-5, "{mean}");
        let bright =
            |turn: f32| widths.towards(Vec3::Z, at_turn(0.85, turn)).map_or(0.0, |(shape, _)| shape[0]);
        assert!(bright(0.0) > 5.0 * bright(std::f32::consts::FRAC_PI_2));
    }

    #[test]
    fn axes_lie_in_the_surface_and_are_turned() {
        let stretch =
            Stretch::of(&Anisotropy { amount: 0.5, turn: std::f32::consts::FRAC_PI_2, around: None });
        let [along, across] = stretch.axes(Vec3::Y, Vec3::new(2.0, 1.0, 0.0)).expect("it has a tangent");
        assert!(
            (along - Vec3::NEG_Z).length() < 1e-6 && (across - Vec3::NEG_X).length() < 1e-6,
            "{along} {across}"
        );
        assert_eq!(stretch.axes(Vec3::Y, Vec3::ZERO), None);
        assert_eq!(stretch.axes(Vec3::Y, Vec3::Y), None);
    }
}
