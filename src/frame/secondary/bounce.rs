//! Rays beyond the first surface: the light that mirrors and glass show. They depend on the eye and are traced
//! anew, unless they are known to bring the same light as before ([`ray_trees`](super::ray_trees)). Tracing is
//! breadth first: all rays of a tile that have bounced equally often are cast together.

use glam::Vec3;

use super::bounced_ray::{Bounce, Kind, LEAST_WEIGHT};
use super::in_media::InMedia;
use super::met_surfaces::{MetSurface, MetSurfaces, share_of};
use super::mirrors::{Mirrors, Served, may_be_kept, surface_of};
use super::parts;
use super::ray_trees::TreeScratch;
use super::tree_times::TreeTimes;
use super::ways::{Way, Ways};
use crate::changes::Until;
use crate::frame::light::step::Step;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::computed_hits::ComputedHit;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::radiance::Radiance;
use crate::frame::surface::ray_tally::RayTally;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::lanes::LANES;
use crate::layers::Layers;
use crate::pose::Clip;
use crate::scene::material::Optics;
use crate::scene::{RayKind, Role};
use crate::settings::Backdrop;
use crate::shade::Surface;
use crate::shade::bsdf::{Reflected, SeenBsdf};
use crate::shade::optics::{Branches, branch, random_of_place};
use crate::trace::{self, Coherence, HitPacket, NO_HIT, OfKind, SceneSubset, Search};

/// Scratch memory of a worker for this phase.
#[derive(Debug, Default)]
pub struct Bounces {
    now: Vec<Bounce>,
    next: Vec<Bounce>,
    met: MetSurfaces,
    /// Kinds of the rays at work, if any model is hidden from some.
    kinds: Vec<RayKind>,
    /// Light that the rough layers of samples reflect, with the cell.
    pub reflected: Vec<(u32, Vec3)>,
    /// Validity of the rays of the current tile, if it is asked for.
    pub times: TreeTimes,
    /// Trees of the current tile.
    pub trees: TreeScratch,
    /// What media show.
    pub media: InMedia,
    /// Ways of the rays of the current tile.
    pub ways: Ways,
    /// What flat mirrors show.
    pub mirrors: Mirrors,
}

impl Bounces {
    /// Starts the rays that leave the sample of `cell`. `guides`: denoisers see the normals of the surfaces
    /// that the rays meet.
    pub fn start(
        &mut self,
        frame: &FrameView,
        (cell, model, triangle): (u32, u32, u32),
        surface: &Surface,
        guides: bool,
        branches: Branches,
    ) {
        let spread = frame.view.spread_of_sample().by_distance;
        let weight = self.media.left(cell as usize);
        let bounce =
            |kind| Bounce { guides, spread, weight, way: Way::DIRECT, ..Bounce::from_sample(cell, kind) };
        let next = (&mut self.ways, &mut self.next);
        grow(frame, step_of_sample(frame), (surface, model, triangle), branches, bounce, next);
    }

    /// Starts a ray for a texel of the map of a model, `receiver`, which is accumulated as that of `cell`, from `origin` (world space)
    /// along `direction`, of unit length.
    pub fn start_from(
        &mut self,
        frame: &FrameView,
        (cell, receiver): (u32, u32),
        origin: Vec3,
        direction: Vec3,
    ) {
        let step = step_of_sample(frame).next(false);
        if !step.is_beyond() {
            let ray_kind = RayKind::Glossy;
            self.next.push(Bounce {
                step,
                ray_kind,
                receiver,
                origin,
                direction,
                ..Bounce::from_sample(cell, Kind::Reflection)
            });
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
                let weight = ray.weight * self.media.left(cell as usize);
                add(radiance, &Bounce { weight, ..Bounce::from_sample(cell, kind) }, weight * light);
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
        (cell, receiver, triangle): (u32, u32, u32),
        guides: bool,
        surface: &Surface,
        seen: &SeenBsdf,
    ) {
        let spread = frame.view.spread_of_sample().by_distance;
        let weight = self.media.left(cell as usize);
        let from_sample = Bounce::from_sample(cell, Kind::Reflection);
        let bounce = Bounce { guides, spread, weight, receiver, way: Way::DIRECT, ..from_sample };
        let next = (&mut self.ways, &mut self.next);
        mirror(frame, step_of_sample(frame), bounce, (surface, triangle), seen, next);
    }
}

/// Place of samples on the ways of rays from the eye: before as many surfaces as the frame has depth.
fn step_of_sample(frame: &FrameView) -> Step {
    Step::first(frame.settings.depth + 1)
}

/// What is a mirror of the layers that were `seen` by a ray of this `weight`, if a ray follows it.
pub fn followed(frame: &FrameView, seen: &SeenBsdf, weight: Vec3) -> Option<SeenBsdf> {
    let is_worth = |seen: &SeenBsdf| (seen.albedo * weight).max_element() >= LEAST_WEIGHT;
    seen.smooth().filter(|seen| frame.settings.depth > 0 && is_worth(seen))
}

/// Adds to `next` the ray that the smooth layer of `surface`, which is at this `step` and `triangle` of the receiver, reflects; `bounce`
/// gives what else is known of it, and the way to the surface.
fn mirror(
    frame: &FrameView,
    step: Step,
    bounce: Bounce,
    (surface, triangle): (&Surface, u32),
    seen: &SeenBsdf,
    (ways, next): (&mut Ways, &mut Vec<Bounce>),
) {
    let step = step.next(false);
    if step.is_beyond() {
        return;
    }
    let reflected = followed(frame, seen, bounce.weight).and_then(|seen| seen.reflect([0.0; 2]));
    if let Some(Reflected { direction, weight, .. }) =
        reflected.filter(|reflected| surface.geometric_normal.dot(reflected.direction) > 0.0)
    {
        let origin = surface.leave(direction);
        let (weight, width, ray_kind) = (bounce.weight * weight, surface.width, RayKind::Glossy);
        let before = (bounce.way, bounce.ray_kind);
        let way = ways.beyond(frame, before, (surface, bounce.receiver, triangle), true);
        next.push(Bounce { step, ray_kind, weight, origin, direction, width, way, ..bounce });
    }
}

/// Traces the rays that were [started](Bounces::start), and those that follow them up to the frame's depth, and
/// adds their light to the cells' radiance; and what media along them and before samples scatter.
pub fn follow(frame: &FrameView, bounces: &mut Bounces, radiance: &mut Radiance, scratch: &mut TraceScratch) {
    let shows_guides = frame.layers.has(Layers::GUIDES);
    while !bounces.next.is_empty() {
        std::mem::swap(&mut bounces.now, &mut bounces.next);
        bounces.next.clear();
        group(&mut bounces.now);
        meet(frame, bounces, radiance, scratch);
        bounces.mirrors.serve(frame, &bounces.ways, &mut bounces.met, scratch);
        bounces.met.light(frame, &mut bounces.times, &mut scratch.tally);
        bounces.mirrors.keep(frame, &bounces.ways, &bounces.met);
        let served = std::mem::take(&mut bounces.mirrors.served);
        for Served { met, sample, .. } in &served {
            let Bounce { cell, weight, guides, direction, .. } = met.bounce;
            add(radiance, &met.bounce, weight * sample.light);
            if shows_guides {
                let surface = surface_of(frame, sample, direction);
                parts::see(frame, &mut radiance.parts, cell as usize, &surface, weight, guides);
            }
            go_on(frame, met, (&mut bounces.ways, &mut bounces.next));
        }
        bounces.mirrors.served = served;
        for met in &bounces.met.all {
            add(radiance, &met.bounce, met.bounce.weight * met.light);
            if shows_guides {
                let Bounce { cell, weight, guides, .. } = met.bounce;
                parts::see(frame, &mut radiance.parts, cell as usize, &met.surface, weight, guides);
            }
            go_on(frame, met, (&mut bounces.ways, &mut bounces.next));
        }
    }
    if frame.media.is_some() {
        bounces.media.scatter(frame, radiance, &mut bounces.times, &mut scratch.tally);
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
    bounces.kinds.clear();
    // clipping planes cut off what the eye sees through veils as well
    if frame.hides_from_some || frame.view.camera.clip != Clip::NONE {
        bounces.kinds.extend(bounces.now.iter().map(|bounce| bounce.ray_kind));
    }
    for bounce in &bounces.now {
        scratch.rays.push(bounce.origin, bounce.direction, 0.0, f32::INFINITY);
        count(bounce, &mut scratch.tally);
    }
    frame.set_ticks(&mut scratch.rays, bounces.now.iter().map(|bounce| bounce.cell));
    let kinds = OfKind::of(&bounces.kinds);
    let search = Search { kinds, among: SceneSubset::All, coherence: Coherence::Bounced };
    frame.tracer.closest(&scratch.rays, search, &mut scratch.hits);
    let beam = |number: usize, t: f32| bounces.now[number].beam_at(t);
    scratch.computed.compute(frame, &scratch.hits, bounces.now.len(), beam);
    bounces.met.all.clear();
    for (number, bounce) in bounces.now.chunks(LANES).enumerate() {
        let (packet, from) =
            (&scratch.hits.packets[number * LANES / trace::LANES], number * LANES % trace::LANES);
        let models = &packet.model[from..from + LANES];
        for (lane, (bounce, model)) in bounce.iter().zip(models).enumerate() {
            let is_hit = *model != NO_HIT && !is_behind_catcher(frame, bounce, *model);
            let far = if is_hit { packet.t[from + lane] } else { f32::INFINITY };
            bounces.times.note_met(frame, bounce.cell, *model);
            bounces.times.note_segment(frame, bounce.cell, bounce.origin, bounce.direction, far);
            let of_lights = bounce.light_of_lights(frame, far);
            let left = match frame.media {
                Some(media) => bounces.media.follow(frame, media, (bounce, far), radiance),
                None => Vec3::ONE,
            };
            let mut of_sky = match (is_hit, bounce.ray_kind) {
                (true, _) => Vec3::ZERO,
                (false, RayKind::Camera) => frame.sky.seen(bounce.direction),
                (false, _) => frame.sky.radiance(bounce.direction),
            } * left;
            if is_hole(frame, bounce, *model) {
                radiance.clear[bounce.cell as usize] += (bounce.weight * left).element_sum() / 3.0;
                if frame.layers.has(Layers::BACKGROUND) {
                    radiance.add_sky(bounce.cell as usize, bounce.weight * of_sky);
                }
                of_sky = Vec3::ZERO;
            }
            if !is_hit || of_lights != Vec3::ZERO {
                add(radiance, bounce, bounce.weight * (of_lights + of_sky));
            }
        }
        let computed = scratch.computed.eight(number);
        meet_surfaces(frame, (packet, from), computed, bounce, &mut bounces.met.all);
    }
}

/// Returns true if a ray has come straight from the eye, through veils, to a catcher of shadows: what is behind the picture is
/// seen there.
fn is_behind_catcher(frame: &FrameView, bounce: &Bounce, model: u32) -> bool {
    bounce.ray_kind == RayKind::Camera && frame.role(model) == Role::ShadowCatcher
}

/// Returns true if a ray sees a hole in the picture: it has come straight from the eye, through veils, to a model that is one, or
/// to a background that is not shown.
fn is_hole(frame: &FrameView, bounce: &Bounce, model: u32) -> bool {
    let is_background = model == NO_HIT || is_behind_catcher(frame, bounce, model);
    let is_transparent = frame.settings.background == Backdrop::Transparent;
    bounce.ray_kind == RayKind::Camera
        && (is_background && is_transparent || frame.role(model) == Role::Holdout)
}

/// Adds the surfaces that up to eight rays met; their hits are in lanes `from` onwards of a packet.
fn meet_surfaces(
    frame: &FrameView,
    (packet, from): (&HitPacket, usize),
    computed: &[ComputedHit],
    bounces: &[Bounce],
    met: &mut Vec<MetSurface>,
) {
    let hits = Hits8::new(packet, from).with_computed(computed);
    let direction = |lane: usize| bounces[lane].direction;
    let beam = |lane: usize| bounces[lane].beam_at(packet.t[from + lane]);
    let tick = |lane: usize| frame.tick_of(bounces[lane].cell);
    surfaces(frame, &hits, bounces.len(), direction, beam, tick, |lane, surface| {
        let mut bounce = bounces[lane];
        if bounce.ray_kind == RayKind::Camera && frame.role(packet.model[from + lane]) != Role::Itself {
            return;
        }
        if frame.palette.absorbs {
            bounce.weight *= bounce.within.left(frame.palette, packet.t[from + lane]);
        }
        if let Some(media) = frame.media {
            let way = (bounce.origin, bounce.direction);
            bounce.weight *= media.left(way, packet.t[from + lane], frame.tick_of(bounce.cell));
        }
        let at = from + lane;
        met.push(MetSurface {
            bounce,
            surface,
            model: packet.model[at],
            triangle: packet.triangle[at],
            weights: [packet.u[at], packet.v[at]],
            paths: share_of(frame.first_paths as u32, bounce.weight),
            is_kept: may_be_kept(frame, &bounce, &surface, packet.model[at]),
            light: Vec3::ZERO,
            until: Until::UNKNOWN,
        });
    });
}

/// Starts the rays that leave a surface that was met.
fn go_on(frame: &FrameView, met: &MetSurface, (ways, next): (&mut Ways, &mut Vec<Bounce>)) {
    let MetSurface { surface, bounce, .. } = met;
    let material = &frame.scene.materials[usize::from(surface.material)];
    if bounce.step.is_last() && !surface.optics(frame.scene).is_straight() {
        return;
    }
    let branches = branch(material, surface, bounce.direction, || random_of_place(surface));
    let guides = bounce.guides && !parts::shows_itself(frame, surface.look());
    let onwards = |kind| Bounce { guides, ..bounce.onwards(kind) };
    let place = (surface, met.model, met.triangle);
    grow(frame, bounce.step, place, branches, onwards, (&mut *ways, &mut *next));
    if let Some(seen) = met.layer(frame) {
        let mirrored = Bounce { guides, receiver: met.model, ..bounce.onwards(Kind::Reflection) };
        mirror(frame, bounce.step, mirrored, (surface, met.triangle), &seen, (ways, next));
    }
}

/// Adds to `next` those of `branches` that are worth following from `surface`, a triangle of `model`, which is at this `step`. `bounce`
/// gives what they have in common with the ray that met it, and the way to it.
fn grow(
    frame: &FrameView,
    step: Step,
    (surface, model, triangle): (&Surface, u32, u32),
    branches: Branches,
    bounce: impl Fn(Kind) -> Bounce,
    (ways, next): (&mut Ways, &mut Vec<Bounce>),
) {
    let optics = surface.optics(frame.scene);
    let is_straight = optics.is_straight();
    // microfacets of rough glass turn rays as no mirror does
    let is_rough = matches!(optics, Optics::Glass { is_rough: true, .. });
    let kinds = [
        (Kind::Reflection, branches.reflection, step.next(false)),
        (Kind::Refraction, branches.refraction, step.next(is_straight)),
    ];
    for (kind, ray, step) in kinds {
        let Some(ray) = ray.filter(|_| !step.is_beyond()) else { continue };
        let bounce = bounce(kind);
        let weight = ray.weight * bounce.weight;
        if bounce.is_worth(weight) {
            let ray_kind = match kind {
                Kind::Reflection => RayKind::Glossy,
                Kind::Refraction if is_straight => bounce.ray_kind,
                Kind::Refraction => RayKind::Transmission,
            };
            let within = match kind {
                Kind::Refraction if frame.palette.absorbs => {
                    surface.within_behind(frame.scene, bounce.within)
                }
                _ => bounce.within,
            };
            // straight through a veil light comes to whoever looks
            let is_veil = kind == Kind::Refraction && is_straight;
            let way = match kind {
                Kind::Refraction if !is_straight => Way::BENT,
                Kind::Reflection if is_rough => Way::BENT,
                _ => {
                    let before = (bounce.way, bounce.ray_kind);
                    ways.beyond(frame, before, (surface, model, triangle), kind == Kind::Reflection)
                }
            };
            next.push(Bounce {
                step,
                ray_kind,
                receiver: if is_veil { bounce.receiver } else { model },
                weight,
                origin: surface.leave(ray.direction),
                direction: ray.direction,
                within,
                width: surface.width,
                way,
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
