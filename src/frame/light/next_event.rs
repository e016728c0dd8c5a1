//! Next-event estimation: rays from surfaces towards strong light, the sky and emitting surfaces.
//!
//! Paths meet both by themselves, too. Light that is found in either way is weighted by the balance heuristic
//! (Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", 1995): by the
//! density of that way over the sum of both.
//!
//! Behind mirrors and glass nothing is asked: a path that goes on from there brings all that it meets. But
//! unless clear glass casts shadows ([`Caustics`](crate::settings::Caustics)), the rays that ask from before
//! it pass through it, and bring the light behind it undimmed. So light that a path meets behind clear glass
//! is weighted as if the glass were not there: by the densities with which the surface before it would have
//! chosen, and asked for, a straight way there. Both weights of a point that shines add up to one, wherever
//! glass bends the path: its light is a mean of the straight and the bent light, and never counts twice. (The
//! density of a rough layer is that of the direction in which the path left.)

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::lighting::lights_passed;
use super::path_ends::{PathResult, PathStart};
use crate::frame::grid::bits::bit;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::ray_tally::RayTally;
use crate::scene::LightFrom;
use crate::shade::Surface;
use crate::shade::area::Glow;
use crate::shade::coat::SeenCoat;
use crate::shade::emitters::{EmitterPlace, NotThere};
use crate::shade::surface::off_surface;
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// Probabilities of the ways that lead from a surface to light.
#[derive(Debug, Clone, Copy)]
pub struct Pdfs {
    /// Probability of asking the sky from there; the number of rays, where it is asked more than once.
    pub asks_sky: f32,
    /// Probability of asking an emitting surface from there.
    pub asks_emitter: f32,
    /// Probability of asking any one of the shot's lights from there; infinite where all of them are summed.
    pub asks_light: f32,
    /// Probability with which a path goes on from there by the cosine law.
    pub goes_on: f32,
}

impl Pdfs {
    /// Pdfs at a surface where its path alone finds light.
    pub const PATH_ALONE: Self = Self { asks_sky: 0.0, asks_emitter: 0.0, asks_light: 0.0, goes_on: 1.0 };

    /// Pdfs at a sample's surface, where paths start.
    pub fn of_start(frame: &FrameView) -> Self {
        let chance = |is_asked| if is_asked { 1.0 } else { 0.0 };
        Self {
            asks_sky: frame.sky.samples() as f32,
            asks_emitter: chance(frame.emitters.are_asked()),
            asks_light: f32::INFINITY,
            goes_on: 1.0,
        }
    }

    /// Weighted radiance of the sky for a path that leaves a surface with this `normal` in this `direction`.
    pub fn of_sky(self, frame: &FrameView, normal: Vec3, direction: Vec3) -> Vec3 {
        if self.asks_sky == 0.0 {
            return frame.sky.radiance(direction);
        }
        let light = frame.sky.light(direction);
        let by_path = self.goes_on * cosine_density(normal, direction);
        light.radiance * weight_of_path(by_path, self.asks_sky * light.pdf)
    }

    /// Returns true if all of the shot's lights are summed where the path left.
    pub fn lights_are_summed(self) -> bool {
        self.asks_light == f32::INFINITY
    }

    /// Weighted radiance of the area lights that a path passes through within `far` of `origin`. They are
    /// asked for from the point `asked_from` on a surface with this `normal`, from which the path has come
    /// straight or through clear glass.
    pub fn of_lights(
        self,
        frame: &FrameView,
        (asked_from, normal): (Vec3, Vec3),
        (origin, direction): (Vec3, Vec3),
        far: f32,
    ) -> Vec3 {
        let weighed = |(glow, direction): (Glow, Vec3)| {
            let by_path = self.goes_on * cosine_density(normal, direction);
            glow.radiance * weight_of_path(by_path, self.asks_light * glow.density)
        };
        lights_passed(&frame.pose.lights, asked_from, (origin, direction), far).map(weighed).sum()
    }

    /// Weight of light that was asked for and arrives in `direction`, where asking chooses that direction
    /// with this `density`.
    pub fn of_asked_light(self, normal: Vec3, direction: Vec3, density: f32) -> f32 {
        let by_asking = self.asks_light * density;
        by_asking / (by_asking + self.goes_on * cosine_density(normal, direction))
    }

    /// Weight of the emission of `met`, a surface of a `primitive`, where a path finds it. It lies in this
    /// `direction` (unit length) and at this `distance` from a surface with this `normal` that the path left.
    pub fn of_path_to_emitter(
        self,
        frame: &FrameView,
        (normal, direction): (Vec3, Vec3),
        (primitive, met): ((u32, u32), &Surface),
        distance: f32,
    ) -> f32 {
        if self.asks_emitter == 0.0 {
            return 1.0;
        }
        let by_path = self.goes_on * cosine_density(normal, direction);
        let normal = met.geometric_normal;
        let of_area = frame.emitters.density(frame.scene, frame.pose, frame.deformations, primitive, normal);
        let cos = met.geometric_normal.dot(direction).abs();
        // both in solid angle times the cosine: on edge neither way is likely
        let (by_path, by_asking) = (by_path * cos, self.asks_emitter * of_area * distance * distance);
        weight_of_path(by_path, by_asking)
    }
}

/// Balance heuristic: weight of light that a path finds. 1 where that light is never asked for.
fn weight_of_path(by_path: f32, by_asking: f32) -> f32 {
    if by_asking == 0.0 { 1.0 } else { by_path / (by_path + by_asking) }
}

/// Density of directions by the cosine law about `normal`, in solid angle.
fn cosine_density(normal: Vec3, direction: Vec3) -> f32 {
    normal.dot(direction).max(0.0) * FRAC_1_PI
}

/// A surface that asks for light.
#[derive(Debug, Clone, Copy)]
pub struct Asking {
    /// Number of its path.
    pub path: u32,
    /// Point on the surface, world space.
    pub point: Vec3,
    /// Shading normal.
    pub normal: Vec3,
    /// Normal of the triangle.
    pub geometric_normal: Vec3,
    /// Weight, in the path's result, of the light that a white surface would reflect.
    pub weight: Vec3,
    /// Pdfs of the ways to light.
    pub chances: Pdfs,
    /// Rough layer that reflects beside the surface.
    pub coat: Option<AskingCoat>,
}

/// The rough layer of a surface that asks for light.
#[derive(Debug, Clone, Copy)]
pub struct AskingCoat {
    /// Layer as the path sees it.
    pub seen: SeenCoat,
    /// Weight, in the path's result, of the light that the layer reflects.
    pub weight: Vec3,
    /// Probability with which the path goes on off the layer.
    pub goes_on: f32,
}

impl AskingCoat {
    /// Factor from light of unit radiance from `direction` to the path's result, by the balance heuristic.
    /// `by_asking` is the density with which that direction was asked for; `measure` converts a density in
    /// solid angle into one of that kind.
    fn reflects(&self, direction: Vec3, by_asking: f32, measure: f32) -> Vec3 {
        let (reflected, density) = self.seen.towards(direction);
        self.weight * reflected * (measure / (by_asking + self.goes_on * density * measure))
    }
}

/// A ray, and the light that it brings if nothing is in its way.
#[derive(Debug, Clone, Copy)]
struct LightRay {
    path: u32,
    origin: Vec3,
    /// Direction to the light, which is at `far` along it.
    direction: Vec3,
    far: f32,
    brings: PathEnd,
}

/// Light that a ray brings to its path.
#[derive(Debug, Clone, Copy)]
enum PathEnd {
    Light(Vec3),
    /// Light of the sky in that direction. The map is looked up only for rays that reach it: indoors these
    /// are few.
    Sky(OfSky),
}

/// Weights of the sky's light that a ray brings.
#[derive(Debug, Clone, Copy)]
struct OfSky {
    /// Weight of the light that a white surface would reflect.
    weight: Vec3,
    /// Density of the ray's direction by the cosine law.
    by_cosine: f32,
    /// Chance of asking the sky, as in [`Pdfs`].
    asks_sky: f32,
    goes_on: f32,
}

impl OfSky {
    fn light(self, LightFrom { radiance, pdf }: LightFrom) -> Vec3 {
        // by rounding, a direction may lie where none are chosen
        if pdf <= 0.0 {
            return Vec3::ZERO;
        }
        self.weight * radiance * (self.by_cosine / (self.asks_sky * pdf + self.goes_on * self.by_cosine))
    }
}

/// Queue of rays to be cast.
#[derive(Debug, Default)]
pub struct LightRays {
    waiting: Vec<LightRay>,
    rays: RayBatch,
    by_still: Vec<u16>,
    blocked: Vec<u16>,
}

impl LightRays {
    /// Adds a ray to the sky if it leaves the surface; two `random` numbers choose its direction.
    pub fn ask_sky(&mut self, frame: &FrameView, asking: &Asking, random: [f32; 2]) {
        let Asking { path, point, normal, geometric_normal, weight, chances, coat } = *asking;
        let direction = frame.sky.sample(random);
        let by_cosine = cosine_density(normal, direction);
        let leads = by_cosine > 0.0 || coat.is_some();
        if !leads || geometric_normal.dot(direction) <= 0.0 {
            return;
        }
        let Pdfs { asks_sky, goes_on, .. } = chances;
        let of_sky = OfSky { weight, by_cosine, asks_sky, goes_on };
        let mut brings = PathEnd::Sky(of_sky);
        if let Some(coat) = coat {
            let light = frame.sky.light(direction);
            if light.pdf <= 0.0 {
                return;
            }
            let reflected = light.radiance * coat.reflects(direction, asks_sky * light.pdf, 1.0);
            brings = PathEnd::Light(of_sky.light(light) + reflected);
        }
        let origin = off_surface(point, geometric_normal);
        self.waiting.push(LightRay { path, origin, direction, far: f32::INFINITY, brings });
    }

    /// Adds a ray to a point that three `random` numbers choose on all emitting surfaces, if it leaves the
    /// surface. The result in `brought` becomes invalid when that point moves or appears.
    pub fn ask_emitter(
        &mut self,
        frame: &FrameView,
        asking: &Asking,
        random: [f32; 3],
        brought: &mut PathResult,
    ) {
        let Asking { path, point, normal, geometric_normal, weight, chances, coat } = *asking;
        let Some(chosen) = frame.emitters.choose(frame.scene, frame.pose, frame.deformations, random) else {
            return;
        };
        // the light of that point, be it none, depends on its model: on where that is, or will be when it
        // appears
        let (Ok(EmitterPlace { model, .. }) | Err(NotThere { model })) = chosen;
        brought.until = brought.until.min(frame.first_change_of(model));
        let Ok(place) = chosen else { return };
        let way = place.point - point;
        let squared = way.length_squared();
        let direction = way / squared.sqrt();
        let (by_cosine, cos) = (cosine_density(normal, direction), place.normal.dot(direction));
        // a NaN leads nowhere, nor does a triangle that has shrunk to nothing
        let leads = (by_cosine > 0.0 || coat.is_some())
            && geometric_normal.dot(direction) > 0.0
            && place.density > 0.0
            && cos != 0.0
            && squared.is_normal();
        if !leads {
            return;
        }
        let by_cosine_of_area = by_cosine * cos.abs() / squared;
        let densities = chances.asks_emitter * place.density + chances.goes_on * by_cosine_of_area;
        let mut light = weight * place.radiance * (by_cosine_of_area / densities);
        if let Some(coat) = coat {
            let (by_asking, measure) = (chances.asks_emitter * place.density, cos.abs() / squared);
            light += place.radiance * coat.reflects(direction, by_asking, measure);
        }
        let origin = off_surface(point, geometric_normal);
        let facing = if cos > 0.0 { -place.normal } else { place.normal };
        let direction = off_surface(place.point, facing) - origin;
        self.waiting.push(LightRay { path, origin, direction, far: 1.0, brings: PathEnd::Light(light) });
    }

    /// Casts the rays, and adds their light to the results in `brought` of the paths that began at `starts`.
    pub fn cast(
        &mut self,
        frame: &FrameView,
        starts: &[PathStart],
        brought: &mut [PathResult],
        tally: &mut RayTally,
    ) {
        let Self { waiting, rays, by_still, blocked } = self;
        if waiting.is_empty() {
            return;
        }
        rays.clear();
        for ray in &*waiting {
            rays.push(ray.origin, ray.direction, 0.0, ray.far);
            let counted = &mut tally.cells.shadow[starts[ray.path as usize].cell as usize];
            *counted = counted.saturating_add(1);
        }
        tally.counts.shadow += waiting.len() as u64;
        by_still.clear();
        by_still.resize(rays.packet_count(), 0);
        let ask = |by: Occluders, blocked: &mut [u16]| {
            frame.tracer.blocked(rays, by, Purpose::Shadow, Coherence::Incoherent, blocked);
        };
        ask(Occluders::Still, by_still);
        blocked.clone_from(by_still);
        ask(Occluders::Movable, blocked);
        for (number, ray) in waiting.drain(..).enumerate() {
            let brought = &mut brought[ray.path as usize];
            // a still occluder stays in the way, whatever else comes there or goes
            if !bit(by_still, number) {
                brought.until = frame.first_touch_before(ray.origin, ray.direction, ray.far, brought.until);
            }
            if !bit(blocked, number) {
                brought.radiance += match ray.brings {
                    PathEnd::Light(light) => light,
                    PathEnd::Sky(of_sky) => of_sky.light(frame.sky.light(ray.direction)),
                };
            }
        }
    }
}
