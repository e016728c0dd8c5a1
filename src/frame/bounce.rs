//! Rays beyond the first surface: what mirrors and glass show. They depend on the eye and are traced anew
//! in every frame, breadth first: all rays of a tile that have bounced equally often go together.

use glam::Vec3;

use super::enhance::Radiance;
use super::light::ShadowQueue;
use super::plan::ShadowCheck;
use super::stage::{CellRays, Stage, Workbench};
use crate::shade::light::arrival;
use crate::shade::optics::{Branches, branch};
use crate::shade::{Surface, phong};
use crate::stats::RayCounts;
use crate::trace::Coherence;

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
    weight: Vec3,
    origin: Vec3,
    direction: Vec3,
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
    queue: ShadowQueue,
}

impl Bounces {
    /// Starts the rays that leave the sample of `cell`.
    pub fn start(&mut self, cell: u32, surface: &Surface, branches: Branches) {
        let next = &mut self.next;
        grow(next, surface, branches, |kind, weight, origin, direction| Bounce {
            cell,
            kind,
            layer: kind,
            weight,
            origin,
            direction,
        });
    }
}

/// Follows the rays that were [started](Bounces::start), up to the stage's depth, and adds what they bring
/// to the cells' radiance.
pub fn follow(stage: &Stage, bench: &mut Workbench) {
    let mut bounces = std::mem::take(&mut bench.bounces);
    for _ in 0..stage.depth {
        std::mem::swap(&mut bounces.now, &mut bounces.next);
        bounces.next.clear();
        if bounces.now.is_empty() {
            break;
        }
        meet(stage, &mut bounces, bench);
        light(stage, &mut bounces, bench);
        for met in &bounces.met {
            add(&mut bench.radiance, &met.bounce, met.light);
            go_on(stage, met, &mut bounces.next);
        }
    }
    bounces.next.clear();
    bench.bounces = bounces;
}

/// Finds what the rays meet; those that meet nothing see the background.
fn meet(stage: &Stage, bounces: &mut Bounces, bench: &mut Workbench) {
    bench.begin_rays();
    for bounce in &bounces.now {
        bench.rays.push(bounce.origin, bounce.direction, 0.0, f32::INFINITY);
        count(bounce, &mut bench.counts, &mut bench.cell_rays);
    }
    stage.tracer.closest(&bench.rays, Coherence::Incoherent, &mut bench.hits);
    bounces.met.clear();
    for (ray, bounce) in bounces.now.iter().enumerate() {
        match bench.hits.get(ray) {
            None => add(&mut bench.radiance, bounce, stage.scene.background.radiance(bounce.direction)),
            Some(hit) => {
                let transform = stage.transform(hit.model);
                let surface = Surface::at(stage.scene, transform, hit, bounce.direction);
                bounces.met.push(Met { bounce: *bounce, surface, light: Vec3::ZERO });
            }
        }
    }
}

/// Lights what was met, highlights included.
fn light(stage: &Stage, bounces: &mut Bounces, bench: &mut Workbench) {
    let material = |met: &Met| &stage.scene.materials[usize::from(met.surface.material)];
    for met in &mut bounces.met {
        met.light = phong::emitted_and_ambient(material(met), met.surface.albedo, stage.scene.ambient);
    }
    for light in &stage.pose.lights {
        bounces.queue.clear();
        for (owner, Met { surface, bounce, .. }) in bounces.met.iter().enumerate() {
            let arrival = arrival(light, surface.point);
            if phong::faces(surface.normal, surface.facet, arrival.direction)
                && arrival.irradiance != Vec3::ZERO
            {
                bounces.queue.push(surface.point, surface.facet, &arrival, owner as u32);
                bench.cell_rays[bounce.cell as usize].shadow += 1;
            }
        }
        bench.counts.shadow += bounces.queue.count();
        let met = &mut bounces.met;
        let order = ShadowCheck::StillThenMovable;
        bounces.queue.answer(order, Coherence::Incoherent, stage.tracer, |owner, tag| {
            if tag.is_lit() {
                let met = &mut met[owner as usize];
                let arrival = arrival(light, met.surface.point);
                let view = -met.bounce.direction;
                met.light += phong::diffuse(met.surface.albedo, met.surface.normal, &arrival)
                    + phong::specular(material(met), met.surface.normal, view, &arrival);
            }
        });
    }
}

/// Starts the rays that leave what was met.
fn go_on(stage: &Stage, met: &Met, next: &mut Vec<Bounce>) {
    let optics = stage.scene.materials[usize::from(met.surface.material)].optics;
    let branches = branch(optics, &met.surface, met.bounce.direction);
    grow(next, &met.surface, branches, |kind, weight, origin, direction| Bounce {
        kind,
        weight: weight * met.bounce.weight,
        origin,
        direction,
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

fn count(bounce: &Bounce, counts: &mut RayCounts, cells: &mut [CellRays]) {
    cells[bounce.cell as usize].secondary += 1;
    match bounce.kind {
        Kind::Reflection => counts.reflection += 1,
        Kind::Refraction => counts.refraction += 1,
    }
}

fn add(radiance: &mut [Radiance], bounce: &Bounce, light: Vec3) {
    let cell = &mut radiance[bounce.cell as usize];
    match bounce.layer {
        Kind::Reflection => cell.reflection += bounce.weight * light,
        Kind::Refraction => cell.refraction += bounce.weight * light,
    }
}
