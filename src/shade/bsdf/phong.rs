//! Phong's reflection model as MTL means it: no division by pi, no energy balance. Eight points at a time.

use std::f32::consts::LOG2_E;

use crate::lanes::{F32x8, Mask, Vec3x8};
use crate::shade::horizon;
use crate::shade::light::LightSample;

/// Highlights of eight surfaces: their parameters.
#[derive(Debug, Clone, Copy)]
pub struct Gloss {
    /// Colour of the highlight.
    pub specular: Vec3x8,
    /// Exponent of the highlight.
    pub shininess: F32x8,
    /// True if any of the eight has a highlight.
    pub is_any: bool,
    /// Mask of surfaces from which rays go on.
    pub goes_on: Mask,
    /// Mask of mirrors and glass among these.
    pub is_followed: Mask,
}

/// Diffuse light by Lambert's cosine law. `smooth`: normals of the curved surfaces, where a normal map bends any; light
/// [fades](horizon::fading) towards their horizons.
#[inline(always)]
pub fn diffuse(albedo: Vec3x8, normal: Vec3x8, smooth: Option<Vec3x8>, light_sample: &LightSample) -> Vec3x8 {
    let light = albedo * light_sample.irradiance * normal.dot(light_sample.direction).max(F32x8::ZERO);
    match smooth {
        Some(smooth) => light * horizon::fading(normal, smooth, light_sample.direction),
        None => light,
    }
}

/// Logarithm (base 2) of the share of a light below which a highlight is left out: half floats end at 2^-24,
/// so that the highlight could be told from none only if the light were 2^16 strong.
const LEAST_LOG: f32 = -40.0;

/// Highlight: its colour times (R . V) to its exponent, where R is the direction to the light mirrored at the normal and `view` (unit
/// length) points to the eye.
#[inline(always)]
pub fn specular(gloss: &Gloss, normal: Vec3x8, view: Vec3x8, light_sample: &LightSample) -> Vec3x8 {
    let cos = normal.dot(light_sample.direction);
    let mirrored = normal * (cos + cos) - light_sample.direction;
    // in this order a NaN stays one, and shows nothing
    let toward = F32x8::ONE.min(mirrored.dot(view));
    // the tangent of a logarithm at 1 is nowhere below it: most of a highlight is known to be invisible
    // without a power
    let most = (toward - F32x8::ONE) * F32x8::splat(LOG2_E) * gloss.shininess;
    let shows = toward.gt(F32x8::ZERO) & most.gt(F32x8::splat(LEAST_LOG));
    if !shows.any() {
        return Vec3x8::ZERO;
    }
    let strength = shows.select(toward.power(gloss.shininess), F32x8::ZERO);
    gloss.specular * light_sample.irradiance * strength
}

/// Returns true if any of eight surfaces may have a highlight of a light whose points are no further than
/// `reach` from its centre: a bound of [`specular`] for all of them. A `false` is certain, up to highlights
/// that cannot be seen.
///
/// R . V is L . M, where M is the view mirrored at the normal; and with a centre in the direction C and a
/// point beside it, L . M is at most (C . M + reach) / (|C| - reach).
#[inline(always)]
pub fn may_shine(gloss: &Gloss, normal: Vec3x8, view: Vec3x8, to_centre: Vec3x8, reach: f32) -> bool {
    // for differences of rounding between here and there
    const SLACK: f32 = 1e-4;
    let cos = normal.dot(view);
    let mirrored = normal * (cos + cos) - view;
    let distance = to_centre.dot(to_centre).sqrt();
    let reach = F32x8::splat(reach) + distance * F32x8::splat(SLACK);
    let (along, nearest) = (to_centre.dot(mirrored) + reach, distance - reach);
    let most = (along / nearest - F32x8::ONE) * F32x8::splat(LOG2_E) * gloss.shininess;
    let is_within = nearest.le(F32x8::ZERO);
    (is_within | along.gt(F32x8::ZERO) & most.gt(F32x8::splat(LEAST_LOG))).any()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn from(direction: Vec3) -> LightSample {
        let direction = Vec3x8::splat(direction);
        let irradiance = Vec3x8::splat(Vec3::splat(2.0));
        LightSample { to_light: direction, direction, far: f32::INFINITY, irradiance, reaches: Mask::ALL }
    }

    #[test]
    fn diffuse_follows_the_cosine() {
        let slanted = from(Vec3::new(0.6, 0.8, 0.0));
        let lit = |albedo: f32, normal| {
            diffuse(Vec3x8::splat(Vec3::splat(albedo)), Vec3x8::splat(normal), None, &slanted)
        };
        assert!((lit(0.5, Vec3::Y).lane(0) - Vec3::splat(0.8)).length() < 1e-6);
        assert_eq!(lit(1.0, Vec3::NEG_Y).lane(0), Vec3::ZERO);
    }

    #[test]
    fn the_highlight_peaks_in_the_mirror_direction() {
        let gloss = Gloss {
            specular: Vec3x8::splat(Vec3::splat(0.25)),
            shininess: F32x8::splat(10.0),
            is_any: true,
            goes_on: Mask::NONE,
            is_followed: Mask::NONE,
        };
        let slanted = from(Vec3::new(0.6, 0.8, 0.0));
        let seen = |view| specular(&gloss, Vec3x8::splat(Vec3::Y), Vec3x8::splat(view), &slanted).lane(7);
        let peak = seen(Vec3::new(-0.6, 0.8, 0.0));
        assert!((peak - Vec3::splat(0.5)).length() < 1e-5, "{peak}");
        assert_eq!(seen(Vec3::new(1.0, 0.0, 0.0)), Vec3::ZERO);
        assert_eq!(seen(Vec3::NAN), Vec3::ZERO, "what is not a number shows nothing");
    }

    #[test]
    fn no_highlight_that_can_be_seen_is_taken_for_none() {
        let above = from(Vec3::Y);
        for shininess in [0.5, 3.0, 40.0, 96.0, 1000.0] {
            let gloss = Gloss {
                specular: Vec3x8::splat(Vec3::ONE),
                shininess: F32x8::splat(shininess),
                is_any: true,
                goes_on: Mask::NONE,
                is_followed: Mask::NONE,
            };
            for step in 0..=1000 {
                let cos = step as f32 / 1000.0;
                let view = Vec3::new((1.0 - cos * cos).sqrt(), cos, 0.0);
                let got = specular(&gloss, Vec3x8::splat(Vec3::Y), Vec3x8::splat(view), &above).lane(2).x;
                let wanted = 2.0 * f64::from(cos).powf(f64::from(shininess));
                assert!((f64::from(got) - wanted).abs() < 1e-5 * wanted + 1e-11, "{cos}^{shininess}: {got}");
            }
        }
    }

    #[test]
    fn a_light_that_shines_is_never_said_not_to() {
        let mut state = 7_u32;
        let mut any = move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let mut kept_out = 0;
        for round in 0..20_000 {
            let mut vector = || Vec3::new(any(), any(), any());
            let (normal, view) = (vector().normalize(), vector().normalize());
            let (centre, aside) = (vector() * 3.0, vector().normalize());
            let reach = [0.0, 0.1, 1.0][round % 3];
            let place = centre + aside * reach;
            let light_sample = from(place.normalize());
            let gloss = Gloss {
                specular: Vec3x8::splat(Vec3::ONE),
                shininess: F32x8::splat([1.0, 10.0, 60.0, 1000.0][round % 4]),
                is_any: true,
                goes_on: Mask::NONE,
                is_followed: Mask::NONE,
            };
            let [normal, view] = [normal, view].map(Vec3x8::splat);
            let shines = specular(&gloss, normal, view, &light_sample) != Vec3x8::ZERO;
            let may = may_shine(&gloss, normal, view, Vec3x8::splat(centre), reach);
            assert!(may || !shines, "round {round}");
            kept_out += u32::from(!may);
        }
        assert!(kept_out > 8000, "most are told without a power: {kept_out}");
    }
}
