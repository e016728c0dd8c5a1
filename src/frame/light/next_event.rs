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

use glam::Vec3;

use super::layer_paths::AskedLight;
use super::path_ends::{DrawnLayer, PathResult, PathStart};
use super::pdfs::{Pdfs, cosine_density};
use super::select::select;
use crate::exposure::Tick;
use crate::frame::grid::bits::bit;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::ray_tally::RayTally;
use crate::scene::{LightFrom, RayKind, SkyDensity};
use crate::shade::bsdf::SeenBsdf;
use crate::shade::emitters::{EmitterPlace, NotThere};
use crate::shade::horizon::Horizon;
use crate::shade::light_chances::Sent;
use crate::shade::sampling::PathRandom;
use crate::shade::surface::off_surface;
use crate::trace::{Coherence, Occluders, Purpose, RayBatch};

/// A surface that asks for light.
#[derive(Debug, Clone, Copy)]
pub struct Asking<'a> {
    /// Number of its path.
    pub path: u32,
    /// Tick of the exposure at which it asks.
    pub tick: Tick,
    /// Model of the surface.
    pub model: u32,
    /// Point on the surface, world space.
    pub point: Vec3,
    /// Shading normal.
    pub normal: Vec3,
    /// The point off the surface.
    pub origin: Vec3,
    /// Normal of the triangle.
    pub geometric_normal: Vec3,
    /// The curved surface that it stands for.
    pub horizon: Horizon,
    /// Weight, in the path's result, of the light that a white surface would reflect.
    pub weight: Vec3,
    /// Pdfs of the ways to light.
    pub chances: Pdfs,
    /// Rough layer that reflects beside the surface.
    pub bsdf: Option<AskingBsdf<'a>>,
}

/// The rough layer of a surface that asks for light.
#[derive(Debug, Clone, Copy)]
pub struct AskingBsdf<'a> {
    /// Layer as the path sees it.
    pub seen: &'a SeenBsdf,
    /// Weight, in the path's result, of the light that the layer reflects.
    pub weight: Vec3,
    /// Probability with which the path goes on off the layer.
    pub goes_on: f32,
}

impl AskingBsdf<'_> {
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
    /// Who blocks it.
    purpose: Purpose,
    brings: PathEnd,
}

/// Light that a ray brings to its path.
#[derive(Debug, Clone, Copy)]
enum PathEnd {
    Light(Vec3),
    /// Light of the sky in that direction. The map is looked up only for rays that reach it: indoors these
    /// are few.
    Sky(OfSky),
    /// The answer that the light source is in sight. What it brings depends on the eye.
    Sight,
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
    /// Density with which it is asked, likewise.
    density: SkyDensity,
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

impl Pdfs {
    /// Light of the sky that the start of a path by the cosine law would ask for, with two random numbers, if nothing were
    /// in the way.
    pub fn of_asked_sky(self, frame: &FrameView, start: &PathStart, random: [f32; 2]) -> Vec3 {
        let direction = frame.sky.sample(self.sky, random);
        let by_cosine = cosine_density(start.normal, direction);
        if !start.leaves(direction) || by_cosine <= 0.0 {
            return Vec3::ZERO;
        }
        let Self { asks_sky, sky: density, goes_on, .. } = self;
        let weight = Vec3::splat(start.horizon.fading(start.normal, direction));
        let of_sky = OfSky { weight, by_cosine, asks_sky, density, goes_on };
        of_sky.light(frame.sky.light(density, direction))
    }
}

/// Queue of rays to be cast.
#[derive(Debug, Default)]
pub struct LightRays {
    waiting: Vec<LightRay>,
    /// What emitting surfaces may send to the surface that has asked last.
    sent: Sent,
    rays: RayBatch,
    by_still: Vec<u16>,
    blocked: Vec<u16>,
    /// Numbers of the rays that nothing still blocks.
    open: Vec<u32>,
}

impl LightRays {
    /// Begins with other paths, maybe of another scene.
    pub fn begin(&mut self) {
        self.sent = Sent::NOWHERE;
    }

    /// Adds a ray from a place along `segment`, at `far` of which there is the light that it brings; `purpose`: what may hide that light.
    pub fn ask(
        &mut self,
        path: u32,
        (origin, segment): (Vec3, Vec3),
        (far, purpose): (f32, Purpose),
        light: Vec3,
    ) {
        let brings = PathEnd::Light(light);
        self.waiting.push(LightRay { path, origin, direction: segment, far, purpose, brings });
    }

    /// Adds a ray to the sky if it leaves the surface; two `random` numbers choose its direction.
    pub fn ask_sky(&mut self, frame: &FrameView, asking: &Asking<'_>, random: [f32; 2]) {
        let Asking { path, origin, normal, geometric_normal, horizon, weight, chances, bsdf, .. } = *asking;
        let direction = frame.sky.sample(chances.sky, random);
        let by_cosine = cosine_density(normal, direction);
        let leaves = horizon.is_below(direction, geometric_normal);
        let weight = weight * horizon.fading(normal, direction);
        let Pdfs { asks_sky, sky, goes_on, .. } = chances;
        let of_sky = OfSky { weight, by_cosine, asks_sky, density: sky, goes_on };
        let origin = horizon.origin(origin, direction, geometric_normal);
        let (far, purpose) = (f32::INFINITY, Purpose::Shadow);
        let ray = |brings| LightRay { path, origin, direction, far, purpose, brings };
        let Some(bsdf) = bsdf else {
            // half of them lead nowhere, and no processor foresees which: the ray is added in any case, and taken away again
            let count = self.waiting.len() + usize::from(leaves & (by_cosine > 0.0));
            self.waiting.push(ray(PathEnd::Sky(of_sky)));
            self.waiting.truncate(count);
            return;
        };
        let light = if leaves { frame.sky.light(sky, direction) } else { LightFrom::NONE };
        if light.pdf > 0.0 {
            let reflected = light.radiance * bsdf.reflects(direction, asks_sky * light.pdf, 1.0);
            self.waiting.push(ray(PathEnd::Light(of_sky.light(light) + reflected)));
        }
    }

    /// Adds a ray to a point that three `random` numbers choose on all emitting surfaces, if it leaves the
    /// surface. The result in `brought` becomes invalid when that point moves or appears.
    pub fn ask_emitter(
        &mut self,
        frame: &FrameView,
        asking: &Asking<'_>,
        random: [f32; 3],
        brought: &mut PathResult,
    ) {
        let Asking {
            path, tick, model: receiver, point, origin, normal, horizon, weight, chances, bsdf, ..
        } = *asking;
        let geometric_normal = asking.geometric_normal;
        let (scene, at, deformations) = (frame.scene, (frame.pose, tick), frame.deformations);
        let Some(chosen) = frame.emitters.choose(scene, at, deformations, (point, &mut self.sent), random)
        else {
            return;
        };
        // the light of that point, be it none, depends on its model: on where that is, or will be when it
        // appears
        let (Ok(EmitterPlace { model, .. }) | Err(NotThere { model })) = chosen;
        brought.until = brought.until.min(frame.first_change_of(model));
        let Ok(place) = chosen else { return };
        if !frame.sees_emission(receiver, model) {
            return;
        }
        // what is asked alone is not met by paths
        let is_met = !frame.is_emission_shadow_linked(model);
        let met = |chance: f32| if is_met { chance } else { 0.0 };
        let bsdf = bsdf.map(|bsdf| AskingBsdf { goes_on: met(bsdf.goes_on), ..bsdf });
        let bsdf = bsdf.filter(|_| !frame.is_hidden_from(model, RayKind::Glossy));
        let to_place = place.point - point;
        let squared = to_place.length_squared();
        let direction = to_place / squared.sqrt();
        let (by_cosine, cos) = (cosine_density(normal, direction), place.normal.dot(direction));
        // a NaN leads nowhere, nor does a triangle that has shrunk to nothing
        let leads = (by_cosine > 0.0 || bsdf.is_some())
            && horizon.is_below(direction, geometric_normal)
            && place.density > 0.0
            && cos != 0.0
            && squared.is_normal();
        if !leads {
            return;
        }
        let by_cosine_of_area = by_cosine * cos.abs() / squared;
        let densities = chances.asks_emitter * place.density + met(chances.goes_on) * by_cosine_of_area;
        let shown = by_cosine_of_area * horizon.fading(normal, direction);
        let mut light = weight * place.radiance * (shown / densities);
        if let Some(bsdf) = bsdf {
            let (by_asking, measure) = (chances.asks_emitter * place.density, cos.abs() / squared);
            light += place.radiance * bsdf.reflects(direction, by_asking, measure);
        }
        let origin = horizon.origin(origin, direction, geometric_normal);
        let facing = if cos > 0.0 { -place.normal } else { place.normal };
        let direction = off_surface(place.point, facing) - origin;
        let (far, purpose) = (1.0, frame.shadows_of_emission(model));
        self.waiting.push(LightRay { path, origin, direction, far, purpose, brings: PathEnd::Light(light) });
    }

    /// Adds a ray from the start of a reflected path to the light source that its layer asks, if there is one.
    /// The result in `brought` becomes invalid when that moves or appears.
    pub fn ask_for_layer(
        &mut self,
        frame: &FrameView,
        path: u32,
        (start, random): (&PathStart, PathRandom),
        layer: &DrawnLayer,
        brought: &mut PathResult,
    ) {
        let (asked, until) = layer.asks(frame, start, random);
        brought.until = brought.until.min(until);
        let Some(AskedLight { direction, place, purpose, .. }) = asked else { return };
        let origin = start.origin(direction);
        let (direction, far) = match place {
            Some(place) => (place - origin, 1.0),
            None => (direction, f32::INFINITY),
        };
        self.waiting.push(LightRay { path, origin, direction, far, purpose, brings: PathEnd::Sight });
    }

    /// Casts the rays, and adds their light to the results in `brought` of the paths that began at `starts`.
    pub fn cast(
        &mut self,
        frame: &FrameView,
        starts: &[PathStart],
        brought: &mut [PathResult],
        tally: &mut RayTally,
    ) {
        let Self { waiting, rays, by_still, blocked, open, .. } = self;
        // those that the same models block go together
        if frame.has_shadow_links() {
            waiting.sort_by_key(|ray| ray.purpose.blockers().number());
        }
        for waiting in waiting.chunk_by(|one, other| one.purpose == other.purpose) {
            rays.clear();
            for ray in waiting {
                rays.push(ray.origin, ray.direction, 0.0, ray.far);
                let counted = &mut tally.cells.shadow[starts[ray.path as usize].cell as usize];
                *counted = counted.saturating_add(1);
            }
            frame.set_ticks(rays, waiting.iter().map(|ray| starts[ray.path as usize].cell));
            tally.counts.shadow += waiting.len() as u64;
            by_still.clear();
            by_still.resize(rays.packet_count(), 0);
            let ask = |by: Occluders, blocked: &mut [u16]| {
                frame.tracer.blocked(rays, by, waiting[0].purpose, Coherence::Incoherent, blocked);
            };
            ask(Occluders::Still, by_still);
            blocked.clone_from(by_still);
            ask(Occluders::Movable, blocked);
            // a still occluder stays in the way, whatever else comes there or goes
            select(open, waiting.len(), |number| !bit(by_still, number));
            for number in open.iter().map(|number| *number as usize) {
                let ray = &waiting[number];
                let brought = &mut brought[ray.path as usize];
                brought.until = frame.first_touch_before(ray.origin, ray.direction, ray.far, brought.until);
                if !bit(blocked, number) {
                    let left = frame.media.map_or(Vec3::ONE, |media| {
                        let tick = frame.tick_of(starts[ray.path as usize].cell);
                        media.left((ray.origin, ray.direction), ray.far, tick)
                    });
                    match ray.brings {
                        PathEnd::Light(light) => brought.radiance += light * left,
                        PathEnd::Sky(of_sky) => {
                            brought.radiance +=
                                of_sky.light(frame.sky.light(of_sky.density, ray.direction)) * left;
                        }
                        PathEnd::Sight => brought.sees_light = true,
                    }
                }
            }
        }
        waiting.clear();
    }
}
