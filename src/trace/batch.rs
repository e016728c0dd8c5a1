//! Rays in packets of 16, as structures of arrays.

use glam::Vec3;

use crate::exposure::{MIDDLE_TICK, Tick};
use crate::lanes::{F32x8, LANES as HALF, Vec3x8};

/// Number of rays in a packet: the width that Embree's widest kernels take.
pub const LANES: usize = 16;

/// `model` of a lane without a hit.
pub const NO_HIT: u32 = u32::MAX;

/// Similarity of the rays of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coherence {
    /// Rays of neighbours in one picture, or shadow rays of neighbours: traversed as a bundle.
    Coherent,
    /// Rays off and through the surfaces of neighbours, which often go about the same way. The backend
    /// chooses how to traverse them. The hit of such a ray depends on no other ray of its batch, to the bit,
    /// so that it may be cast again among others; except for rays exactly along a plane of two axes that graze
    /// a triangle's edge.
    Bounced,
    /// Rays to the points of an area light, from one surface or from neighbours: a bundle for walls and
    /// floors. But among the small triangles of one model each ray finds its own. The backend chooses how to
    /// traverse them.
    SharedOrigin,
    /// Rays in all directions: each is traversed by itself. The hit of such a ray depends on no other ray of
    /// its batch, to the bit, so that it may be cast again among others.
    Incoherent,
}

/// Sixteen rays in world space: points `origin + t * direction` for t above `near` and up to `far`.
/// Directions have any length but zero.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct RayPacket {
    /// x, y and z of the origins.
    pub origin: [[f32; LANES]; 3],
    /// x, y and z of the directions.
    pub direction: [[f32; LANES]; 3],
    /// Lower end of t, which is excluded.
    pub near: [f32; LANES],
    /// Upper end of t.
    pub far: [f32; LANES],
    /// Model of the sample at the ray's end, at t = 1, or [`NO_HIT`]. For
    /// [`Purpose::Sight`](super::Purpose::Sight).
    pub own_model: [u32; LANES],
    /// Triangle of that sample.
    pub own_triangle: [u32; LANES],
}

impl RayPacket {
    const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        near: [0.0; LANES],
        far: [0.0; LANES],
        own_model: [NO_HIT; LANES],
        own_triangle: [NO_HIT; LANES],
    };

    #[inline(always)]
    fn put(&mut self, lane: usize, origin: Vec3, direction: Vec3, [near, far]: [f32; 2]) {
        let (origin, direction) = (origin.to_array(), direction.to_array());
        for axis in 0..3 {
            self.origin[axis][lane] = origin[axis];
            self.direction[axis][lane] = direction[axis];
        }
        self.near[lane] = near;
        self.far[lane] = far;
    }
}

/// Any number of rays, packed in the order in which they were pushed: rays that were pushed together are
/// traced together. Keeps its memory when cleared.
///
/// Packets may be pushed whole, with lanes that are not in use, before any ray that is pushed by itself.
#[derive(Debug, Default)]
pub struct RayBatch {
    packets: Vec<RayPacket>,
    len: usize,
    /// Bit masks of the lanes in use of packets that were pushed whole.
    whole: Vec<u16>,
    /// Ticks of the rays of each packet, if they were [set](Self::set_ticks).
    ticks: Vec<[Tick; LANES]>,
}

impl RayBatch {
    /// Removes all rays, and keeps their memory.
    pub fn clear(&mut self) {
        self.len = 0;
        self.whole.clear();
        self.ticks.clear();
    }

    /// Sets the ticks of the exposure at which the rays, all that there are, in their order, meet what moves within it; in packets that were
    /// pushed whole, lanes that are not in use count, too. Rays meet it in the middle otherwise.
    pub fn set_ticks(&mut self, ticks: impl Iterator<Item = Tick>) {
        self.ticks.clear();
        self.ticks.resize(self.packet_count(), [MIDDLE_TICK; LANES]);
        self.ticks.as_flattened_mut().iter_mut().zip(ticks).for_each(|(to, tick)| *to = tick);
    }

    /// Ticks of the rays of packet number `packet`.
    #[inline(always)]
    pub fn ticks(&self, packet: usize) -> &[Tick; LANES] {
        self.ticks.get(packet).unwrap_or(&[MIDDLE_TICK; LANES])
    }

    /// Number of rays; in packets that were pushed whole, lanes that are not in use count, too.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of rays in use.
    pub fn count(&self) -> u64 {
        let in_whole: u64 = self.whole.iter().map(|lanes| u64::from(lanes.count_ones())).sum();
        in_whole + (self.len - self.whole.len() * LANES) as u64
    }

    /// Adds a packet of its own: the rays from one point along sixteen directions, t in `0..=far`. Those
    /// whose bit is set in `lanes` are in use. They end in no sample, and must not be traced for
    /// [`Purpose::Sight`](super::Purpose::Sight).
    #[inline(always)]
    pub fn push_packet(&mut self, origin: Vec3, directions: [Vec3x8; 2], far: f32, lanes: u16) {
        let far = F32x8::splat(far);
        self.next_whole(&directions.map(|direction| (Vec3x8::splat(origin), direction, far)), lanes);
    }

    /// Adds a packet of rays that end in samples, each with its own origin, direction and upper end of t: the
    /// samples never block them.
    #[inline(always)]
    pub fn push_packet_to_samples(
        &mut self,
        segments: &[(Vec3x8, Vec3x8, F32x8); 2],
        [models, triangles]: [&[u32]; 2],
        lanes: u16,
    ) {
        let packet = self.next_whole(segments, lanes);
        packet.own_model.copy_from_slice(models);
        packet.own_triangle.copy_from_slice(triangles);
    }

    #[inline(always)]
    fn next_whole(&mut self, segments: &[(Vec3x8, Vec3x8, F32x8); 2], lanes: u16) -> &mut RayPacket {
        debug_assert_eq!(self.len, self.whole.len() * LANES, "whole packets come first");
        let at = self.whole.len();
        if at == self.packets.len() {
            self.packets.push(RayPacket::EMPTY);
        }
        self.whole.push(lanes);
        self.len += LANES;
        let packet = &mut self.packets[at];
        // by reference: the array is large enough to be copied by a call
        for (half, (origins, directions, far)) in segments.iter().enumerate() {
            let [x, y, z] = &mut packet.origin;
            origins.store([x, y, z], half * HALF);
            let [x, y, z] = &mut packet.direction;
            directions.store([x, y, z], half * HALF);
            far.store(&mut packet.far, half * HALF);
        }
        packet.near = [0.0; LANES];
        packet
    }

    /// Returns true if there are no rays.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds the ray `origin + t * direction`, `near < t <= far`.
    #[inline(always)]
    pub fn push(&mut self, origin: Vec3, direction: Vec3, near: f32, far: f32) {
        self.push_to_sample(origin, direction, near, far, NO_HIT, NO_HIT);
    }

    /// Adds a ray that ends in a sample on `triangle` of `model`, at t = 1. The sample's own triangle never
    /// blocks it; a curved primitive may hide its own sample.
    #[inline(always)]
    pub fn push_to_sample(
        &mut self,
        origin: Vec3,
        direction: Vec3,
        near: f32,
        far: f32,
        model: u32,
        triangle: u32,
    ) {
        let (at, lane) = (self.len / LANES, self.len % LANES);
        if at == self.packets.len() {
            self.packets.push(RayPacket::EMPTY);
        }
        let packet = &mut self.packets[at];
        packet.put(lane, origin, direction, [near, far]);
        packet.own_model[lane] = model;
        packet.own_triangle[lane] = triangle;
        self.len += 1;
    }

    /// Adds those of eight rays, from t = 0 on, whose bit is set in `wanted`. They end in no sample, and must
    /// not be traced for [`Purpose::Sight`](super::Purpose::Sight).
    #[inline(always)]
    pub fn push_lanes(&mut self, origin: Vec3x8, direction: Vec3x8, far: F32x8, wanted: u8) {
        self.make_room();
        let (at, lane) = (self.len / LANES, self.len % LANES);
        if wanted == u8::MAX && lane + HALF <= LANES {
            let packet = &mut self.packets[at];
            for (axis, (origin, direction)) in
                [(origin.x, direction.x), (origin.y, direction.y), (origin.z, direction.z)]
                    .into_iter()
                    .enumerate()
            {
                origin.store(&mut packet.origin[axis], lane);
                direction.store(&mut packet.direction[axis], lane);
            }
            F32x8::ZERO.store(&mut packet.near, lane);
            far.store(&mut packet.far, lane);
            self.len += HALF;
            return;
        }
        for i in (0..HALF).filter(|i| wanted >> i & 1 != 0) {
            let packet = &mut self.packets[self.len / LANES];
            packet.put(self.len % LANES, origin.lane(i), direction.lane(i), [0.0, far.lane(i)]);
            self.len += 1;
        }
    }

    /// Like [`push_lanes`](Self::push_lanes), for rays that end in samples: these never block them.
    #[inline(always)]
    pub fn push_lanes_to_samples(
        &mut self,
        origin: Vec3x8,
        direction: Vec3x8,
        far: F32x8,
        [models, triangles]: [&[u32]; 2],
        wanted: u8,
    ) {
        self.make_room();
        let (at, lane) = (self.len / LANES, self.len % LANES);
        if wanted == u8::MAX && lane + HALF <= LANES {
            self.packets[at].own_model[lane..lane + HALF].copy_from_slice(models);
            self.packets[at].own_triangle[lane..lane + HALF].copy_from_slice(triangles);
        } else {
            for (at, i) in (self.len..).zip((0..HALF).filter(|i| wanted >> i & 1 != 0)) {
                let packet = &mut self.packets[at / LANES];
                packet.own_model[at % LANES] = models[i];
                packet.own_triangle[at % LANES] = triangles[i];
            }
        }
        self.push_lanes(origin, direction, far, wanted);
    }

    /// Creates packets for eight more rays, where they are missing.
    #[inline(always)]
    fn make_room(&mut self) {
        while self.packets.len() * LANES < self.len + HALF {
            self.packets.push(RayPacket::EMPTY);
        }
    }

    /// Copies the batch, with each packet as `change` leaves it; it gets the bit mask of the lanes in use and their ticks as well.
    pub fn changed(&self, mut change: impl FnMut(&mut RayPacket, u16, &[Tick; LANES])) -> Self {
        let mut packets = self.packets[..self.packet_count()].to_vec();
        packets
            .iter_mut()
            .enumerate()
            .for_each(|(i, packet)| change(packet, self.lanes_in_use(i), self.ticks(i)));
        Self { packets, len: self.len, whole: self.whole.clone(), ticks: self.ticks.clone() }
    }

    /// Packets, each with the bit mask of its lanes in use.
    pub fn packets(&self) -> impl Iterator<Item = (&RayPacket, u16)> {
        let used = self.len.div_ceil(LANES);
        self.packets[..used].iter().enumerate().map(|(i, packet)| (packet, self.lanes_in_use(i)))
    }

    /// Packet by its number.
    #[inline(always)]
    pub fn packet(&self, number: usize) -> &RayPacket {
        &self.packets[number]
    }

    /// Number of packets in use.
    pub fn packet_count(&self) -> usize {
        self.len.div_ceil(LANES)
    }

    fn lanes_in_use(&self, packet: usize) -> u16 {
        if let Some(lanes) = self.whole.get(packet) {
            return *lanes;
        }
        match self.len - packet * LANES {
            LANES.. => u16::MAX,
            rest => (1 << rest) - 1,
        }
    }
}

/// Hits of sixteen rays.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct HitPacket {
    /// Ray parameters.
    pub t: [f32; LANES],
    /// Barycentric weights of the triangles' second corners.
    pub u: [f32; LANES],
    /// Barycentric weights of the triangles' third corners.
    pub v: [f32; LANES],
    /// Indices into [`Scene::models`](crate::scene::Scene::models), or [`NO_HIT`].
    pub model: [u32; LANES],
    /// Numbers of triangles, or of other primitives, of the models' meshes.
    pub triangle: [u32; LANES],
}

impl HitPacket {
    /// Packet without hits.
    pub const NONE: Self = Self {
        t: [f32::INFINITY; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        model: [NO_HIT; LANES],
        triangle: [NO_HIT; LANES],
    };
}

/// One hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
    /// Index into [`Scene::models`](crate::scene::Scene::models).
    pub model: u32,
    /// Number of the triangle, or of another primitive, of the model's mesh.
    pub triangle: u32,
}

/// The hits of a [`RayBatch`], packet by packet.
#[derive(Debug, Default)]
pub struct HitBatch {
    /// Hits of each packet of rays.
    pub packets: Vec<HitPacket>,
}

impl HitBatch {
    /// Hit of ray number `ray`.
    #[inline]
    pub fn get(&self, ray: usize) -> Option<Hit> {
        let (packet, lane) = (&self.packets[ray / LANES], ray % LANES);
        (packet.model[lane] != NO_HIT).then(|| Hit {
            t: packet.t[lane],
            u: packet.u[lane],
            v: packet.v[lane],
            model: packet.model[lane],
            triangle: packet.triangle[lane],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_packet_knows_its_lanes() {
        let mut rays = RayBatch::default();
        for i in 0..35 {
            rays.push(Vec3::splat(i as f32), Vec3::X, 0.0, 1.0);
        }
        let lanes: Vec<u16> = rays.packets().map(|(_, lanes)| lanes).collect();
        assert_eq!(lanes, [u16::MAX, u16::MAX, 0b111]);
        rays.clear();
        assert_eq!(rays.packets().count(), 0);
        rays.push_packet(Vec3::ONE, [Vec3x8::splat(Vec3::X); 2], 1.0, 0b101);
        rays.push_packet(Vec3::ONE, [Vec3x8::splat(Vec3::Y); 2], 1.0, 1 << 15);
        assert_eq!(rays.packets().map(|(_, lanes)| lanes).collect::<Vec<_>>(), [0b101, 1 << 15]);
        assert_eq!((rays.packet_count(), rays.count()), (2, 3));
        for i in 0..17 {
            rays.push_to_sample(Vec3::splat(i as f32), Vec3::X, 0.0, 1.0, 4, i);
        }
        let lanes: Vec<u16> = rays.packets().map(|(_, lanes)| lanes).collect();
        assert_eq!(lanes, [0b101, 1 << 15, u16::MAX, 1], "rays by themselves come after whole packets");
        assert_eq!((rays.packet_count(), rays.count()), (4, 20));
        let own: Vec<u32> = rays.packets().skip(2).map(|(packet, _)| packet.own_triangle[0]).collect();
        assert_eq!(own, [0, 16]);
        rays.clear();
        for _ in 0..16 {
            rays.push(Vec3::ZERO, Vec3::X, 0.0, 1.0);
        }
        assert_eq!(rays.packets().map(|(_, lanes)| lanes).collect::<Vec<_>>(), [u16::MAX]);
    }
}
