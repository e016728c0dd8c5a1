//! Paths by which rough layers reflect: where they lead, and what an eye sees of what they bring.
//!
//! A path is drawn for one direction to the eye, by the layer's lobe as that eye sees it. The light that it
//! brings does not depend on the eye, so that it serves other eyes, too: the reflectance towards them over the
//! density with which the path was drawn is its weight. The estimate is unbiased for every eye, as long as
//! which paths are kept depends on neither their directions nor what they brought.
//!
//! Beside each path the layer asks one light source: the sky or an emitting surface, where these are worth
//! asking. Of that, what is kept is the answer whether it is in sight. What both find is weighted by the
//! balance heuristic with the densities with which they were drawn. The shot's lights are asked by the
//! sample's shadow rays; those that have a size are met by paths as well, and both are weighted in the same
//! way.

use std::f32::consts::PI;

use glam::Vec3;

use super::light_choice::free_sets;
use super::path_ends::{DrawnLayer, PathStart};
use super::pdfs::{LightsAsked, Pdfs};
use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::scene::{LightFrom, RayKind, SkyDensity};
use crate::shade::bsdf::SeenBsdf;
use crate::shade::emitters::{EmitterPlace, NotThere};
use crate::shade::light_chances::Sent;
use crate::shade::sampling::PathRandom;
use crate::shade::surface::off_surface;
use crate::trace::Purpose;

/// Least albedo of a layer of which reflected paths are drawn: half the step of an 8-bit picture, of light 32 times as bright as white.
pub const LEAST_ALBEDO: f32 = 1.0 / 16384.0;

/// Number of paths that a sample draws for what is rough: in proportion to the layer's albedo, so that a weak
/// reflection costs less than a strong one and has no more noise.
pub fn paths_of_layer(frame: &FrameView, seen: &SeenBsdf) -> u32 {
    let share = seen.albedo.max_element().clamp(0.0, 1.0);
    if frame.settings.depth == 0 || share < LEAST_ALBEDO {
        0
    } else {
        (frame.settings.reflections as f32 * share).ceil() as u32
    }
}

/// A light source that a layer asks.
#[derive(Debug, Clone, Copy)]
pub struct AskedLight {
    /// Direction to it, unit length.
    pub direction: Vec3,
    /// The point that is asked, just before its surface; world space. None for the sky.
    pub place: Option<Vec3>,
    /// Who blocks the way there.
    pub purpose: Purpose,
    /// Its radiance over the densities of both ways that lead there.
    light: Vec3,
}

impl DrawnLayer {
    /// Direction of a path, and the density with which it was drawn; None if it leads into the surface.
    pub fn direction(&self, start: &PathStart, [along, above]: [f32; 2]) -> Option<(Vec3, f32)> {
        let reflected = self.seen.reflect([along, above])?;
        let density = reflected.density.filter(|_| start.leaves(reflected.direction))?;
        Some((reflected.direction, density))
    }

    /// Pdfs of the ways to light for a path that was drawn with this density. The path takes its direction for
    /// its normal.
    pub fn chances(&self, frame: &FrameView, density: f32) -> Pdfs {
        let chance = chance_of_asking(frame);
        let of = |is_asked| if is_asked { chance } else { 0.0 };
        Pdfs {
            asks_sky: of(frame.sky.is_uneven()),
            sky: SkyDensity::Peaks,
            asks_emitter: of(frame.emitters.are_asked()),
            lights: LightsAsked::ByAllPoints { share: 1.0 / self.paths as f32 },
            goes_on: density * PI,
        }
    }

    /// Light source that is asked beside a path with these random numbers, if there is any, and the first
    /// frame in which there may be another.
    pub fn asks(
        &self,
        frame: &FrameView,
        start: &PathStart,
        random: PathRandom,
    ) -> (Option<AskedLight>, Until) {
        let [_, _, across, up] = random.four(0);
        match [frame.sky.is_uneven(), frame.emitters.are_asked()] {
            [false, false] => (None, Until::FOREVER),
            [true, false] => (self.asks_sky(frame, start, [across, up]), Until::FOREVER),
            [asks_sky, true] => {
                let [choice, along, above, triangle] = random.four(free_sets(frame));
                if asks_sky && choice < 0.5 {
                    return (self.asks_sky(frame, start, [across, up]), Until::FOREVER);
                }
                self.asks_emitter(frame, start, [triangle, along, above])
            }
        }
    }

    fn asks_sky(&self, frame: &FrameView, start: &PathStart, random: [f32; 2]) -> Option<AskedLight> {
        let direction = frame.sky.sample(SkyDensity::Peaks, random);
        if !start.leaves(direction) {
            return None;
        }
        let LightFrom { radiance, pdf } = frame.sky.light(SkyDensity::Peaks, direction);
        // by rounding, a direction may lie where none are chosen
        let light = radiance / (chance_of_asking(frame) * pdf + self.seen.density(direction));
        (pdf > 0.0).then_some(AskedLight { direction, place: None, purpose: Purpose::Shadow, light })
    }

    fn asks_emitter(
        &self,
        frame: &FrameView,
        start: &PathStart,
        random: [f32; 3],
    ) -> (Option<AskedLight>, Until) {
        let (scene, deformations) = (frame.scene, frame.deformations);
        let at = (frame.pose, frame.tick_of(start.cell));
        let asked_from = (start.point, &mut Sent::default());
        let Some(chosen) = frame.emitters.choose(scene, at, deformations, asked_from, random) else {
            return (None, Until::FOREVER);
        };
        // the light of that point, be it none, depends on its model: on where that is, or will be when it
        // appears
        let (Ok(EmitterPlace { model, .. }) | Err(NotThere { model })) = chosen;
        let is_seen =
            |model| !frame.is_hidden_from(model, RayKind::Glossy) && frame.sees_emission(start.model, model);
        let place = chosen.ok().filter(|_| is_seen(model));
        let asked = place.and_then(|place| self.asks_place(frame, start, &place));
        (asked, frame.first_change_of(model))
    }

    fn asks_place(&self, frame: &FrameView, start: &PathStart, place: &EmitterPlace) -> Option<AskedLight> {
        let segment = place.point - start.point;
        let squared = segment.length_squared();
        let direction = segment / squared.sqrt();
        let cos = place.normal.dot(direction);
        // a NaN leads nowhere, nor does a triangle that has shrunk to nothing
        if !(start.leaves(direction) && place.density > 0.0 && cos != 0.0 && squared.is_normal()) {
            return None;
        }
        // from a density by area to one by solid angle
        let by_asking = chance_of_asking(frame) * place.density * (squared / cos.abs());
        // what is asked alone is not met by paths
        let is_met = !frame.is_emission_shadow_linked(place.model);
        let by_path = if is_met { self.seen.density(direction) } else { 0.0 };
        let light = place.radiance / (by_asking + by_path);
        let facing = if cos > 0.0 { -place.normal } else { place.normal };
        let purpose = frame.shadows_of_emission(place.model);
        Some(AskedLight { direction, place: Some(off_surface(place.point, facing)), purpose, light })
    }

    /// Light that an eye sees of path number `index`, which has brought this `radiance`. `seen`: the layer as
    /// this eye sees it. `sees_light`: the light source that is asked is in sight.
    pub fn shows(
        &self,
        frame: &FrameView,
        start: &PathStart,
        index: u32,
        seen: &SeenBsdf,
        (radiance, sees_light): (Vec3, bool),
    ) -> Vec3 {
        let random = start.sequence.path(index);
        let mut light = Vec3::ZERO;
        if radiance != Vec3::ZERO {
            let [along, above, ..] = random.four(0);
            if let Some((direction, density)) = self.direction(start, [along, above]) {
                light += seen.towards(direction).0 * radiance / density;
            }
        }
        if sees_light {
            if let (Some(asked), _) = self.asks(frame, start, random) {
                let left = frame.media.map_or(Vec3::ONE, |media| {
                    let origin = start.origin(asked.direction);
                    let (segment, far) = match asked.place {
                        Some(place) => (place - origin, 1.0),
                        None => (asked.direction, f32::INFINITY),
                    };
                    media.left((origin, segment), far, frame.tick_of(start.cell))
                });
                light += seen.towards(asked.direction).0 * asked.light * left;
            }
        }
        let light = light / self.paths as f32;
        // densities of directions on edge are next to nothing
        if light.is_finite() { light } else { Vec3::ZERO }
    }
}

/// Chance with which a layer asks the sky, or an emitting surface, where it asks that at all.
fn chance_of_asking(frame: &FrameView) -> f32 {
    if frame.sky.is_uneven() && frame.emitters.are_asked() { 0.5 } else { 1.0 }
}
