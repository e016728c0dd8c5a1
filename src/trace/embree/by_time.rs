//! Queries of models that move within an exposure: rays of one time together.
//!
//! Neighbours see at times that lie far apart, and Embree takes such rays through different nodes: packets of them take seven times as long as packets
//! of one time, and twice as long as single rays (300 instances with 17 keys, Embree 4.4). So rays are sorted by their times here, and packets are made of
//! those of each. What stands still is asked before, by the packets as they come.

use embree::{Coherence as EmbreeCoherence, Committed, Ray, RayHit, Valid};

use super::places::TIMES;
use super::{EmbreeTracer, LEAST_T, Question, mask_of};
use crate::trace::{HitBatch, LANES, NO_HIT, OfKind, Purpose, RayBatch, Search};

/// Least number of rays of one time that are traced as a bundle.
const LEAST_BUNDLE: usize = 4;

/// Geometry of a hit in another scene, for [`Committed::intersect_least`]: any that is none of no hit.
const ELSEWHERE: u32 = 0;

/// Numbers of rays, by their times.
struct ByTime([Vec<u32>; TIMES]);

impl ByTime {
    /// Sorts the rays of `rays`; `open` gives the lanes of a packet that are asked.
    fn new(rays: &RayBatch, times: &[f32; TIMES], open: impl Fn(usize, u16) -> u16) -> Self {
        let mut all: [Vec<u32>; TIMES] = std::array::from_fn(|_| Vec::new());
        for (number, (_, lanes)) in rays.packets().enumerate() {
            let (ticks, mut left) = (rays.ticks(number), open(number, lanes));
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                // those that share a time have that of the first of them
                let time = (times[usize::from(ticks[lane])] * TIMES as f32) as usize;
                all[time].push((number * LANES + lane) as u32);
                left &= left - 1;
            }
        }
        Self(all)
    }

    /// Up to N rays of one time each, and that time.
    fn packets<const N: usize>(&self) -> impl Iterator<Item = (&[u32], f32)> {
        let timed = self.0.iter().enumerate().map(|(time, rays)| (rays, time as f32 / TIMES as f32));
        timed.flat_map(|(rays, time)| rays.chunks(N).map(move |rays| (rays, time)))
    }
}

/// Loads these rays, which have one time, and leaves their masks and ends.
#[inline(always)]
fn gather<const N: usize>(ray: &mut Ray<N>, rays: &RayBatch, (numbers, time): (&[u32], f32)) {
    ray.time = [time; N];
    for (to, number) in numbers.iter().enumerate() {
        let (packet, lane) = (rays.packet(*number as usize / LANES), *number as usize % LANES);
        let [x, y, z] = &packet.origin;
        (ray.org_x[to], ray.org_y[to], ray.org_z[to]) = (x[lane], y[lane], z[lane]);
        let [x, y, z] = &packet.direction;
        (ray.dir_x[to], ray.dir_y[to], ray.dir_z[to]) = (x[lane], y[lane], z[lane]);
        ray.tnear[to] = packet.near[lane].max(LEAST_T);
    }
}

/// How so many rays of one time are traced.
fn way_of(count: usize, way: EmbreeCoherence) -> EmbreeCoherence {
    if count < LEAST_BUNDLE { EmbreeCoherence::Incoherent } else { way }
}

impl EmbreeTracer<'_> {
    /// Shortens rays to their first hits in the `scene` of models that move; `hits` has those in the other one. `is_least`: of several at the same t
    /// the least is met.
    pub(super) fn closest_by_time<const N: usize>(
        &self,
        (scene, way, is_least): (Committed, EmbreeCoherence, bool),
        (rays, times): (&RayBatch, &[f32; TIMES]),
        search: Search,
        hits: &mut HitBatch,
    ) {
        let mut both = RayHit::<N>::default();
        if let OfKind::All(kind) = search.kinds {
            both.ray.mask = [mask_of(kind); N];
        }
        for (numbers, time) in ByTime::new(rays, times, |_, lanes| lanes).packets::<N>() {
            gather(&mut both.ray, rays, (numbers, time));
            both.hit.clear();
            for (lane, number) in numbers.iter().enumerate() {
                let (packet, at) = (&hits.packets[*number as usize / LANES], *number as usize % LANES);
                both.ray.tfar[lane] = packet.t[at];
                if packet.model[at] != NO_HIT {
                    both.hit.geom_id[lane] = ELSEWHERE;
                }
                if let OfKind::Each(kinds) = search.kinds {
                    both.ray.mask[lane] = mask_of(kinds[*number as usize]);
                }
            }
            let valid = Valid::first(numbers.len());
            if is_least {
                scene.intersect_least(&valid, &mut both);
            } else {
                scene.intersect(&valid, &mut both, way_of(numbers.len(), way));
            }
            for (lane, number) in numbers.iter().enumerate() {
                let instance = both.hit.inst_id[lane];
                if instance == embree::INVALID {
                    continue;
                }
                let (out, at) = (&mut hits.packets[*number as usize / LANES], *number as usize % LANES);
                let part = self.part(instance, both.hit.geom_id[lane]);
                (out.t[at], out.u[at], out.v[at]) = (both.ray.tfar[lane], both.hit.u[lane], both.hit.v[lane]);
                (out.model[at], out.triangle[at]) = (part.model, part.first + both.hit.prim_id[lane]);
            }
        }
    }

    /// Sets the bits of rays that models which move block: those that are set already are not traced.
    pub(super) fn blocked_by_time<const N: usize>(
        &self,
        (rays, times): (&RayBatch, &[f32; TIMES]),
        question: &Question,
        blocked: &mut [u16],
    ) {
        let Question { scene, mask, purpose, coherence } = *question;
        let mut ray = Ray { mask: [mask; N], ..Ray::<N>::default() };
        let sorted = ByTime::new(rays, times, |number, lanes| lanes & !blocked[number]);
        for (numbers, time) in sorted.packets::<N>() {
            gather(&mut ray, rays, (numbers, time));
            for (end, number) in ray.tfar.iter_mut().zip(numbers) {
                *end = rays.packet(*number as usize / LANES).far[*number as usize % LANES];
            }
            let (valid, way) = (Valid::first(numbers.len()), way_of(numbers.len(), coherence));
            match purpose {
                Purpose::Shadow => scene.occluded(&valid, &mut ray, way),
                Purpose::Sight => scene.occluded_past(&valid, &mut ray, way, &|lane, met| {
                    let number = numbers[lane] as usize;
                    self.is_own(rays.packet(number / LANES), number % LANES, met)
                }),
            }
            for (end, number) in ray.tfar.iter().zip(numbers) {
                // Embree sets the end of a ray that is blocked to minus infinity
                let is_blocked = u16::from(*end == f32::NEG_INFINITY);
                blocked[*number as usize / LANES] |= is_blocked << (*number as usize % LANES);
            }
        }
    }
}
