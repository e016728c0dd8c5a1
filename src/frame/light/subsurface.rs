//! Light that goes into a surface and comes out of it somewhere else: skin, wax, marble, milk.
//!
//! A path that gathers light may go below its surface. There it walks at random, as light is scattered there: straight on for a distance by the
//! mean free path, and then in any direction, until it meets the surface from within. Where it comes out it goes on as from any matt
//! surface (M. Chiang, P. Kutz and B. Burley, "Practical and Controllable Subsurface Scattering for Production Path Tracing", 2016).
//! None of it depends on the eye: walks are kept as gathered paths are, for as long as nothing touches any of their segments.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};

use super::light_choice::{Kinds, light_asked, surfaces_on_paths};
use super::lobes::Lobes;
use super::path_ends::{Below, PathResult, PathStart};
use super::path_ray::{InMedia, PathRay};
use super::pdfs::Pdfs;
use super::starts::Starts;
use super::step::Step;
use super::vertex::{NO_BSDF, Vertex};
use crate::exposure::Tick;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::footprints::SPREAD_OF_PATHS;
use crate::frame::surface::hits::{Hits8, surfaces};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::LANES;
use crate::scene::look::Look;
use crate::scene::material::Entry;
use crate::scene::{RayKind, Scene};
use crate::shade::Surface;
use crate::shade::bsdf::{SeenBy, ggx};
use crate::shade::sampling::PathRandom;
use crate::shade::surface::off_surface;
use crate::shade::within::Within;
use crate::trace::{self, Coherence, HitBatch, NO_HIT, OfKind, RayBatch, SceneSubset, Search};

/// Scattering of a walk before it is given up. Walks of white media are that long where the mean free path is far less than the thing.
const MOST_STEPS: u32 = 256;

/// Least weight with which a walk goes on; below it chance decides.
const LEAST_WEIGHT: f32 = 0.05;

/// Number that tells the random numbers of walks from those of paths.
const OF_WALKS: u32 = 0x5e3d_a11c;

/// Number that tells the random numbers of their first directions from these.
const OF_ENTRIES: u32 = 0x1e_57a7;

/// Light in a medium, by channel.
#[derive(Debug, Clone, Copy)]
struct Medium {
    /// Share of the light that goes on where it is scattered.
    albedo: Vec3,
    /// Scattering and absorption for each unit of length, world space.
    extinction: Vec3,
}

/// Least albedo of a medium. One of a darker surface would scatter so rarely that walks had no light; it gets less of it instead.
const LEAST_ALBEDO: f32 = 0.2;

impl Medium {
    /// The medium in which a half-space has this albedo, and the weight of light in it: the fit of Blender's Cycles for isotropic scattering,
    /// which is of walks whose first direction is by the cosine law (`subsurface_random_walk_remap`).
    fn new(below: &Below) -> (Self, Vec3) {
        let surface = below.albedo.clamp(Vec3::ZERO, Vec3::ONE);
        let scattered = Vec3::from(surface.to_array().map(single_albedo));
        let albedo = scattered.max(Vec3::splat(LEAST_ALBEDO));
        let weight = below.weight_below() * scattered / albedo / below.albedo;
        let weight = Vec3::select(below.albedo.cmpgt(Vec3::splat(1e-6)), weight, Vec3::ZERO);
        let extinction = below.scattering.radius.max(Vec3::splat(f32::MIN_POSITIVE)).recip();
        (Self { albedo, extinction: extinction.min(Vec3::splat(1e16)) }, weight)
    }
}

/// Albedo of one scattering in a medium whose half-space has this albedo.
fn single_albedo(of_surface: f32) -> f32 {
    let dark = 1.826_052_4 * (5.112_3 * of_surface).atan().powf(1.096_861);
    let bright = 0.496_310_22 * (4.235_009 * of_surface).atan().powf(2.406_03);
    let share = of_surface.sqrt().sqrt();
    ((1.0 - share) * dark + share * bright).clamp(0.0, 0.999_999)
}

/// A walk.
#[derive(Debug, Clone, Copy)]
struct Walk {
    path: u32,
    tick: Tick,
    model: u32,
    material: u16,
    /// See [`Below::from_behind`].
    from_behind: bool,
    /// Number of other surfaces of its material that it has entered.
    within: u32,
    medium: Medium,
    random: PathRandom,
    steps: u32,
    origin: Vec3,
    direction: Vec3,
    /// Distance to the place where it is scattered next.
    left: f32,
    weight: Vec3,
}

/// Scratch memory of a worker for walks.
#[derive(Debug, Default)]
pub struct WalkScratch {
    walks: Vec<Walk>,
    rays: RayBatch,
    kinds: Vec<RayKind>,
    hits: HitBatch,
    /// Walks that met a surface of their material, with the packet and the lane of the hit.
    out: Vec<(Walk, u32, u32)>,
    /// Paths that go through their surface, and leave it on the other side at once.
    through: Vec<u32>,
    next: Vec<Walk>,
}

/// Has a path go below the surface of `start`, or through it, if its `random` numbers lead it there.
pub fn enter(
    frame: &FrameView,
    (path, start): (u32, &PathStart),
    below: &Below,
    random: PathRandom,
    scratch: &mut WalkScratch,
) -> bool {
    let random = random.apart(OF_WALKS);
    let [choice, along, above, _] = random.four(0);
    if choice >= below.chance() {
        let is_through = choice < below.chance() + below.scattering.through;
        scratch.through.extend(is_through.then_some(path));
        return is_through;
    }
    let (medium, weight) = Medium::new(below);
    let mut walk = Walk {
        path,
        tick: frame.tick_of(start.cell),
        model: below.model,
        material: below.look.material,
        from_behind: below.from_behind,
        within: 0,
        medium,
        random,
        steps: 0,
        origin: off_surface(start.point, -start.geometric_normal),
        direction: way_in(&below.scattering.entry, start, random, [along, above]),
        left: 0.0,
        weight,
    };
    if walk.direction.dot(start.geometric_normal) < 0.0 && walk.set_out() {
        scratch.walks.push(walk);
    }
    true
}

/// Direction in which a walk begins. A path does not depend on the eye: `numbers` choose by the cosine law from where the surface is seen, and
/// what comes from there is bent as Blender's Cycles bends what comes from the eye (`subsurface_entry_bounce`).
fn way_in(entry: &Entry, start: &PathStart, random: PathRandom, numbers: [f32; 2]) -> Vec3 {
    let seen_from = start.direction(numbers);
    if entry.matt >= 1.0 {
        return -seen_from;
    }
    let [choice, around, along, _] = random.apart(OF_ENTRIES).four(0);
    if choice < entry.matt {
        return -seen_from;
    }
    let axes = Mat3::from_cols(start.tangent, start.normal.cross(start.tangent), start.normal);
    let facet = axes * ggx::visible_normal(entry.alpha, axes.transpose() * seen_from, [around, along]);
    // Snell's law
    let (bent, cos) = (entry.index.recip(), facet.dot(seen_from));
    let cos_within = (1.0 - bent * bent * (1.0 - cos * cos)).max(0.0).sqrt();
    (facet * (bent * cos - cos_within) - seen_from * bent).normalize_or(-start.normal)
}

impl Walk {
    /// Chooses how far it goes before it is scattered again. Returns false if no light is left.
    fn set_out(&mut self) -> bool {
        let [choice, distance, ..] = self.random.four(2 * self.steps + 1);
        let chances = self.chances();
        if chances.element_sum() == 0.0 {
            return false;
        }
        let [r, g, b] = self.medium.extinction.to_array();
        let extinction = match choice {
            _ if choice < chances.x => r,
            _ if choice < chances.x + chances.y => g,
            _ => b,
        };
        self.left = -(1.0 - distance).ln() / extinction;
        true
    }

    /// Chances of the channels by which its distances are chosen, which add up to 1: by the light that they scatter.
    fn chances(&self) -> Vec3 {
        let light = (self.weight * self.medium.albedo).abs();
        let sum = light.element_sum();
        if sum > 0.0 && sum.is_finite() { light / sum } else { Vec3::ZERO }
    }

    /// Takes the light that is left over a `distance` into account, with the density by which it was chosen: of being scattered there, or
    /// of coming as far as that.
    fn attenuate(&mut self, distance: f32, is_scattered: bool) {
        let Medium { extinction, albedo } = self.medium;
        let chances = self.chances();
        let left = (-extinction * distance).exp();
        let (light, density) =
            if is_scattered { (extinction * albedo * left, extinction * left) } else { (left, left) };
        let density = chances.dot(density);
        self.weight = if density > 0.0 { self.weight * light / density } else { Vec3::ZERO };
    }

    /// Scatters it in any direction. Returns false if it ends there.
    fn scatter(&mut self) -> bool {
        self.origin += self.direction * self.left;
        let left = self.left;
        self.attenuate(left, true);
        let [around, up, survival, _] = self.random.four(2 * self.steps + 2);
        self.steps += 1;
        let z = 1.0 - 2.0 * up;
        let (sin, cos) = (2.0 * PI * around).sin_cos();
        let across = (1.0 - z * z).max(0.0).sqrt();
        self.direction = Vec3::new(across * cos, across * sin, z);
        let most = self.weight.max_element();
        if most < LEAST_WEIGHT {
            let chance = most / LEAST_WEIGHT;
            if survival >= chance {
                return false;
            }
            self.weight /= chance;
        }
        self.steps < MOST_STEPS && self.set_out()
    }
}

/// Follows the walks of a batch to where they come out of their surfaces: vertices, from which their paths go on.
pub fn walk(
    frame: &FrameView,
    scratch: &mut WalkScratch,
    (starts, random): (&Starts, &[PathRandom]),
    (brought, vertices): (&mut [PathResult], &mut Vec<Vertex>),
    tally: &mut RayTally,
) {
    vertices.clear();
    pass_through(frame, scratch, (starts, random), vertices);
    while !scratch.walks.is_empty() {
        cast(frame, scratch, starts, brought, tally);
        meet(frame, scratch, (starts, random), vertices);
    }
}

/// Casts the current rays of the walks: those that meet nothing are scattered, those that meet their surface come out, and those that
/// meet others go on through them.
fn cast(
    frame: &FrameView,
    scratch: &mut WalkScratch,
    starts: &[PathStart],
    brought: &mut [PathResult],
    tally: &mut RayTally,
) {
    let WalkScratch { walks, rays, kinds, hits, out, next, .. } = scratch;
    rays.clear();
    kinds.clear();
    if frame.hides_from_some {
        kinds.extend(walks.iter().map(|_| RayKind::Diffuse));
    }
    for walk in &*walks {
        rays.push(walk.origin, walk.direction, 0.0, walk.left);
        let counted = &mut tally.cells.secondary[starts[walk.path as usize].cell as usize];
        *counted = counted.saturating_add(1);
    }
    frame.set_ticks(rays, walks.iter().map(|walk| starts[walk.path as usize].cell));
    tally.counts.gathering += walks.len() as u64;
    let search =
        Search { kinds: OfKind::of(kinds), among: SceneSubset::All, coherence: Coherence::Incoherent };
    frame.tracer.closest(rays, search, hits);
    out.clear();
    next.clear();
    for (number, walk) in walks.iter().enumerate() {
        let mut walk = *walk;
        let (packet, lane) = (number / trace::LANES, number % trace::LANES);
        let hit = &hits.packets[packet];
        let (model, met) = (hit.model[lane], hit.t[lane]);
        let far = if model == NO_HIT { walk.left } else { met };
        let brought = &mut brought[walk.path as usize];
        brought.until = brought.until.min(frame.change_of_met(model));
        brought.until = frame.first_touch_before(walk.origin, walk.direction, far, brought.until);
        let is_own = |model: u32| {
            let Scene { models, materials, .. } = &frame.scene;
            let met = models[model as usize].mesh.material_of[hit.triangle[lane] as usize];
            let [of_met, of_walk] = [met, walk.material].map(|material| &materials[usize::from(material)]);
            // copies that are read from several files have a material each, and what is in one place is not to be passed with its copy
            model == walk.model || met == walk.material || of_met == of_walk
        };
        if model != NO_HIT && is_own(model) {
            out.push((walk, packet as u32, lane as u32));
        } else if model == NO_HIT {
            if walk.scatter() {
                next.push(walk);
            }
        } else if walk.pass(met) {
            next.push(walk);
        }
    }
    std::mem::swap(walks, next);
}

impl Walk {
    /// Goes on behind something else that it has met at this distance. Returns false if it gives up.
    fn pass(&mut self, met: f32) -> bool {
        let beyond = met + THROUGH * (met + self.origin.abs().max_element());
        self.attenuate(beyond.min(self.left), false);
        self.origin += self.direction * beyond;
        self.steps += 1;
        // as far as light comes that has not been scattered so far
        self.steps < MOST_STEPS && self.set_out()
    }
}

/// Way on behind a surface of another model, as a share of the size of coordinates there.
const THROUGH: f32 = 1e-5;

/// Makes vertices of the places where walks come out. Where things of one material lie in each other, as copies in one place do, a walk has
/// entered some on its way, and comes out of the last one.
fn meet(
    frame: &FrameView,
    scratch: &mut WalkScratch,
    (starts, random): (&[PathStart], &[PathRandom]),
    vertices: &mut Vec<Vertex>,
) {
    let WalkScratch { walks, out, hits, .. } = scratch;
    let step = Step::first(surfaces_on_paths(frame, false) + 1);
    let of_packet = |packet: u32, lane: u32| (packet, lane / LANES as u32);
    for same in out.chunk_by(|a, b| of_packet(a.1, a.2) == of_packet(b.1, b.2)) {
        let (packet, eight) = of_packet(same[0].1, same[0].2);
        let (packet, from) = (&hits.packets[packet as usize], eight as usize * LANES);
        let walk_in =
            |lane: usize| same.iter().find(|(.., of)| *of as usize == from + lane).map(|(walk, ..)| walk);
        // seen from outside
        let direction = |lane: usize| walk_in(lane).map_or(Vec3::Z, |walk| -walk.direction);
        let tick = |lane: usize| walk_in(lane).map_or(same[0].0.tick, |walk| walk.tick);
        surfaces(
            frame,
            &Hits8::new(packet, from),
            LANES,
            direction,
            |lane| packet.t[from + lane] * SPREAD_OF_PATHS,
            tick,
            |lane, surface| {
                let Some(walk) = walk_in(lane) else { return };
                let (mut walk, met, model) = (*walk, packet.t[from + lane], packet.model[from + lane]);
                // it is seen from outside, if that is where the walk leads
                let leaves = surface.from_behind == (walk.from_behind && model == walk.model);
                if leaves && walk.within == 0 {
                    walk.attenuate(met, false);
                    let Walk { path, tick, model, weight, direction, .. } = walk;
                    let within = starts[path as usize].within;
                    let exit = Exit { path, tick, model, weight, direction, within };
                    vertices.push(vertex(frame, exit, surface, (step, random[path as usize])));
                    return;
                }
                walk.within = if leaves { walk.within - 1 } else { walk.within + 1 };
                walks.extend(walk.pass(met).then_some(walk));
            },
        );
    }
}

/// Makes vertices of the places where paths leave their surfaces on the other side.
fn pass_through(
    frame: &FrameView,
    scratch: &mut WalkScratch,
    (starts, random): (&Starts, &[PathRandom]),
    vertices: &mut Vec<Vertex>,
) {
    let step = Step::first(surfaces_on_paths(frame, false) + 1);
    for path in scratch.through.drain(..) {
        let start = &starts[path as usize];
        let Some(below) = starts.below(start) else { continue };
        let Look { material, varied } = below.look;
        let near = Surface {
            point: start.point,
            normal: start.normal,
            geometric_normal: start.geometric_normal,
            tangent: Vec3::ZERO,
            horizon: start.horizon,
            reflectance: Vec3::ONE,
            material,
            varied,
            from_behind: false,
            width: 0.0,
        };
        let (tick, model, within) = (frame.tick_of(start.cell), start.model, start.within);
        let exit = Exit { path, tick, model, weight: Vec3::ONE, direction: start.normal, within };
        vertices.push(vertex(frame, exit, near.flipped(), (step, random[path as usize])));
    }
}

/// The side of a surface that a path shows, where a `random` number from 0 to below 1 chooses it: the other one, in as many cases as light
/// goes through. That is seen of surfaces without a layer alone: above those with one all of their light is that of this side.
pub fn side(frame: &FrameView, surface: Surface, random: impl FnOnce() -> f32) -> Surface {
    if !frame.palette.scatters_below {
        return surface;
    }
    let through = frame.palette.scattering(surface.look()).map_or(0.0, |scattering| scattering.through);
    let has_layer = || frame.scene.materials[usize::from(surface.material)].metal_rough.is_some();
    if through > 0.0 && !has_layer() && random() < through { surface.flipped() } else { surface }
}

/// How a path comes out of a surface.
struct Exit {
    path: u32,
    tick: Tick,
    /// Model of the surface.
    model: u32,
    weight: Vec3,
    direction: Vec3,
    within: Within,
}

/// The surface where a path comes out: white, as the colour of its light is known by now.
fn vertex(frame: &FrameView, exit: Exit, surface: Surface, (step, random): (Step, PathRandom)) -> Vertex {
    let Exit { path, tick, model, weight, direction, within } = exit;
    let surface = Surface { reflectance: frame.palette.white(surface.look()), ..surface };
    let ray = PathRay {
        path,
        tick,
        step,
        weight,
        origin: surface.point,
        direction,
        asked_from: surface.point,
        normal: surface.normal,
        chances: Pdfs::PATH_ALONE,
        seen_by: SeenBy::Path,
        kind: RayKind::Diffuse,
        receiver: model,
        within,
        media: InMedia::default(),
    };
    let random = random.four(step.asking());
    let (asked_light, chance) = light_asked(frame, model, surface.point, random[0]);
    Vertex {
        ray,
        surface,
        model,
        light: Vec3::ZERO,
        emission_weight: 0.0,
        asks: Kinds::of(frame, step),
        asked_light,
        chance,
        random,
        lobes: Lobes::matt(Vec3::ONE),
        bsdf: NO_BSDF,
        is_exit: true,
    }
}

/// Result of a path whose walk has not come out yet.
pub fn nothing_yet(frame: &FrameView, start: &PathStart) -> PathResult {
    PathResult {
        radiance: Vec3::ZERO,
        sees_light: false,
        until: frame.first_touch(start.point, start.normal, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::material::Scattering;

    /// Light that leaves a half-space, lit evenly, has the albedo from which the medium was made: by walks in a plane-parallel one.
    #[test]
    fn a_half_space_has_the_albedo_of_its_surface() {
        for albedo in [0.1, 0.4, 0.7, 0.9_f32] {
            let (below, radius) = (Vec3::ONE, Vec3::ONE);
            let scattering = Scattering { below, radius, through: 0.0, entry: Entry::MATT };
            let (model, look, albedo_of_all) = (0, Look::plain(0), Vec3::splat(albedo));
            let below = Below { scattering, model, look, from_behind: false, albedo: albedo_of_all };
            let (medium, weight) = Medium::new(&below);
            let (count, mut sum) = (20_000, 0.0_f64);
            for index in 0..count {
                let random = PathRandom::new(7, index).apart(OF_WALKS);
                let [_, _, above, _] = random.four(0);
                let direction = Vec3::new((1.0 - above).sqrt(), 0.0, -above.sqrt());
                let mut walk = Walk {
                    path: 0,
                    tick: 0,
                    model: 0,
                    material: 0,
                    from_behind: false,
                    within: 0,
                    medium,
                    random,
                    steps: 0,
                    origin: Vec3::ZERO,
                    direction,
                    left: 0.0,
                    weight,
                };
                let mut goes_on = walk.set_out();
                while goes_on {
                    let to_surface = if walk.direction.z > 0.0 {
                        -walk.origin.z / walk.direction.z
                    } else {
                        f32::INFINITY
                    };
                    if to_surface <= walk.left {
                        walk.attenuate(to_surface, false);
                        sum += f64::from(walk.weight.x * albedo);
                        break;
                    }
                    goes_on = walk.scatter();
                }
            }
            let found = sum / f64::from(count);
            assert!((found - f64::from(albedo)).abs() < 0.03, "{albedo}: {found}");
        }
    }
}
