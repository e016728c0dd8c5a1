//! Light paths: rays that leave surfaces in all directions and collect the light that arrives from there.
//!
//! A path starts at a surface in a direction by the cosine law. A ray that escapes brings the light of the
//! sky. A ray that meets a surface brings the light that this surface emits, and its reflection of one light,
//! of the sky or of an emitting surface, chosen at random ([next-event estimation](super::next_event)). From
//! there the path goes on, as many times as the shot says. A path is a function of its start and of the scene
//! in this frame, and of no other path: rays are cast one by one ([`Coherence::Incoherent`]). So a path can
//! be traced again, alone, with the same result to the bit.
//!
//! For each path the first frame is found in which its result may differ
//! ([`Motion`](crate::changes::Motion)): when something that moves touches one of its segments, or when a
//! light changes that it has asked.

use std::f32::consts::PI;

use glam::Vec3;

use super::clamp::limit_paths;
use super::light_choice::{LightChoice, asks_sky, paths_go_on};
use super::lobes::Lobes;
use super::next_event::{Asking, AskingCoat, LightRays, Pdfs};
use super::path_ends::{PathResult, PathStart};
use super::path_ray::PathRay;
use super::shadow::ShadowQueue;
use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::pose::LightPose;
use crate::samples::Tag;
use crate::shade::area::{density_of, radiance};
use crate::shade::coat::{SeenBy, SeenCoat};
use crate::shade::light::light_from_anywhere;
use crate::shade::sampling::{cosine_direction, orthonormal};
use crate::shade::surface::{off_surface, off_surfaces};
use crate::shade::{Surface, phong};
use crate::trace::{self, Coherence, HitBatch, NO_HIT, RayBatch, SceneSubset};

/// A surface that a path has met.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    ray: PathRay,
    surface: Surface,
    /// Light towards the path: its emission, and its reflection of the light source that it has asked.
    light: Vec3,
    /// Weight of its emission, which next-event estimation finds, too.
    emission_weight: f32,
    /// Light source that it asks.
    asks: LightChoice,
    /// Number of light sources that it chose among.
    choices: u32,
    /// Random numbers for the point on that light, in the sky, or on emitting surfaces.
    place: [f32; 3],
    /// Ways in which the path may go on.
    lobes: Lobes,
}

/// Paths that are traced at once: their rays fit into a second-level cache.
pub const AT_ONCE: usize = 256;

/// Prefetch distance of the triangles of hits, in groups of eight hits; their corners are fetched at half of
/// it.
const AHEAD: usize = 4;

/// The segment `origin + t * direction`, t in 0 to the last value.
type Way = (Vec3, Vec3, f32);

/// Scratch memory of a worker for paths.
#[derive(Debug, Default)]
pub struct PathScratch {
    /// Paths to be traced.
    pub starts: Vec<PathStart>,
    /// Results of these paths, in the same order.
    pub brought: Vec<PathResult>,
    /// Direct light in these results, if the rest is limited.
    direct: Vec<Vec3>,
    rays: RayBatch,
    hits: HitBatch,
    now: Vec<PathRay>,
    next: Vec<PathRay>,
    vertices: Vec<Vertex>,
    /// Numbers of vertices, sorted by the light that they ask.
    by_light: Vec<u32>,
    /// Light that each of the vertices that ask one light reflects if nothing is in the way.
    reflected: Vec<Vec3>,
    /// Segments to that light, from those vertices that face it.
    ways: Vec<Way>,
    light_rays: LightRays,
    queue: ShadowQueue,
}

/// Traces the paths in `scratch.starts`, and writes their results to `scratch.brought`.
pub fn trace_paths(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, direct, now, light_rays, .. } = &mut *scratch;
    brought.clear();
    direct.clear();
    now.clear();
    let chances = Pdfs::of_start(frame);
    for (path, start) in (0..).zip(&*starts) {
        let random = start.random();
        let [along, above, across, up] = random.four(0);
        let direction = start.direction([along, above]);
        let mut until = Until::FOREVER;
        if start.geometric_normal.dot(direction) > 0.0 {
            let origin = off_surface(start.point, start.geometric_normal);
            let PathStart { normal, .. } = *start;
            let (weight, asked_from) = (Vec3::ONE, origin);
            now.push(PathRay { path, weight, origin, direction, asked_from, normal, chances });
        } else {
            // below the surface: dark until the surface moves
            until = frame.first_touch(start.point, start.normal, 0.0);
        }
        let mut brings = PathResult { radiance: Vec3::ZERO, until };
        let PathStart { point, normal, geometric_normal, .. } = *start;
        let weight = Vec3::ONE;
        let asking = Asking { path, point, normal, geometric_normal, weight, chances, coat: None };
        for number in 0..frame.sky.samples() {
            // further rays use sets of random numbers of their own, after those of emitters and of all
            // vertices
            let place = match number {
                0 => [across, up],
                _ => {
                    let [across, up, ..] = random.four(2 * frame.bounces + 1 + number);
                    [across, up]
                }
            };
            light_rays.ask_sky(frame, &asking, place);
        }
        if chances.asks_emitter > 0.0 {
            // a set that no vertex uses: theirs have numbers up to twice the bounces
            let [triangle, along, above, _] = random.four(2 * frame.bounces + 1);
            light_rays.ask_emitter(frame, &asking, [triangle, along, above], &mut brings);
        }
        brought.push(brings);
    }
    light_rays.cast(frame, starts, brought, tally);
    for bounce in 0..frame.bounces {
        if scratch.now.is_empty() {
            break;
        }
        cast(frame, scratch, tally);
        meet(frame, bounce, scratch);
        if bounce == 0 && frame.clamp.is_some() {
            note_direct(frame, scratch);
        }
        light(frame, bounce, scratch, tally);
        let PathScratch { starts, brought, next, vertices, .. } = &mut *scratch;
        next.clear();
        for vertex in &*vertices {
            brought[vertex.ray.path as usize].radiance += vertex.ray.weight * vertex.light;
            if paths_go_on(frame, bounce) || vertex.passes_on(frame) {
                let random = starts[vertex.ray.path as usize].random();
                next.extend(go_on(frame, bounce, vertex, random.four(2 * bounce + 2)));
            }
        }
        std::mem::swap(&mut scratch.now, &mut scratch.next);
    }
    if !scratch.now.is_empty() {
        cast(frame, scratch, tally);
        end(frame, scratch);
    }
    if let Some(most) = frame.clamp {
        limit_paths(&mut scratch.brought, &scratch.direct, most);
    }
}

/// Notes the direct light of paths: the light that they have brought so far, and the emission of the surfaces
/// that they have met first.
fn note_direct(frame: &FrameView, scratch: &mut PathScratch) {
    let PathScratch { brought, direct, vertices, .. } = scratch;
    direct.extend(brought.iter().map(|brought| brought.radiance));
    for vertex in &*vertices {
        let emission = frame.scene.materials[usize::from(vertex.surface.material)].emission;
        direct[vertex.ray.path as usize] += vertex.ray.weight * emission * vertex.emission_weight;
    }
}

/// Casts the current rays. Rays that escape bring the light of the sky. The paths expire when something that
/// moves touches these rays, if not before.
fn cast(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, rays, hits, now, .. } = scratch;
    rays.clear();
    for ray in &*now {
        rays.push(ray.origin, ray.direction, 0.0, f32::INFINITY);
        let counted = &mut tally.cells.secondary[starts[ray.path as usize].cell as usize];
        *counted = counted.saturating_add(1);
    }
    tally.counts.gathering += now.len() as u64;
    frame.tracer.closest(rays, SceneSubset::All, Coherence::Incoherent, hits);
    for (packet, some) in hits.packets.iter().zip(now.chunks(trace::LANES)) {
        for (lane, ray) in some.iter().enumerate() {
            let model = packet.model[lane];
            let is_hit = model != NO_HIT;
            let far = if is_hit { packet.t[lane] } else { f32::INFINITY };
            let brought = &mut brought[ray.path as usize];
            brought.until = brought.until.min(frame.change_of_met(model));
            brought.until = frame.first_touch_before(ray.origin, ray.direction, far, brought.until);
            if !ray.chances.lights_are_summed() {
                brought.until = brought.until.min(frame.area_light_change);
                brought.radiance += ray.light_of_lights(frame, far);
            }
            if !is_hit {
                brought.radiance += ray.light_of_sky(frame);
            }
        }
    }
}

/// Makes vertices of the hits of the current rays.
fn meet(frame: &FrameView, bounce: u32, scratch: &mut PathScratch) {
    let PathScratch { starts, hits, now, vertices, .. } = scratch;
    vertices.clear();
    let eights = now.len().div_ceil(LANES);
    let eight = |number: usize| {
        let (packet, from) = (number * LANES / trace::LANES, number * LANES % trace::LANES);
        (number < eights).then(|| (&hits.packets[packet], from))
    };
    let hits_of = |number: usize| eight(number).map(|(packet, from)| Hits8::new(packet, from));
    (0..AHEAD).filter_map(hits_of).for_each(|hits| hits.prefetch_triangles(frame));
    for (number, some) in now.chunks(LANES).enumerate() {
        if let Some(hits) = hits_of(number + AHEAD) {
            hits.prefetch_triangles(frame);
        }
        if let Some(hits) = hits_of(number + AHEAD / 2) {
            hits.prefetch_corners(frame);
        }
        let Some((packet, from)) = eight(number) else { break };
        surfaces(
            frame,
            &Hits8::new(packet, from),
            some.len(),
            |lane| some[lane].direction,
            |lane, surface| {
                let ray = some[lane];
                let random = starts[ray.path as usize].random();
                let [choice, along, above, triangle] = random.four(2 * bounce + 1);
                let choices = LightChoice::count(frame, bounce);
                let choice = ((choice * choices as f32) as u32).min(choices.saturating_sub(1));
                let primitive = (packet.model[from + lane], packet.triangle[from + lane]);
                let distance = packet.t[from + lane];
                vertices.push(Vertex {
                    ray,
                    surface,
                    light: Vec3::ZERO,
                    emission_weight: ray.emission_weight(frame, primitive, &surface, distance),
                    asks: LightChoice::new(frame, bounce, choice),
                    choices,
                    place: [along, above, triangle],
                    lobes: Lobes::new(frame, &surface, ray.direction),
                });
            },
        );
    }
}

/// Adds the emission of the surfaces that the current rays have met: the last rays of their paths.
fn end(frame: &FrameView, scratch: &mut PathScratch) {
    let PathScratch { brought, hits, now, .. } = scratch;
    for (number, some) in now.chunks(LANES).enumerate() {
        let (packet, from) = (&hits.packets[number * LANES / trace::LANES], number * LANES % trace::LANES);
        let eight = Hits8::new(packet, from);
        let emits = |lane| eight.is_hit(lane) && frame.emitters.emits(eight.material(frame, lane));
        if !(0..some.len()).any(emits) {
            continue;
        }
        surfaces(
            frame,
            &eight,
            some.len(),
            |lane| some[lane].direction,
            |lane, surface| {
                let ray = some[lane];
                let primitive = (packet.model[from + lane], packet.triangle[from + lane]);
                let distance = packet.t[from + lane];
                let emission = frame.scene.materials[usize::from(surface.material)].emission;
                let weight = ray.emission_weight(frame, primitive, &surface, distance);
                brought[ray.path as usize].radiance += ray.weight * emission * weight;
            },
        );
    }
}

/// Lights the vertices: emission and ambient light, and the light of the source that each has chosen.
fn light(frame: &FrameView, bounce: u32, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, vertices, by_light, reflected, ways, light_rays, queue, .. } = scratch;
    for some in vertices.chunks_mut(LANES) {
        let surfaces = Eight::of(some.len(), |lane| &some[lane]);
        let light = frame.palette.emitted_and_ambient(&surfaces.materials, surfaces.reflectance);
        for (lane, vertex) in some.iter_mut().enumerate() {
            let emission = frame.scene.materials[usize::from(vertex.surface.material)].emission;
            let found_otherwise = emission * (1.0 - vertex.emission_weight);
            let light = light.lane(lane);
            let light = vertex.seen_coat(frame).map_or(light, |coat| coat.show(light));
            vertex.light = (light - found_otherwise).max(Vec3::ZERO);
        }
    }
    for vertex in &*vertices {
        let Surface { point, normal, geometric_normal, .. } = vertex.surface;
        let (path, weight) = (vertex.ray.path, vertex.ray.weight * vertex.lobes.ways[0].0);
        let (chances, coat) = (vertex.chances(frame, bounce), vertex.coat(frame, bounce));
        let asking = Asking { path, point, normal, geometric_normal, weight, chances, coat };
        let [along, above, triangle] = vertex.place;
        match vertex.asks {
            LightChoice::Sky => light_rays.ask_sky(frame, &asking, [along, above]),
            LightChoice::Emitter => {
                let brought = &mut brought[path as usize];
                light_rays.ask_emitter(frame, &asking, [triangle, along, above], brought);
            }
            LightChoice::Light(_) | LightChoice::Nothing => {}
        }
    }
    light_rays.cast(frame, starts, brought, tally);
    if frame.pose.lights.is_empty() {
        return;
    }
    by_light.clear();
    let asks_light = |vertex: &u32| matches!(vertices[*vertex as usize].asks, LightChoice::Light(_));
    by_light.extend((0..vertices.len() as u32).filter(asks_light));
    by_light.sort_by_key(|vertex| vertices[*vertex as usize].asks);
    let mut rest = &by_light[..];
    while let Some(LightChoice::Light(number)) = rest.first().map(|first| vertices[*first as usize].asks) {
        let change = frame.light_changes[number as usize];
        let same = |vertex: &u32| vertices[*vertex as usize].asks == LightChoice::Light(number);
        let (group, after) = rest.split_at(rest.partition_point(same));
        for vertex in group {
            let brought = &mut brought[vertices[*vertex as usize].ray.path as usize];
            brought.until = brought.until.min(change);
        }
        let light = &frame.pose.lights[number as usize];
        ask_light(
            frame,
            (bounce, light),
            group,
            starts,
            (vertices, brought),
            (queue, reflected, ways),
            tally,
        );
        rest = after;
    }
}

/// Adds the light that `light` sends to the vertices listed in `group`, all of which ask it.
fn ask_light(
    frame: &FrameView,
    (bounce, light): (u32, &LightPose),
    group: &[u32],
    starts: &[PathStart],
    (vertices, brought): (&mut [Vertex], &mut [PathResult]),
    (queue, reflected, ways): (&mut ShadowQueue, &mut Vec<Vec3>, &mut Vec<Way>),
    tally: &mut RayTally,
) {
    // the first vertex stands for all
    let choices = vertices[group[0] as usize].choices as f32;
    let radiance = light.shape.is_area().then(|| radiance(light));
    queue.clear();
    reflected.clear();
    ways.clear();
    for (first, some) in (0..).step_by(LANES).zip(group.chunks(LANES)) {
        let eight = Eight::of(some.len(), |lane| &vertices[some[lane] as usize]);
        let light_sample = light_from_anywhere(light, eight.place, eight.point);
        let asked = phong::receives(eight.normal, eight.geometric_normal, &light_sample).bits() & eight.used;
        let origins = off_surfaces(eight.point, eight.geometric_normal);
        queue.push_from(origins, &light_sample, asked, first);
        let albedo = frame.palette.albedo(&eight.materials, eight.reflectance);
        let light = phong::diffuse(albedo, eight.normal, &light_sample) * F32x8::splat(choices);
        for (lane, vertex) in some.iter().enumerate() {
            let weight = match radiance.filter(|_| asked >> lane & 1 != 0) {
                Some(radiance) => {
                    let density = density_of(radiance, light_sample.irradiance.lane(lane));
                    let (normal, direction) = (eight.normal.lane(lane), light_sample.direction.lane(lane));
                    vertices[*vertex as usize]
                        .chances(frame, bounce)
                        .of_asked_light(normal, direction, density)
                }
                None => 1.0,
            };
            let mut light = light.lane(lane) * weight;
            let vertex_of_lane = &vertices[*vertex as usize];
            if let Some(coat) = &vertex_of_lane.seen_coat(frame) {
                let irradiance = light_sample.irradiance.lane(lane) * choices;
                let arrives = (light_sample.direction.lane(lane), irradiance);
                light =
                    light * coat.through + vertex_of_lane.highlight(frame, bounce, coat, arrives, radiance);
            }
            reflected.push(light);
            if asked >> lane & 1 != 0 {
                let path = vertices[*vertex as usize].ray.path as usize;
                let counted = &mut tally.cells.shadow[starts[path].cell as usize];
                *counted = counted.saturating_add(1);
                ways.push((origins.lane(lane), light_sample.to_light.lane(lane), light_sample.far));
            }
        }
    }
    tally.counts.shadow += queue.count();
    let (check, coherence) = (ShadowCheck::StillThenMovable, Coherence::Incoherent);
    // segments in the order of the answers
    let mut ways = ways.iter();
    queue.answer(check, SceneSubset::All, coherence, frame.tracer, |member, tag| {
        let vertex = &mut vertices[group[member as usize] as usize];
        if tag.is_lit() {
            vertex.light += reflected[member as usize];
        }
        // a still occluder stays in the way, whatever else comes there or goes
        if let Some((from, way, far)) = ways.next().filter(|_| tag != Tag::StaticOccluder) {
            let brought = &mut brought[vertex.ray.path as usize];
            brought.until = frame.first_touch_before(*from, *way, *far, brought.until);
        }
    });
}

impl Vertex {
    /// Pdfs of the ways from this vertex to light.
    fn chances(&self, frame: &FrameView, bounce: u32) -> Pdfs {
        let chance = |is_asked| if is_asked { 1.0 / self.choices as f32 } else { 0.0 };
        Pdfs {
            asks_sky: chance(asks_sky(frame, bounce)),
            asks_emitter: chance(frame.emitters.are_asked()),
            asks_light: chance(!frame.pose.lights.is_empty()),
            goes_on: self.goes_on(frame, bounce, 0),
        }
    }

    /// Returns true if one of its ways brings light even if the path ends here: off mirrors and through
    /// glass, where paths alone find that light; or else through clear glass, where rays have asked for a
    /// part of it.
    fn passes_light_on(&self, frame: &FrameView, way: usize) -> bool {
        let passes = || way == Lobes::THROUGH && frame.shines_through(self.surface.material);
        self.lobes.ways[way].1.is_some() && (frame.finds_caustics || passes())
    }

    /// Returns true if any of its ways [brings light](Self::passes_light_on) even if the path ends here.
    fn passes_on(&self, frame: &FrameView) -> bool {
        (0..self.lobes.ways.len()).any(|way| self.passes_light_on(frame, way))
    }

    /// Layer of the vertex as the path sees it, if it has one. It is computed whenever it is needed: few
    /// vertices have one, and all are copied.
    #[inline]
    fn seen_coat(&self, frame: &FrameView) -> Option<SeenCoat> {
        let Surface { material, reflectance, normal, geometric_normal, .. } = self.surface;
        let normals = [normal, geometric_normal];
        frame.palette.coats.seen(material, reflectance, normals, self.ray.direction, SeenBy::Path)
    }

    /// Probability with which the path goes on by one of the ways.
    fn goes_on(&self, frame: &FrameView, bounce: u32, way: usize) -> f32 {
        if paths_go_on(frame, bounce) { self.lobes.chance(way) } else { 0.0 }
    }

    /// Highlight on its layer `coat` of a light that it has asked, which sends an irradiance from a
    /// direction. `radiance` is that of an area light, which the path itself may meet, too.
    fn highlight(
        &self,
        frame: &FrameView,
        bounce: u32,
        coat: &SeenCoat,
        (direction, irradiance): (Vec3, Vec3),
        radiance: Option<Vec3>,
    ) -> Vec3 {
        let (highlight, density) = coat.highlight(direction, irradiance);
        let by_path = self.goes_on(frame, bounce, Lobes::COAT) * density;
        let weight = match radiance {
            Some(radiance) if by_path > 0.0 => {
                let by_asking = density_of(radiance, irradiance);
                by_asking / (by_asking + by_path)
            }
            _ => 1.0,
        };
        highlight * weight
    }

    /// Layer of the vertex for next-event estimation, if it has one.
    fn coat(&self, frame: &FrameView, bounce: u32) -> Option<AskingCoat> {
        let seen = self.seen_coat(frame).filter(|_| frame.depth > 0)?;
        Some(AskingCoat { seen, weight: self.ray.weight, goes_on: self.goes_on(frame, bounce, Lobes::COAT) })
    }

    /// Pdfs of the ways from it to light in a direction in which its layer has reflected with this
    /// `density`. The ray takes that direction for its normal; the chances are scaled so that it is as likely
    /// as the layer chose it.
    fn chances_of_coat(&self, frame: &FrameView, bounce: u32, density: f32) -> Pdfs {
        let goes_on = self.lobes.chance(Lobes::COAT) * density * PI;
        Pdfs { goes_on, ..self.chances(frame, bounce) }
    }
}

/// Chooses one of the ways from a vertex, in proportion to the light that each carries, and makes the ray
/// that goes on.
fn go_on(
    frame: &FrameView,
    bounce: u32,
    vertex: &Vertex,
    [along, above, choice, _]: [f32; 4],
) -> Option<PathRay> {
    let Vertex { ray, surface, lobes, .. } = vertex;
    // from the last surface a ray only finds light, for which the other ways have asked
    let leads = |way: &usize| paths_go_on(frame, bounce) || vertex.passes_light_on(frame, *way);
    let chosen = lobes.choose(choice).filter(leads)?;
    let (weight, direction) = lobes.ways[chosen];
    let mut asked_from = None;
    let (weight, direction, normal, chances) = match direction {
        Some(direction) if chosen == Lobes::THROUGH && frame.shines_through(surface.material) => {
            // rays of next-event estimation have passed here, too
            asked_from = Some(ray.asked_from);
            (weight, direction, ray.normal, ray.chances)
        }
        Some(direction) => (weight, direction, surface.normal, Pdfs::PATH_ALONE),
        None if chosen == Lobes::COAT => {
            let reflected = vertex.seen_coat(frame)?.reflect([along, above])?;
            if surface.geometric_normal.dot(reflected.direction) <= 0.0 {
                return None;
            }
            let chances = match reflected.density {
                Some(density) => vertex.chances_of_coat(frame, bounce, density),
                None => Pdfs::PATH_ALONE,
            };
            (reflected.weight, reflected.direction, reflected.direction, chances)
        }
        None => {
            let [tangent, bitangent] = orthonormal(surface.normal);
            let direction = cosine_direction([along, above], [tangent, bitangent, surface.normal]);
            if surface.geometric_normal.dot(direction) <= 0.0 {
                return None;
            }
            (weight, direction, surface.normal, vertex.chances(frame, bounce))
        }
    };
    let (weight, origin) = (ray.weight * weight / lobes.chance(chosen), surface.leave(direction));
    let asked_from = asked_from.unwrap_or(origin);
    Some(PathRay { path: ray.path, weight, origin, direction, asked_from, normal, chances })
}

/// Up to eight vertices side by side. Lanes without one repeat the first.
struct Eight {
    point: Vec3x8,
    normal: Vec3x8,
    geometric_normal: Vec3x8,
    reflectance: Vec3x8,
    place: [F32x8; 2],
    materials: [u16; LANES],
    /// Bit mask of the lanes in use.
    used: u8,
}

impl Eight {
    fn of<'v>(count: usize, vertex: impl Fn(usize) -> &'v Vertex) -> Self {
        let mut eight = Self {
            point: Vec3x8::ZERO,
            normal: Vec3x8::ZERO,
            geometric_normal: Vec3x8::ZERO,
            reflectance: Vec3x8::ZERO,
            place: [F32x8::ZERO; 2],
            materials: [0; LANES],
            used: u8::MAX >> (LANES - count),
        };
        for lane in 0..LANES {
            let Vertex { surface, place, .. } = vertex(if lane < count { lane } else { 0 });
            eight.point.set_lane(lane, surface.point);
            eight.normal.set_lane(lane, surface.normal);
            eight.geometric_normal.set_lane(lane, surface.geometric_normal);
            eight.reflectance.set_lane(lane, surface.reflectance);
            eight.place[0].set_lane(lane, place[0]);
            eight.place[1].set_lane(lane, place[1]);
            eight.materials[lane] = surface.material;
        }
        eight
    }
}
