//! Light paths: rays that leave surfaces in all directions and collect the light that arrives from there.
//!
//! A path starts at a surface in a direction by the cosine law. A ray that escapes brings the light of the
//! sky. A ray that meets a surface brings the light that this surface emits, and its reflection of a light, of
//! the sky and of an emitting surface, each asked at random ([next-event estimation](super::next_event)). From
//! there the path goes on, as many times as the shot says. A path is a function of its start and of the scene
//! in this frame, and of no other path: rays are cast one by one ([`Coherence::Incoherent`]). So a path can
//! be traced again, alone, with the same result to the bit.
//!
//! For each path the first frame is found in which its result may differ
//! ([`Motion`](crate::changes::Motion)): when something that moves touches one of its segments, or when a
//! light changes that it has asked.

use glam::Vec3;

use super::asked_lights::{AskingScratch, light_vertices};
use super::clamp::limit_paths;
use super::light_choice::{Kinds, light_asked, paths_go_on, surfaces_on_paths};
use super::lobes::Lobes;
use super::next_event::{Asking, LightRays};
use super::path_ends::{Below, PathResult, PathStart};
use super::path_ray::{InMedia, PathRay};
use super::pdfs::Pdfs;
use super::scattering::{self, OnWay};
use super::starts::Starts;
use super::step::Step;
use super::subsurface::{self, WalkScratch};
use super::vertex::{NO_BSDF, Vertex, go_on};
use crate::changes::Until;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::computed_hits::ComputedHits;
use crate::frame::surface::footprints::SPREAD_OF_PATHS;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::media::spans::Spans;
use crate::scene::RayKind;
use crate::shade::bsdf::{SeenBsdf, SeenBy};
use crate::shade::sampling::PathRandom;
use crate::shade::surface::off_surface;
use crate::trace::{self, Coherence, HitBatch, NO_HIT, OfKind, RayBatch, SceneSubset, Search};

/// Paths that are traced at once: their rays fit into a second-level cache.
pub const AT_ONCE: usize = 256;

/// Prefetch distance of the triangles of hits, in groups of eight hits; their corners are fetched at half of
/// it.
const AHEAD: usize = 4;

/// Scratch memory of a worker for paths.
#[derive(Debug, Default)]
pub struct PathScratch {
    /// Paths to be traced.
    pub starts: Starts,
    /// Results of these paths, in the same order.
    pub brought: Vec<PathResult>,
    /// Their random numbers.
    random: Vec<PathRandom>,
    /// Direct light in these results, if the rest is limited.
    direct: Vec<Vec3>,
    rays: RayBatch,
    /// Their kinds, if any model is hidden from some.
    kinds: Vec<RayKind>,
    hits: HitBatch,
    computed: ComputedHits,
    now: Vec<PathRay>,
    next: Vec<PathRay>,
    walks: WalkScratch,
    /// Last rays of their paths.
    last: Vec<PathRay>,
    vertices: Vec<Vertex>,
    /// Layers of those vertices that have one.
    bsdfs: Vec<SeenBsdf>,
    asking: AskingScratch,
    light_rays: LightRays,
    /// Parts of the ray at work that lie in media.
    spans: Spans,
}

/// Traces the paths in `scratch.starts`, and writes their results to `scratch.brought`. They are all gathered
/// or all reflected.
pub fn trace_paths(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let is_reflected = scratch.starts.are_reflected();
    begin(frame, is_reflected, scratch);
    let PathScratch { starts, brought, light_rays, .. } = &mut *scratch;
    light_rays.cast(frame, starts, brought, tally);
    if frame.palette.scatters_below {
        let PathScratch { starts, brought, random, walks, vertices, .. } = &mut *scratch;
        subsurface::walk(frame, walks, (starts, random), (brought, vertices), tally);
        scratch.bsdfs.clear();
        light(frame, scratch, tally);
        go_on_from_vertices(frame, scratch);
        let PathScratch { now, next, .. } = &mut *scratch;
        now.append(next);
    }
    let mut is_first = true;
    while !scratch.now.is_empty() {
        cast(frame, is_reflected && is_first, scratch, tally);
        meet(frame, scratch);
        if is_first && frame.settings.clamp.is_some() {
            note_direct(frame, scratch);
        }
        light(frame, scratch, tally);
        scratch.now.clear();
        go_on_from_vertices(frame, scratch);
        std::mem::swap(&mut scratch.now, &mut scratch.next);
        is_first = false;
    }
    std::mem::swap(&mut scratch.now, &mut scratch.last);
    if !scratch.now.is_empty() {
        cast(frame, false, scratch, tally);
        end(frame, scratch);
    }
    if let Some(most) = frame.settings.clamp {
        limit_paths(&mut scratch.brought, &scratch.direct, most);
    }
}

/// Lights the vertices.
fn light(frame: &FrameView, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, vertices, bsdfs, asking, light_rays, .. } = scratch;
    light_vertices(frame, (vertices, bsdfs), (starts, brought), (asking, light_rays), tally);
}

/// Adds what the vertices bring to the results of their paths, and makes the rays that go on from there.
fn go_on_from_vertices(frame: &FrameView, scratch: &mut PathScratch) {
    let PathScratch { random, brought, next, last, vertices, bsdfs, .. } = scratch;
    for vertex in &*vertices {
        let (path, step) = (vertex.ray.path as usize, vertex.ray.step);
        brought[path].radiance += vertex.ray.weight * vertex.light;
        if paths_go_on(frame, step) || vertex.goes_on_at_all(frame) {
            let numbers = random[path].four(step.going_on());
            if let Some(ray) = go_on(frame, (vertex, vertex.seen_bsdf(bsdfs)), numbers) {
                (if ray.step.is_beyond() { &mut *last } else { &mut *next }).push(ray);
            }
        }
    }
}

/// Makes the first rays of the paths, and asks for light at their starts.
fn begin(frame: &FrameView, is_reflected: bool, scratch: &mut PathScratch) {
    let PathScratch {
        starts,
        brought,
        random: all_random,
        direct,
        now,
        next,
        last,
        light_rays,
        walks,
        spans,
        ..
    } = scratch;
    all_random.clear();
    all_random.extend(starts.iter().map(PathStart::random));
    brought.clear();
    direct.clear();
    now.clear();
    next.clear();
    last.clear();
    light_rays.begin();
    let step = Step::first(surfaces_on_paths(frame, is_reflected));
    let first = if step.is_beyond() { last } else { now };
    for ((path, start), random) in (0..).zip(starts.iter()).zip(&*all_random) {
        if let (Some(media), Some(seen)) = (frame.media, starts.seen(start)) {
            media.find((seen.origin, seen.direction), seen.far, frame.tick_of(start.cell), spans);
            let mut brings = PathResult { radiance: Vec3::ZERO, sees_light: false, until: Until::FOREVER };
            let asking = (&mut *light_rays, &mut brings);
            first.extend(scattering::towards(frame, (path, start, seen), spans, *random, asking));
            brought.push(brings);
            continue;
        }
        let below = starts.below(start);
        if below.is_some_and(|below| subsurface::enter(frame, (path, start), below, *random, walks)) {
            brought.push(subsurface::nothing_yet(frame, start));
            continue;
        }
        let mut brings = PathResult { radiance: Vec3::ZERO, sees_light: false, until: Until::FOREVER };
        let ray = match starts.layer(start) {
            None => gathers(frame, (path, step), (start, below, *random), light_rays, &mut brings),
            Some(layer) => {
                light_rays.ask_for_layer(frame, path, (start, *random), layer, &mut brings);
                let [along, above, ..] = random.four(0);
                let drawn = layer.direction(start, [along, above]);
                drawn.map(|(direction, density)| {
                    let origin = start.origin(direction);
                    let (weight, asked_from, normal) = (Vec3::ONE, origin, direction);
                    let chances = layer.chances(frame, density);
                    let seen_by = if layer.seen.is_narrow() { SeenBy::Eye } else { SeenBy::Path };
                    let (kind, within) = (RayKind::Glossy, start.within);
                    PathRay {
                        path,
                        tick: frame.tick_of(start.cell),
                        step,
                        weight,
                        origin,
                        direction,
                        asked_from,
                        normal,
                        chances,
                        seen_by,
                        kind,
                        receiver: start.model,
                        within,
                        media: InMedia::default(),
                    }
                })
            }
        };
        match ray {
            Some(ray) => first.push(ray),
            // below the surface: dark until the surface moves
            None => brings.until = brings.until.min(frame.first_touch(start.point, start.normal, 0.0)),
        }
        brought.push(brings);
    }
}

/// First ray of a path by the cosine law, if it leaves the surface, which asks the sky and emitting surfaces
/// beside it.
fn gathers(
    frame: &FrameView,
    (path, step): (u32, Step),
    (start, below, random): (&PathStart, Option<&Below>, PathRandom),
    light_rays: &mut LightRays,
    brings: &mut PathResult,
) -> Option<PathRay> {
    let [along, above, ..] = random.four(0);
    let PathStart { point, normal, geometric_normal, horizon, .. } = *start;
    let weight = below.map_or(Vec3::ONE, Below::weight_at_surface);
    let chances = Pdfs::of_start(frame);
    let (origin, bsdf) = (off_surface(point, geometric_normal), None);
    let (tick, model) = (frame.tick_of(start.cell), start.model);
    let asking =
        Asking { path, tick, model, point, origin, normal, geometric_normal, horizon, weight, chances, bsdf };
    for place in places_in_sky(frame, &random) {
        light_rays.ask_sky(frame, &asking, place);
    }
    if chances.asks_emitter > 0.0 {
        // a set that no vertex uses: theirs have numbers up to twice the bounces
        let [triangle, along, above, _] = random.four(2 * frame.settings.bounces + 1);
        light_rays.ask_emitter(frame, &asking, [triangle, along, above], brings);
    }
    let direction = start.direction([along, above]);
    start.leaves(direction).then(|| {
        let origin = horizon.origin(origin, direction, geometric_normal);
        let weight = weight * horizon.fading(normal, direction);
        let (asked_from, seen_by, kind) = (origin, SeenBy::Path, RayKind::Diffuse);
        PathRay {
            path,
            tick,
            step,
            weight,
            origin,
            direction,
            asked_from,
            normal,
            chances,
            seen_by,
            kind,
            receiver: start.model,
            within: start.within,
            media: InMedia::default(),
        }
    })
}

/// Light of the sky that a path by the cosine law would bring by its first rays if nothing were in their way.
pub fn light_of_open_sky(frame: &FrameView, start: &PathStart) -> Vec3 {
    let (random, chances) = (start.random(), Pdfs::of_start(frame));
    let mut light = Vec3::ZERO;
    for place in places_in_sky(frame, &random) {
        light += chances.of_asked_sky(frame, start, place);
    }
    let [along, above, ..] = random.four(0);
    let direction = start.direction([along, above]);
    if start.leaves(direction) {
        let shown = start.horizon.fading(start.normal, direction);
        light += shown * chances.of_sky(frame, start.normal, direction);
    }
    light
}

/// Random numbers for the directions in which the start of a path asks the sky. Further rays use sets of numbers of their
/// own, after those of emitters and of all vertices.
fn places_in_sky(frame: &FrameView, random: &PathRandom) -> impl Iterator<Item = [f32; 2]> {
    (0..frame.sky.samples()).map(move |number| match number {
        0 => {
            let [.., across, up] = random.four(0);
            [across, up]
        }
        _ => {
            let [across, up, ..] = random.four(2 * frame.settings.bounces + 1 + number);
            [across, up]
        }
    })
}

/// Notes the direct light of paths: the light that they have brought so far, and the emission of the surfaces
/// that they have met first.
fn note_direct(frame: &FrameView, scratch: &mut PathScratch) {
    let PathScratch { brought, direct, vertices, .. } = scratch;
    direct.extend(brought.iter().map(|brought| brought.radiance));
    for vertex in &*vertices {
        let emission = vertex.surface.emission(frame.scene);
        direct[vertex.ray.path as usize] += vertex.ray.weight * emission * vertex.emission_weight;
    }
}

/// Casts the current rays. Rays that escape bring the light of the sky. The paths expire when something that
/// moves touches these rays, if not before. `is_reflection`: they leave the layers of surfaces.
fn cast(frame: &FrameView, is_reflection: bool, scratch: &mut PathScratch, tally: &mut RayTally) {
    let PathScratch { starts, brought, random, rays, kinds, hits, now, next, light_rays, spans, .. } =
        scratch;
    rays.clear();
    kinds.clear();
    if frame.hides_from_some {
        kinds.extend(now.iter().map(|ray| ray.kind));
    }
    for ray in &*now {
        rays.push(ray.origin, ray.direction, 0.0, f32::INFINITY);
        let counted = &mut tally.cells.secondary[starts[ray.path as usize].cell as usize];
        *counted = counted.saturating_add(1);
    }
    frame.set_ticks(rays, now.iter().map(|ray| starts[ray.path as usize].cell));
    let counts = &mut tally.counts;
    *(if is_reflection { &mut counts.reflection } else { &mut counts.gathering }) += now.len() as u64;
    let search =
        Search { kinds: OfKind::of(kinds), among: SceneSubset::All, coherence: Coherence::Incoherent };
    frame.tracer.closest(rays, search, hits);
    let has_areas = frame.media.is_some() && frame.pose.lights.iter().any(|light| light.shape.is_area());
    for (packet, some) in hits.packets.iter_mut().zip(now.chunks_mut(trace::LANES)) {
        for (lane, ray) in some.iter_mut().enumerate() {
            let model = packet.model[lane];
            let is_hit = model != NO_HIT;
            let far = if is_hit { packet.t[lane] } else { f32::INFINITY };
            let brought = &mut brought[ray.path as usize];
            brought.until = brought.until.min(frame.change_of_met(model));
            brought.until = frame.first_touch_before(ray.origin, ray.direction, far, brought.until);
            let mut left = Vec3::ONE;
            if let Some(media) = frame.media {
                media.find((ray.origin, ray.direction), far, ray.tick, spans);
                brought.radiance += ray.weight * spans.emitted(frame.scene.ambient);
                let way = (&*spans, has_areas && !ray.chances.lights_are_summed());
                let random = random[ray.path as usize];
                if !ray.step.is_beyond()
                    && let OnWay::Scattered(onwards) =
                        scattering::on_way(frame, ray, way, random, light_rays, brought)
                {
                    // it does not come to what it would have met
                    packet.model[lane] = NO_HIT;
                    next.extend(onwards);
                    continue;
                }
                left = spans.left();
            }
            if !ray.chances.lights_are_summed() {
                brought.until = brought.until.min(frame.area_light_change);
                brought.radiance += ray.light_of_lights(frame, far);
            }
            if !is_hit {
                brought.radiance += ray.light_of_sky(frame) * left;
                continue;
            }
            ray.weight *= left;
            if frame.palette.absorbs {
                ray.weight *= ray.within.left(frame.palette, far);
            }
        }
    }
}

/// Makes vertices of the hits of the current rays.
fn meet(frame: &FrameView, scratch: &mut PathScratch) {
    let PathScratch { random, hits, computed, now, vertices, bsdfs, .. } = scratch;
    vertices.clear();
    bsdfs.clear();
    computed.compute(frame, hits, now.len(), |_, t| t * SPREAD_OF_PATHS);
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
            &Hits8::new(packet, from).with_computed(computed.eight(number)),
            some.len(),
            |lane| some[lane].direction,
            |lane| packet.t[from + lane] * SPREAD_OF_PATHS,
            |lane| some[lane].tick,
            |lane, surface| {
                let ray = some[lane];
                let step = ray.step;
                let random = random[ray.path as usize];
                let surface = subsurface::side(frame, surface, || random.four(step.going_on())[3]);
                let random = random.four(step.asking());
                let primitive = (packet.model[from + lane], packet.triangle[from + lane]);
                let (asked_light, chance) = light_asked(frame, primitive.0, surface.point, random[0]);
                let distance = packet.t[from + lane];
                let (look, axes) = (surface.look(), surface.axes());
                let layers = &frame.palette.bsdfs;
                let bsdf = layers.seen(look, surface.reflectance, axes, ray.direction, ray.seen_by);
                let lobes = Lobes::new(frame, &surface, ray.direction, bsdf.as_ref());
                let number = if bsdf.is_some() { bsdfs.len() as u32 } else { NO_BSDF };
                bsdfs.extend(bsdf);
                vertices.push(Vertex {
                    ray,
                    surface,
                    model: primitive.0,
                    light: Vec3::ZERO,
                    emission_weight: ray.emission_weight(frame, primitive, &surface, distance),
                    asks: Kinds::of(frame, step),
                    asked_light,
                    chance,
                    random,
                    lobes,
                    bsdf: number,
                    is_exit: false,
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
            |lane| packet.t[from + lane] * SPREAD_OF_PATHS,
            |lane| some[lane].tick,
            |lane, surface| {
                let ray = some[lane];
                let primitive = (packet.model[from + lane], packet.triangle[from + lane]);
                let distance = packet.t[from + lane];
                let emission = surface.emission(frame.scene);
                let weight = ray.emission_weight(frame, primitive, &surface, distance);
                brought[ray.path as usize].radiance += ray.weight * emission * weight;
            },
        );
    }
}
