//! Direct light on samples: shadow rays where a tag is no longer valid, and the part of the colour that does
//! not depend on the eye (the paper's "Verification Phase" for shadows, and its "Color Calculation").

use super::lighting::{Places, add_light, of_itself, sample_of_light};
use super::shadow::{CHECKS, Checks, ShadowQueue, Shadows};
use crate::frame::grid::bits::{count_bits, set_bits, status_bits, surface_bits};
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::{LightChange, ShadowCheck};
use crate::frame::shot::tile_bounds::TileBounds;
use crate::frame::surface::placed::{Placed, PlacedTile, lift};
use crate::frame::surface::ray_tally::RayTally;
use crate::lanes::{F32x8, LANES, Mask, Vec3x8};
use crate::samples::{AREA_POINTS, CELLS, Flags, Status, Tag, TagSlot, Tile};
use crate::shade::bsdf::phong;
use crate::shade::light::{StratifiedPattern, light_samples};
use crate::shade::terminator::{ToLight, ToSixteen};
use crate::trace::{Coherence, SceneSubset};

/// Scratch memory of a worker for this phase.
#[derive(Debug)]
pub struct Lighting {
    /// Queues, one for each of [`CHECKS`].
    queues: [ShadowQueue; 3],
    /// Bit masks, for each eight cells, of those whose light must be summed anew.
    stale: [u8; CELLS / LANES],
}

impl Default for Lighting {
    fn default() -> Self {
        Self { queues: Default::default(), stale: [0; CELLS / LANES] }
    }
}

/// Updates all shadow tags of `tile`, and with them the light that its samples store. `flags` are those that
/// any sample of the tile has. Returns true if any of that light may have changed; and the bounds of the
/// samples, if they were computed.
pub fn light(
    frame: &FrameView,
    tile: &mut Tile,
    flags: Flags,
    lighting: &mut Lighting,
    placed: &mut PlacedTile,
    tally: &mut RayTally,
) -> (bool, Option<TileBounds>) {
    for (stale, first) in lighting.stale.iter_mut().zip((0..).step_by(LANES)) {
        *stale = must_be_summed(frame, tile, first);
        if flags.has(Flags::STALE) {
            *stale |= tile.flagged(first, Flags::STALE);
            tile.unflag(first, u8::MAX, Flags::STALE);
        }
    }
    // computed at once where a tag may hold though something moved, and else for the first light whose tags
    // are tested
    let may_hold = frame.plan.any_moved && frame.plan.lights.iter().any(|light| *light != LightChange::Moved);
    let mut bounds = may_hold.then(|| TileBounds::samples(frame, tile));
    for (light, pose) in frame.pose.lights.iter().enumerate() {
        let may_be_in_shadow = |bounds: &TileBounds, of| bounds.may_be_in_shadow(of, frame.pose, light);
        let may_be_met = frame.moves_blockers(light)
            && bounds.as_ref().is_none_or(|bounds| may_be_in_shadow(bounds, frame.moved_bounds));
        if !may_be_met && all_tags_hold(frame, light, tile) {
            continue;
        }
        let checks = [false, true].map(|moved| Checks::new(frame, light, moved, may_be_met));
        if frame.pose.is_dark(light) {
            forget_doubtful(frame, &checks, tile, frame.slots[light]);
            continue;
        }
        let purpose = frame.shadows_of_light(light);
        lighting.queues.iter_mut().for_each(|queue| queue.begin(purpose));
        let bounds = bounds.get_or_insert_with(|| TileBounds::samples(frame, tile));
        let is_among_all = may_be_in_shadow(bounds, frame.dynamic_bounds);
        let among = if is_among_all { SceneSubset::All } else { SceneSubset::Still };
        let query = LightQuery { light, among, checks };
        let ask = if pose.points == 1 { ask_light } else { ask_area_light };
        ask(frame, &query, tile, lighting, placed, tally);
    }
    for (stale, first) in lighting.stale.iter().zip((0..).step_by(LANES)) {
        if *stale != 0 {
            // the other lanes of the eight come out unchanged
            let lit = sum_light(frame, tile, first, &placed.get(frame, tile, first));
            tile.keep_light(first, lit);
        }
    }
    let is_changed = lighting.stale.iter().any(|stale| *stale != 0);
    (is_changed, bounds)
}

/// Returns true if no tag of the tile needs a ray, provided that nothing that moved can lie between the tile
/// and the light: none of the tags is in doubt by itself.
fn all_tags_hold(frame: &FrameView, light: usize, tile: &Tile) -> bool {
    frame.plan.lights[light] != LightChange::Moved
        && !tile.tags.any_doubtful(frame.slots[light], &tile.model)
        && tile.model.chunks_exact(LANES).all(|models| frame.moved_bits(models) == 0)
}

/// Bit mask of those of eight cells whose light must be summed anew whatever their tags say.
fn must_be_summed(frame: &FrameView, tile: &Tile, first: usize) -> u8 {
    let models = &tile.model[first..first + LANES];
    let [still, moved] = [false, true].map(|moved| frame.plan.light_changes(moved));
    let mut bits = !status_bits(&tile.status[first..first + LANES], Status::is_reused);
    if still {
        bits = u8::MAX;
    } else if moved {
        bits |= frame.moved_bits(models);
    }
    bits & surface_bits(models)
}

/// Resets the tags of a light without power that would have to be tested. No ray tells whom the light reaches
/// until it shines again, and until then its tags decide nothing.
fn forget_doubtful(frame: &FrameView, checks: &[Checks; 2], tile: &mut Tile, slot: TagSlot) {
    for first in (0..CELLS).step_by(LANES) {
        let moved = frame.moved_bits(&tile.model[first..first + LANES]);
        let check = |lane: usize| &checks[usize::from(moved >> lane & 1)];
        if let Some(tags) = tile.tags.single_mut(slot).get_mut(first..first + LANES) {
            for (lane, tag) in tags.iter_mut().enumerate() {
                *tag = if check(lane).asks(*tag) { Tag::Unknown } else { *tag };
            }
        }
        if let Some(tags) = tile.tags.area_mut(slot).get_mut(first..first + LANES) {
            for (lane, tags) in tags.iter_mut().enumerate() {
                *tags = tags.without(|tag| check(lane).asks(tag));
            }
        }
    }
}

/// A light for which the samples of a tile are tested, and the manner of the tests.
struct LightQuery {
    /// Number of the light.
    light: usize,
    /// Models that its rays can meet; they meet no others.
    among: SceneSubset,
    /// Checks for samples of models that did not move, and of those that did.
    checks: [Checks; 2],
}

/// Updates the tags of a light to which each sample sends one ray.
fn ask_light(
    frame: &FrameView,
    query: &LightQuery,
    tile: &mut Tile,
    lighting: &mut Lighting,
    placed: &mut PlacedTile,
    tally: &mut RayTally,
) {
    let LightQuery { light, among, ref checks } = *query;
    let slot = frame.slots[light];
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let tags = &tile.tags.single(slot)[first..first + LANES];
        let moved = frame.moved_bits(models);
        let hold = |checks: &Checks, lanes: u8| lanes == 0 || checks.all_hold(tags);
        if hold(&checks[0], !moved) && hold(&checks[1], moved) {
            continue;
        }
        let surfaces = surface_bits(models);
        let mut asked = Checks::queues(checks, tags, moved).map(|asked| asked & surfaces);
        if asked == [0; CHECKS.len()] {
            continue;
        }
        let placed = placed.get(frame, tile, first);
        let places = (placed.point, tile.gathered.seeds(first));
        let light_sample = sample_of_light(frame, (light, 0), || tile.ticks(first), places);
        let wanted = asked[0] | asked[1] | asked[2];
        let ToLight { faces, origins, to_light } =
            placed.receivers().to_light(&light_sample, wanted, |lane| lift(frame, tile, first + lane));
        let faces = faces & frame.lit_bits(light, &tile.model[first..first + LANES]);
        let far = F32x8::splat(light_sample.far);
        if asked[0] != 0 {
            asked[0] &= frame.moved_bounds.may_meet(origins, to_light, far);
            if asked == [0; CHECKS.len()] {
                continue;
            }
        }
        let tags = &mut tile.tags.single_mut(slot)[first..first + LANES];
        for lane in set_bits(!faces & (asked[0] | asked[1] | asked[2])) {
            lighting.stale[first / LANES] |= u8::from(tags[lane].changes_light_to(Tag::BackFacing)) << lane;
            tags[lane] = Tag::BackFacing;
        }
        for (queue, asked) in lighting.queues.iter_mut().zip(asked) {
            queue.push(origins, to_light, far, asked & faces, first as u32);
            count_bits(asked & faces, &mut tally.cells.shadow[first..first + LANES]);
        }
    }
    let tags = tile.tags.single_mut(slot);
    for (check, queue) in CHECKS.into_iter().zip(&mut lighting.queues) {
        tally.counts.shadow += queue.count();
        queue.set_ticks(frame, |cell| cell);
        queue.answer_packets(check, among, Coherence::Coherent, frame.tracer, |cells, now| {
            let first = cells[0] as usize;
            // whole blocks, which is the case in every frame that is traced in full
            let is_block = cells.len() == now.len()
                && first % LANES == 0
                && cells[now.len() - 1] as usize == first + now.len() - 1;
            if is_block {
                for (half, now) in (first..).step_by(LANES).zip(now.chunks_exact(LANES)) {
                    let tags = &mut tags[half..half + LANES];
                    let changes = tags.iter().zip(now).enumerate();
                    lighting.stale[half / LANES] |= changes.fold(0, |bits, (lane, (tag, now))| {
                        bits | u8::from(tag.changes_light_to(*now)) << lane
                    });
                    tags.copy_from_slice(now);
                }
            } else {
                for (cell, now) in cells.iter().zip(now).map(|(cell, now)| (*cell as usize, *now)) {
                    let changes = tags[cell].changes_light_to(now);
                    lighting.stale[cell / LANES] |= u8::from(changes) << (cell % LANES);
                    tags[cell] = now;
                }
            }
        });
    }
}

/// Updates the tags of a light to which each sample sends several rays. Where all points of the light are
/// tested, each sample's rays make one packet: they start in one point and cost no more than those of
/// neighbours to one point of the light. Where only models that moved are tested, a few points of each sample
/// are in doubt, and neighbours' rays to one point share a packet.
fn ask_area_light(
    frame: &FrameView,
    query: &LightQuery,
    tile: &mut Tile,
    lighting: &mut Lighting,
    placed: &mut PlacedTile,
    tally: &mut RayTally,
) {
    let LightQuery { light, among, ref checks } = *query;
    let slot = frame.slots[light];
    for first in (0..CELLS).step_by(LANES) {
        let models = &tile.model[first..first + LANES];
        let moved = frame.moved_bits(models);
        let asked_of =
            |lane: usize| checks[usize::from(moved >> lane & 1)].asked(tile.tags.area(slot)[first + lane]);
        let mut asked = [[0; CHECKS.len()]; LANES];
        set_bits(surface_bits(models)).for_each(|lane| asked[lane] = asked_of(lane));
        if asked == [[0; CHECKS.len()]; LANES] {
            continue;
        }
        let placed = placed.get(frame, tile, first);
        let seeds = tile.gathered.seeds(first);
        let receivers = placed.receivers();
        let (mut origins, mut lifts) = (Vec3x8::ZERO, Vec3x8::ZERO);
        let mut to_points = [[0; LANES]; CHECKS.len()];
        for (lane, mut asked) in asked.into_iter().enumerate().filter(|(_, asked)| *asked != [0; 3]) {
            let cell = first + lane;
            let point = placed.point.lane(lane);
            let pose = &frame.pose.lights_at(tile.record[cell].traced.tick())[light];
            let pattern = StratifiedPattern::of_seeds(pose, seeds);
            let light_samples = light_samples(pose, &pattern, lane, point);
            let ToSixteen { faces, origin, lift, light_samples } =
                receivers.to_sixteen(lane, &light_samples, || lift(frame, tile, cell));
            let faces = if frame.lights(light, tile.model[cell]) { faces } else { 0 };
            origins.set_lane(lane, origin);
            lifts.set_lane(lane, lift);
            if asked[0] != 0 {
                let ([low, high], origin) = (asked[0].to_le_bytes(), Vec3x8::splat(origin));
                let far = F32x8::splat(light_samples[0].far);
                let meets =
                    |half: usize| frame.moved_bounds.may_meet(origin, light_samples[half].to_light, far);
                asked[0] = u16::from_le_bytes([meets(0) & low, meets(1) & high]);
            }
            let all_asked = asked.into_iter().fold(0, |all, asked| all | asked);
            lighting.learn(
                tile,
                slot,
                cell,
                Shadows { asked: all_asked & !faces, blocked: u16::MAX, by_dynamic: 0 },
            );
            for (check, asked) in asked.into_iter().enumerate() {
                let asked = asked & faces;
                if asks_all_points(CHECKS[check]) {
                    lighting.queues[check].push_sixteen(origin, &light_samples, asked, cell as u32);
                } else {
                    to_points[check][lane] = asked;
                }
            }
            let counted = &mut tally.cells.shadow[cell];
            *counted = counted.saturating_add((all_asked & faces).count_ones() as u16);
        }
        for (queue, asked) in lighting.queues.iter_mut().zip(&to_points) {
            let points = asked.iter().fold(0, |points, asked| points | asked);
            for point in (0..AREA_POINTS).filter(|point| points >> point & 1 != 0) {
                let places = (placed.point, seeds);
                let light_sample = sample_of_light(frame, (light, point), || tile.ticks(first), places);
                let wanted = (0..)
                    .zip(asked)
                    .fold(0, |bits, (lane, asked)| bits | ((asked >> point & 1) as u8) << lane);
                let (to_light, far) =
                    (light_sample.from_points_beside(lifts), F32x8::splat(light_sample.far));
                queue.push(origins, to_light, far, wanted, (point * CELLS + first) as u32);
            }
        }
    }
    let mut queues = std::mem::take(&mut lighting.queues);
    for (check, queue) in CHECKS.into_iter().zip(&mut queues) {
        tally.counts.shadow += queue.count();
        if asks_all_points(check) {
            queue.set_ticks_of_sixteen(frame, |cell| cell);
            queue.answer_sixteen(check, among, Coherence::SharedOrigin, frame.tracer, |cell, shadows| {
                lighting.learn(tile, slot, cell as usize, shadows);
            });
        } else {
            queue.set_ticks(frame, |owner| owner % CELLS as u32);
            queue.answer(check, among, Coherence::SharedOrigin, frame.tracer, |owner, tag| {
                let (point, cell) = (owner as usize / CELLS, owner as usize % CELLS);
                lighting.learn(tile, slot, cell, Shadows::of_point(point, tag));
            });
        }
    }
    lighting.queues = queues;
}

/// Returns true if samples with this check mostly test all points of an area light.
fn asks_all_points(check: ShadowCheck) -> bool {
    check == ShadowCheck::StillThenMovable
}

impl Lighting {
    /// Updates the tags of one cell for an area light, and notes whether its light changes.
    #[inline]
    fn learn(&mut self, tile: &mut Tile, slot: TagSlot, cell: usize, shadows: Shadows) {
        let tags = &mut tile.tags.area_mut(slot)[cell];
        let before = *tags;
        tags.learn(shadows.asked, !shadows.blocked, shadows.by_dynamic);
        let changes = before.changes_light_to(*tags);
        self.stale[cell / LANES] |= u8::from(changes) << (cell % LANES);
    }
}

/// Sums the light of eight samples: emission, ambient light, the diffuse light of all lights that reach them,
/// and the light that they have gathered.
#[inline]
pub fn sum_light(frame: &FrameView, tile: &Tile, first: usize, placed: &Placed) -> Vec3x8 {
    let (reflectance, looks) = (tile.reflectances(first), tile.looks(first));
    let albedo = frame.palette.albedo(&looks, reflectance);
    let of_lights = frame.albedo_of_lights(&looks, albedo);
    let models = &tile.model[first..first + LANES];
    let mut sum = of_itself(frame, models, (&looks, reflectance), || tile.gathered.opennesses(first));
    for (light, slot) in (0..).zip(frame.slots).filter(|(light, _)| !frame.pose.is_dark(*light)) {
        frame.pose.each_of_light(
            light,
            || tile.ticks(first),
            |light, bits| {
                let at = (placed.point, tile.gathered.seeds(first));
                let places = Places::new(frame, at, || tile.ticks(first));
                let reached = |point| tile.tags.lit(*slot, point, first) & Mask::from_bits(bits);
                sum = add_light(frame, sum, light, places, reached, |light_sample| {
                    phong::diffuse(of_lights, placed.normal, placed.smooth, light_sample)
                });
            },
        );
    }
    if tile.gathered.is_some() {
        sum = sum + albedo * tile.gathered.means(first);
    }
    sum
}
