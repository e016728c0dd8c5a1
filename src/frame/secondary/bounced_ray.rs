//! A ray beyond the first surface: its origin, and its weight in the picture.

use glam::Vec3;

use super::ways::Way;
use crate::frame::light::lighting::lights_passed;
use crate::frame::light::step::Step;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::links::OF_EYE;
use crate::frame::surface::radiance::Layer;
use crate::scene::RayKind;
use crate::shade::area::Glow;
use crate::shade::within::Within;

/// Least weight in the picture of a ray that is followed: half the step of an 8-bit picture at full
/// brightness. Rays that are below it in all three channels end.
pub const LEAST_WEIGHT: f32 = 1.0 / 512.0;

/// Event that a ray comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Reflected by a surface.
    Reflection,
    /// Passed through a surface.
    Refraction,
}

/// A ray to be cast.
#[derive(Debug, Clone, Copy)]
pub struct Bounce {
    /// Cell for which it is cast.
    pub cell: u32,
    /// Event that it comes from.
    pub kind: Kind,
    /// Kind of ray by what it comes from: as before through veils.
    pub ray_kind: RayKind,
    /// Model of the surface that it comes from, as before through veils, or [`OF_EYE`].
    pub receiver: u32,
    /// Layer of the first ray that left the sample.
    pub layer: Layer,
    /// Place of the surface that it will meet.
    pub step: Step,
    /// Kinds of the last 64 rays from the sample to this one, a bit each, the first one highest.
    pub path: u64,
    /// Weight of its light in its cell.
    pub weight: Vec3,
    /// Origin, world space.
    pub origin: Vec3,
    /// Direction, world space, unit length.
    pub direction: Vec3,
    /// What it goes through.
    pub within: Within,
    /// Width of its beam at the origin, world space: textures are filtered over it.
    pub width: f32,
    /// Growth of the width for each unit of length.
    pub spread: f32,
    /// True if denoisers see the normals of the surfaces that it meets.
    pub guides: bool,
    /// Its way over flat mirrors, if all on it were.
    pub way: Way,
}

impl Bounce {
    /// Creates a ray that leaves the sample of `cell`; step, origin and direction are still to be set.
    pub fn from_sample(cell: u32, kind: Kind) -> Self {
        let layer = match kind {
            Kind::Reflection => Layer::Reflection,
            Kind::Refraction => Layer::Refraction,
        };
        let (path, weight, [origin, direction]) = (kind as u64, Vec3::ONE, [Vec3::ZERO; 2]);
        let step = Step::first(0);
        Self {
            cell,
            kind,
            // that to the sample
            ray_kind: RayKind::Camera,
            receiver: OF_EYE,
            layer,
            step,
            path,
            weight,
            origin,
            direction,
            within: Within::NOTHING,
            width: 0.0,
            spread: 0.0,
            guides: false,
            way: Way::BENT,
        }
    }

    /// Width of its beam at a ray parameter, world space.
    #[inline(always)]
    pub fn beam_at(&self, t: f32) -> f32 {
        self.width + self.spread * t
    }

    /// Creates a ray that goes on from where this one meets a surface; step, origin, direction, kind of ray and receiver are
    /// still to be set.
    pub fn onwards(&self, kind: Kind) -> Self {
        Self { kind, path: self.path << 1 | kind as u64, ..*self }
    }

    /// Radiance of the area lights that it passes through within `far`.
    pub fn light_of_lights(&self, frame: &FrameView, far: f32) -> Vec3 {
        let lights = frame.pose.lights_at(frame.tick_of(self.cell));
        let passed = lights_passed(lights, self.origin, (self.origin, self.direction), far);
        let passed = passed.filter(|(light, ..)| frame.lights(*light, self.receiver));
        let left = |distance: f32| {
            let way = (self.origin, self.direction);
            frame.media.map_or(Vec3::ONE, |media| media.left(way, distance, frame.tick_of(self.cell)))
        };
        let shown =
            |glow: Glow| glow.radiance * self.within.left(frame.palette, glow.distance) * left(glow.distance);
        passed.map(|(_, glow, _)| shown(glow)).sum()
    }

    /// Returns true if a ray of this weight is visible in the picture.
    pub fn is_worth(&self, weight: Vec3) -> bool {
        weight.max_element() >= LEAST_WEIGHT
    }
}
