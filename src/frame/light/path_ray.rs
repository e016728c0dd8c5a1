//! A ray of a light path, and the weights of the light that it meets.

use glam::Vec3;

use super::pdfs::Pdfs;
use super::step::Step;
use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::scene::RayKind;
use crate::shade::Surface;
use crate::shade::bsdf::SeenBy;
use crate::shade::within::Within;

/// How often a path has been in media.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct InMedia {
    /// Places at which it was scattered.
    pub scatterings: u8,
    /// Rays on which it might have been: each has random numbers of its own.
    pub asked: u8,
}

impl InMedia {
    /// Sets of random numbers for a ray.
    pub fn sets(self) -> u32 {
        4 * u32::from(self.asked)
    }
}

/// A ray of a path.
#[derive(Debug, Clone, Copy)]
pub struct PathRay {
    /// Number of its path in the batch.
    pub path: u32,
    /// Tick of the exposure at which it meets what moves.
    pub tick: Tick,
    /// Place of the surface that it will meet.
    pub step: Step,
    /// Weight of its light in the path's result.
    pub weight: Vec3,
    /// Origin, world space.
    pub origin: Vec3,
    /// Direction, world space, unit length.
    pub direction: Vec3,
    /// Point from which the light that it meets is asked for: its origin, unless it has gone through clear
    /// glass since.
    pub asked_from: Vec3,
    /// Shading normal at that point; the direction in which the ray left, where a rough layer reflected it.
    pub normal: Vec3,
    /// Pdfs of the ways from that point to light.
    pub chances: Pdfs,
    /// Kind of ray as which it sees the layers of surfaces.
    pub seen_by: SeenBy,
    /// Kind of ray by what it comes from.
    pub kind: RayKind,
    /// Model of the surface from which the light that it meets is asked for.
    pub receiver: u32,
    /// What it goes through.
    pub within: Within,
    /// How often its path has been in media.
    pub media: InMedia,
}

impl PathRay {
    /// Light of the sky that it brings to the path's result.
    pub fn light_of_sky(&self, frame: &FrameView) -> Vec3 {
        self.weight * self.chances.of_sky(frame, self.normal, self.direction)
    }

    /// Light that it brings of the area lights that it passes through within `far`.
    pub fn light_of_lights(&self, frame: &FrameView, far: f32) -> Vec3 {
        let Self { asked_from, normal, .. } = *self;
        self.weight * self.chances.of_lights(frame, (asked_from, normal), self, far)
    }

    /// Weight of the emission of `surface`, of a `primitive`, which the ray has met at this distance.
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
            let offset = surface.point - self.asked_from;
            (offset.normalize_or(self.direction), offset.length())
        };
        self.chances.of_path_to_emitter(
            frame,
            (self.asked_from, self.normal, direction, self.tick, self.receiver),
            (primitive, surface),
            distance,
        )
    }
}
