//! Rays in Embree's scenes.
//!
//! Widths. A [`RayPacket`] has sixteen rays. Embree gets them in packets of the widest kind that is native to
//! the processor: whole, in halves or in quarters. Embree's layout differs from ours, so that rays are copied
//! in any case, and parts cost no more than the whole.

use embree::{Coherence as EmbreeCoherence, Committed, PacketWidth, PrimId, Ray, RayHit, Valid};

use super::parts::PartsById;
use super::{by_time, mask, one_by_one};
use crate::exposure::{TICKS, Tick};
use crate::lanes::F32x8;
use crate::scene::RayKind;
use crate::trace::{
    Coherence, HitBatch, HitPacket, LANES, NO_HIT, Occluders, OfKind, Purpose, RayBatch, RayPacket,
    SceneSubset, Search, Tracer,
};

/// Least t of rays. Embree counts t = tnear as met: an eye in a surface, at t = 0, would see nothing else.
/// Large enough that products with it are not subnormal in scenes of usual size, which would be slow.
const LEAST_T: f32 = 1e-20;

/// Scenes of the triangles that cast shadows, open for rays.
pub struct OpenCasters<'a> {
    pub still: Committed<'a>,
    /// Scene of movable models, if there are any.
    pub movable: Option<Committed<'a>>,
}

/// All scenes, open for rays.
pub struct EmbreeTracer<'a> {
    pub still: Committed<'a>,
    /// Scene of movable models, if there are any.
    pub movable: Option<Committed<'a>>,
    pub casters: Option<OpenCasters<'a>>,
    pub parts: &'a PartsById,
    pub width: PacketWidth,
    pub clear_passes: bool,
    /// Times of rays by their ticks, if it matters.
    pub times: Option<[f32; TICKS]>,
    /// True if rays of different times do not go [together](super::by_time).
    pub is_by_time: bool,
    /// True if models that stand still, or that move, [lie in each other](super::places::are_twins): of these the least is met.
    pub twins: [bool; 2],
}

impl Tracer for EmbreeTracer<'_> {
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let Search { kinds, among, coherence } = search;
        hits.packets.resize(rays.packet_count(), HitPacket::NONE);
        let is_alone = coherence == Coherence::Incoherent;
        let [of_still, of_movable] = self.twins;
        let has_twins = of_still || of_movable && among == SceneSubset::All;
        if is_alone && !has_twins {
            let both = [self.still, self.movable.unwrap_or(self.still)];
            let has_movable = among == SceneSubset::All && self.movable.is_some();
            let scenes = &both[..1 + usize::from(has_movable)];
            let name = |met: PrimId| self.parts.name(met);
            return match kinds {
                OfKind::All(kind) => {
                    let mask = mask_of(kind);
                    one_by_one::closest(scenes, rays, |_| mask, (self.times.as_ref(), LEAST_T), hits, name)
                }
                OfKind::Each(kinds) => {
                    let mask = |ray: usize| mask_of(kinds[ray]);
                    one_by_one::closest(scenes, rays, mask, (self.times.as_ref(), LEAST_T), hits, name)
                }
            };
        }
        match self.width {
            PacketWidth::Four => self.closest_by::<4>(rays, search, hits),
            PacketWidth::Eight => self.closest_by::<8>(rays, search, hits),
            PacketWidth::Sixteen => self.closest_by::<16>(rays, search, hits),
        }
    }

    fn blocked(
        &self,
        rays: &RayBatch,
        by: Occluders,
        purpose: Purpose,
        coherence: Coherence,
        blocked: &mut [u16],
    ) {
        let (still, movable) = match (&self.casters, purpose) {
            (Some(casters), Purpose::Shadow | Purpose::LinkedShadow(_)) => (casters.still, casters.movable),
            _ => (self.still, self.movable),
        };
        let Some(scene) = (if by == Occluders::Still { Some(still) } else { movable }) else { return };
        if coherence == Coherence::Incoherent && purpose.is_shadow() {
            let mask = self.ray_mask(by, purpose);
            return one_by_one::blocked(scene, rays, mask, (self.times.as_ref(), LEAST_T), blocked);
        }
        let question = Question {
            scene,
            mask: self.ray_mask(by, purpose),
            purpose,
            coherence: to_embree_coherence(coherence, by),
        };
        match self.width {
            PacketWidth::Four => self.blocked_by::<4>(rays, by, &question, blocked),
            PacketWidth::Eight => self.blocked_by::<8>(rays, by, &question, blocked),
            PacketWidth::Sixteen => self.blocked_by::<16>(rays, by, &question, blocked),
        }
    }
}

/// Lanes of a packet, as bit masks, that are traced together: each ray by itself where no result may depend on other rays.
fn together(lanes: u16, coherence: Coherence) -> impl Iterator<Item = u16> {
    let mut left = lanes;
    std::iter::from_fn(move || {
        let next = if coherence == Coherence::Incoherent { left & left.wrapping_neg() } else { left };
        left &= !next;
        (next != 0).then_some(next)
    })
}

/// Query of [`Tracer::blocked`], in Embree's terms.
struct Question<'a> {
    scene: Committed<'a>,
    mask: u32,
    purpose: Purpose,
    coherence: EmbreeCoherence,
}

impl EmbreeTracer<'_> {
    /// [`Tracer::closest`] in Embree's packets of N rays.
    fn closest_by<const N: usize>(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        let Search { kinds, among, coherence } = search;
        let movable = self.movable.filter(|_| among == SceneSubset::All);
        let [way, movable_way] =
            [Occluders::Still, Occluders::Movable].map(|by| to_embree_coherence(coherence, by));
        let is_bounced = coherence == Coherence::Bounced;
        let [of_still, of_movable] = self.twins.map(|has_twins| has_twins || is_bounced);
        // single rays are of one time in any case
        let times = self.times.as_ref().filter(|_| self.is_by_time && coherence != Coherence::Incoherent);
        let later = movable.zip(times);
        let movable = movable.filter(|_| later.is_none());
        let asked = || {
            let movable = movable.map(|scene| (scene, movable_way, of_movable));
            std::iter::once((self.still, way, of_still)).chain(movable)
        };
        let mut both = RayHit::<N>::default();
        if let OfKind::All(kind) = kinds {
            both.ray.mask = [mask_of(kind); N];
        }
        for (number, ((packet, lanes), out)) in rays.packets().zip(&mut hits.packets).enumerate() {
            for part in 0..LANES / N {
                let (first, in_part) = (part * N, part_of::<N>(lanes, part));
                if in_part == 0 {
                    out.model[first..first + N].fill(NO_HIT);
                    continue;
                }
                load(&mut both.ray, packet, first);
                self.set_times(&mut both.ray, rays.ticks(number), first);
                if let OfKind::Each(kinds) = kinds {
                    let kinds = &kinds[number * LANES + first..];
                    both.ray.mask.iter_mut().zip(kinds).for_each(|(mask, kind)| *mask = mask_of(*kind));
                }
                both.hit.clear();
                (both.hit.u, both.hit.v) = ([0.0; N], [0.0; N]);
                for bits in together(in_part, coherence) {
                    let valid = Valid::from_bits(bits);
                    for (scene, way, is_least) in asked() {
                        if is_least {
                            scene.intersect_least(&valid, &mut both);
                        } else {
                            scene.intersect(&valid, &mut both, way);
                        }
                    }
                }
                out.t[first..first + N].copy_from_slice(&both.ray.tfar);
                out.u[first..first + N].copy_from_slice(&both.hit.u);
                out.v[first..first + N].copy_from_slice(&both.hit.v);
                let triangles = (&mut out.model[first..first + N], &mut out.triangle[first..first + N]);
                self.parts.name_all(&both.hit, triangles);
            }
        }
        if let Some((scene, times)) = later {
            let asked = by_time::Asked { scene, way: movable_way, is_least: of_movable };
            let mask = |ray: usize| match kinds {
                OfKind::All(kind) => mask_of(kind),
                OfKind::Each(kinds) => mask_of(kinds[ray]),
            };
            by_time::closest::<N>(asked, rays, mask, (times, LEAST_T), hits, |met| self.parts.name(met));
        }
    }

    /// [`Tracer::blocked`] in Embree's packets of N rays.
    fn blocked_by<const N: usize>(
        &self,
        rays: &RayBatch,
        by: Occluders,
        question: &Question,
        blocked: &mut [u16],
    ) {
        let Question { scene, mask, purpose, coherence } = *question;
        if let Some(times) = self.times.as_ref().filter(|_| self.is_by_time && by != Occluders::Still) {
            let is_own = |packet: &RayPacket, lane: usize, met: PrimId| self.is_own(packet, lane, met);
            let (asked, of_ray) = ((scene, coherence), (mask, purpose));
            return by_time::blocked::<N>(asked, rays, of_ray, (times, LEAST_T), blocked, is_own);
        }
        let mut ray = Ray { mask: [mask; N], ..Ray::<N>::default() };
        for (number, ((packet, lanes), blocked)) in rays.packets().zip(blocked).enumerate() {
            let open = lanes & !*blocked;
            let mut ends = [0.0; LANES];
            for part in 0..LANES / N {
                let (first, in_part) = (part * N, part_of::<N>(open, part));
                if in_part == 0 {
                    continue;
                }
                load(&mut ray, packet, first);
                self.set_times(&mut ray, rays.ticks(number), first);
                let valid = Valid::from_bits(in_part);
                match purpose {
                    Purpose::Shadow | Purpose::LinkedShadow(_) => {
                        scene.occluded(&valid, &mut ray, coherence);
                    }
                    Purpose::Sight => scene.occluded_past(&valid, &mut ray, coherence, &|lane, met| {
                        self.is_own(packet, first + lane, met)
                    }),
                }
                ends[first..first + N].copy_from_slice(&ray.tfar);
            }
            // Embree sets the end of a ray that is blocked to minus infinity
            let is_set = |end: F32x8| end.le(F32x8::splat(f32::NEG_INFINITY)).bits();
            let set = [0, LANES / 2].map(|first| is_set(F32x8::load(&ends, first)));
            *blocked |= open & u16::from_le_bytes(set);
        }
    }

    /// Sets the times of N rays, from lane `first` of their packet on.
    #[inline(always)]
    fn set_times<const N: usize>(&self, ray: &mut Ray<N>, ticks: &[Tick; LANES], first: usize) {
        let Some(times) = &self.times else { return };
        for (time, tick) in ray.time.iter_mut().zip(&ticks[first..first + N]) {
            *time = times[usize::from(*tick)];
        }
    }

    fn ray_mask(&self, by: Occluders, purpose: Purpose) -> u32 {
        match purpose {
            Purpose::LinkedShadow(set) => mask::of_linked_ray(set, self.clear_passes),
            _ => mask::of_ray(purpose.kind(), by == Occluders::Moved, self.clear_passes),
        }
    }

    /// Returns true if a ray of `packet` has met the triangle that its own sample is on.
    fn is_own(&self, packet: &RayPacket, lane: usize, met: PrimId) -> bool {
        self.parts.name(met) == (packet.own_model[lane], packet.own_triangle[lane])
    }
}

/// Mask of a ray that finds its first hit.
fn mask_of(kind: RayKind) -> u32 {
    mask::of_ray(kind, false, false)
}

/// Bits of lanes `part * N..(part + 1) * N`.
#[inline(always)]
fn part_of<const N: usize>(lanes: u16, part: usize) -> u16 {
    lanes >> (part * N) & (u16::MAX >> (LANES - N))
}

/// Copies N rays of `packet` from lane `first` on, and leaves their masks.
#[inline(always)]
fn load<const N: usize>(ray: &mut Ray<N>, packet: &RayPacket, first: usize) {
    for (to, from) in [
        (&mut ray.org_x, &packet.origin[0]),
        (&mut ray.org_y, &packet.origin[1]),
        (&mut ray.org_z, &packet.origin[2]),
        (&mut ray.dir_x, &packet.direction[0]),
        (&mut ray.dir_y, &packet.direction[1]),
        (&mut ray.dir_z, &packet.direction[2]),
        (&mut ray.tfar, &packet.far),
    ] {
        to.copy_from_slice(&from[first..first + N]);
    }
    for (to, from) in ray.tnear.iter_mut().zip(&packet.near[first..first + N]) {
        *to = from.max(LEAST_T);
    }
}

fn to_embree_coherence(coherence: Coherence, by: Occluders) -> EmbreeCoherence {
    match coherence {
        // a bundle is faster than single rays in a kitchen at rest, and slower before a moving ball of small
        // triangles
        Coherence::SharedOrigin if by != Occluders::Still => EmbreeCoherence::Incoherent,
        Coherence::SharedOrigin => EmbreeCoherence::Coherent,
        // mirrors and panes are flat enough: as bundles their rays take a quarter less of the time of
        // `enhance`, in a kitchen and in a city of glass
        Coherence::Coherent | Coherence::Bounced => EmbreeCoherence::Coherent,
        Coherence::Incoherent => EmbreeCoherence::Incoherent,
    }
}
