//! Surfaces that rays beyond the first surface meet, and the light that they show: that of lights, and what they
//! gather and reflect by rough layers, by [paths](crate::frame::light::light_paths) as samples do.

use glam::Vec3;
use wide::u32x8;

use super::bounced_ray::Bounce;
use super::tree_times::TreeTimes;
use crate::changes::Until;
use crate::exposure::Tick;
use crate::frame::grid::bits::set_bits;
use crate::frame::light::light_paths::{PathScratch, trace_paths};
use crate::frame::light::lighting::{
    Places, add_light, emitted_and_ambient, sample_of_light, shows_highlight,
};
use crate::frame::light::occlusion::{self, OcclusionScratch, OpenSurface};
use crate::frame::light::path_ends::{Below, DrawnLayer, PathStart};
use crate::frame::light::shadow::ShadowQueue;
use crate::frame::light::starts::NOTHING;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{EMPTY, Tag};
use crate::scene::look::Look;
use crate::shade::Surface;
use crate::shade::bsdf::phong;
use crate::shade::bsdf::{LayerRays, SeenBsdf, SeenBsdfs, SeenBy, SurfaceAxes};
use crate::shade::light::{StratifiedPattern, light_samples, seeds_of_places, to_light};
use crate::shade::sampling::{PathSequence, orthonormal, seed_of};
use crate::shade::terminator::{Receivers, ToSixteen};
use crate::trace::{Coherence, SceneSubset};

/// A surface that a ray has met.
#[derive(Debug, Clone, Copy)]
pub struct MetSurface {
    /// The ray.
    pub bounce: Bounce,
    pub surface: Surface,
    /// Number of the model.
    pub model: u32,
    /// Number of the triangle, or of another primitive.
    pub triangle: u32,
    /// Barycentric weights there.
    pub weights: [f32; 2],
    /// Number of paths by which it gathers light, if it does.
    pub paths: u32,
    /// True if its light may be [kept](super::mirrors).
    pub is_kept: bool,
    /// Light that it shows, once that is [known](MetSurfaces::light).
    pub light: Vec3,
    /// First frame in which that may differ, if it is asked.
    pub until: Until,
}

impl MetSurface {
    /// Start of the first path by which it gathers light; `owner` is its number.
    fn start(&self, owner: u32) -> PathStart {
        let Surface { point, normal, geometric_normal, horizon, material, .. } = self.surface;
        let sequence = PathSequence::of_seed(seed_of(point, material.into()));
        let ([tangent, _], cell) = (orthonormal(normal), self.bounce.cell);
        PathStart {
            owner,
            cell,
            model: self.model,
            index: 0,
            sequence,
            point,
            normal,
            tangent,
            geometric_normal,
            horizon,
            of_surface: NOTHING,
            within: self.bounce.within,
        }
    }

    /// What is below it, if light goes there.
    fn below(&self, frame: &FrameView) -> Option<Below> {
        let albedo = || self.albedo(frame);
        let scatters = frame.palette.scatters_below;
        scatters
            .then(|| Below::of(frame, (self.model, self.surface.from_behind), self.surface.look(), albedo()))
            .flatten()
    }

    /// Albedo of what it scatters.
    fn albedo(&self, frame: &FrameView) -> Vec3 {
        frame.palette.albedo_of(self.surface.look(), self.surface.reflectance)
    }

    /// Layer of the surface as the ray sees it, if it has one.
    pub fn layer(&self, frame: &FrameView) -> Option<SeenBsdf> {
        let Self { surface, bounce, .. } = self;
        let axes = surface.axes();
        frame.palette.bsdfs.seen(surface.look(), surface.reflectance, axes, bounce.direction, SeenBy::Eye)
    }

    /// Notes that its light holds until `until` at most.
    fn note(&mut self, until: Until) {
        self.until = until.min(self.until);
    }
}

/// Number of paths or rays that a surface has, which was met by a ray of this `weight`, where a sample has `count`. Noise is in proportion
/// to the weight over the root of this number: a faint picture needs fewer for no more of it.
pub fn share_of(count: u32, weight: Vec3) -> u32 {
    let weight = weight.max_element().min(1.0);
    (count.div_ceil(SHARE_OF_PATHS) as f32 * weight * weight).ceil() as u32
}

/// Surfaces that rays have met, and scratch memory for lighting them.
#[derive(Debug, Default)]
pub struct MetSurfaces {
    /// The surfaces.
    pub all: Vec<MetSurface>,
    /// True if it is asked of all how long their light holds, and not only of those that are kept.
    asks_all: bool,
    /// The same, eight side by side.
    eights: Vec<MetLanes>,
    /// Layers of some of these.
    bsdfs: Vec<SeenBsdfs>,
    queue: ShadowQueue,
    /// Points of the current light that reach each surface, a bit each.
    lit: Vec<u16>,
    /// Segments of shadow rays, if their answers' validity is asked for.
    to_light: Vec<(Vec3, Vec3, f32)>,
    gathering: PathScratch,
    occlusion: OcclusionScratch,
}

impl MetSurfaces {
    /// Computes the light that they show, and notes for how long it holds, where that is asked: in `times`, and of what is kept.
    pub fn light(&mut self, frame: &FrameView, times: &mut TreeTimes, tally: &mut RayTally) {
        self.asks_all = times.are_asked();
        for met in self.all.iter_mut().filter(|met| met.is_kept || times.are_asked()) {
            // less is asked of what is known to expire soon
            let known = if times.are_asked() { times.of(met.bounce.cell as usize) } else { Until::FOREVER };
            met.until = known.min(frame.light_change).min(frame.change_of_met(met.model));
        }
        light(frame, self, tally);
        gather(frame, self, tally);
        reflect(frame, self, tally);
        if self.asks_all {
            self.all.iter().for_each(|met| times.note(met.bounce.cell, met.until));
        }
    }
}

/// Eight of the surfaces that were met, side by side. Lanes without one repeat the first.
#[derive(Debug)]
struct MetLanes {
    receivers: Receivers,
    /// Ways to the curved surfaces that the triangles stand for.
    lifts: Vec3x8,
    reflectance: Vec3x8,
    /// Tangents of their surfaces.
    tangents: Vec3x8,
    view: Vec3x8,
    /// Seeds for the points on area lights that they ask.
    seeds: u32x8,
    looks: [Look; LANES],
    /// Light that they show, summed so far.
    light: Vec3x8,
    /// Index of their layers, if any has one.
    bsdfs: Option<usize>,
    /// Ticks at which they are seen.
    ticks: [Tick; LANES],
    /// Bit mask of the lanes in use.
    used: u8,
}

impl MetLanes {
    fn new(frame: &FrameView, met: &[MetSurface]) -> Self {
        let at = |lane: usize| &met[if lane < met.len() { lane } else { 0 }];
        let each = |value: fn(&MetSurface) -> Vec3| {
            let mut all = Vec3x8::ZERO;
            (0..LANES).for_each(|lane| all.set_lane(lane, value(at(lane))));
            all
        };
        let point = each(|met| met.surface.point);
        let receivers = Receivers {
            point,
            normal: each(|met| met.surface.normal),
            smooth: frame.palette.bends_normals.then(|| each(|met| met.surface.horizon.normal)),
            geometric_normal: each(|met| met.surface.geometric_normal),
            fibres: (0..LANES)
                .fold(0, |bits, lane| bits | u8::from(at(lane).surface.horizon.is_fibre) << lane),
        };
        Self {
            receivers,
            lifts: each(|met| met.surface.horizon.lift),
            seeds: seeds_of_places(point),
            reflectance: each(|met| met.surface.reflectance),
            tangents: if frame.palette.has_tangents() {
                each(|met| met.surface.tangent)
            } else {
                Vec3x8::ZERO
            },
            view: each(|met| -met.bounce.direction),
            looks: std::array::from_fn(|lane| at(lane).surface.look()),
            light: Vec3x8::ZERO,
            bsdfs: None,
            ticks: std::array::from_fn(|lane| frame.tick_of(at(lane).bounce.cell)),
            used: u8::MAX >> (LANES - met.len()),
        }
    }
}

/// Computes the light that comes to the surfaces straight from lights, highlights included.
fn light(frame: &FrameView, met: &mut MetSurfaces, tally: &mut RayTally) {
    met.eights.clear();
    met.eights.extend(met.all.chunks(LANES).map(|some| MetLanes::new(frame, some)));
    met.bsdfs.clear();
    look_around(frame, met, tally);
    for (first, (eight, some)) in (0..).step_by(LANES).zip(met.eights.iter_mut().zip(met.all.chunks(LANES))) {
        let share = |lane: usize| if lane < some.len() { met.occlusion.share(first + lane) } else { 0.0 };
        let openness = || F32x8::new(std::array::from_fn(share));
        eight.light = emitted_and_ambient(frame, (&eight.looks, eight.reflectance), openness);
        if frame.has_linked_emission() {
            eight.light = without_unseen_emission(frame, some, eight.light);
        }
        let MetLanes { reflectance, view, receivers, .. } = *eight;
        let Receivers { normal, geometric_normal, .. } = receivers;
        let axes = SurfaceAxes { normal, geometric_normal, tangent: eight.tangents };
        let has_bsdfs = frame.palette.bsdfs.any(&eight.looks);
        let rays = has_bsdfs.then(|| {
            let mut rays = LayerRays { count: [0; LANES], followed: 0, incoming: -view };
            for (lane, met) in some.iter().enumerate() {
                let Onwards { rough, is_followed } = Onwards::of(frame, met);
                rays.count[lane] = u32::from(rough.is_some());
                rays.followed |= u8::from(is_followed) << lane;
            }
            rays
        });
        let bsdfs = frame.palette.bsdfs.seen_lanes(&eight.looks, reflectance, axes, -view, rays);
        if let Some(bsdfs) = bsdfs {
            eight.light = bsdfs.show(eight.light);
            eight.bsdfs = Some(met.bsdfs.len());
            met.bsdfs.push(bsdfs);
        }
    }
    for light in (0..frame.pose.lights.len()).filter(|light| !frame.pose.is_dark(*light)) {
        ask_light(frame, light, met, tally);
        shine(frame, light, met);
    }
    for (some, eight) in met.all.chunks_mut(LANES).zip(&met.eights) {
        some.iter_mut().enumerate().for_each(|(lane, met)| met.light = eight.light.lane(lane));
    }
}

/// `light` of up to eight surfaces, without what those emit that do not light the surfaces from which the rays have come.
#[inline(never)]
fn without_unseen_emission(frame: &FrameView, met: &[MetSurface], mut light: Vec3x8) -> Vec3x8 {
    for (lane, met) in met.iter().enumerate() {
        if !frame.sees_emission(met.bounce.receiver, met.model) {
            let emission = met.surface.emission(frame.scene);
            light.set_lane(lane, (light.lane(lane) - emission).max(Vec3::ZERO));
        }
    }
    light
}

/// Computes the openness of the surfaces that were met, where it dims their ambient light: by fewer rays than
/// samples have.
fn look_around(frame: &FrameView, met: &mut MetSurfaces, tally: &mut RayTally) {
    let Some(occlusion) = frame.occlusion.filter(|occlusion| occlusion.dims_ambient) else { return };
    let MetSurfaces { all: met, occlusion: scratch, .. } = met;
    scratch.looks.clear();
    scratch.looks.extend((0..).zip(&*met).map(|(number, met)| {
        let is_dimmed = frame.palette.has_ambient(met.surface.material);
        OpenSurface {
            start: met.start(number),
            rays: if is_dimmed { share_of(occlusion.rays, met.bounce.weight) } else { 0 },
        }
    }));
    occlusion::look_around(frame, scratch, tally);
    let found = scratch.looks.iter().zip(&scratch.found);
    found.for_each(|(look, found)| met[look.start.owner as usize].note(found.until));
}

/// Adds the light that the surfaces that were met gather from all around. It is computed anew for each frame
/// in which they are seen, by fewer paths than samples have: a surface in a mirror counts for less, and its
/// light is not kept.
fn gather(frame: &FrameView, met: &mut MetSurfaces, tally: &mut RayTally) {
    let MetSurfaces { all: met, gathering, .. } = met;
    let is_diffuse = |met: &MetSurface| frame.palette.is_diffuse(met.surface.material);
    for (first, some) in (0..).step_by(GATHER_AT_ONCE).zip(met.chunks_mut(GATHER_AT_ONCE)) {
        gathering.starts.clear();
        for (number, met) in (first..).zip(&*some).filter(|(_, met)| is_diffuse(met)) {
            gathering.starts.gather(&met.start(number), met.below(frame), 0..met.paths);
        }
        trace_paths(frame, gathering, tally);
        let brought = gathering.starts.iter().zip(&gathering.brought);
        for (start, brought) in brought {
            let met = &mut some[(start.owner - first) as usize];
            let albedo = met.albedo(frame);
            let albedo = met.layer(frame).map_or(albedo, |seen| albedo * seen.through);
            met.light += albedo * brought.radiance / met.paths as f32;
            met.note(brought.until);
        }
    }
}

/// Adds the light that the rough layers of the surfaces that were met reflect: by one path each, which is drawn
/// anew for each frame.
fn reflect(frame: &FrameView, met: &mut MetSurfaces, tally: &mut RayTally) {
    let MetSurfaces { all: met, gathering, .. } = met;
    for (first, some) in (0..).step_by(GATHER_AT_ONCE).zip(met.chunks_mut(GATHER_AT_ONCE)) {
        gathering.starts.clear();
        for (number, met) in (first..).zip(&*some) {
            if let Some(seen) = Onwards::of(frame, met).rough {
                let seed = seed_of(met.surface.point, met.surface.material.into());
                let sequence = PathSequence::of_reflections_of_seed(seed);
                let start = PathStart { sequence, ..met.start(number) };
                gathering.starts.reflect(&start, DrawnLayer { seen, paths: 1 }, 0..1);
            }
        }
        trace_paths(frame, gathering, tally);
        for (start, brought) in gathering.starts.iter().zip(&gathering.brought) {
            if let Some(layer) = gathering.starts.layer(start) {
                let brings = (brought.radiance, brought.sees_light);
                some[(start.owner - first) as usize].light +=
                    layer.shows(frame, start, 0, &layer.seen, brings);
            }
            some[(start.owner - first) as usize].note(brought.until);
        }
    }
}

/// Divisor of the number of paths and of occlusion rays, from that of a sample to that of a surface in a
/// mirror or behind glass.
const SHARE_OF_PATHS: u32 = 4;

/// Number of surfaces that gather light at once.
const GATHER_AT_ONCE: usize = 256;

/// Finds the points of light number `light` that reach each surface that was met.
fn ask_light(frame: &FrameView, light: usize, met: &mut MetSurfaces, tally: &mut RayTally) {
    let MetSurfaces { all: met, asks_all, eights, queue, lit, to_light, .. } = met;
    let asks = |met: &MetSurface| *asks_all || met.is_kept;
    let points = frame.pose.lights[light].points;
    queue.begin(frame.shadows_of_light(light));
    to_light.clear();
    lit.clear();
    lit.resize(met.len(), 0);
    let mut count = |number: usize, rays: u32| {
        let counted = &mut tally.cells.shadow[met[number].bounce.cell as usize];
        // many panes under many panels may cast more rays than a word holds
        *counted = counted.saturating_add(rays as u16);
    };
    // lights that do not light a model send no ray to it
    let lit_bits = |first: usize| {
        let models = |lane: usize| met.get(first + lane).map_or(EMPTY, |met| met.model);
        frame.lit_bits(light, &std::array::from_fn::<u32, LANES, _>(models))
    };
    for (eight, first) in eights.iter().zip((0..).step_by(LANES)) {
        let MetLanes { receivers, lifts, used, ticks, seeds, .. } = eight;
        if points == 1 {
            let places = (receivers.point, *seeds);
            let light_sample = sample_of_light(frame, (light, 0), || *ticks, places);
            let rays = receivers.to_light(&light_sample, *used, |lane| lifts.lane(lane));
            let asked = rays.faces & light_sample.irradiance.is_some().bits() & used & lit_bits(first);
            queue.push(rays.origins, rays.to_light, F32x8::splat(light_sample.far), asked, first as u32);
            for lane in set_bits(asked) {
                count(first + lane, 1);
                if asks(&met[first + lane]) {
                    to_light.push((rays.origins.lane(lane), rays.to_light.lane(lane), light_sample.far));
                }
            }
            continue;
        }
        for lane in set_bits(*used & lit_bits(first)) {
            let light = &frame.pose.lights_at(ticks[lane])[light];
            let pattern = StratifiedPattern::of_seeds(light, *seeds);
            let light_samples = light_samples(light, &pattern, lane, receivers.point.lane(lane));
            let ToSixteen { faces: asked, origin, light_samples, .. } =
                receivers.to_sixteen(lane, &light_samples, || lifts.lane(lane));
            queue.push_sixteen(origin, &light_samples, asked, (first + lane) as u32);
            count(first + lane, asked.count_ones());
            for point in set_bits(if asks(&met[first + lane]) { asked } else { 0 }) {
                let way = light_samples[point / LANES].to_light.lane(point % LANES);
                to_light.push((origin, way, light_samples[0].far));
            }
        }
    }
    tally.counts.shadow += queue.count();
    let check = ShadowCheck::StillThenMovable;
    // segments in the order of the answers; a still occluder stays in the way, whatever else comes there or
    // goes
    let mut to_light = to_light.iter();
    let mut note = |met: &mut MetSurface, by_still: bool| {
        if (*asks_all || met.is_kept)
            && let Some((origin, way, far)) = to_light.next().filter(|_| !by_still)
        {
            met.until = frame.first_touch_before(*origin, *way, *far, met.until);
        }
    };
    if points > 1 {
        queue.set_ticks_of_sixteen(frame, |owner| met[owner as usize].bounce.cell);
        queue.answer_sixteen(
            check,
            SceneSubset::All,
            Coherence::SharedOrigin,
            frame.tracer,
            |owner, shadows| {
                lit[owner as usize] = shadows.asked & !shadows.blocked;
                let by_still = shadows.blocked & !shadows.by_dynamic;
                let met = &mut met[owner as usize];
                set_bits(shadows.asked).for_each(|point| note(met, by_still >> point & 1 != 0));
            },
        );
    } else {
        queue.set_ticks(frame, |owner| met[owner as usize].bounce.cell);
        queue.answer(check, SceneSubset::All, Coherence::Bounced, frame.tracer, |owner, tag| {
            lit[owner as usize] = u16::from(tag.is_lit());
            note(&mut met[owner as usize], tag == Tag::StaticOccluder);
        });
    }
}

/// Adds the light of those points of light `number` that reach the surfaces that were met.
fn shine(frame: &FrameView, number: usize, met: &mut MetSurfaces) {
    let eights = met.eights.iter_mut().zip(met.lit.chunks(LANES));
    for (eight, lit) in eights.filter(|(_, lit)| lit.iter().any(|points| *points != 0)) {
        let gloss = frame.palette.gloss(&eight.looks);
        let bsdfs = eight.bsdfs.map(|number| &met.bsdfs[number]);
        let Receivers { point, normal, smooth, .. } = eight.receivers;
        let albedo = frame.palette.albedo(&eight.looks, eight.reflectance);
        let albedo = frame.albedo_of_lights(&eight.looks, albedo);
        let mut points = [0; LANES];
        points[..lit.len()].copy_from_slice(lit);
        let places = Places::new(frame, (point, eight.seeds), || eight.ticks);
        let (ticks, view, mut sum) = (eight.ticks, eight.view, eight.light);
        frame.pose.each_of_light(
            number,
            || ticks,
            |light, bits| {
                let (to_centre, reach) = (to_light(light, point).0, light.shape.reach());
                let stands_for = shows_highlight(frame, light, &gloss);
                let radiance = frame.radiance_of(number, light);
                let may_shine = gloss.is_any && phong::may_shine(&gloss, normal, view, to_centre, reach);
                let reached = |point: usize| {
                    Mask::new(|lane| (bits >> lane & 1 != 0) & (points[lane] >> point & 1 != 0))
                };
                sum = add_light(frame, sum, light, places, reached, |light_sample| {
                    let mut light = phong::diffuse(albedo, normal, smooth, light_sample);
                    if let Some(bsdfs) = bsdfs {
                        light = (light * bsdfs.through + bsdfs.of_rough_matt(light_sample)).max(Vec3x8::ZERO)
                            + bsdfs.highlight(light_sample, radiance);
                    }
                    if !may_shine {
                        return light;
                    }
                    let highlight = phong::specular(&gloss, normal, view, light_sample);
                    light + stands_for.select3(highlight, Vec3x8::ZERO)
                });
            },
        );
        eight.light = sum;
    }
}

/// How light goes on from a surface that a ray has met, off what reflects beside the diffuse part: not at all if it is the last one.
#[derive(Debug, Default)]
struct Onwards {
    /// What is rough, if a path shows it: one at most; only samples have several.
    rough: Option<SeenBsdf>,
    /// True if a ray follows what is a mirror.
    is_followed: bool,
}

impl Onwards {
    fn of(frame: &FrameView, met: &MetSurface) -> Self {
        let Some(seen) = met.layer(frame).filter(|_| !met.bounce.step.is_last()) else {
            return Self::default();
        };
        let is_worth = |seen: &SeenBsdf| met.bounce.is_worth(seen.albedo * met.bounce.weight);
        Self {
            rough: seen.rough().filter(|seen| frame.settings.reflections > 0 && is_worth(seen)),
            is_followed: seen.smooth().is_some_and(|seen| is_worth(&seen)),
        }
    }
}
