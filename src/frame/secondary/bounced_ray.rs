//! A ray beyond the first surface: how it came about, and what it stands for.

use glam::Vec3;

use crate::frame::light::clamp::limited;
use crate::frame::light::lighting::lights_passed;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::Layer;
use crate::shade::area::Glow;

/// A ray whose share in the picture is below this in all three colours is not followed: half the step of
/// an 8-bit picture at full brightness.
pub const LEAST_WEIGHT: f32 = 1.0 / 512.0;

/// How a ray came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Bounced off.
    Reflection,
    /// Gone through.
    Refraction,
}

/// Which light a ray finds, as far as a [limit](FrameView::clamp) asks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// There are mirrors and glass alone between it and the eye: what it meets is seen.
    Mirrors,
    /// It has left a rough surface that is seen in that way: the light that it meets shines on that directly.
    Rough,
    /// It has gone on from there: all that it finds comes indirectly.
    Beyond,
}

/// A ray on its way.
#[derive(Debug, Clone, Copy)]
pub struct Bounce {
    /// For which it is cast.
    pub cell: u32,
    /// Of the ray itself.
    pub kind: Kind,
    /// That of the first ray that left the sample.
    pub layer: Layer,
    /// The kinds of all rays from the sample to this one, a bit each, the first one highest.
    pub path: u64,
    /// Of what it brings, in what its cell shows.
    pub weight: Vec3,
    /// How many rays left the sample in its stead.
    pub shared: u32,
    /// The density with which a rough surface chose its direction, in solid angle: what it sees of a light that has a size, the
    /// surface shows by a highlight, too. It stays as it is behind clear glass, if such a light shines through
    /// that.
    pub density: Option<f32>,
    /// The place from where that surface asks; world space.
    pub asked_from: Vec3,
    /// Whether the sky was asked from that surface, too.
    pub asked_sky: bool,
    /// World space.
    pub origin: Vec3,
    /// World space, unit length.
    pub direction: Vec3,
    /// Whether denoisers are told of the normals of what it meets.
    pub guides: bool,
    /// Since the eye.
    pub way: Way,
}

impl Bounce {
    /// A ray that leaves the sample of `cell`, where to is not yet said.
    pub fn from_sample(cell: u32, kind: Kind) -> Self {
        let layer = match kind {
            Kind::Reflection => Layer::Reflection,
            Kind::Refraction => Layer::Refraction,
        };
        let (path, weight) = (kind as u64, Vec3::ONE);
        let [asked_from, origin, direction] = [Vec3::ZERO; 3];
        let (shared, density, asked_sky, guides, way) = (1, None, false, false, Way::Mirrors);
        Self {
            cell,
            kind,
            layer,
            path,
            weight,
            shared,
            density,
            asked_from,
            asked_sky,
            origin,
            direction,
            guides,
            way,
        }
    }

    /// A ray that goes on from where this one meets a `material`, where to is not yet said.
    pub fn onwards(&self, frame: &FrameView, kind: Kind, material: u16) -> Self {
        let passes = kind == Kind::Refraction && frame.shines_through(material);
        let density = self.density.filter(|_| passes);
        let way = if self.way == Way::Mirrors { Way::Mirrors } else { Way::Beyond };
        Self { kind, path: self.path << 1 | kind as u64, density, asked_sky: false, way, ..*self }
    }

    /// Which light a ray finds that leaves a rough surface in its stead.
    pub fn way_off_rough(&self) -> Way {
        if self.way == Way::Mirrors { Way::Rough } else { Way::Beyond }
    }

    /// What the cell shows of `light`, which the ray has met: lights, the sky.
    pub fn shows(&self, frame: &FrameView, light: Vec3) -> Vec3 {
        self.limited(frame, self.weight * light)
    }

    /// The same of `light` that a surface has sent, of which it emits `emission`.
    pub fn shows_surface(&self, frame: &FrameView, light: Vec3, emission: Vec3) -> Vec3 {
        match frame.clamp {
            Some(most) if self.way == Way::Rough => {
                let shown = self.weight * light;
                let reflected = (self.weight * (light - emission)).max(Vec3::ZERO);
                shown - (reflected - limited(reflected, self.most(most)))
            }
            _ => self.shows(frame, light),
        }
    }

    /// Of `light` in the cell, what it shows of it where the ray has found that.
    pub fn limited(&self, frame: &FrameView, light: Vec3) -> Vec3 {
        match frame.clamp {
            Some(most) if self.way == Way::Beyond => limited(light, self.most(most)),
            _ => light,
        }
    }

    /// What it brings of the sky where it finds that, weighed by the balance heuristic.
    pub fn light_of_sky(&self, frame: &FrameView) -> Vec3 {
        match self.density.filter(|_| self.asked_sky) {
            Some(density) => {
                let light = frame.sky.light(self.direction);
                light.radiance * (density / (density + light.pdf))
            }
            None => frame.sky.radiance(self.direction),
        }
    }

    /// What it brings of the lights that it passes through before it is so `far`.
    pub fn light_of_lights(&self, frame: &FrameView, far: f32) -> Vec3 {
        let asked_from = self.density.map_or(self.origin, |_| self.asked_from);
        let passed = lights_passed(&frame.pose.lights, asked_from, (self.origin, self.direction), far);
        passed.map(|(glow, _)| glow.radiance * self.weight_of_light(&glow)).sum()
    }

    /// The weight of a light that it passes through.
    fn weight_of_light(&self, glow: &Glow) -> f32 {
        let Some(density) = self.density else { return 1.0 };
        let by_rays = density * self.shared as f32;
        by_rays / (by_rays + glow.density * glow.points as f32)
    }

    /// Its share of what is allowed where one ray stands for all that left the sample.
    fn most(&self, most: f32) -> f32 {
        most / self.shared as f32
    }

    /// Whether what it brings can be told from nothing.
    pub fn is_worth(&self, weight: Vec3) -> bool {
        (weight * self.shared as f32).max_element() >= LEAST_WEIGHT
    }
}
