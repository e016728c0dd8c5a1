//! A ray of a light path, and what it brings of the light that it meets.

use glam::Vec3;

use super::next_event::Chances;
use crate::frame::shot::frame_view::FrameView;
use crate::shade::Surface;

/// A ray of a path.
#[derive(Debug, Clone, Copy)]
pub struct PathRay {
    /// Number of its path in the batch.
    pub path: u32,
    /// Of what it brings, in what its path brings.
    pub weight: Vec3,
    /// World space.
    pub origin: Vec3,
    /// World space, unit length.
    pub direction: Vec3,
    /// From where the light that it meets is asked for: its origin, but for a ray that has gone through clear glass since.
    pub asked_from: Vec3,
    /// For shading, there; the direction in which it left where a rough layer reflected it.
    pub normal: Vec3,
    /// Of the ways from there to light.
    pub chances: Chances,
}

impl PathRay {
    /// What it brings of the sky.
    pub fn light_of_sky(&self, frame: &FrameView) -> Vec3 {
        self.weight * self.chances.of_sky(frame, self.normal, self.direction)
    }

    /// What it brings of the lights that it passes through before it is so `far`.
    pub fn light_of_lights(&self, frame: &FrameView, far: f32) -> Vec3 {
        let Self { asked_from, normal, origin, direction, .. } = *self;
        self.weight * self.chances.of_lights(frame, (asked_from, normal), (origin, direction), far)
    }

    /// The weight of what `surface` of a `primitive` emits, which the ray has met at this distance.
    pub fn emission_weight(
        &self,
        frame: &FrameView,
        primitive: (u32, u32),
        surface: &Surface,
        distance: f32,
    ) -> f32 {
        let (direction, distance) = if self.asked_from == self.origin {
            (self.direction, distance)
        } else {
            let way = surface.point - self.asked_from;
            (way.normalize_or(self.direction), way.length())
        };
        self.chances.of_path_to_emitter(frame, (self.normal, direction), (primitive, surface), distance)
    }
}
