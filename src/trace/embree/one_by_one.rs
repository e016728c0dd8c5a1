//! Rays that are traced one by one: as fast as packets are where rays go all around, and no ray's result
//! depends on another's.

use embree::{Coherence, Committed, PrimId, Segment};

use crate::exposure::TICKS;
use crate::trace::{HitBatch, LANES, NO_HIT, RayBatch, RayPacket};

/// Finds the first hit of each ray in `scenes`; the later scenes are searched up to the hit found before.
/// `mask_of` gives the mask of a ray by its number, and `name` looks up the model and the triangle. `times`: those of rays by their
/// ticks, if it matters. Rays begin at `least_t` at least.
pub fn closest(
    scenes: &[Committed],
    rays: &RayBatch,
    mask_of: impl Fn(usize) -> u32,
    (times, least_t): (Option<&[f32; TICKS]>, f32),
    hits: &mut HitBatch,
    name: impl Fn(PrimId) -> (u32, u32),
) {
    for (number, ((packet, lanes), out)) in rays.packets().zip(&mut hits.packets).enumerate() {
        out.model = [NO_HIT; LANES];
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 != 0) {
            let time = times.map_or(0.0, |times| times[usize::from(rays.ticks(number)[lane])]);
            let mut ray = segment(packet, lane, mask_of(number * LANES + lane), (time, least_t));
            for hit in scenes.iter().filter_map(|scene| {
                let hit = scene.intersect_one(&ray, Coherence::Incoherent);
                ray.far = hit.map_or(ray.far, |hit| hit.t);
                hit
            }) {
                (out.t[lane], out.u[lane], out.v[lane]) = (hit.t, hit.u, hit.v);
                (out.model[lane], out.triangle[lane]) = name(hit.met);
            }
        }
    }
}

/// Sets the bits of those rays that `scene` blocks. Rays whose bit is set already are not traced.
pub fn blocked(
    scene: Committed,
    rays: &RayBatch,
    mask: u32,
    (times, least_t): (Option<&[f32; TICKS]>, f32),
    blocked: &mut [u16],
) {
    for (number, ((packet, lanes), blocked)) in rays.packets().zip(blocked).enumerate() {
        let open = lanes & !*blocked;
        for lane in (0..LANES).filter(|lane| open >> lane & 1 != 0) {
            let time = times.map_or(0.0, |times| times[usize::from(rays.ticks(number)[lane])]);
            let ray = segment(packet, lane, mask, (time, least_t));
            let is_blocked = scene.occluded_one(&ray, Coherence::Incoherent);
            *blocked |= u16::from(is_blocked) << lane;
        }
    }
}

/// Ray number `lane` of `packet`.
#[inline(always)]
fn segment(packet: &RayPacket, lane: usize, mask: u32, (time, least_t): (f32, f32)) -> Segment {
    let of = |rows: &[[f32; LANES]; 3]| [rows[0][lane], rows[1][lane], rows[2][lane]];
    let (origin, direction) = (of(&packet.origin), of(&packet.direction));
    Segment { origin, direction, near: packet.near[lane].max(least_t), far: packet.far[lane], mask, time }
}
