//! Light on samples: shadow rays where a tag no longer answers, and the part of the colour that does not
//! depend on the eye (the paper's "Verification Phase" for shadows, and its "Color Calculation").

use super::movers::{Bounds, Sweep};
use super::placed::Placed;
use super::plan::{LightChange, ShadowCheck};
use super::stage::{Stage, Workbench, bit, set_bits, surface_bits};
use crate::lanes::{LANES, Lanes, Lanes3};
use crate::motion::pose::LightShape;
use crate::samples::{CELLS, Status, Tag, Tile, load_colors, store_colors};
use crate::shade::light::{Aim, Arrival, arrival};
use crate::shade::phong;
use crate::shade::surface::off_surfaces;
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

    /// Adds the rays from those of eight surfaces whose bit is set to a light that they face. Their owners'
    /// numbers count up from `owner`.
    #[inline(always)]
    pub fn push(&mut self, point: Lanes3, facet: Lanes3, arrival: &Arrival, wanted: u8, owner: u32) {
        if wanted == 0 {
            return;
        }
        let far = Lanes::splat(arrival.far);
        self.rays.push_lanes(off_surfaces(point, facet), arrival.to_light, far, wanted);
        self.owners.extend(set_bits(wanted).map(|lane| owner + lane as u32));
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
#[derive(Debug)]
pub struct Lighting {
    /// One for each of [`CHECKS`].
    queues: [ShadowQueue; 3],
    /// For each eight cells, a bit each, whether the light must be summed anew.
    stale: [u8; CELLS / LANES],
}

impl Default for Lighting {
    fn default() -> Self {
        Self { queues: Default::default(), stale: [0; CELLS / LANES] }
    }
}

/// Brings all shadow tags of `tile` up to date, and with them what its samples keep of their light. Whether
/// any of that may have changed.
pub fn light(stage: &Stage, tile: &mut Tile, bench: &mut Workbench) -> bool {
    let mut lighting = std::mem::take(&mut bench.lighting);
    for (stale, first) in lighting.stale.iter_mut().zip((0..).step_by(LANES)) {
        *stale = must_be_summed(stage, tile, first);
    }
    // asked for only where a tag may hold though something moved
    let may_hold = stage.plan.any_moved && stage.plan.lights.iter().any(|light| *light != LightChange::Moved);
    let surfaces = if may_hold { Bounds::of_samples(stage, tile, false) } else { Bounds::EMPTY };
    for light in 0..stage.pose.lights.len() {
        if !all_tags_hold(stage, light, tile, &surfaces) {
            let points = 0..stage.pose.lights[light].shape.points();
            points.for_each(|point| ask_light(stage, light, point, tile, &mut lighting, bench));
        }
    }
    for (stale, first) in lighting.stale.iter().zip((0..).step_by(LANES)) {
        if *stale != 0 {
            // those beside them would come out as they are
            let lit = sum_light(stage, tile, first, &bench.placed.get(stage, tile, first));
            store_colors(lit, &mut tile.lit, first);
        }
    }
    let is_changed = lighting.stale.iter().any(|stale| *stale != 0);
    bench.lighting = lighting;
    is_changed
}

/// Whether no tag of a whole tile needs a ray: none is in doubt by itself, and nothing that moved can have
/// come between the light and the tile's `surfaces`.
fn all_tags_hold(stage: &Stage, light: usize, tile: &Tile, surfaces: &Bounds) -> bool {
    if surfaces.is_empty() || stage.plan.lights[light] == LightChange::Moved {
        return false;
    }
    let is_doubtful = |cell: usize| tile.tags.is_doubtful(stage.slots[light], cell);
    let in_doubt =
        |cell: usize| tile.is_surface(cell) && (is_doubtful(cell) || stage.moved(tile.model[cell]));
    let doubtful = (0..CELLS).any(in_doubt);
    let ways = || match stage.pose.lights[light].shape {
        LightShape::Directional { to_light } => Sweep::along(surfaces, to_light),
        LightShape::Point { position } | LightShape::Spot { position, .. } => {
            Sweep::between(&Bounds::at(position), surfaces)
        }
        LightShape::Rectangle { center, across, up, .. } => {
            Sweep::between(&Bounds::of_rectangle(center, across, up), surfaces)
        }
    };
    !doubtful && !stage.movers.may_meet_sweep(&ways())
}

/// Of eight cells, those whose light must be summed anew whatever their tags say.
fn must_be_summed(stage: &Stage, tile: &Tile, first: usize) -> u8 {
    let models = &tile.model[first..first + LANES];
    let [still, moved] = [false, true].map(|moved| stage.plan.light_changes(moved));
    let is_new = |status: &Status| !status.is_reused();
    let mut bits = tile.status[first..first + LANES]
        .iter()
        .enumerate()
        .fold(0, |bits, (lane, status)| bits | u8::from(is_new(status)) << lane);
    if still {
        bits = u8::MAX;
    } else if moved {
        bits |= stage.moved_bits(models);
    }
    bits & surface_bits(models)
}

/// Brings the tags of one point of a light up to date.
fn ask_light(
    stage: &Stage,
    light: usize,
    point: usize,
    tile: &mut Tile,
    lighting: &mut Lighting,
    bench: &mut Workbench,
) {
    let (pose, slot) = (&stage.pose.lights[light], stage.slots[light]);
    let checks = [false, true].map(|moved| Checks::of(stage, light, moved));
    if checks.iter().all(|checks| checks.all_keep) {
        return;
    }
    lighting.queues.iter_mut().for_each(ShadowQueue::clear);
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let tags = tile.tags.eight(slot, point, first);
        let (surfaces, moved) = (surface_bits(models), stage.moved_bits(models));
        let mut asked = [0; CHECKS.len()];
        for lane in 0..LANES {
            let queue = checks[usize::from(moved >> lane & 1)].queue_of[tags[lane] as usize];
            if let Some(queue) = queue {
                asked[usize::from(queue)] |= 1 << lane & surfaces;
            }
        }
        if asked == [0; CHECKS.len()] {
            continue;
        }
        let placed = bench.placed.get(stage, tile, first);
        let arrival = arrival(pose, point, &Aim::at(pose, tile.points(first)), placed.point);
        asked[0] &= may_meet_mover(stage, &placed, &arrival, asked[0]);
        let faces = phong::faces(placed.normal, placed.facet, &arrival).bits();
        for lane in set_bits(!faces & (asked[0] | asked[1] | asked[2])) {
            lighting.stale[first / LANES] |= u8::from(tags[lane].changes_light_to(Tag::Averted)) << lane;
            tile.tags.set(slot, point, first + lane, Tag::Averted);
        }
        for (queue, asked) in lighting.queues.iter_mut().zip(asked) {
            queue.push(placed.point, placed.facet, &arrival, asked & faces, first as u32);
            for lane in set_bits(asked & faces) {
                bench.cell_rays.shadow[first + lane] += 1;
            }
        }
    }
    let tags = &mut tile.tags;
    for (check, queue) in CHECKS.into_iter().zip(&mut lighting.queues) {
        bench.counts.shadow += queue.count();
        queue.answer(check, Coherence::Coherent, stage.tracer, |cell, now| {
            let cell = cell as usize;
            let changes = tags.get(slot, point, cell).changes_light_to(now);
            lighting.stale[cell / LANES] |= u8::from(changes) << (cell % LANES);
            tags.set(slot, point, cell, now);
        });
    }
}

/// For one light, what is to be asked about samples with each tag.
struct Checks {
    /// Index into [`CHECKS`] by tag; `None` where the tag holds.
    queue_of: [Option<u8>; Tag::ALL.len()],
    all_keep: bool,
}

impl Checks {
    /// `moved`: the sample's model did.
    fn of(stage: &Stage, light: usize, moved: bool) -> Self {
        let queue_of = Tag::ALL.map(|tag| {
            let check = stage.plan.shadow_check(light, moved, tag);
            CHECKS.iter().position(|known| *known == check).map(|queue| queue as u8)
        });
        Self { queue_of, all_keep: queue_of.iter().all(Option::is_none) }
    }
}

/// Of the eight surfaces that are `asked` for, those whose way to the light may lead through a mover.
#[inline]
fn may_meet_mover(stage: &Stage, placed: &Placed, arrival: &Arrival, asked: u8) -> u8 {
    let meets = |lane: usize| {
        stage.movers.may_meet(placed.point.lane(lane), arrival.to_light.lane(lane), arrival.far)
    };
    set_bits(asked).filter(|lane| meets(*lane)).fold(0, |bits, lane| bits | 1 << lane)
}

/// For eight samples: emission, ambient light, and the diffuse light of all lights that reach them.
#[inline]
pub fn sum_light(stage: &Stage, tile: &Tile, first: usize, placed: &Placed) -> Lanes3 {
    let albedo = load_colors(&tile.albedo, first);
    let mut sum = stage.palette.emitted_and_ambient(&tile.material[first..first + LANES], albedo);
    for (light, slot) in stage.pose.lights.iter().zip(stage.slots) {
        let aim = Aim::at(light, tile.points(first));
        for point in 0..light.shape.points() {
            let lit = tile.tags.lit(*slot, point, first);
            if lit.any() {
                let arrival = arrival(light, point, &aim, placed.point);
                let diffuse = phong::diffuse(albedo, placed.normal, &arrival);
                sum = sum + lit.select3(diffuse, Lanes3::ZERO);
            }
        }
    }
    sum
}
