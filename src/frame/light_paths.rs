//! Light paths: rays that leave surfaces in all directions and bring back the light that arrives there.
//!
//! A path starts at a surface in a direction by the cosine law. What escapes brings the sky. What meets a surface brings
//! what that surface emits and reflects of one light, chosen by chance (next-event estimation), and goes on from there, as
//! many times as the shot says. A path is a function of its start and of the scene in this frame, and of no other path: rays
//! are cast one by one ([`Coherence::Incoherent`]). So it can be traced again, alone, and brings the same to the bit.
//!
//! Each path is told the first frame in which it may bring something else ([`Motion`](crate::changes::Motion)): when what
//! moves touches one of its segments, or when a light changes that it has asked.

use glam::Vec3;

use super::frame_view::FrameView;
use super::plan::ShadowCheck;
use super::ray_tally::RayTally;
use super::shadow::ShadowQueue;
use super::surface::{Hits8, surfaces};
use crate::changes::Until;
use crate::lanes::{F32x8, LANES, Vec3x8};
use crate::shade::light::light_from_anywhere;
use crate::shade::optics::branch;
use crate::shade::sampling::{PathRandom, cosine_direction, orthonormal};
use crate::shade::surface::off_surface;
use crate::shade::{Surface, phong};
use crate::trace::{self, Coherence, HitBatch, NO_HIT, RayBatch, SceneSubset};

/// Where a path starts.
#[derive(Debug, Clone, Copy)]
pub struct PathStart {
    /// Whatever number its owner knows it by.
    pub owner: u32,
    /// Its number among the paths of its surface.
    pub index: u32,
    /// Of its random numbers: all paths of a surface share it.
    pub seed: u32,
    /// On the surface, world space.
    pub point: Vec3,
    /// For shading, world space, unit length.
    pub normal: Vec3,
    /// At right angles to the normal, unit length; turns with the model, and the path with it.
    pub tangent: Vec3,
    /// Of the triangle, world space, unit length, on the same side.
    pub geometric_normal: Vec3,
}

/// What a path brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brought {
    /// Radiance, linear RGB.
    pub radiance: Vec3,
    /// The first frame in which it may be another.
    pub until: Until,
}

/// A ray of a path.
#[derive(Debug, Clone, Copy)]
struct PathRay {
    /// Number of its path in the batch.
    path: u32,
    /// Of what it brings, in what its path brings.
    weight: Vec3,
    origin: Vec3,
    direction: Vec3,
}

/// A surface that a path has met.
#[derive(Debug, Clone, Copy)]
struct Vertex {
    ray: PathRay,
    surface: Surface,
    /// What it shows of the light that it has asked, and emits.
    light: Vec3,
    /// The light that it asks.
    asks: u32,
    /// Where on that light.
    place: [f32; 2],
}

/// Paths that are traced at once: their rays fit into a second-level cache.
pub const AT_ONCE: usize = 1024;

/// How many eights of hits ahead their triangles are fetched; half of that, their corners.
const AHEAD: usize = 4;

/// A worker's memory for paths.
#[derive(Debug, Default)]
pub struct PathScratch {
    /// Paths to be traced.
    pub starts: Vec<PathStart>,
    /// What they bring, in the same order.
    pub brought: Vec<Brought>,
    rays: RayBatch,
    hits: HitBatch,
    now: Vec<PathRay>,
    next: Vec<PathRay>,
    vertices: Vec<Vertex>,
    /// Numbers of vertices, by the light that they ask.
    by_light: Vec<u32>,
    /// Of those that ask one light: what reaches them if nothing is in its way.
    reflected: Vec<Vec3>,
    queue: ShadowQueue,
}

/// Traces the paths in `scratch.starts`; what they bring comes into `scratch.brought`.
pub fn trace_paths(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, now, .. } = &mut *scratch;
    brought.clear();
    now.clear();
    for (path, start) in (0..).zip(&*starts) {
        let [along, above, ..] = PathRandom { seed: start.seed, index: start.index }.four(0);
        let axes = [start.tangent, start.normal.cross(start.tangent), start.normal];
        let direction = cosine_direction([along, above], axes);
        let mut until = Until::FOREVER;
        if start.geometric_normal.dot(direction) > 0.0 {
            let origin = off_surface(start.point, start.geometric_normal);
            now.push(PathRay { path, weight: Vec3::ONE, origin, direction });
        } else {
            // below the surface: dark until the surface moves
            until = frame.first_touch(start.point, start.normal, 0.0);
        }
        brought.push(Brought { radiance: Vec3::ZERO, until });
    }
    for bounce in 0..frame.bounces {
        if scratch.now.is_empty() {
            break;
        }
        meet(frame, bounce, scratch, tally);
        light(frame, scratch, tally);
        let PathScratch { starts, brought, next, vertices, .. } = &mut *scratch;
        next.clear();
        for vertex in &*vertices {
            brought[vertex.ray.path as usize].radiance += vertex.ray.weight * vertex.light;
            if bounce + 1 < frame.bounces {
                let start = &starts[vertex.ray.path as usize];
                let random = PathRandom { seed: start.seed, index: start.index };
                next.extend(go_on(frame, vertex, random.four(2 * bounce + 2)));
            }
        }
        std::mem::swap(&mut scratch.now, &mut scratch.next);
    }
}

/// Finds what the rays at work meet.
fn meet(frame: &FrameView, bounce: u32, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, rays, hits, now, vertices, .. } = scratch;
    rays.clear();
    now.iter().for_each(|ray| rays.push(ray.origin, ray.direction, 0.0, f32::INFINITY));
    tally.counts.gathering += now.len() as u64;
    frame.tracer.closest(rays, SceneSubset::All, Coherence::Incoherent, hits);
    vertices.clear();
    let eights = now.len().div_ceil(LANES);
    let eight = |number: usize| {
        let (packet, from) = (number * LANES / trace::LANES, number * LANES % trace::LANES);
        (number < eights).then(|| (&hits.packets[packet], from))
    };
    let hits_of = |number: usize| eight(number).map(|(packet, from)| Hits8::of(packet, from));
    (0..AHEAD).filter_map(hits_of).for_each(|hits| hits.prefetch_triangles(frame));
    for (number, some) in now.chunks(LANES).enumerate() {
        if let Some(hits) = hits_of(number + AHEAD) {
            hits.prefetch_triangles(frame);
        }
        if let Some(hits) = hits_of(number + AHEAD / 2) {
            hits.prefetch_corners(frame);
        }
        let Some((packet, from)) = eight(number) else { break };
        for (lane, ray) in some.iter().enumerate() {
            let is_hit = packet.model[from + lane] != NO_HIT;
            let far = if is_hit { packet.t[from + lane] } else { f32::INFINITY };
            let brought = &mut brought[ray.path as usize];
            brought.until = brought.until.min(frame.first_touch(ray.origin, ray.direction, far));
            if !is_hit {
                brought.radiance += ray.weight * frame.scene.background.radiance(ray.direction);
            }
        }
        surfaces(
            frame,
            &Hits8::of(packet, from),
            some.len(),
            |lane| some[lane].direction,
            |lane, surface| {
                let ray = some[lane];
                let start = &starts[ray.path as usize];
                let [choice, along, above, _] =
                    PathRandom { seed: start.seed, index: start.index }.four(2 * bounce + 1);
                let lights = frame.pose.lights.len();
                let asks = ((choice * lights as f32) as usize).min(lights.saturating_sub(1)) as u32;
                vertices.push(Vertex { ray, surface, light: Vec3::ZERO, asks, place: [along, above] });
            },
        );
    }
}

/// Lights the vertices: emission and ambient light, and what reaches them of the light that each has chosen.
fn light(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { brought, vertices, by_light, reflected, queue, .. } = scratch;
    for some in vertices.chunks_mut(LANES) {
        let surfaces = Eight::of(some.len(), |lane| &some[lane]);
        let light = frame.palette.emitted_and_ambient(&surfaces.materials, surfaces.reflectance);
        some.iter_mut().enumerate().for_each(|(lane, vertex)| vertex.light = light.lane(lane));
    }
    if frame.pose.lights.is_empty() {
        return;
    }
    let lights_change = frame.first_light_change();
    for vertex in &*vertices {
        let brought = &mut brought[vertex.ray.path as usize];
        brought.until = brought.until.min(lights_change);
    }
    by_light.clear();
    by_light.extend(0..vertices.len() as u32);
    by_light.sort_by_key(|vertex| vertices[*vertex as usize].asks);
    let mut rest = &by_light[..];
    while let Some(first) = rest.first() {
        let asks = vertices[*first as usize].asks;
        let count = rest.partition_point(|vertex| vertices[*vertex as usize].asks == asks);
        let (group, after) = rest.split_at(count);
        ask_light(frame, group, (vertices, brought), (queue, reflected), tally);
        rest = after;
    }
}

/// Adds to those vertices that are named in `group`, all of which ask the same light, what it sends them.
fn ask_light(
    frame: &FrameView,
    group: &[u32],
    (vertices, brought): (&mut [Vertex], &mut [Brought]),
    (queue, reflected): (&mut ShadowQueue, &mut Vec<Vec3>),
    tally: &mut RayTally,
) {
    // one of them stands for all
    let lights = frame.pose.lights.len() as f32;
    let light = &frame.pose.lights[vertices[group[0] as usize].asks as usize];
    queue.clear();
    reflected.clear();
    for (first, some) in (0..).step_by(LANES).zip(group.chunks(LANES)) {
        let eight = Eight::of(some.len(), |lane| &vertices[some[lane] as usize]);
        let light_sample = light_from_anywhere(light, eight.place, eight.point);
        let asked = phong::faces(eight.normal, eight.geometric_normal, &light_sample).bits() & eight.used;
        queue.push(eight.point, eight.geometric_normal, &light_sample, asked, first);
        let albedo = frame.palette.albedo(&eight.materials, eight.reflectance);
        let light = phong::diffuse(albedo, eight.normal, &light_sample) * F32x8::splat(lights);
        for (lane, vertex) in some.iter().enumerate() {
            reflected.push(light.lane(lane));
            if asked >> lane & 1 != 0 {
                let brought = &mut brought[vertices[*vertex as usize].ray.path as usize];
                let (from, to_light) = (eight.point.lane(lane), light_sample.to_light.lane(lane));
                brought.until = brought.until.min(frame.first_touch(from, to_light, light_sample.far));
            }
        }
    }
    tally.counts.shadow += queue.count();
    let (check, coherence) = (ShadowCheck::StillThenMovable, Coherence::Incoherent);
    queue.answer(check, SceneSubset::All, coherence, frame.tracer, |member, tag| {
        if tag.is_lit() {
            vertices[group[member as usize] as usize].light += reflected[member as usize];
        }
    });
}

/// The ray that goes on from a vertex: diffusely, off a mirror or through glass, by chance in proportion to what each
/// would carry.
fn go_on(frame: &FrameView, vertex: &Vertex, [along, above, choice, _]: [f32; 4]) -> Option<PathRay> {
    let Vertex { ray, surface, .. } = vertex;
    let materials = [surface.material; LANES];
    let albedo = frame.palette.albedo(&materials, Vec3x8::splat(surface.reflectance)).lane(0);
    let mut ways = [(albedo, None); 3];
    if frame.depth > 0 {
        let optics = frame.scene.materials[usize::from(surface.material)].optics;
        let branches = branch(optics, surface, ray.direction);
        for (way, branch) in ways[1..].iter_mut().zip([branches.reflection, branches.refraction]) {
            *way = branch.map_or((Vec3::ZERO, None), |branch| (branch.weight, Some(branch.direction)));
        }
    } else {
        ways[1..].fill((Vec3::ZERO, None));
    }
    let chances = ways.map(|(weight, _)| weight.max_element().max(0.0));
    let sum: f32 = chances.iter().sum();
    if sum <= 0.0 || !sum.is_finite() {
        return None;
    }
    let mut at = choice * sum;
    let chosen = chances.iter().position(|chance| {
        let is_here = at < *chance;
        at -= chance;
        is_here
    });
    // rounding may lead past the last way that carries anything
    let chosen = chosen.or_else(|| chances.iter().rposition(|chance| *chance > 0.0))?;
    let (weight, direction) = ways[chosen];
    let direction = direction.unwrap_or_else(|| {
        let [tangent, bitangent] = orthonormal(surface.normal);
        cosine_direction([along, above], [tangent, bitangent, surface.normal])
    });
    if chosen == 0 && surface.geometric_normal.dot(direction) <= 0.0 {
        return None;
    }
    let weight = ray.weight * weight * (sum / chances[chosen]);
    Some(PathRay { path: ray.path, weight, origin: surface.leave(direction), direction })
}

/// Up to eight vertices side by side. Lanes without one repeat the first.
struct Eight {
    point: Vec3x8,
    normal: Vec3x8,
    geometric_normal: Vec3x8,
    reflectance: Vec3x8,
    place: [F32x8; 2],
    materials: [u16; LANES],
    /// Lanes in use.
    used: u8,
}

impl Eight {
    fn of<'v>(count: usize, vertex: impl Fn(usize) -> &'v Vertex) -> Self {
        let at = |lane: usize| vertex(if lane < count { lane } else { 0 });
        let each = |value: fn(&Surface) -> Vec3| {
            let mut all = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, value(&at(lane).surface)));
            all
        };
        let place = |axis: usize| F32x8::of(std::array::from_fn(|lane| at(lane).place[axis]));
        Self {
            point: each(|surface| surface.point),
            normal: each(|surface| surface.normal),
            geometric_normal: each(|surface| surface.geometric_normal),
            reflectance: each(|surface| surface.reflectance),
            place: [place(0), place(1)],
            materials: std::array::from_fn(|lane| at(lane).surface.material),
            used: u8::MAX >> (LANES - count),
        }
    }
}
