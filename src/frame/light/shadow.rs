//! Shadow rays: queued by the order in which occluders are tested, traced together, and answered with the
//! occluder in their way.

use glam::Vec3;

use crate::frame::grid::bits::set_bits;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::shot::plan::ShadowCheck;
use crate::lanes::{F32x8, LANES, Vec3x8, are_same};
use crate::samples::{AREA_POINTS, AreaTag, Tag};
use crate::scene::Light;
use crate::shade::light::LightSample;
use crate::trace::{Coherence, Occluders, Purpose, RayBatch, SceneSubset, Tracer};

// a bit of a sample's word for each point of a light
const _: () = assert!(Light::MOST_SAMPLES as usize == AREA_POINTS);

/// Orders in which occluders of shadow rays are tested.
pub const CHECKS: [ShadowCheck; 3] =
    [ShadowCheck::Moved, ShadowCheck::StillThenMovable, ShadowCheck::MovableThenStill];

/// Number of rays of a packet.
const PACKET: usize = crate::trace::LANES;

/// Queue of shadow rays that are tested in the same order: either one by one, or sixteen from each surface.
#[derive(Debug, Default)]
pub struct ShadowQueue {
    rays: RayBatch,
    /// Who blocks the rays.
    purpose: Purpose,
    /// Owner of each ray, or of each packet of sixteen.
    owners: Vec<u32>,
    blocked: Vec<u16>,
    by_first: Vec<u16>,
}

/// Occluders in the way of sixteen rays from one surface, as bit masks.
#[derive(Debug, Clone, Copy)]
pub struct Shadows {
    /// Rays that were cast.
    pub asked: u16,
    /// Rays that any model blocks.
    pub blocked: u16,
    /// Rays that a movable model blocks.
    pub by_dynamic: u16,
}

impl Shadows {
    /// Result of the one ray to a point of the light, from its tag.
    pub fn of_point(point: usize, tag: Tag) -> Self {
        let bit = |is_set: bool| u16::from(is_set) << point;
        Self { asked: bit(true), blocked: bit(tag != Tag::Lit), by_dynamic: bit(tag == Tag::DynamicOccluder) }
    }
}

impl ShadowQueue {
    /// Removes all rays. Those that follow are `purpose`.
    pub fn begin(&mut self, purpose: Purpose) {
        self.rays.clear();
        self.owners.clear();
        self.purpose = purpose;
    }

    /// Number of rays.
    pub fn count(&self) -> u64 {
        self.rays.count()
    }

    /// Adds rays from those of eight `origins`, off their surfaces, whose bit in `wanted` is set: `to_light`, which is at `far`.
    /// Their owners' numbers count up from `owner`.
    #[inline(always)]
    pub fn push(&mut self, origins: Vec3x8, to_light: Vec3x8, far: F32x8, wanted: u8, owner: u32) {
        if wanted == 0 {
            return;
        }
        self.rays.push_lanes(origins, to_light, far, wanted);
        if wanted == u8::MAX {
            self.owners.extend(owner..owner + LANES as u32);
        } else {
            self.owners.extend(set_bits(wanted).map(|lane| owner + lane as u32));
        }
    }

    /// Adds rays from `origin`, off its surface, to those points of an area light whose bit in `wanted` is
    /// set.
    #[inline(always)]
    pub fn push_sixteen(&mut self, origin: Vec3, light_samples: &[LightSample; 2], wanted: u16, owner: u32) {
        if wanted != 0 {
            let segments = [light_samples[0].to_light, light_samples[1].to_light];
            self.rays.push_packet(origin, segments, light_samples[0].far, wanted);
            self.owners.push(owner);
        }
    }

    /// Has the rays meet what moves at the ticks of the cells of their owners.
    pub fn set_ticks(&mut self, frame: &FrameView, cell: impl Fn(u32) -> u32) {
        let Self { rays, owners, .. } = self;
        frame.set_ticks(rays, owners.iter().map(|owner| cell(*owner)));
    }

    /// [`set_ticks`](Self::set_ticks) for sixteen rays from each owner.
    pub fn set_ticks_of_sixteen(&mut self, frame: &FrameView, cell: impl Fn(u32) -> u32) {
        let Self { rays, owners, .. } = self;
        frame.set_ticks(rays, owners.iter().flat_map(|owner| [cell(*owner); PACKET]));
    }

    /// Traces the rays, which can meet nothing but models `among` these, and calls `say` for each with its
    /// owner and its tag.
    pub fn answer(
        &mut self,
        check: ShadowCheck,
        among: SceneSubset,
        coherence: Coherence,
        tracer: &dyn Tracer,
        mut say: impl FnMut(u32, Tag),
    ) {
        self.answer_packets(check, among, coherence, tracer, |owners, tags| {
            owners.iter().zip(tags).for_each(|(owner, tag)| say(*owner, *tag));
        });
    }

    /// Like [`answer`](Self::answer), with up to sixteen owners a call.
    pub fn answer_packets(
        &mut self,
        check: ShadowCheck,
        among: SceneSubset,
        coherence: Coherence,
        tracer: &dyn Tracer,
        mut say: impl FnMut(&[u32], &[Tag; PACKET]),
    ) {
        let [first, second] = self.trace(check, among, coherence, tracer);
        let answers = self.by_first.iter().zip(&self.blocked);
        for (owners, (by_first, blocked)) in self.owners.chunks(PACKET).zip(answers) {
            let tags = std::array::from_fn(|lane| match (by_first >> lane & 1, blocked >> lane & 1) {
                (0, 0) => Tag::Lit,
                (0, _) => second,
                _ => first,
            });
            say(owners, &tags);
        }
    }

    /// Like [`answer`](Self::answer), for sixteen rays from each owner.
    pub fn answer_sixteen(
        &mut self,
        check: ShadowCheck,
        among: SceneSubset,
        coherence: Coherence,
        tracer: &dyn Tracer,
        mut say: impl FnMut(u32, Shadows),
    ) {
        let [first, second] = self.trace(check, among, coherence, tracer).map(|tag| match tag {
            Tag::DynamicOccluder => u16::MAX,
            _ => 0,
        });
        let words = self.blocked.iter().zip(&self.by_first).zip(self.rays.packets());
        for (owner, ((blocked, by_first), (_, asked))) in self.owners.iter().zip(words) {
            let by_dynamic = by_first & first | blocked & !by_first & second;
            say(*owner, Shadows { asked, blocked: *blocked, by_dynamic });
        }
    }

    /// Traces the rays. Returns the tags that stand for hits in the first and in the second test.
    fn trace(
        &mut self,
        check: ShadowCheck,
        among: SceneSubset,
        coherence: Coherence,
        tracer: &dyn Tracer,
    ) -> [Tag; 2] {
        let [first, second] = match check {
            ShadowCheck::Keep => [None, None],
            ShadowCheck::Moved => [Some(Occluders::Moved), None],
            ShadowCheck::StillThenMovable => [Some(Occluders::Still), Some(Occluders::Movable)],
            ShadowCheck::MovableThenStill => [Some(Occluders::Movable), Some(Occluders::Still)],
        };
        self.blocked.clear();
        self.blocked.resize(self.rays.packet_count(), 0);
        let ask = |by: Option<Occluders>, blocked: &mut [u16]| {
            // occluders that are not tested block nothing
            let Some(by) = by.filter(|by| among == SceneSubset::All || *by == Occluders::Still) else {
                return Tag::Lit;
            };
            tracer.blocked(&self.rays, by, self.purpose, coherence, blocked);
            if by == Occluders::Still { Tag::StaticOccluder } else { Tag::DynamicOccluder }
        };
        let first = ask(first, &mut self.blocked);
        self.by_first.clone_from(&self.blocked);
        [first, ask(second, &mut self.blocked)]
    }
}

/// Tests of samples for one light, by the tags that they have.
pub struct Checks {
    /// Index into [`CHECKS`] by tag; `None` where the tag holds.
    pub queue_of: [Option<u8>; Tag::ALL.len()],
}

impl Checks {
    /// Creates the checks for a light. `moved`: the samples' model moved. `may_be_met`: something that moved
    /// may lie between samples and light.
    pub fn new(frame: &FrameView, light: usize, moved: bool, may_be_met: bool) -> Self {
        let queue_of = Tag::ALL.map(|tag| {
            let check = match frame.shadow_check(light, moved, tag) {
                ShadowCheck::Moved if !may_be_met => ShadowCheck::Keep,
                check => check,
            };
            CHECKS.iter().position(|known| *known == check).map(|queue| queue as u8)
        });
        Self { queue_of }
    }

    /// Returns true if a sample with this tag must be tested.
    pub fn asks(&self, tag: Tag) -> bool {
        self.queue_of[tag as usize].is_some()
    }

    /// Bit masks, by queue, of those of eight samples that must be tested. `moved` is the mask of samples
    /// whose models moved; `checks` are those for samples of other models and those for these.
    #[inline(always)]
    pub fn queues(checks: &[Self; 2], tags: &[Tag], moved: u8) -> [u8; CHECKS.len()] {
        let mut asked = [0; CHECKS.len()];
        let mut ask = |tag: Tag, moved: bool, lanes: u8| {
            if let Some(queue) = checks[usize::from(moved)].queue_of[tag as usize] {
                asked[usize::from(queue)] |= lanes;
            }
        };
        let moved_at_all = moved != 0;
        if are_same(tags) && moved == if moved_at_all { u8::MAX } else { 0 } {
            ask(tags[0], moved_at_all, u8::MAX);
        } else {
            (0..).zip(tags).for_each(|(lane, tag)| ask(*tag, moved >> lane & 1 != 0, 1 << lane));
        }
        asked
    }

    /// Returns true if none of eight tags needs a test.
    #[inline]
    pub fn all_hold(&self, tags: &[Tag]) -> bool {
        let asked = Tag::ALL.into_iter().zip(self.queue_of).filter(|(_, queue)| queue.is_some());
        // no early exit: eight are compared at once
        let has = |wanted: Tag| tags.iter().fold(false, |any, tag| any | (*tag == wanted));
        !asked.into_iter().any(|(tag, _)| has(tag))
    }

    /// Bit masks, by queue, of the points of the light for which a sample must be tested.
    #[inline]
    pub fn asked(&self, tags: AreaTag) -> [u16; CHECKS.len()] {
        let mut asked = [0; CHECKS.len()];
        for (tag, queue) in Tag::ALL.into_iter().zip(self.queue_of) {
            if let Some(queue) = queue {
                asked[usize::from(queue)] |= tags.points(tag);
            }
        }
        asked
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sample_goes_to_the_queue_of_its_own_tag() {
        let rests = Checks { queue_of: [Some(1), Some(0), None, None, Some(2)] };
        let moved = Checks { queue_of: [Some(1), Some(1), Some(1), Some(1), Some(2)] };
        let checks = [rests, moved];
        let mixed = [
            Tag::Unknown,
            Tag::Lit,
            Tag::BackFacing,
            Tag::StaticOccluder,
            Tag::DynamicOccluder,
            Tag::Lit,
            Tag::Lit,
            Tag::Lit,
        ];
        for tags in [mixed, [Tag::Lit; LANES], [Tag::BackFacing; LANES]] {
            for moved in [0, u8::MAX, 0b1010_0110, 1] {
                let asked = Checks::queues(&checks, &tags, moved);
                for lane in 0..LANES {
                    let wanted = checks[usize::from(moved >> lane & 1)].queue_of[tags[lane] as usize];
                    let queues = (0..).zip(asked).filter(|(_, lanes)| lanes >> lane & 1 != 0);
                    assert!(queues.map(|(queue, _)| queue).eq(wanted), "{tags:?} {moved:b} {lane}");
                }
            }
        }
    }
}
