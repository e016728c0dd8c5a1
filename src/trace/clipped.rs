//! Clipping planes before a tracer: rays from the eye begin at the near one and end at the far one.
//!
//! A sample that lies beyond either counts as hidden. What goes on straight through veils ends at the far one as well. All
//! other rays pass unchanged.

use glam::Vec3;

use super::{
    Coherence, HitBatch, LANES, NO_HIT, Occluders, OfKind, Purpose, RayBatch, RayPacket, Search, Tracer,
};
use crate::exposure::Tick;
use crate::pose::{CameraPose, Pose};
use crate::scene::RayKind;

/// Cuts off what rays from the eye see of another tracer's scene.
pub struct Clipped<'a> {
    tracer: &'a dyn Tracer,
    pose: &'a Pose,
}

impl<'a> Clipped<'a> {
    /// Puts the planes of the cameras of `pose` before a tracer.
    pub fn new(tracer: &'a dyn Tracer, pose: &'a Pose) -> Self {
        Self { tracer, pose }
    }

    /// The same rays, those that are `from_eye` by their number between the planes; and bits of those that end in samples
    /// beyond them.
    fn clip(&self, rays: &RayBatch, from_eye: impl Fn(usize) -> bool) -> (RayBatch, Vec<u16>) {
        let mut beyond = Vec::with_capacity(rays.packet_count());
        let clipped = rays.changed(|packet, used, ticks| {
            let first = beyond.len() * LANES;
            let lanes = (0..LANES).filter(|lane| used >> lane & 1 != 0 && from_eye(first + lane));
            let bits = lanes.map(|lane| u16::from(self.clip_lane(packet, lane, ticks[lane])) << lane);
            beyond.push(bits.fold(0, |all, bit| all | bit));
        });
        (clipped, beyond)
    }

    /// Shortens a ray to what is between the planes. Returns true if it ends in a sample that is not.
    fn clip_lane(&self, packet: &mut RayPacket, lane: usize, tick: Tick) -> bool {
        let of = |rows: &[[f32; LANES]; 3]| Vec3::from_array(rows.map(|row| row[lane]));
        let CameraPose { eye, forward, clip, .. } = *self.pose.camera_at(tick);
        let (start, pace) = ((of(&packet.origin) - eye).dot(forward), of(&packet.direction).dot(forward));
        // rounding has such rays where the eye is in a surface
        if pace <= 0.0 || !pace.is_finite() {
            return false;
        }
        let [near, far] = [clip.near, clip.far].map(|depth| (depth - start) / pace);
        // segments to surfaces have an end
        let is_sample = packet.own_model[lane] != NO_HIT && packet.far[lane].is_finite();
        packet.near[lane] = packet.near[lane].max(near);
        packet.far[lane] = packet.far[lane].min(far);
        is_sample && !(near < 1.0 && 1.0 <= far)
    }
}

impl Tracer for Clipped<'_> {
    fn closest(&self, rays: &RayBatch, search: Search, hits: &mut HitBatch) {
        match search.kinds {
            OfKind::All(RayKind::Camera) => {
                let (clipped, _) = self.clip(rays, |_| true);
                self.tracer.closest(&clipped, search, hits);
            }
            OfKind::Each(each) if each.contains(&RayKind::Camera) => {
                let (clipped, _) = self.clip(rays, |ray| each[ray] == RayKind::Camera);
                self.tracer.closest(&clipped, search, hits);
            }
            _ => self.tracer.closest(rays, search, hits),
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
        if purpose != Purpose::Sight {
            return self.tracer.blocked(rays, by, purpose, coherence, blocked);
        }
        let (rays, beyond) = self.clip(rays, |_| true);
        blocked.iter_mut().zip(beyond).for_each(|(blocked, beyond)| *blocked |= beyond);
        self.tracer.blocked(&rays, by, purpose, coherence, blocked);
    }
}
