//! Matt surfaces that are rough: dust, clay, the moon. What faces the light is brighter towards it, and rims hardly fade.
//!
//! The energy-preserving Oren-Nayar model, as OpenPBR and Cycles have it (Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving
//! Rough Diffuse BRDF", 2024): Fujii's single scattering, and what it takes comes back after several. Light of lights is shown as the
//! model has it, for their directions are known. Light that is gathered from all around is kept without them: of it the eye sees the share
//! that it would if the light were even.

use std::f32::consts::PI;

use glam::Vec3;

use crate::lanes::{F32x8, Real, Vec3x8};

/// Share by which Fujii's model dims what faces the light, for each unit of roughness; and what of that is left in the mean of all directions.
const DIMS: f32 = 0.5 - 2.0 / (3.0 * PI);
const DIMS_IN_ALL: f32 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// A rough matt surface as one ray sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenRough {
    /// Roughness, from 0 to 1.
    pub roughness: f32,
    /// Light that comes back after several scatterings, for each unit of what does not after one.
    pub several: Vec3,
    /// Share of light from all around that it shows, over that of a smooth one.
    pub shown: Vec3,
}

impl SeenRough {
    /// A surface of this colour that is seen at this cosine.
    pub fn new(roughness: f32, color: Vec3, cos: f32) -> Self {
        let color = color.clamp(Vec3::ZERO, Vec3::ONE);
        let mean = (1.0 + DIMS_IN_ALL * roughness) / (1.0 + DIMS * roughness);
        let rest = 1.0 - once(roughness, cos.clamp(0.0, 1.0));
        // of light that is scattered again and again, over the colour
        let again = color * mean / (Vec3::ONE - color * (1.0 - mean));
        Self {
            roughness,
            several: again * (rest / (1.0 - mean).max(LEAST_REST)),
            shown: Vec3::splat(1.0 - rest) + again * rest,
        }
    }
}

/// Least share of light that single scattering takes: what is hardly rough takes none.
const LEAST_REST: f32 = 1e-7;

/// Share of light from all around, or to all around, that leaves a white surface after one scattering, at this cosine: the fit of the
/// authors to its integral.
#[inline(always)]
fn once<T: Real>(roughness: T, cos: T) -> T {
    let one = T::of(1.0);
    let aside = one - cos;
    let [a, b, c, d] = [0.057_108_5, 0.491_882, -0.332_181, 0.071_443].map(T::of);
    let more = aside * (a + aside * (b + aside * (c + aside * d)));
    (one + roughness * more) / (one + T::of(DIMS) * roughness)
}

/// Rough matt surfaces, eight side by side.
#[derive(Debug, Clone, Copy)]
pub struct RoughLanes {
    roughness: F32x8,
    several: Vec3x8,
    shown: Vec3x8,
    /// Albedo, as far as what is above lets its light through.
    albedo: Vec3x8,
}

impl RoughLanes {
    pub const NONE: Self =
        Self { roughness: F32x8::ZERO, several: Vec3x8::ZERO, shown: Vec3x8::ZERO, albedo: Vec3x8::ZERO };

    pub fn set(&mut self, lane: usize, seen: &SeenRough, albedo: Vec3) {
        self.roughness.set_lane(lane, seen.roughness);
        self.several.set_lane(lane, seen.several);
        self.shown.set_lane(lane, seen.shown);
        self.albedo.set_lane(lane, albedo);
    }

    /// What surfaces show of light from this direction more, or less, than smooth ones that are shown as they are in even light.
    pub fn beyond_smooth(&self, normal: Vec3x8, to_eye: Vec3x8, to_light: Vec3x8) -> Vec3x8 {
        let one = F32x8::ONE;
        let (of_eye, of_light) = (normal.dot(to_eye), normal.dot(to_light));
        let apart = to_eye.dot(to_light) - of_eye * of_light;
        let towards = apart.gt(F32x8::ZERO).select(apart / of_eye.max(of_light), apart);
        let single = (one + self.roughness * towards) / (one + self.roughness * F32x8::splat(DIMS));
        let rest = one - once(self.roughness, of_light);
        let shown = Vec3x8::all_of(single) + self.several * rest - self.shown;
        let is_lit = of_light.gt(F32x8::ZERO) & of_eye.gt(F32x8::ZERO) & self.roughness.gt(F32x8::ZERO);
        is_lit.select3(self.albedo * shown * of_light, Vec3x8::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::at_turn;
    use super::*;

    /// In even light what it shows of all directions is what it is said to show, and white stays white.
    #[test]
    fn even_light_is_shown_as_all_directions_show_it() {
        const STEPS: u32 = 200;
        for (roughness, cos) in [(0.3, 0.9), (1.0, 0.5), (1.0, 0.1), (0.6, 1.0)] {
            let color = Vec3::new(1.0, 0.5, 0.1);
            let seen = SeenRough::new(roughness, color, cos);
            assert!((seen.shown.x - 1.0).abs() < 1e-5, "white: {seen:?}");
            assert!(seen.shown.z < seen.shown.y && seen.shown.y < 1.0);
            let mut lanes = RoughLanes::NONE;
            lanes.set(0, &seen, Vec3::ONE);
            let mut sum = Vec3::ZERO;
            for ring in 0..STEPS {
                for turn in 0..STEPS {
                    let light = at_turn(
                        (ring as f32 + 0.5) / STEPS as f32,
                        2.0 * PI * (turn as f32 + 0.5) / STEPS as f32,
                    );
                    let [normal, eye, light] = [Vec3::Z, at_turn(cos, 0.0), light].map(Vec3x8::splat);
                    let shown = lanes.beyond_smooth(normal, eye, light).lane(0);
                    sum += shown * (2.0 / (STEPS * STEPS) as f32);
                }
            }
            // as near as the authors' fit is
            assert!(sum.abs().max_element() < 4e-3, "{roughness} {cos}: {sum}");
        }
    }

    /// The full moon does not fade towards its rim: what is lit from where it is seen is nearly as bright on edge.
    #[test]
    fn rims_hardly_fade() {
        let brightness = |roughness: f32, cos: f32| {
            let seen = SeenRough::new(roughness, Vec3::splat(0.2), cos);
            let mut lanes = RoughLanes::NONE;
            lanes.set(0, &seen, Vec3::ONE);
            let [normal, eye] = [Vec3::Z, at_turn(cos, 0.0)].map(Vec3x8::splat);
            lanes.beyond_smooth(normal, eye, eye).lane(0).y + cos * seen.shown.y
        };
        let [smooth, rough] =
            [0.0, 1.0].map(|roughness| brightness(roughness, 0.3) / brightness(roughness, 1.0));
        assert!((smooth - 0.3).abs() < 1e-5 && rough > 0.8, "{smooth} {rough}");
        assert_eq!(SeenRough::new(0.0, Vec3::ONE, 0.4).shown, Vec3::ONE);
    }
}
