//! Probabilities of the ways that lead from a surface to light, and the weights of light that follow.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::lighting::lights_passed;
use super::path_ray::PathRay;
use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::scene::SkyDensity;
use crate::shade::Surface;
use crate::shade::area::Glow;
use crate::shade::bsdf::mis::mis_weight;

/// Probabilities of the ways that lead from a surface to light.
#[derive(Debug, Clone, Copy)]
pub struct Pdfs {
    /// Probability of asking the sky from there; the number of rays, where it is asked more than once.
    pub asks_sky: f32,
    /// Density with which it is asked.
    pub sky: SkyDensity,
    /// Probability of asking an emitting surface from there.
    pub asks_emitter: f32,
    /// How the shot's lights are asked from there.
    pub lights: LightsAsked,
    /// Probability with which a path goes on from there by the cosine law.
    pub goes_on: f32,
}

/// How the shot's lights are asked from a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightsAsked {
    /// All of them, in sums that no path is part of: what a path meets of them is not needed.
    InSums,
    /// All of them, by all of their points, of which each path has this share.
    ByAllPoints {
        /// 1 over the number of paths.
        share: f32,
    },
    /// With this probability one of them, by [`LightChances`](crate::shade::light_chances::LightChances).
    One {
        /// 0 where none is asked.
        chance: f32,
    },
}

impl Pdfs {
    /// Pdfs at a surface where its path alone finds light.
    pub const PATH_ALONE: Self = Self {
        asks_sky: 0.0,
        sky: SkyDensity::Peaks,
        asks_emitter: 0.0,
        lights: LightsAsked::One { chance: 0.0 },
        goes_on: 1.0,
    };

    /// Pdfs at a sample's surface, where paths start.
    pub fn of_start(frame: &FrameView) -> Self {
        let chance = |is_asked| if is_asked { 1.0 } else { 0.0 };
        Self {
            asks_sky: frame.sky.samples() as f32,
            sky: SkyDensity::Peaks,
            asks_emitter: chance(frame.emitters.are_asked()),
            lights: LightsAsked::InSums,
            goes_on: 1.0,
        }
    }

    /// Weighted radiance of the sky for a path that leaves a surface with this `normal` in this `direction`.
    pub fn of_sky(self, frame: &FrameView, normal: Vec3, direction: Vec3) -> Vec3 {
        if self.asks_sky == 0.0 {
            return frame.sky.radiance(direction);
        }
        let light = frame.sky.light(self.sky, direction);
        let by_path = self.goes_on * cosine_density(normal, direction);
        light.radiance * weight_of_path(by_path, self.asks_sky * light.pdf)
    }

    /// Returns true if all of the shot's lights are summed where the path left.
    pub fn lights_are_summed(self) -> bool {
        self.lights == LightsAsked::InSums
    }

    /// Weighted radiance of the area lights that a `ray` passes through within `far` of its origin. They are
    /// asked for from the point `asked_from` on a surface with this `normal`, from which the path has come
    /// straight or through clear glass.
    pub fn of_lights(
        self,
        frame: &FrameView,
        (asked_from, normal): (Vec3, Vec3),
        ray: &PathRay,
        far: f32,
    ) -> Vec3 {
        let PathRay { origin, direction, tick, within, receiver, .. } = *ray;
        let weighed = |(number, glow, direction): (usize, Glow, Vec3)| {
            if !frame.lights(number, receiver) {
                return Vec3::ZERO;
            }
            let by_path = self.goes_on * cosine_density(normal, direction);
            let asked = match self.lights {
                LightsAsked::InSums => return Vec3::ZERO,
                LightsAsked::ByAllPoints { share } => share * glow.points as f32,
                LightsAsked::One { chance } => chance * frame.chance_of_light(receiver, asked_from, number),
            };
            // rays that ask know what casts shadows in it
            if asked > 0.0 && frame.is_shadow_linked(number) {
                return Vec3::ZERO;
            }
            let mut left = within.left(frame.palette, glow.distance);
            if let Some(media) = frame.media {
                left *= media.left((origin, ray.direction), glow.distance, tick);
            }
            left * glow.radiance * weight_of_path(by_path, asked * glow.density)
        };
        let lights = frame.pose.lights_at(tick);
        lights_passed(lights, asked_from, (origin, direction), far).map(weighed).sum()
    }

    /// Weight of light of a source that is asked with a probability of `chance`, and arrives in `direction`,
    /// where asking the source chooses that direction with this `density`.
    pub fn of_asked_light(self, chance: f32, normal: Vec3, direction: Vec3, density: f32) -> f32 {
        mis_weight(chance * density, self.goes_on * cosine_density(normal, direction))
    }

    /// Weight of the emission of `met`, a surface of a `primitive`, where a path finds it. It lies in this
    /// `direction` (unit length) at a `tick`, and at this `distance` from `asked_from`, on a surface with this `normal` of the
    /// model `receiver` that the path left.
    pub fn of_path_to_emitter(
        self,
        frame: &FrameView,
        (asked_from, normal, direction, tick, receiver): (Vec3, Vec3, Vec3, Tick, u32),
        (primitive, met): ((u32, u32), &Surface),
        distance: f32,
    ) -> f32 {
        let (emitter, _) = primitive;
        if !frame.sees_emission(receiver, emitter) {
            return 0.0;
        }
        if self.asks_emitter == 0.0 {
            return 1.0;
        }
        let by_path = self.goes_on * cosine_density(normal, direction);
        let normal = met.geometric_normal;
        let (scene, at, deformations) = (frame.scene, (frame.pose, tick), frame.deformations);
        let of_area = frame.emitters.density(scene, at, deformations, asked_from, primitive, normal);
        if of_area > 0.0 && frame.is_emission_shadow_linked(emitter) {
            return 0.0;
        }
        let cos = met.geometric_normal.dot(direction).abs();
        // both in solid angle times the cosine: on edge neither way is likely
        let (by_path, by_asking) = (by_path * cos, self.asks_emitter * of_area * distance * distance);
        weight_of_path(by_path, by_asking)
    }
}

/// Weight of light that a path finds. 1 where that light is never asked for.
fn weight_of_path(by_path: f32, by_asking: f32) -> f32 {
    if by_asking == 0.0 { 1.0 } else { mis_weight(by_path, by_asking) }
}

/// Density of directions by the cosine law about `normal`, in solid angle.
pub fn cosine_density(normal: Vec3, direction: Vec3) -> f32 {
    normal.dot(direction).max(0.0) * FRAC_1_PI
}
