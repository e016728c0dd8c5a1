//! Light on samples: shadow rays where a tag no longer answers, and the part of the colour that does not
//! depend on the eye (the paper's "Verification Phase" for shadows, and its "Color Calculation").

use glam::Vec3;

use super::placed::Placed;
use super::plan::ShadowCheck;
use super::stage::{Stage, Workbench, bit};
use crate::samples::{EMPTY, Tag, Tile, from_half, to_half};
use crate::shade::light::{Arrival, arrival};
use crate::shade::phong;
use crate::shade::surface::off_surface;
use crate::trace::{Blockers, Coherence, Purpose, RayBatch, Tracer};

/// Shadow rays of one light that are to be tested in the same order.
#[derive(Debug, Default)]
pub struct ShadowQueue {
    rays: RayBatch,
    owners: Vec<u32>,
    blocked: Vec<u16>,
    by_first: Vec<u16>,
}

impl ShadowQueue {
    /// No rays.
    pub fn clear(&mut self) {
        self.rays.clear();
        self.owners.clear();
    }

    /// How many rays.
    pub fn count(&self) -> u64 {
        self.rays.len() as u64
    }

    /// Adds the ray from a surface to a light that it faces.
    #[inline]
    pub fn push(&mut self, point: Vec3, facet: Vec3, arrival: &Arrival, owner: u32) {
        self.rays.push(off_surface(point, facet), arrival.to_light, 0.0, arrival.far);
        self.owners.push(owner);
    }

    /// Traces the rays and says to each owner who shadows it, if anyone.
    pub fn answer(
        &mut self,
        check: ShadowCheck,
        coherence: Coherence,
        tracer: &dyn Tracer,
        mut say: impl FnMut(u32, Tag),
    ) {
        let [first, second] = match check {
            ShadowCheck::Keep => return,
            ShadowCheck::Moved => [Some((Blockers::Moved, Tag::ByMovable)), None],
            ShadowCheck::StillThenMovable => [BY_STILL, BY_MOVABLE],
            ShadowCheck::MovableThenStill => [BY_MOVABLE, BY_STILL],
        };
        self.blocked.clear();
        self.blocked.resize(self.rays.packet_count(), 0);
        let ask = |stage: Option<(Blockers, Tag)>, blocked: &mut [u16]| {
            let (by, tag) = stage?;
            tracer.blocked(&self.rays, by, Purpose::Shadow, coherence, blocked);
            Some(tag)
        };
        let first = ask(first, &mut self.blocked);
        self.by_first.clone_from(&self.blocked);
        let second = ask(second, &mut self.blocked);
        for (ray, owner) in self.owners.iter().enumerate() {
            let tag = if bit(&self.by_first, ray) {
                first
            } else if bit(&self.blocked, ray) {
                second
            } else {
                None
            };
            say(*owner, tag.unwrap_or(Tag::Lit));
        }
    }
}

const BY_STILL: Option<(Blockers, Tag)> = Some((Blockers::Still, Tag::ByStill));
const BY_MOVABLE: Option<(Blockers, Tag)> = Some((Blockers::Movable, Tag::ByMovable));

/// The orders in which shadow rays are tested.
const CHECKS: [ShadowCheck; 3] =
    [ShadowCheck::Moved, ShadowCheck::StillThenMovable, ShadowCheck::MovableThenStill];

/// A worker's memory for this phase.
#[derive(Debug, Default)]
pub struct Lighting {
    /// One for each of [`CHECKS`].
    queues: [ShadowQueue; 3],
    /// For each cell, whether its light must be summed anew.
    stale: Vec<bool>,
}

/// Brings all shadow tags of `tile` up to date, and with them what its samples keep of their light.
pub fn light(stage: &Stage, tile: &mut Tile, bench: &mut Workbench) {
    let mut lighting = std::mem::take(&mut bench.lighting);
    lighting.stale.clear();
    lighting.stale.extend(tile.hot.iter().zip(&tile.cold).map(|(hot, cold)| {
        hot.model < EMPTY && (!cold.status.is_reused() || stage.plan.light_changes(stage.moved(hot)))
    }));
    for light in 0..stage.pose.lights.len() {
        ask_light(stage, light, tile, &mut lighting, bench);
    }
    for (cell, _) in lighting.stale.iter().enumerate().filter(|(_, stale)| **stale) {
        let lit = sum_light(stage, tile, cell, &bench.placed.get(stage, tile, cell));
        tile.cold[cell].lit = to_half(lit);
    }
    bench.lighting = lighting;
}

/// Brings the tags of one light up to date.
fn ask_light(stage: &Stage, light: usize, tile: &mut Tile, lighting: &mut Lighting, bench: &mut Workbench) {
    let lights = stage.pose.lights.len();
    lighting.queues.iter_mut().for_each(ShadowQueue::clear);
    for cell in 0..tile.hot.len() {
        let hot = &tile.hot[cell];
        if hot.model >= EMPTY {
            continue;
        }
        let tag = tile.tags[cell * lights + light];
        let check = stage.plan.shadow_check(light, stage.moved(hot), tag);
        let Some(queue) = CHECKS.iter().position(|known| *known == check) else { continue };
        let placed = bench.placed.get(stage, tile, cell);
        let arrival = arrival(&stage.pose.lights[light], placed.point);
        if check == ShadowCheck::Moved && !stage.movers.may_meet(placed.point, arrival.to_light, arrival.far)
        {
            continue;
        }
        if phong::faces(placed.normal, placed.facet, arrival.direction) && arrival.irradiance != Vec3::ZERO {
            lighting.queues[queue].push(placed.point, placed.facet, &arrival, cell as u32);
            bench.cell_rays[cell].shadow += 1;
        } else {
            lighting.stale[cell] |= tag.changes_light_to(Tag::Averted);
            tile.tags[cell * lights + light] = Tag::Averted;
        }
    }
    for (check, queue) in CHECKS.into_iter().zip(&mut lighting.queues) {
        bench.counts.shadow += queue.count();
        queue.answer(check, Coherence::Coherent, stage.tracer, |cell, now| {
            let tag = &mut tile.tags[cell as usize * lights + light];
            lighting.stale[cell as usize] |= tag.changes_light_to(now);
            *tag = now;
        });
    }
}

/// Emission, ambient light, and the diffuse light of all lights that reach the sample.
pub fn sum_light(stage: &Stage, tile: &Tile, cell: usize, placed: &Placed) -> Vec3 {
    let cold = &tile.cold[cell];
    let material = stage.material(&tile.hot[cell], cold);
    let albedo = from_half(cold.albedo);
    let mut sum = phong::emitted_and_ambient(material, albedo, stage.scene.ambient);
    let tags = &tile.tags[cell * stage.pose.lights.len()..];
    for (light, _) in stage.pose.lights.iter().zip(tags).filter(|(_, tag)| tag.is_lit()) {
        sum += phong::diffuse(albedo, placed.normal, &arrival(light, placed.point));
    }
    sum
}
