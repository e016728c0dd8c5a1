//! Rays beyond the first surface: what mirrors and glass show. They depend on the eye and are traced anew, unless
//! they are known to bring what the film shows ([`path_bounds`](super::path_bounds)); breadth first: all rays of a tile that have
//! bounced equally often go together.

use glam::Vec3;

use super::bits::set_bits;
use super::frame_view::FrameView;
use super::light_paths::{PathScratch, trace_paths};
use super::lighting::{Places, add_light, lights_passed, shows_highlight};
use super::parts;
use super::path_bounds::{PathBounds, TOGETHER, TilePaths};
use super::path_ends::PathStart;
use super::plan::ShadowCheck;
use super::radiance::Radiance;
use super::ray_tally::RayTally;
use super::shadow::{ShadowQueue, facing};
use super::surface::{Hits8, surfaces};
use super::trace_scratch::TraceScratch;
use crate::lanes::{LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::pose::LightPose;
use crate::samples::Tag;
use crate::shade::light::{StratifiedPattern, light_sample, light_samples, way};
use crate::shade::optics::{Branches, branch};
use crate::shade::sampling::{orthonormal, seed_of};
use crate::shade::surface::off_surfaces;
use crate::shade::{Surface, phong};
use crate::trace::{self, Coherence, HitBatch, HitPacket, NO_HIT, SceneSubset};

/// A ray whose share in the picture is below this in all three colours is not followed: half the step of
/// an 8-bit picture at full brightness.
pub const LEAST_WEIGHT: f32 = 1.0 / 512.0;

/// How a ray came about, or the layer of the picture that it adds to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Bounced off.
    Reflection,
    /// Gone through.
    Refraction,
}

/// A ray on its way.
#[derive(Debug, Clone, Copy)]
struct Bounce {
    cell: u32,
    /// Of the ray itself.
    kind: Kind,
    /// Of the first ray that left the sample.
    layer: Kind,
    /// The kinds of all rays from the sample to this one, a bit each, the first one highest.
    path: u64,
    weight: Vec3,
    origin: Vec3,
    direction: Vec3,
    /// Whether denoisers are told of the normals of what it meets.
    guides: bool,
}

/// What a ray met.
#[derive(Debug, Clone, Copy)]
struct Met {
    bounce: Bounce,
    surface: Surface,
    light: Vec3,
}

/// A worker's memory for this phase.
#[derive(Debug, Default)]
pub struct Bounces {
    now: Vec<Bounce>,
    next: Vec<Bounce>,
    met: Vec<Met>,
    /// The same, side by side.
    eights: Vec<MetLanes>,
    queue: ShadowQueue,
    /// Of `met`: which points of the light at hand reach it, a bit each.
    lit: Vec<u16>,
    gathering: PathScratch,
    /// Where the rays of the tile at work went, if the frame records that.
    pub paths: TilePaths,
}

impl Bounces {
    /// Starts the rays that leave the sample of `cell`. `guides`: denoisers are told of the normals of what they meet.
    pub fn start(&mut self, cell: u32, surface: &Surface, guides: bool, branches: Branches) {
        let next = &mut self.next;
        grow(next, surface, branches, |kind, weight, origin, direction| Bounce {
            cell,
            kind,
            layer: kind,
            path: kind as u64,
            weight,
            origin,
            direction,
            guides,
        });
    }
}

/// Follows the rays that were [started](Bounces::start), up to the frame's depth, and adds what they bring
/// to the cells' radiance.
pub fn follow(frame: &FrameView, bounces: &mut Bounces, radiance: &mut Radiance, scratch: &mut TraceScratch) {
    bounces.paths.clear();
    let shows_guides = frame.layers.has(Layers::GUIDES);
    for _ in 0..frame.depth {
        std::mem::swap(&mut bounces.now, &mut bounces.next);
        bounces.next.clear();
        group(&mut bounces.now);
        if bounces.now.is_empty() {
            break;
        }
        meet(frame, bounces, radiance, scratch);
        light(frame, bounces, &mut scratch.tally);
        gather(frame, bounces, &mut scratch.tally);
        for met in &bounces.met {
            add(radiance, &met.bounce, met.light);
            if shows_guides {
                let Bounce { cell, weight, guides, .. } = met.bounce;
                parts::see(frame, &mut radiance.parts, cell as usize, &met.surface, weight, guides);
            }
            go_on(frame, met, &mut bounces.next);
        }
    }
    bounces.next.clear();
}

/// Puts rays side by side that came the same way: what a surface reflects and what it lets through part there, and
/// in one packet neither would have a neighbour. The order within a cell, in which light is added up, stays: in
/// `rays` those of one cell are in the order of their paths, all of which are equally long.
fn group(rays: &mut [Bounce]) {
    rays.sort_by_key(|ray| ray.path);
}

/// Finds what the rays meet; those that meet nothing see the background.
fn meet(frame: &FrameView, bounces: &mut Bounces, radiance: &mut Radiance, scratch: &mut TraceScratch) {
    scratch.begin_rays();
    for bounce in &bounces.now {
        scratch.rays.push(bounce.origin, bounce.direction, 0.0, f32::INFINITY);
        count(bounce, &mut scratch.tally);
    }
    frame.tracer.closest(&scratch.rays, SceneSubset::All, Coherence::Bounced, &mut scratch.hits);
    bounces.met.clear();
    for (number, bounce) in bounces.now.chunks(LANES).enumerate() {
        let (packet, from) =
            (&scratch.hits.packets[number * LANES / trace::LANES], number * LANES % trace::LANES);
        let models = &packet.model[from..from + LANES];
        for (lane, (bounce, model)) in bounce.iter().zip(models).enumerate() {
            let is_hit = *model != NO_HIT;
            let far = if is_hit { packet.t[from + lane] } else { f32::INFINITY };
            let of_lights = lights_passed(&frame.pose.lights, bounce.origin, bounce.direction, far);
            let of_lights: Vec3 = of_lights.map(|glow| glow.radiance).sum();
            let of_sky = if is_hit { Vec3::ZERO } else { frame.sky.radiance(bounce.direction) };
            if !is_hit || of_lights != Vec3::ZERO {
                add(radiance, bounce, of_lights + of_sky);
            }
        }
        meet_surfaces(frame, packet, from, bounce, &mut bounces.met);
    }
    if frame.records_paths {
        record_paths(frame, bounces, &scratch.hits);
    }
}

/// Records where the rays went.
fn record_paths(frame: &FrameView, bounces: &mut Bounces, hits: &HitBatch) {
    let Bounces { now, met, paths, .. } = bounces;
    let dynamic = frame.dynamic_bounds.models();
    let mut met = met.iter();
    for (first, some) in (0..).step_by(TOGETHER).zip(now.chunks(TOGETHER)) {
        // mirrors and glass send theirs different ways
        let mut bounds = [PathBounds::NONE; 2];
        for (number, bounce) in (first..).zip(some) {
            let bounds = &mut bounds[bounce.kind as usize];
            let model = hits.packets[number / trace::LANES].model[number % trace::LANES];
            if model == NO_HIT {
                bounds.add_to_sky(bounce.origin, bounce.direction);
            } else if let Some(met) = met.next() {
                bounds.add_to_surface(bounce.origin, met.surface.point);
                paths.note_dynamic(dynamic.may_hold(model));
            }
        }
        bounds.into_iter().for_each(|bounds| paths.add(bounds));
    }
}

/// Adds the surfaces that up to eight rays met, those from lane `from` of a packet on.
fn meet_surfaces(frame: &FrameView, hits: &HitPacket, from: usize, bounces: &[Bounce], met: &mut Vec<Met>) {
    let hits = Hits8::of(hits, from);
    let direction = |lane: usize| bounces[lane].direction;
    surfaces(frame, &hits, bounces.len(), direction, |lane, surface| {
        met.push(Met { bounce: bounces[lane], surface, light: Vec3::ZERO });
    });
}

/// Eight of the surfaces that were met, side by side. Lanes without one repeat the first.
#[derive(Debug)]
struct MetLanes {
    point: Vec3x8,
    normal: Vec3x8,
    geometric_normal: Vec3x8,
    reflectance: Vec3x8,
    view: Vec3x8,
    materials: [u16; LANES],
    /// What they show, as far as it is summed.
    light: Vec3x8,
    /// Lanes in use.
    used: u8,
}

impl MetLanes {
    fn of(met: &[Met]) -> Self {
        let at = |lane: usize| &met[if lane < met.len() { lane } else { 0 }];
        let each = |value: fn(&Met) -> Vec3| {
            let mut all = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, value(at(lane))));
            all
        };
        Self {
            point: each(|met| met.surface.point),
            normal: each(|met| met.surface.normal),
            geometric_normal: each(|met| met.surface.geometric_normal),
            reflectance: each(|met| met.surface.reflectance),
            view: each(|met| -met.bounce.direction),
            materials: std::array::from_fn(|lane| at(lane).surface.material),
            light: Vec3x8::ZERO,
            used: u8::MAX >> (LANES - met.len()),
        }
    }
}

/// Lights what was met, highlights included.
fn light(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    bounces.eights.clear();
    bounces.eights.extend(bounces.met.chunks(LANES).map(MetLanes::of));
    for eight in &mut bounces.eights {
        eight.light = frame.palette.emitted_and_ambient(&eight.materials, eight.reflectance);
    }
    for light in &frame.pose.lights {
        ask_light(frame, light, bounces, tally);
        shine(frame, light, bounces);
    }
    for (met, eight) in bounces.met.chunks_mut(LANES).zip(&bounces.eights) {
        met.iter_mut().enumerate().for_each(|(lane, met)| met.light = eight.light.lane(lane));
    }
}

/// Adds what the surfaces that were met gather from all around. It is made anew for each frame in which they are seen, by
/// fewer paths than samples have: what a mirror shows counts for less, and is not kept.
fn gather(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    let Bounces { met, gathering, paths, .. } = bounces;
    let count = frame.first_paths.div_ceil(SHARE_OF_PATHS);
    let is_diffuse = |met: &Met| frame.palette.is_diffuse(met.surface.material);
    for (first, some) in (0..).step_by(GATHER_AT_ONCE).zip(met.chunks_mut(GATHER_AT_ONCE)) {
        gathering.starts.clear();
        for (number, met) in (first..).zip(&*some).filter(|(_, met)| count > 0 && is_diffuse(met)) {
            let Surface { point, normal, geometric_normal, .. } = met.surface;
            let seed = seed_of(point, met.surface.material.into());
            let [tangent, _] = orthonormal(normal);
            let cell = met.bounce.cell;
            let start =
                PathStart { owner: number, cell, index: 0, seed, point, normal, tangent, geometric_normal };
            gathering.starts.extend((0..count as u32).map(|index| PathStart { index, ..start }));
        }
        trace_paths(frame, gathering, tally);
        let brought = gathering.starts.iter().zip(&gathering.brought);
        for (start, brought) in brought {
            let met = &mut some[(start.owner - first) as usize];
            let materials = [met.surface.material; LANES];
            let albedo = frame.palette.albedo(&materials, Vec3x8::splat(met.surface.reflectance)).lane(0);
            met.light += albedo * brought.radiance / count as f32;
            paths.note_until(brought.until);
        }
    }
}

/// Of a sample's paths, one in so many is traced where a mirror or glass shows a surface.
const SHARE_OF_PATHS: usize = 4;

/// Surfaces that gather light at once.
const GATHER_AT_ONCE: usize = 256;

/// Finds out whether `light`, or which of its points, reach what was met.
fn ask_light(frame: &FrameView, light: &LightPose, bounces: &mut Bounces, tally: &mut RayTally) {
    let Bounces { met, eights, queue, lit, paths, .. } = bounces;
    queue.clear();
    lit.clear();
    lit.resize(met.len(), 0);
    let mut count = |number: usize, rays: u32| {
        let counted = &mut tally.cells.shadow[met[number].bounce.cell as usize];
        // many panes under many panels may be more than a word holds
        *counted = counted.saturating_add(rays as u16);
    };
    for (eight, first) in eights.iter().zip((0..).step_by(LANES)) {
        let pattern = StratifiedPattern::at(light, eight.point);
        if !light.shape.is_area() {
            let light_sample = light_sample(light, 0, &pattern, eight.point);
            let asked = phong::faces(eight.normal, eight.geometric_normal, &light_sample).bits() & eight.used;
            queue.push(eight.point, eight.geometric_normal, &light_sample, asked, first as u32);
            set_bits(asked).for_each(|lane| count(first + lane, 1));
            continue;
        }
        let origins = off_surfaces(eight.point, eight.geometric_normal);
        for lane in set_bits(eight.used) {
            let light_samples = light_samples(light, &pattern, lane, eight.point.lane(lane));
            let asked = facing(eight.normal.lane(lane), eight.geometric_normal.lane(lane), &light_samples);
            queue.push_sixteen(origins.lane(lane), &light_samples, asked, (first + lane) as u32);
            count(first + lane, asked.count_ones());
        }
    }
    tally.counts.shadow += queue.count();
    let check = ShadowCheck::StillThenMovable;
    if light.shape.is_area() {
        queue.answer_sixteen(
            check,
            SceneSubset::All,
            Coherence::SharedOrigin,
            frame.tracer,
            |owner, shadows| {
                lit[owner as usize] = shadows.asked & !shadows.blocked;
                paths.note_dynamic(shadows.by_dynamic != 0);
            },
        );
    } else {
        queue.answer(check, SceneSubset::All, Coherence::Bounced, frame.tracer, |owner, tag| {
            lit[owner as usize] = u16::from(tag.is_lit());
            paths.note_dynamic(tag == Tag::DynamicOccluder);
        });
    }
}

/// Adds the light of those points of `light` that reach what was met.
fn shine(frame: &FrameView, light: &LightPose, bounces: &mut Bounces) {
    let eights = bounces.eights.iter_mut().zip(bounces.lit.chunks(LANES));
    for (eight, lit) in eights.filter(|(_, lit)| lit.iter().any(|points| *points != 0)) {
        let gloss = frame.palette.gloss(&eight.materials);
        let (to_centre, reach) = (way(light, eight.point).0, light.shape.reach());
        let albedo = frame.palette.albedo(&eight.materials, eight.reflectance);
        let stands_for = shows_highlight(frame, light, &gloss);
        let may_shine = gloss.is_any && phong::may_shine(&gloss, eight.normal, eight.view, to_centre, reach);
        let mut points = [0; LANES];
        points[..lit.len()].copy_from_slice(lit);
        let places = Places { point: eight.point, pattern: eight.point };
        let reached = |point: usize| Mask::of(|lane| points[lane] >> point & 1 != 0);
        eight.light = add_light(eight.light, light, places, reached, |light_sample| {
            let diffuse = phong::diffuse(albedo, eight.normal, light_sample);
            if !may_shine {
                return diffuse;
            }
            let highlight = phong::specular(&gloss, eight.normal, eight.view, light_sample);
            diffuse + stands_for.select3(highlight, Vec3x8::ZERO)
        });
    }
}

/// Starts the rays that leave what was met.
fn go_on(frame: &FrameView, met: &Met, next: &mut Vec<Bounce>) {
    let optics = frame.scene.materials[usize::from(met.surface.material)].optics;
    let branches = branch(optics, &met.surface, met.bounce.direction);
    let guides = met.bounce.guides && !parts::shows_itself(frame, met.surface.material);
    grow(next, &met.surface, branches, |kind, weight, origin, direction| Bounce {
        kind,
        path: met.bounce.path << 1 | kind as u64,
        weight: weight * met.bounce.weight,
        origin,
        direction,
        guides,
        ..met.bounce
    });
}

/// Adds to `next` those of `branches` that are worth following.
fn grow(
    next: &mut Vec<Bounce>,
    surface: &Surface,
    branches: Branches,
    bounce: impl Fn(Kind, Vec3, Vec3, Vec3) -> Bounce,
) {
    let kinds = [(Kind::Reflection, branches.reflection), (Kind::Refraction, branches.refraction)];
    for (kind, ray) in kinds {
        let Some(ray) = ray else { continue };
        let grown = bounce(kind, ray.weight, surface.leave(ray.direction), ray.direction);
        if grown.weight.max_element() >= LEAST_WEIGHT {
            next.push(grown);
        }
    }
}

fn count(bounce: &Bounce, tally: &mut RayTally) {
    let counted = &mut tally.cells.secondary[bounce.cell as usize];
    *counted = counted.saturating_add(1);
    match bounce.kind {
        Kind::Reflection => tally.counts.reflection += 1,
        Kind::Refraction => tally.counts.refraction += 1,
    }
}

fn add(radiance: &mut Radiance, bounce: &Bounce, light: Vec3) {
    let layer = match bounce.layer {
        Kind::Reflection => &mut radiance.reflection,
        Kind::Refraction => &mut radiance.refraction,
    };
    for (column, light) in layer.iter_mut().zip((bounce.weight * light).to_array()) {
        column[bounce.cell as usize] += light;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_came_the_same_way_go_together_and_cells_keep_their_order() {
        // two rays on the way from each cell: off its glass, and through it and off what is behind
        let ray = |cell: u32, path: u64| Bounce {
            cell,
            kind: Kind::Reflection,
            layer: Kind::Reflection,
            path,
            weight: Vec3::ONE,
            origin: Vec3::ZERO,
            direction: Vec3::X,
            guides: false,
        };
        let mut rays: Vec<Bounce> = (0..20).flat_map(|cell| [ray(cell, 0b01), ray(cell, 0b10)]).collect();
        group(&mut rays);
        let sorted: Vec<(u64, u32)> = rays.iter().map(|ray| (ray.path, ray.cell)).collect();
        let expected: Vec<(u64, u32)> =
            [0b01, 0b10].into_iter().flat_map(|path| (0..20).map(move |cell| (path, cell))).collect();
        assert_eq!(sorted, expected);
    }
}
