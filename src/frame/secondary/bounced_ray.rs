//! A ray beyond the first surface: its origin, and its weight in the picture.

use glam::Vec3;

use crate::frame::light::clamp::limited;
use crate::frame::light::lighting::lights_passed;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::Layer;
use crate::shade::area::Glow;
use crate::shade::mis::mis_weight;

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

/// Kind of light that a ray finds, as far as the [limit](FrameView::clamp) depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Directly seen light: there are mirrors and glass alone between the ray and the eye.
    Mirrors,
    /// Direct light on a rough surface that is seen in that way, which the ray has left.
    Rough,
    /// Indirect light: the ray has gone on from there.
    Beyond,
}

/// A ray to be cast.
#[derive(Debug, Clone, Copy)]
pub struct Bounce {
    /// Cell for which it is cast.
    pub cell: u32,
    /// Event that it comes from.
    pub kind: Kind,
    /// Layer of the first ray that left the sample.
    pub layer: Layer,
    /// Kinds of all rays from the sample to this one, a bit each, the first one highest.
    pub path: u64,
    /// Weight of its light in its cell.
    pub weight: Vec3,
    /// Number of rays that left the sample in its stead.
    pub shared: u32,
    /// Density, in solid angle, with which a rough surface chose the ray's direction. Area lights that the
    /// ray meets are shown by that surface as highlights, too, and both are weighted. The density is kept
    /// behind clear glass, if such lights shine through that.
    pub density: Option<f32>,
    /// Point from which that surface asks for light; world space.
    pub asked_from: Vec3,
    /// True if the sky was asked from that surface, too.
    pub asked_sky: bool,
    /// Origin, world space.
    pub origin: Vec3,
    /// Direction, world space, unit length.
    pub direction: Vec3,
    /// True if denoisers see the normals of the surfaces that it meets.
    pub guides: bool,
    /// Kind of light that it finds.
    pub way: Way,
}

impl Bounce {
    /// Creates a ray that leaves the sample of `cell`; origin and direction are still to be set.
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

    /// Creates a ray that goes on from where this one meets a `material`; origin and direction are still to
    /// be set.
    pub fn onwards(&self, frame: &FrameView, kind: Kind, material: u16) -> Self {
        let passes = kind == Kind::Refraction && frame.shines_through(material);
        let density = self.density.filter(|_| passes);
        let way = if self.way == Way::Mirrors { Way::Mirrors } else { Way::Beyond };
        Self { kind, path: self.path << 1 | kind as u64, density, asked_sky: false, way, ..*self }
    }

    /// Kind of light that a ray finds that leaves a rough surface in this one's stead.
    pub fn way_off_rough(&self) -> Way {
        if self.way == Way::Mirrors { Way::Rough } else { Way::Beyond }
    }

    /// Share in the cell of `light`, that of lights or of the sky, which the ray has met.
    pub fn shows(&self, frame: &FrameView, light: Vec3) -> Vec3 {
        self.limited(frame, self.weight * light)
    }

    /// Share in the cell of `light` that a surface has sent; `emission` is the part that it emits.
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

    /// Limits `light`, which is weighted for the cell already, if the ray finds indirect light.
    pub fn limited(&self, frame: &FrameView, light: Vec3) -> Vec3 {
        match frame.clamp {
            Some(most) if self.way == Way::Beyond => limited(light, self.most(most)),
            _ => light,
        }
    }

    /// Radiance of the sky in its direction, weighted by the balance heuristic.
    pub fn light_of_sky(&self, frame: &FrameView) -> Vec3 {
        match self.density.filter(|_| self.asked_sky) {
            Some(density) => {
                let light = frame.sky.light(self.direction);
                light.radiance * mis_weight(density, light.pdf)
            }
            None => frame.sky.radiance(self.direction),
        }
    }

    /// Radiance of the area lights that it passes through within `far`, weighted by the balance heuristic.
    pub fn light_of_lights(&self, frame: &FrameView, far: f32) -> Vec3 {
        let asked_from = self.density.map_or(self.origin, |_| self.asked_from);
        let passed = lights_passed(&frame.pose.lights, asked_from, (self.origin, self.direction), far);
        passed.map(|(glow, _)| glow.radiance * self.weight_of_light(&glow)).sum()
    }

    /// Weight of a light that it passes through.
    fn weight_of_light(&self, glow: &Glow) -> f32 {
        let Some(density) = self.density else { return 1.0 };
        mis_weight(density * self.shared as f32, glow.density * glow.points as f32)
    }

    /// Its share of the limit for one ray that stands for all that left the sample.
    fn most(&self, most: f32) -> f32 {
        most / self.shared as f32
    }

    /// Returns true if a ray of this weight is visible in the picture.
    pub fn is_worth(&self, weight: Vec3) -> bool {
        (weight * self.shared as f32).max_element() >= LEAST_WEIGHT
    }
}
