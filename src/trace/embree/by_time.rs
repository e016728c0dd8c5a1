//! Queries of models whose ways through an exposure bend: rays of one time together.
//!
//! Neighbours see at times that lie far apart, and where an instance has a key for each of them Embree takes such rays through different nodes: packets of
//! them take seven times as long as packets with two keys, and twice as long as single rays (300 instances with 17 keys, Embree 4.4). So rays are sorted by their times here, and packets are made of
//! those of each. What stands still is asked before, by the packets as they come.

use embree::{Coherence as EmbreeCoherence, Committed, INVALID, PrimId, Ray, RayHit, Valid};

use super::places::TIMES;
use crate::trace::{HitBatch, LANES, NO_HIT, Purpose, RayBatch, RayPacket};

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
fn gather<const N: usize>(ray: &mut Ray<N>, rays: &RayBatch, (numbers, time): (&[u32], f32), least_t: f32) {
    ray.time = [time; N];
    for (to, number) in numbers.iter().enumerate() {
        let (packet, lane) = (rays.packet(*number as usize / LANES), *number as usize % LANES);
        let [x, y, z] = &packet.origin;
        (ray.org_x[to], ray.org_y[to], ray.org_z[to]) = (x[lane], y[lane], z[lane]);
        let [x, y, z] = &packet.direction;
        (ray.dir_x[to], ray.dir_y[to], ray.dir_z[to]) = (x[lane], y[lane], z[lane]);
        ray.tnear[to] = packet.near[lane].max(least_t);
    }
}

/// How so many rays of one time are traced.
fn way_of(count: usize, way: EmbreeCoherence) -> EmbreeCoherence {
    if count < LEAST_BUNDLE { EmbreeCoherence::Incoherent } else { way }
}

/// Scene of models that move, and how it is asked.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    pub scene: Committed<'a>,
    pub way: EmbreeCoherence,
    /// True if of several primitives at the same t the least is met.
    pub is_least: bool,
}

/// Shortens rays to their first hits in the scene; `hits` has those in another one. `mask_of` gives the mask of a ray by its number, and `name` looks up
/// the model and the triangle. Rays begin at `least_t` at least.
pub fn closest<const N: usize>(
    Asked { scene, way, is_least }: Asked<'_>,
    rays: &RayBatch,
    mask_of: impl Fn(usize) -> u32,
    (times, least_t): (&[f32; TIMES], f32),
    hits: &mut HitBatch,
    name: impl Fn(PrimId) -> (u32, u32),
) {
    let mut both = RayHit::<N>::default();
    for (numbers, time) in ByTime::new(rays, times, |_, lanes| lanes).packets::<N>() {
        gather(&mut both.ray, rays, (numbers, time), least_t);
        both.hit.clear();
        for (lane, number) in numbers.iter().enumerate() {
            let (packet, at) = (&hits.packets[*number as usize / LANES], *number as usize % LANES);
            (both.ray.tfar[lane], both.ray.mask[lane]) = (packet.t[at], mask_of(*number as usize));
            if packet.model[at] != NO_HIT {
                both.hit.geom_id[lane] = ELSEWHERE;
            }
        }
        let valid = Valid::first(numbers.len());
        if is_least {
            scene.intersect_least(&valid, &mut both);
        } else {
            scene.intersect(&valid, &mut both, way_of(numbers.len(), way));
        }
        for (lane, number) in numbers.iter().enumerate() {
            let hit = &both.hit;
            let met =
                PrimId { inst_id: hit.inst_id[lane], geom_id: hit.geom_id[lane], prim_id: hit.prim_id[lane] };
            // what moves is met in an instance
            if met.inst_id != INVALID {
                let (out, at) = (&mut hits.packets[*number as usize / LANES], *number as usize % LANES);
                (out.t[at], out.u[at], out.v[at]) = (both.ray.tfar[lane], hit.u[lane], hit.v[lane]);
                (out.model[at], out.triangle[at]) = name(met);
            }
        }
    }
}

/// Sets the bits of rays that the scene blocks: those that are set already are not traced. `is_own` tells whether a ray of a packet has met its own
/// sample, where that counts for nothing.
pub fn blocked<const N: usize>(
    (scene, way): (Committed<'_>, EmbreeCoherence),
    rays: &RayBatch,
    (mask, purpose): (u32, Purpose),
    (times, least_t): (&[f32; TIMES], f32),
    blocked: &mut [u16],
    is_own: impl Fn(&RayPacket, usize, PrimId) -> bool,
) {
    let mut ray = Ray { mask: [mask; N], ..Ray::<N>::default() };
    let sorted = ByTime::new(rays, times, |number, lanes| lanes & !blocked[number]);
    for (numbers, time) in sorted.packets::<N>() {
        gather(&mut ray, rays, (numbers, time), least_t);
        for (end, number) in ray.tfar.iter_mut().zip(numbers) {
            *end = rays.packet(*number as usize / LANES).far[*number as usize % LANES];
        }
        let (valid, way) = (Valid::first(numbers.len()), way_of(numbers.len(), way));
        match purpose {
            Purpose::Shadow | Purpose::LinkedShadow(_) => scene.occluded(&valid, &mut ray, way),
            Purpose::Sight => scene.occluded_past(&valid, &mut ray, way, &|lane, met| {
                let number = numbers[lane] as usize;
                is_own(rays.packet(number / LANES), number % LANES, met)
            }),
        }
        for (end, number) in ray.tfar.iter().zip(numbers) {
            // Embree sets the end of a ray that is blocked to minus infinity
            let is_blocked = u16::from(*end == f32::NEG_INFINITY);
            blocked[*number as usize / LANES] |= is_blocked << (*number as usize % LANES);
        }
    }
}
