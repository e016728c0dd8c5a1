//! Light at the vertices of paths: what they emit, and the sources of light that they ask. The shot's lights are asked light by light, by
//! eight vertices at a time.

use glam::Vec3;

use super::light_choice::NO_LIGHT;
use super::lobes::Lobes;
use super::next_event::{Asking, LightRays};
use super::path_ends::{PathResult, PathStart};
use super::path_ray::PathRay;
use super::select::select;
use super::shadow::ShadowQueue;
use super::starts::Starts;
use super::vertex::{Vertex, VertexLanes};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::{F32x8, LANES};
use crate::pose::LightPose;
use crate::samples::Tag;
use crate::shade::Surface;
use crate::shade::area::density_of;
use crate::shade::bsdf::{SeenBsdf, phong};
use crate::shade::light::light_from_anywhere;
use crate::shade::surface::off_surface;
use crate::shade::terminator::ToLight;
use crate::trace::{Coherence, SceneSubset};

/// The segment `origin + t * direction`, t in 0 to the last value.
type LightSegment = (Vec3, Vec3, f32);

/// Scratch memory for vertices that ask for light.
#[derive(Debug, Default)]
pub struct AskingScratch {
    /// Numbers of the vertices, sorted by the light that they ask.
    by_light: Vec<u32>,
    one_light: OneLight,
}

/// Scratch memory for the vertices that ask one light.
#[derive(Debug, Default)]
struct OneLight {
    /// Light that each of them reflects if nothing is in the way.
    reflected: Vec<Vec3>,
    /// Segments to the light, from those that face it.
    segments: Vec<LightSegment>,
    queue: ShadowQueue,
    /// For each segment its vertex' number among those that ask the light, and what is in the way.
    answers: Vec<(u32, Tag)>,
    /// Numbers of the segments in whose way nothing still is.
    open: Vec<u32>,
}

/// Lights the vertices: emission and ambient light, and light of the sources that each asks.
///
/// `bsdfs`: layers of those that have one. Rays of `starts` are counted in `tally`; what paths bring is added to `brought`.
pub fn light_vertices(
    frame: &FrameView,
    (vertices, bsdfs): (&mut [Vertex], &[SeenBsdf]),
    (starts, brought): (&Starts, &mut [PathResult]),
    (scratch, light_rays): (&mut AskingScratch, &mut LightRays),
    tally: &mut RayTally,
) {
    let AskingScratch { by_light, one_light } = scratch;
    for some in vertices.chunks_mut(LANES) {
        let surfaces = VertexLanes::of(some.len(), |lane| &some[lane]);
        let light = frame.palette.emitted_and_ambient(&surfaces.looks, surfaces.reflectance);
        for (lane, vertex) in some.iter_mut().enumerate() {
            let emission = vertex.surface.emission(frame.scene);
            let found_otherwise = emission * (1.0 - vertex.emission_weight);
            let light = light.lane(lane);
            let light = vertex.seen_bsdf(bsdfs).map_or(light, |bsdf| bsdf.show(light));
            vertex.light =
                if vertex.is_exit { Vec3::ZERO } else { (light - found_otherwise).max(Vec3::ZERO) };
        }
    }
    let asking = |vertex: &Vertex| {
        let Surface { point, normal, geometric_normal, horizon, .. } = vertex.surface;
        let PathRay { path, tick, weight, .. } = vertex.ray;
        let weight = weight * vertex.lobes.all[Lobes::DIFFUSE].0;
        let (chances, bsdf) = (vertex.chances(frame), vertex.asking_bsdf(frame, bsdfs));
        let origin = off_surface(point, geometric_normal);
        let model = vertex.model;
        Asking { path, tick, model, point, origin, normal, geometric_normal, horizon, weight, chances, bsdf }
    };
    for vertex in &*vertices {
        if vertex.asks.sky {
            light_rays.ask_sky(frame, &asking(vertex), vertex.in_sky());
        }
        if vertex.asks.emitters {
            let brought = &mut brought[vertex.ray.path as usize];
            light_rays.ask_emitter(frame, &asking(vertex), vertex.on_emitters(), brought);
        }
    }
    light_rays.cast(frame, starts, brought, tally);
    if frame.pose.lights.is_empty() {
        return;
    }
    by_light.clear();
    by_light.extend(0..vertices.len() as u32);
    // where lights change within the exposure those of one tick ask together
    let changes = !frame.pose.lights_at_ticks.is_empty();
    let asked = |vertex: &Vertex| (vertex.asked_light, if changes { vertex.ray.tick } else { 0 });
    by_light.sort_by_key(|vertex| asked(&vertices[*vertex as usize]));
    // those that no light lights ask none, and come last
    let asking = by_light.partition_point(|vertex| vertices[*vertex as usize].asked_light != NO_LIGHT);
    let mut rest = &by_light[..asking];
    while let Some((number, tick)) = rest.first().map(|first| asked(&vertices[*first as usize])) {
        let change = frame.light_changes[number as usize];
        let same = |vertex: &u32| asked(&vertices[*vertex as usize]) == (number, tick);
        let (group, after) = rest.split_at(rest.partition_point(same));
        for vertex in group {
            let brought = &mut brought[vertices[*vertex as usize].ray.path as usize];
            brought.until = brought.until.min(change);
        }
        rest = after;
        if frame.is_dark_group(number as usize) {
            continue;
        }
        let light = &frame.pose.lights_at(tick)[number as usize];
        let light = (number as usize, light);
        ask_light(frame, light, group, starts, (vertices, bsdfs, brought), one_light, tally);
    }
}

/// Adds the light that `light`, of this `number`, sends to the vertices listed in `group`, all of which ask it.
fn ask_light(
    frame: &FrameView,
    (number, light): (usize, &LightPose),
    group: &[u32],
    starts: &[PathStart],
    (vertices, bsdfs, brought): (&mut [Vertex], &[SeenBsdf], &mut [PathResult]),
    one_light: &mut OneLight,
    tally: &mut RayTally,
) {
    let OneLight { reflected, segments, queue, answers, open } = one_light;
    let radiance = frame.radiance_of(number, light);
    queue.begin(frame.shadows_of_light(number));
    reflected.clear();
    segments.clear();
    for (first, some) in (0..).step_by(LANES).zip(group.chunks(LANES)) {
        let eight = VertexLanes::of(some.len(), |lane| &vertices[some[lane] as usize]);
        let horizon = |lane: usize| &vertices[some[lane] as usize].surface.horizon;
        let receivers = eight.receivers(frame, |lane| horizon(lane).normal);
        let light_sample = light_from_anywhere(light, eight.place, eight.point);
        let ToLight { faces, origins, to_light } =
            receivers.to_light(&light_sample, eight.used, |lane| horizon(lane).lift);
        let asked = faces & light_sample.irradiance.is_some().bits() & eight.used;
        queue.push(origins, to_light, F32x8::splat(light_sample.far), asked, first);
        let albedo = frame.palette.albedo(&eight.looks, eight.reflectance);
        let light = phong::diffuse(albedo, eight.normal, receivers.smooth, &light_sample) / eight.chance;
        for (lane, vertex) in some.iter().enumerate() {
            let weight = match radiance.filter(|radiance| radiance.is_met && asked >> lane & 1 != 0) {
                Some(radiance) => {
                    let (normal, direction) = (eight.normal.lane(lane), light_sample.direction.lane(lane));
                    let density = density_of(radiance.along(direction), light_sample.irradiance.lane(lane));
                    let chance = eight.chance.lane(lane);
                    vertices[*vertex as usize]
                        .chances(frame)
                        .of_asked_light(chance, normal, direction, density)
                }
                None => 1.0,
            };
            let mut light = light.lane(lane) * weight;
            let vertex_of_lane = &vertices[*vertex as usize];
            if let Some(bsdf) = vertex_of_lane.seen_bsdf(bsdfs) {
                let irradiance = light_sample.irradiance.lane(lane) / eight.chance.lane(lane);
                let arrives = (light_sample.direction.lane(lane), irradiance);
                light = light * bsdf.through + vertex_of_lane.highlight(frame, bsdf, arrives, radiance);
            }
            reflected.push(light);
            let asks = asked >> lane & 1;
            let path = vertices[*vertex as usize].ray.path as usize;
            let counted = &mut tally.cells.shadow[starts[path].cell as usize];
            *counted = counted.saturating_add(u16::from(asks));
            // added in any case, and taken away again: every other surface faces the light
            let count = segments.len() + usize::from(asks);
            segments.push((origins.lane(lane), to_light.lane(lane), light_sample.far));
            segments.truncate(count);
        }
    }
    tally.counts.shadow += queue.count();
    let (check, coherence) = (ShadowCheck::StillThenMovable, Coherence::Incoherent);
    answers.clear();
    let cell = |member: u32| {
        let path = vertices[group[member as usize] as usize].ray.path;
        starts[path as usize].cell
    };
    queue.set_ticks(frame, cell);
    queue.answer(check, SceneSubset::All, coherence, frame.tracer, |member, tag| answers.push((member, tag)));
    // a still occluder stays in the way, whatever else comes there or goes
    select(open, answers.len(), |number| answers[number].1 != Tag::StaticOccluder);
    for number in open.iter().map(|number| *number as usize) {
        let ((member, tag), (from, to, far)) = (answers[number], segments[number]);
        let vertex = &mut vertices[group[member as usize] as usize];
        if tag.is_lit() {
            let left = frame.media.map_or(Vec3::ONE, |media| media.left((from, to), far, vertex.ray.tick));
            vertex.light += reflected[member as usize] * left;
        }
        let brought = &mut brought[vertex.ray.path as usize];
        brought.until = frame.first_touch_before(from, to, far, brought.until);
    }
}
