//! Rays beyond the first surface: the light that mirrors and glass show. They depend on the eye and are traced
//! anew, unless they are known to bring the same light as before ([`ray_trees`](super::ray_trees)). Tracing is
//! breadth first: all rays of a tile that have bounced equally often are cast together. Light that the surfaces
//! gather or reflect by rough layers comes by [paths](crate::frame::light::light_paths), as that of samples
//! does.

use glam::Vec3;
use wide::u32x8;

use super::bounced_ray::{Bounce, Kind, LEAST_WEIGHT};
use super::parts;
use super::ray_trees::TreeScratch;
use super::tree_times::TreeTimes;
use crate::changes::Until;
use crate::frame::grid::bits::set_bits;
use crate::frame::light::light_paths::{PathScratch, trace_paths};
use crate::frame::light::lighting::{Places, add_light, emitted_and_ambient, shows_highlight};
use crate::frame::light::occlusion::{self, OcclusionScratch, OpenSurface};
use crate::frame::light::path_ends::{DrawnLayer, PathStart};
use crate::frame::light::shadow::{ShadowQueue, facing};
use crate::frame::light::step::Step;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::radiance::Radiance;
use crate::frame::surface::ray_tally::RayTally;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::layers::Layers;
use crate::pose::LightPose;
use crate::samples::Tag;
use crate::shade::area;
use crate::shade::coat::{LayerRays, Reflected, SeenBy, SeenCoat, SeenCoats};
use crate::shade::light::{StratifiedPattern, light_sample, light_samples, seeds_of_places, to_light};
use crate::shade::optics::{Branches, branch, random_of_place};
use crate::shade::sampling::{PathSequence, orthonormal, seed_of};
use crate::shade::surface::off_surfaces;
use crate::shade::{Surface, phong};
use crate::trace::{self, Coherence, HitPacket, NO_HIT, SceneSubset};

/// A surface that a ray has met.
#[derive(Debug, Clone, Copy)]
struct SecondaryHit {
    bounce: Bounce,
    surface: Surface,
    light: Vec3,
}

impl SecondaryHit {
    /// Start of the first path by which it gathers light; `owner` is its number.
    fn start(&self, owner: u32) -> PathStart {
        let Surface { point, normal, geometric_normal, material, .. } = self.surface;
        let sequence = PathSequence::of_seed(seed_of(point, material.into()));
        let ([tangent, _], cell) = (orthonormal(normal), self.bounce.cell);
        PathStart { owner, cell, index: 0, sequence, point, normal, tangent, geometric_normal, layer: None }
    }

    /// Layer of the surface as the ray sees it, if it has one.
    fn layer(&self, frame: &FrameView) -> Option<SeenCoat> {
        let Surface { normal, geometric_normal, material, reflectance, .. } = self.surface;
        let incoming = self.bounce.direction;
        frame.palette.coats.seen(material, reflectance, [normal, geometric_normal], incoming, SeenBy::Eye)
    }

    /// Number of paths or rays that it has where a sample has `count`. Noise is in proportion to the ray's
    /// weight over the root of this number: a faint picture needs fewer for no more of it.
    fn share_of(&self, count: u32) -> u32 {
        let weight = self.bounce.weight.max_element().min(1.0);
        (count.div_ceil(SHARE_OF_PATHS) as f32 * weight * weight).ceil() as u32
    }
}

/// Scratch memory of a worker for this phase.
#[derive(Debug, Default)]
pub struct Bounces {
    now: Vec<Bounce>,
    next: Vec<Bounce>,
    met: Vec<SecondaryHit>,
    /// Surfaces of `met`, eight side by side.
    eights: Vec<MetLanes>,
    /// Layers of some of these.
    coats: Vec<SeenCoats>,
    queue: ShadowQueue,
    /// Points of the current light that reach each surface of `met`, a bit each.
    lit: Vec<u16>,
    /// Segments of shadow rays, if their answers' validity is asked for.
    to_light: Vec<(Vec3, Vec3, f32)>,
    gathering: PathScratch,
    occlusion: OcclusionScratch,
    /// Light that the rough layers of samples reflect, with the cell.
    pub reflected: Vec<(u32, Vec3)>,
    /// Validity of the rays of the current tile, if it is asked for.
    pub times: TreeTimes,
    /// Trees of the current tile.
    pub trees: TreeScratch,
}

impl Bounces {
    /// Starts the rays that leave the sample of `cell`. `guides`: denoisers see the normals of the surfaces
    /// that the rays meet.
    pub fn start(
        &mut self,
        frame: &FrameView,
        cell: u32,
        surface: &Surface,
        guides: bool,
        branches: Branches,
    ) {
        let spread = frame.view.spread().by_distance;
        let bounce = |kind| Bounce { guides, spread, ..Bounce::from_sample(cell, kind) };
        grow(frame, step_of_sample(frame), surface, branches, bounce, &mut self.next);
    }

    /// Starts a ray for a texel of a map, which is accumulated as that of `cell`, from `origin` (world space)
    /// along `direction`, of unit length.
    pub fn start_from(&mut self, frame: &FrameView, cell: u32, origin: Vec3, direction: Vec3) {
        let step = step_of_sample(frame).next(false);
        if !step.is_beyond() {
            self.next.push(Bounce { step, origin, direction, ..Bounce::from_sample(cell, Kind::Reflection) });
        }
    }

    /// Adds to `radiance` the light that the map of `model` has in the directions in which rays would leave
    /// the sample of `cell`.
    pub fn look_up(
        &mut self,
        frame: &FrameView,
        (cell, model): (u32, u32),
        branches: Branches,
        radiance: &mut Radiance,
    ) {
        for (kind, ray) in [(Kind::Reflection, branches.reflection), (Kind::Refraction, branches.refraction)]
        {
            let Some(ray) = ray else { continue };
            if let Some(light) = frame.maps.look_up(model, ray.direction) {
                add(
                    radiance,
                    &Bounce { weight: ray.weight, ..Bounce::from_sample(cell, kind) },
                    ray.weight * light,
                );
                // the map is another when anything has moved
                self.times.note(cell, Until::UNKNOWN);
            }
        }
    }

    /// Starts the ray that the sample of `cell` reflects off the layer that the eye has `seen`, if that is
    /// smooth.
    pub fn start_off_layer(
        &mut self,
        frame: &FrameView,
        cell: u32,
        guides: bool,
        surface: &Surface,
        seen: &SeenCoat,
    ) {
        let spread = frame.view.spread().by_distance;
        let bounce = Bounce { guides, spread, ..Bounce::from_sample(cell, Kind::Reflection) };
        mirror(frame, step_of_sample(frame), bounce, surface, seen, &mut self.next);
    }
}

/// Place of samples on the ways of rays from the eye: before as many surfaces as the frame has depth.
fn step_of_sample(frame: &FrameView) -> Step {
    Step::first(frame.settings.depth + 1)
}

/// Returns true if a ray follows the layer that was `seen` by a ray of this `weight`.
pub fn is_followed(frame: &FrameView, seen: &SeenCoat, weight: Vec3) -> bool {
    seen.is_smooth() && frame.settings.depth > 0 && (seen.albedo * weight).max_element() >= LEAST_WEIGHT
}

/// Adds to `next` the ray that the smooth layer of `surface`, which is at this `step`, reflects; `bounce` gives
/// what else is known of it.
fn mirror(
    frame: &FrameView,
    step: Step,
    bounce: Bounce,
    surface: &Surface,
    seen: &SeenCoat,
    next: &mut Vec<Bounce>,
) {
    let step = step.next(false);
    if step.is_beyond() {
        return;
    }
    let reflected = seen.reflect([0.0; 2]).filter(|_| is_followed(frame, seen, bounce.weight));
    if let Some(Reflected { direction, weight, .. }) =
        reflected.filter(|reflected| surface.geometric_normal.dot(reflected.direction) > 0.0)
    {
        let origin = surface.leave(direction);
        let (weight, width) = (bounce.weight * weight, surface.width);
        next.push(Bounce { step, weight, origin, direction, width, ..bounce });
    }
}

/// Traces the rays that were [started](Bounces::start), and those that follow them up to the frame's depth, and
/// adds their light to the cells' radiance.
pub fn follow(frame: &FrameView, bounces: &mut Bounces, radiance: &mut Radiance, scratch: &mut TraceScratch) {
    let shows_guides = frame.layers.has(Layers::GUIDES);
    while !bounces.next.is_empty() {
        std::mem::swap(&mut bounces.now, &mut bounces.next);
        bounces.next.clear();
        group(&mut bounces.now);
        meet(frame, bounces, radiance, scratch);
        light(frame, bounces, &mut scratch.tally);
        gather(frame, bounces, &mut scratch.tally);
        reflect(frame, bounces, &mut scratch.tally);
        for met in &bounces.met {
            add(radiance, &met.bounce, met.bounce.weight * met.light);
            if shows_guides {
                let Bounce { cell, weight, guides, .. } = met.bounce;
                parts::see(frame, &mut radiance.parts, cell as usize, &met.surface, weight, guides);
            }
            go_on(frame, met, &mut bounces.next);
        }
    }
}

/// Groups rays by their paths. The rays that a surface reflects and those that it lets through part there,
/// and in one packet neither would have a neighbour. The order of rays within a cell, in which light is added
/// up, stays: in `rays` those of one cell are in the order of their paths, all of which are equally long.
fn group(rays: &mut [Bounce]) {
    rays.sort_by_key(|ray| ray.path);
}

/// Finds the surfaces that the rays meet; rays that meet nothing see the background.
fn meet(frame: &FrameView, bounces: &mut Bounces, radiance: &mut Radiance, scratch: &mut TraceScratch) {
    scratch.begin_rays();
    for bounce in &bounces.now {
        scratch.rays.push(bounce.origin, bounce.direction, 0.0, f32::INFINITY);
        count(bounce, &mut scratch.tally);
    }
    // trees that are no longer valid are traced among others that are
    let coherence = if frame.keeps_trees { Coherence::BouncedIndependent } else { Coherence::Bounced };
    frame.tracer.closest(&scratch.rays, SceneSubset::All, coherence, &mut scratch.hits);
    bounces.met.clear();
    for (number, bounce) in bounces.now.chunks(LANES).enumerate() {
        let (packet, from) =
            (&scratch.hits.packets[number * LANES / trace::LANES], number * LANES % trace::LANES);
        let models = &packet.model[from..from + LANES];
        for (lane, (bounce, model)) in bounce.iter().zip(models).enumerate() {
            let is_hit = *model != NO_HIT;
            let far = if is_hit { packet.t[from + lane] } else { f32::INFINITY };
            bounces.times.note_met(frame, bounce.cell, *model);
            bounces.times.note_segment(frame, bounce.cell, bounce.origin, bounce.direction, far);
            let of_lights = bounce.light_of_lights(frame, far);
            let of_sky = if is_hit { Vec3::ZERO } else { frame.sky.radiance(bounce.direction) };
            if !is_hit || of_lights != Vec3::ZERO {
                add(radiance, bounce, bounce.weight * (of_lights + of_sky));
            }
        }
        meet_surfaces(frame, packet, from, bounce, &mut bounces.met);
    }
}

/// Adds the surfaces that up to eight rays met; their hits are in lanes `from` onwards of a packet.
fn meet_surfaces(
    frame: &FrameView,
    packet: &HitPacket,
    from: usize,
    bounces: &[Bounce],
    met: &mut Vec<SecondaryHit>,
) {
    let hits = Hits8::new(packet, from);
    let direction = |lane: usize| bounces[lane].direction;
    let beam = |lane: usize| bounces[lane].width + bounces[lane].spread * packet.t[from + lane];
    surfaces(frame, &hits, bounces.len(), direction, beam, |lane, surface| {
        met.push(SecondaryHit { bounce: bounces[lane], surface, light: Vec3::ZERO });
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
    /// Seeds for the points on area lights that they ask.
    seeds: u32x8,
    materials: [u16; LANES],
    /// Light that they show, summed so far.
    light: Vec3x8,
    /// Index of their layers, if any has one.
    coats: Option<usize>,
    /// Bit mask of the lanes in use.
    used: u8,
}

impl MetLanes {
    fn new(met: &[SecondaryHit]) -> Self {
        let at = |lane: usize| &met[if lane < met.len() { lane } else { 0 }];
        let each = |value: fn(&SecondaryHit) -> Vec3| {
            let mut all = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, value(at(lane))));
            all
        };
        let point = each(|met| met.surface.point);
        Self {
            point,
            seeds: seeds_of_places(point),
            normal: each(|met| met.surface.normal),
            geometric_normal: each(|met| met.surface.geometric_normal),
            reflectance: each(|met| met.surface.reflectance),
            view: each(|met| -met.bounce.direction),
            materials: std::array::from_fn(|lane| at(lane).surface.material),
            light: Vec3x8::ZERO,
            coats: None,
            used: u8::MAX >> (LANES - met.len()),
        }
    }
}

/// Computes the light of the surfaces that were met, highlights included.
fn light(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    bounces.eights.clear();
    bounces.eights.extend(bounces.met.chunks(LANES).map(MetLanes::new));
    bounces.coats.clear();
    look_around(frame, bounces, tally);
    for (first, (eight, met)) in
        (0..).step_by(LANES).zip(bounces.eights.iter_mut().zip(bounces.met.chunks(LANES)))
    {
        let share = |lane: usize| if lane < met.len() { bounces.occlusion.share(first + lane) } else { 0.0 };
        let openness = || F32x8::new(std::array::from_fn(share));
        eight.light = emitted_and_ambient(frame, (&eight.materials, eight.reflectance), openness);
        let MetLanes { reflectance, normal, geometric_normal, view, .. } = *eight;
        let normals = [normal, geometric_normal];
        let rays = |lane: usize| met.get(lane).map_or(0, |met| rays_onwards(frame, met));
        let has_coats = frame.palette.coats.any(&eight.materials);
        let rays = has_coats.then(|| LayerRays { count: std::array::from_fn(rays), incoming: -view });
        let coats = frame.palette.coats.seen_lanes(&eight.materials, reflectance, normals, -view, rays);
        if let Some(coats) = coats {
            eight.light = coats.show(eight.light);
            eight.coats = Some(bounces.coats.len());
            bounces.coats.push(coats);
        }
    }
    for light in frame.pose.lights.iter().filter(|light| !light.is_dark()) {
        ask_light(frame, light, bounces, tally);
        shine(frame, light, bounces);
    }
    for (met, eight) in bounces.met.chunks_mut(LANES).zip(&bounces.eights) {
        met.iter_mut().enumerate().for_each(|(lane, met)| met.light = eight.light.lane(lane));
    }
}

/// Computes the openness of the surfaces that were met, where it dims their ambient light: by fewer rays than
/// samples have.
fn look_around(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    let Some(occlusion) = frame.occlusion.filter(|occlusion| occlusion.dims_ambient) else { return };
    let Bounces { met, occlusion: scratch, times, .. } = bounces;
    scratch.looks.clear();
    scratch.looks.extend((0..).zip(&*met).map(|(number, met)| {
        let is_dimmed = frame.palette.has_ambient(met.surface.material);
        OpenSurface {
            start: met.start(number),
            rays: if is_dimmed { met.share_of(occlusion.rays) } else { 0 },
        }
    }));
    occlusion::look_around(frame, scratch, tally);
    let found = scratch.looks.iter().zip(&scratch.found);
    found.for_each(|(look, found)| times.note(look.start.cell, found.until));
}

/// Adds the light that the surfaces that were met gather from all around. It is computed anew for each frame
/// in which they are seen, by fewer paths than samples have: a surface in a mirror counts for less, and its
/// light is not kept.
fn gather(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    let Bounces { met, gathering, times, .. } = bounces;
    let count = |met: &SecondaryHit| met.share_of(frame.first_paths as u32);
    let is_diffuse = |met: &SecondaryHit| frame.palette.is_diffuse(met.surface.material);
    for (first, some) in (0..).step_by(GATHER_AT_ONCE).zip(met.chunks_mut(GATHER_AT_ONCE)) {
        gathering.starts.clear();
        for (number, met) in (first..).zip(&*some).filter(|(_, met)| is_diffuse(met)) {
            let start = met.start(number);
            gathering.starts.extend((0..count(met)).map(|index| PathStart { index, ..start }));
        }
        trace_paths(frame, gathering, tally);
        let brought = gathering.starts.iter().zip(&gathering.brought);
        for (start, brought) in brought {
            let met = &mut some[(start.owner - first) as usize];
            let albedo = frame.palette.albedo_of(met.surface.material, met.surface.reflectance);
            let albedo = met.layer(frame).map_or(albedo, |seen| albedo * seen.through);
            met.light += albedo * brought.radiance / count(met) as f32;
            times.note(start.cell, brought.until);
        }
    }
}

/// Adds the light that the rough layers of the surfaces that were met reflect: by one path each, which is drawn
/// anew for each frame.
fn reflect(frame: &FrameView, bounces: &mut Bounces, tally: &mut RayTally) {
    let Bounces { met, gathering, times, .. } = bounces;
    for (first, some) in (0..).step_by(GATHER_AT_ONCE).zip(met.chunks_mut(GATHER_AT_ONCE)) {
        gathering.starts.clear();
        for (number, met) in (first..).zip(&*some) {
            let layer = met.layer(frame).filter(|seen| !seen.is_smooth() && rays_onwards(frame, met) > 0);
            gathering.starts.extend(layer.map(|seen| {
                let seed = seed_of(met.surface.point, met.surface.material.into());
                let sequence = PathSequence::of_reflections_of_seed(seed);
                PathStart { sequence, layer: Some(DrawnLayer { seen, paths: 1 }), ..met.start(number) }
            }));
        }
        trace_paths(frame, gathering, tally);
        for (start, brought) in gathering.starts.iter().zip(&gathering.brought) {
            if let Some(layer) = &start.layer {
                let brings = (brought.radiance, brought.sees_light);
                some[(start.owner - first) as usize].light +=
                    layer.shows(frame, start, 0, &layer.seen, brings);
            }
            times.note(start.cell, brought.until);
        }
    }
}

/// Divisor of the number of paths and of occlusion rays, from that of a sample to that of a surface in a
/// mirror or behind glass.
const SHARE_OF_PATHS: u32 = 4;

/// Number of surfaces that gather light at once.
const GATHER_AT_ONCE: usize = 256;

/// Finds the points of `light` that reach each surface that was met.
fn ask_light(frame: &FrameView, light: &LightPose, bounces: &mut Bounces, tally: &mut RayTally) {
    let Bounces { met, eights, queue, lit, to_light, times, .. } = bounces;
    queue.clear();
    to_light.clear();
    lit.clear();
    lit.resize(met.len(), 0);
    let mut count = |number: usize, rays: u32| {
        let counted = &mut tally.cells.shadow[met[number].bounce.cell as usize];
        // many panes under many panels may cast more rays than a word holds
        *counted = counted.saturating_add(rays as u16);
    };
    for (eight, first) in eights.iter().zip((0..).step_by(LANES)) {
        let pattern = StratifiedPattern::of_seeds(light, eight.seeds);
        let origins = off_surfaces(eight.point, eight.geometric_normal);
        if light.points == 1 {
            let light_sample = light_sample(light, 0, &pattern, eight.point);
            let asked =
                phong::receives(eight.normal, eight.geometric_normal, &light_sample).bits() & eight.used;
            queue.push_from(origins, &light_sample, asked, first as u32);
            for lane in set_bits(asked) {
                count(first + lane, 1);
                if times.are_asked() {
                    to_light.push((origins.lane(lane), light_sample.to_light.lane(lane), light_sample.far));
                }
            }
            continue;
        }
        for lane in set_bits(eight.used) {
            let light_samples = light_samples(light, &pattern, lane, eight.point.lane(lane));
            let asked = facing(eight.normal.lane(lane), eight.geometric_normal.lane(lane), &light_samples);
            queue.push_sixteen(origins.lane(lane), &light_samples, asked, (first + lane) as u32);
            count(first + lane, asked.count_ones());
            for point in set_bits(if times.are_asked() { asked } else { 0 }) {
                let way = light_samples[point / LANES].to_light.lane(point % LANES);
                to_light.push((origins.lane(lane), way, light_samples[0].far));
            }
        }
    }
    tally.counts.shadow += queue.count();
    let check = ShadowCheck::StillThenMovable;
    // segments in the order of the answers; a still occluder stays in the way, whatever else comes there or
    // goes
    let mut to_light = to_light.iter();
    let mut note = |owner: u32, by_still: bool| {
        if let Some((origin, way, far)) = to_light.next().filter(|_| !by_still) {
            times.note_segment(frame, met[owner as usize].bounce.cell, *origin, *way, *far);
        }
    };
    if light.points > 1 {
        queue.answer_sixteen(
            check,
            SceneSubset::All,
            Coherence::SharedOrigin,
            frame.tracer,
            |owner, shadows| {
                lit[owner as usize] = shadows.asked & !shadows.blocked;
                let by_still = shadows.blocked & !shadows.by_dynamic;
                set_bits(shadows.asked).for_each(|point| note(owner, by_still >> point & 1 != 0));
            },
        );
    } else {
        queue.answer(check, SceneSubset::All, Coherence::Bounced, frame.tracer, |owner, tag| {
            lit[owner as usize] = u16::from(tag.is_lit());
            note(owner, tag == Tag::StaticOccluder);
        });
    }
}

/// Adds the light of those points of `light` that reach the surfaces that were met.
fn shine(frame: &FrameView, light: &LightPose, bounces: &mut Bounces) {
    let eights = bounces.eights.iter_mut().zip(bounces.lit.chunks(LANES));
    for (eight, lit) in eights.filter(|(_, lit)| lit.iter().any(|points| *points != 0)) {
        let gloss = frame.palette.gloss(&eight.materials);
        let coats = eight.coats.map(|number| &bounces.coats[number]);
        let (to_centre, reach) = (to_light(light, eight.point).0, light.shape.reach());
        let albedo = frame.palette.albedo(&eight.materials, eight.reflectance);
        let stands_for = shows_highlight(frame, light, &gloss);
        let radiance = area::radiance(light);
        let may_shine = gloss.is_any && phong::may_shine(&gloss, eight.normal, eight.view, to_centre, reach);
        let mut points = [0; LANES];
        points[..lit.len()].copy_from_slice(lit);
        let places = Places { point: eight.point, seeds: eight.seeds };
        let reached = |point: usize| Mask::new(|lane| points[lane] >> point & 1 != 0);
        eight.light = add_light(eight.light, light, places, reached, |light_sample| {
            let mut light = phong::diffuse(albedo, eight.normal, light_sample);
            if let Some(coats) = coats {
                light = light * coats.through + coats.highlight(light_sample, radiance);
            }
            if !may_shine {
                return light;
            }
            let highlight = phong::specular(&gloss, eight.normal, eight.view, light_sample);
            light + stands_for.select3(highlight, Vec3x8::ZERO)
        });
    }
}

/// Number of paths, or rays, by which the layer of a surface that a ray has met reflects: none if it is the last
/// one, and one at most; only samples have several.
fn rays_onwards(frame: &FrameView, met: &SecondaryHit) -> u32 {
    let reflects = |seen: &SeenCoat| seen.is_smooth() || frame.settings.reflections > 0;
    let is_worth = |seen: &SeenCoat| met.bounce.is_worth(seen.albedo * met.bounce.weight);
    let ends = met.bounce.step.is_last();
    u32::from(!ends && met.layer(frame).is_some_and(|seen| reflects(&seen) && is_worth(&seen)))
}

/// Starts the rays that leave a surface that was met.
fn go_on(frame: &FrameView, met: &SecondaryHit, next: &mut Vec<Bounce>) {
    let SecondaryHit { surface, bounce, .. } = met;
    let material = &frame.scene.materials[usize::from(surface.material)];
    if bounce.step.is_last() && !material.optics.is_straight() {
        return;
    }
    let branches = branch(material, surface, bounce.direction, || random_of_place(surface));
    let guides = bounce.guides && !parts::shows_itself(frame, surface.material);
    grow(frame, bounce.step, surface, branches, |kind| Bounce { guides, ..bounce.onwards(kind) }, next);
    if let Some(seen) = met.layer(frame) {
        let mirrored = Bounce { guides, ..bounce.onwards(Kind::Reflection) };
        mirror(frame, bounce.step, mirrored, surface, &seen, next);
    }
}

/// Adds to `next` those of `branches` that are worth following from `surface`, which is at this `step`. `bounce`
/// gives what they have in common with the ray that met it.
fn grow(
    frame: &FrameView,
    step: Step,
    surface: &Surface,
    branches: Branches,
    bounce: impl Fn(Kind) -> Bounce,
    next: &mut Vec<Bounce>,
) {
    let is_straight = frame.scene.materials[usize::from(surface.material)].optics.is_straight();
    let kinds = [
        (Kind::Reflection, branches.reflection, step.next(false)),
        (Kind::Refraction, branches.refraction, step.next(is_straight)),
    ];
    for (kind, ray, step) in kinds {
        let Some(ray) = ray.filter(|_| !step.is_beyond()) else { continue };
        let bounce = bounce(kind);
        let weight = ray.weight * bounce.weight;
        if bounce.is_worth(weight) {
            next.push(Bounce {
                step,
                weight,
                origin: surface.leave(ray.direction),
                direction: ray.direction,
                width: surface.width,
                ..bounce
            });
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

/// Adds `light` to the radiance of the cell of a ray.
fn add(radiance: &mut Radiance, bounce: &Bounce, light: Vec3) {
    radiance.add_secondary(bounce.layer, bounce.cell as usize, light);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_that_came_the_same_way_go_together_and_cells_keep_their_order() {
        // two rays on the way from each cell: off its glass, and through it and off what is behind
        let ray = |cell: u32, path: u64| Bounce { path, ..Bounce::from_sample(cell, Kind::Reflection) };
        let mut rays: Vec<Bounce> = (0..20).flat_map(|cell| [ray(cell, 0b01), ray(cell, 0b10)]).collect();
        group(&mut rays);
        let sorted: Vec<(u64, u32)> = rays.iter().map(|ray| (ray.path, ray.cell)).collect();
        let expected: Vec<(u64, u32)> =
            [0b01, 0b10].into_iter().flat_map(|path| (0..20).map(move |cell| (path, cell))).collect();
        assert_eq!(sorted, expected);
    }
}
