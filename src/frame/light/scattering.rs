//! Light that media scatter: places on rays where it happens, the light that is asked for there, and how paths go on.
//!
//! On each of its rays a path is scattered, or goes straight on, by a chance that follows from the closed formulas of [`Spans`]. Where it is
//! scattered it asks for light as surfaces do, with the phase function in place of the cosine law: one of the shot's lights, the sky and an
//! emitting surface, each weighted against what the path itself may meet ([`next_event`](super::next_event)).
//!
//! What an eye sees of a medium begins with a place on the eye's ray. For the shot's lights that place is chosen in two ways: by the light
//! that comes from there to the eye, and for lights that are somewhere by the angle under which they see it (Kulla and Fajardo, "Importance
//! Sampling Techniques for Path Tracing in Participating Media", 2012); both are combined by the balance heuristic, with one sample.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use super::light_choice::Kinds;
use super::next_event::LightRays;
use super::path_ends::{PathResult, PathStart};
use super::path_ray::{InMedia, PathRay};
use super::pdfs::{LightsAsked, Pdfs};
use super::step::Step;
use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::links::OF_EYE;
use crate::lanes::{F32x8, Vec3x8};
use crate::media::spans::{Phase, Spans};
use crate::pose::LightSource;
use crate::scene::{RayKind, SkyDensity};
use crate::shade::area::density_of;
use crate::shade::bsdf::SeenBy;
use crate::shade::bsdf::mis::mis_weight;
use crate::shade::emitters::{EmitterPlace, NotThere};
use crate::shade::light::light_from_anywhere;
use crate::shade::light_chances::Sent;
use crate::shade::sampling::PathRandom;
use crate::shade::surface::off_surface;
use crate::shade::within::Within;
use crate::trace::Purpose;

/// Difference between the seeds of random numbers in media and of others.
const OF_MEDIA: u32 = 0x3c6e_f35f;

/// Weight below which a path may end at a place where it is scattered.
const LEAST_WEIGHT: f32 = 0.1;

/// Most likely scattering of a ray that may meet lights which have been asked for: what it brings of them counts for the rest.
const MOST_LIKELY: f32 = 0.9;

/// A ray of which is seen what media along it scatter.
#[derive(Debug, Clone, Copy)]
pub struct SeenRay {
    /// Origin, world space.
    pub origin: Vec3,
    /// Direction, unit length.
    pub direction: Vec3,
    /// Its end; infinite, if it meets nothing.
    pub far: f32,
    /// Weight of its light.
    pub weight: Vec3,
}

/// Place at which a path is scattered.
struct Scattered {
    path: u32,
    tick: Tick,
    point: Vec3,
    /// Direction in which the path has come.
    incoming: Vec3,
    weight: Vec3,
    step: Step,
    media: InMedia,
    /// False if the shot's lights are asked elsewhere.
    asks_lights: bool,
}

/// Decides whether a ray of a path is scattered in `spans`, which are those along it. If it is, the path asks for light there and goes on
/// by the ray that is returned, if it does; if not, the weight of `ray` grows in return.
pub fn on_way(
    frame: &FrameView,
    ray: &mut PathRay,
    (spans, may_meet_lights): (&Spans, bool),
    random: PathRandom,
    light_rays: &mut LightRays,
    brought: &mut PathResult,
) -> OnWay {
    let media = ray.media;
    if u32::from(media.scatterings) > frame.settings.volume_bounces || media.asked == u8::MAX {
        return OnWay::Straight;
    }
    let [scattered, straight] =
        [spans.scattered(), spans.left()].map(|left| (ray.weight * left).abs().element_sum());
    // a NaN is scattered nowhere
    if scattered.is_nan() || scattered <= 0.0 {
        return OnWay::Straight;
    }
    let most = if may_meet_lights { MOST_LIKELY } else { 1.0 };
    let chance = (scattered / (scattered + straight)).min(most);
    let random = random.apart(OF_MEDIA);
    let [choice, channel, along, _] = random.four(media.sets());
    let media = InMedia { asked: media.asked + 1, ..media };
    if choice >= chance {
        ray.weight /= 1.0 - chance;
        ray.media = media;
        return OnWay::Straight;
    }
    let Some((distance, weight)) = place(spans, ray.weight, [channel, along]) else {
        return OnWay::Scattered(None);
    };
    let Some(at) = spans.at(distance) else { return OnWay::Scattered(None) };
    let scattered = Scattered {
        path: ray.path,
        tick: ray.tick,
        point: ray.origin + ray.direction * distance,
        incoming: ray.direction,
        weight: weight / chance,
        step: ray.step,
        media,
        asks_lights: true,
    };
    let phase = spans.phase(&at);
    OnWay::Scattered(scatter(frame, &scattered, &phase, (random, ray.media.sets()), light_rays, brought))
}

/// What becomes of a ray in media.
pub enum OnWay {
    /// It goes straight on.
    Straight,
    /// It ends, and the path goes on from there, if it does.
    Scattered(Option<PathRay>),
}

/// A distance that is chosen by what is scattered, and the weight of light from there.
fn place(spans: &Spans, weight: Vec3, random: [f32; 2]) -> Option<(f32, Vec3)> {
    let distance = spans.choose(weight, random)?;
    let (density, at) = (spans.density(weight, distance), spans.at(distance)?);
    (density > 0.0).then(|| (distance, weight * at.weight / density))
}

/// Asks for the light that media scatter towards the origin of a ray. Returns the first ray of a path that brings what is not asked for.
pub fn towards(
    frame: &FrameView,
    (path, start, seen): (u32, &PathStart, &SeenRay),
    spans: &Spans,
    random: PathRandom,
    (light_rays, brought): (&mut LightRays, &mut PathResult),
) -> Option<PathRay> {
    let random = random.apart(OF_MEDIA);
    let media = InMedia::default();
    let sets = media.sets();
    ask_lights(frame, (path, start, seen), spans, (random, sets), (light_rays, brought));
    if frame.paths == 0 {
        return None;
    }
    let [.., channel, along] = random.four(sets);
    let (distance, weight) = place(spans, seen.weight, [channel, along])?;
    let at = spans.at(distance)?;
    let scattered = Scattered {
        path,
        tick: frame.tick_of(start.cell),
        point: seen.origin + seen.direction * distance,
        incoming: seen.direction,
        weight,
        step: Step::first(frame.settings.bounces),
        media: InMedia { asked: 1, ..media },
        asks_lights: false,
    };
    scatter(frame, &scattered, &spans.phase(&at), (random, sets), light_rays, brought)
}

/// Asks one of the shot's lights for what it sends to the origin of a ray by way of media.
fn ask_lights(
    frame: &FrameView,
    (path, start, seen): (u32, &PathStart, &SeenRay),
    spans: &Spans,
    (random, sets): (PathRandom, u32),
    (light_rays, brought): (&mut LightRays, &mut PathResult),
) {
    let tick = frame.tick_of(start.cell);
    let lights = frame.pose.lights_at(tick);
    let Some([near, far]) = spans.range().filter(|_| !lights.is_empty()) else { return };
    let [light, aside, ..] = random.four(sets);
    let [way, along, above, channel] = random.four(sets + 1);
    // which one, follows from the middle of what scatters
    let Some(middle) = spans.choose(seen.weight, [0.5; 2]) else { return };
    let chosen = frame.light_chances.choose(seen.origin + seen.direction * middle, light);
    brought.until = brought.until.min(frame.light_changes[chosen.source]);
    if !frame.lights(chosen.source, OF_EYE) {
        return;
    }
    let light = &lights[chosen.source];
    let angles = match light.shape.source() {
        LightSource::Place(place) => Angles::new(seen, place, [near, far]),
        LightSource::Direction(_) => None,
    };
    let by_angle = if angles.is_some() { 0.5 } else { 0.0 };
    let distance = match &angles {
        Some(angles) if way < by_angle => angles.distance(aside),
        _ => match spans.choose(seen.weight, [channel, aside]) {
            Some(distance) => distance,
            None => return,
        },
    };
    let Some(at) = spans.at(distance) else { return };
    let density = (1.0 - by_angle) * spans.density(seen.weight, distance)
        + by_angle * angles.map_or(0.0, |angles| angles.density(distance));
    let point = seen.origin + seen.direction * distance;
    let places = [along, above].map(F32x8::splat);
    let light_sample = light_from_anywhere(light, places, Vec3x8::splat(point));
    let (irradiance, direction) = (light_sample.irradiance.lane(0), light_sample.direction.lane(0));
    let phase = spans.phase(&at).light(seen.direction.dot(direction));
    // irradiance leaves out a division by pi, which is for surfaces alone
    let arrives = seen.weight * at.weight * phase * irradiance * (PI / (chosen.chance * density));
    if density > 0.0 && arrives != Vec3::ZERO {
        let end = (light_sample.far, frame.shadows_of_light(chosen.source));
        light_rays.ask(path, (point, light_sample.to_light.lane(0)), end, arrives);
    }
}

/// Distances on a ray by the angle under which a place sees them.
struct Angles {
    /// Distance of the point of the ray that is nearest to the place.
    nearest: f32,
    /// Distance of the place from it.
    aside: f32,
    angles: [f32; 2],
}

impl Angles {
    /// Those from `near` to `far`; `None` where the place is on the ray.
    fn new(seen: &SeenRay, place: Vec3, [near, far]: [f32; 2]) -> Option<Self> {
        let offset = place - seen.origin;
        let nearest = offset.dot(seen.direction);
        let aside = (offset - seen.direction * nearest).length();
        let angle = |distance: f32| {
            if distance.is_finite() { (distance - nearest).atan2(aside) } else { FRAC_PI_2 }
        };
        let angles = [angle(near), angle(far)];
        let is_there = aside > 1e-6 * offset.length() && angles[0] < angles[1];
        is_there.then_some(Self { nearest, aside, angles })
    }

    /// A distance that a random number chooses.
    fn distance(&self, random: f32) -> f32 {
        let [first, last] = self.angles;
        self.nearest + self.aside * (first + (last - first) * random).tan()
    }

    /// Density, by length, with which it is chosen.
    fn density(&self, distance: f32) -> f32 {
        let ([first, last], along) = (self.angles, distance - self.nearest);
        self.aside / ((last - first) * (self.aside * self.aside + along * along))
    }
}

/// Asks for light where a path is scattered. Returns the ray by which it goes on, if it does.
fn scatter(
    frame: &FrameView,
    at: &Scattered,
    phase: &Phase<'_>,
    (random, sets): (PathRandom, u32),
    light_rays: &mut LightRays,
    brought: &mut PathResult,
) -> Option<PathRay> {
    let Scattered { path, tick, point, incoming, step, media, asks_lights, .. } = *at;
    let [choice, along, around, survives] = random.four(sets + 2);
    let asks = Kinds { lights: asks_lights && !frame.pose.lights.is_empty(), ..Kinds::of(frame, step) };
    let chance = |is_asked| if is_asked { 1.0 } else { 0.0 };
    let chances = Pdfs {
        asks_sky: chance(asks.sky && frame.sky.is_uneven()),
        sky: SkyDensity::Peaks,
        asks_emitter: chance(asks.emitters),
        lights: if asks_lights {
            LightsAsked::One { chance: chance(asks.lights) }
        } else {
            LightsAsked::InSums
        },
        goes_on: 1.0,
    };
    ask(frame, at, (phase, &chances), random.four(sets + 3), light_rays, brought);
    let most = at.weight.abs().max_element();
    let stays = (most / LEAST_WEIGHT).min(1.0);
    if stays.is_nan() || survives >= stays {
        return None;
    }
    let direction = phase.draw(incoming, [choice, along, around]);
    let cos = incoming.dot(direction);
    let density = phase.density(cos);
    let weight = at.weight * phase.light(cos) / (density * stays);
    weight.is_finite().then(|| PathRay {
        path,
        tick,
        receiver: OF_EYE,
        step,
        weight,
        origin: point,
        direction,
        asked_from: point,
        // as what a layer has reflected: its density is that of its direction
        normal: direction,
        chances: Pdfs { goes_on: density * PI, ..chances },
        seen_by: SeenBy::Path,
        kind: RayKind::Diffuse,
        within: Within::NOTHING,
        media: InMedia { scatterings: media.scatterings.saturating_add(1), ..media },
    })
}

/// Asks the light sources that `chances` name.
fn ask(
    frame: &FrameView,
    at: &Scattered,
    (phase, chances): (&Phase<'_>, &Pdfs),
    [choice, along, above, other]: [f32; 4],
    light_rays: &mut LightRays,
    brought: &mut PathResult,
) {
    let Scattered { path, tick, point, incoming, weight, .. } = *at;
    if matches!(chances.lights, LightsAsked::One { chance } if chance > 0.0) {
        let chosen = frame.light_chances.choose(point, choice);
        brought.until = brought.until.min(frame.light_changes[chosen.source]);
        let light = &frame.pose.lights_at(tick)[chosen.source];
        let light_sample = light_from_anywhere(light, [along, above].map(F32x8::splat), Vec3x8::splat(point));
        let (irradiance, direction) = (light_sample.irradiance.lane(0), light_sample.direction.lane(0));
        if irradiance != Vec3::ZERO && frame.lights(chosen.source, OF_EYE) {
            let cos = incoming.dot(direction);
            // lights that have a size are met by the path as well
            let met = frame.radiance_of(chosen.source, light).filter(|radiance| radiance.is_met);
            let share = met.map_or(1.0, |radiance| {
                let density = density_of(radiance.along(direction), irradiance);
                mis_weight(chosen.chance * density, phase.density(cos))
            });
            let arrives = weight * phase.light(cos) * irradiance * (PI * share / chosen.chance);
            let end = (light_sample.far, frame.shadows_of_light(chosen.source));
            light_rays.ask(path, (point, light_sample.to_light.lane(0)), end, arrives);
        }
    }
    if chances.asks_sky > 0.0 {
        let direction = frame.sky.sample(chances.sky, [other, choice]);
        let (light, cos) = (frame.sky.light(chances.sky, direction), incoming.dot(direction));
        if light.pdf > 0.0 {
            let arrives = weight * phase.light(cos) * light.radiance / (light.pdf + phase.density(cos));
            light_rays.ask(path, (point, direction), (f32::INFINITY, Purpose::Shadow), arrives);
        }
    }
    if chances.asks_emitter > 0.0 {
        let (scene, pose, deformations) = (frame.scene, (frame.pose, tick), frame.deformations);
        let asked_from = (point, &mut Sent::NOWHERE.clone());
        let chosen = frame.emitters.choose(scene, pose, deformations, asked_from, [other, along, above]);
        let Some(chosen) = chosen else { return };
        let (Ok(EmitterPlace { model, .. }) | Err(NotThere { model })) = chosen;
        brought.until = brought.until.min(frame.first_change_of(model));
        let Ok(place) = chosen else { return };
        if !frame.sees_emission(OF_EYE, model) {
            return;
        }
        let offset = place.point - point;
        let squared = offset.length_squared();
        let direction = offset / squared.sqrt();
        let turned = place.normal.dot(direction);
        // a NaN leads nowhere, nor does a triangle that has shrunk to nothing
        if place.density > 0.0 && turned != 0.0 && squared.is_normal() {
            let (cos, measure) = (incoming.dot(direction), turned.abs() / squared);
            // what is asked alone is not met by paths
            let met = if frame.is_emission_shadow_linked(model) { 0.0 } else { phase.density(cos) * measure };
            let density = place.density + met;
            let arrives = weight * phase.light(cos) * place.radiance * (measure / density);
            let facing = if turned > 0.0 { -place.normal } else { place.normal };
            let end = (1.0, frame.shadows_of_emission(model));
            light_rays.ask(path, (point, off_surface(place.point, facing) - point), end, arrives);
        }
    }
}
