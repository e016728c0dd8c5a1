//! Packets of 4, 8 or 16 rays, laid out as Embree reads them.

use embree4_sys as sys;
use std::mem::offset_of;

/// The id that means "no hit" as `geom_id`, and "not in an instance" as `inst_id`.
pub const INVALID: u32 = sys::RTC_INVALID_GEOMETRY_ID;

/// Number of rays in one packet. The numbers are those in the names of Embree's functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PacketWidth {
    /// Native with SSE 4.2, and with anything newer.
    Four = 4,
    /// Native with AVX and AVX2.
    Eight = 8,
    /// Native with AVX-512.
    Sixteen = 16,
}

impl PacketWidth {
    /// Widest packet for which `is_native` holds, or else 4. Embree takes wider packets than native ones
    /// apart, and traces them ray by ray.
    pub fn widest(is_native: impl Fn(Self) -> bool) -> Self {
        [Self::Sixteen, Self::Eight].into_iter().find(|width| is_native(*width)).unwrap_or(Self::Four)
    }

    /// Number of rays in a packet.
    pub fn lanes(self) -> usize {
        self as usize
    }
}

/// Mask of the rays of a packet that take part.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Valid<const N: usize>([i32; N]);

impl<const N: usize> Valid<N> {
    /// All rays.
    pub const ALL: Self = Self([-1; N]);
    /// No ray.
    pub const NONE: Self = Self([0; N]);

    /// Creates a mask of the rays for which `is_on(lane)` holds.
    #[inline]
    pub fn from_fn(mut is_on: impl FnMut(usize) -> bool) -> Self {
        Self(std::array::from_fn(|lane| -i32::from(is_on(lane))))
    }

    /// Creates a mask of the first `count` rays, for the last packet of a list.
    #[inline]
    pub fn first(count: usize) -> Self {
        Self::from_fn(|lane| lane < count)
    }

    /// Creates a mask from bits: bit `i` is ray `i`.
    #[inline]
    pub fn from_bits(bits: u16) -> Self {
        Self::from_fn(|lane| bits >> lane & 1 == 1)
    }

    /// Turns a ray on or off.
    #[inline]
    pub fn set(&mut self, lane: usize, on: bool) {
        self.0[lane] = -i32::from(on);
    }

    /// Returns true if a ray takes part.
    #[inline]
    pub fn is_on(&self, lane: usize) -> bool {
        self.0[lane] != 0
    }

    /// Returns true if any ray takes part.
    #[inline]
    pub fn any(&self) -> bool {
        self.0.iter().any(|&lane| lane != 0)
    }

    #[inline]
    pub(crate) fn as_ptr(&self) -> *const i32 {
        self.0.as_ptr()
    }
}

/// N ray segments: the points `org + t * dir` with `tnear <= t <= tfar`.
///
/// Nothing here needs to be normalised: `t` counts lengths of `dir`. What a ray hits that has a NaN or an
/// infinite origin or direction is undefined (and slow to find out), but harms nothing.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<const N: usize> {
    /// Origins, world space.
    pub org_x: [f32; N],
    /// Origins, world space.
    pub org_y: [f32; N],
    /// Origins, world space.
    pub org_z: [f32; N],
    /// Start of the segment, at least 0.
    pub tnear: [f32; N],
    /// Directions, world space, of any length.
    pub dir_x: [f32; N],
    /// Directions, world space, of any length.
    pub dir_y: [f32; N],
    /// Directions, world space, of any length.
    pub dir_z: [f32; N],
    /// Times at which instances are met that have [several transforms](crate::Scene::set_instance_transforms).
    pub time: [f32; N],
    /// End of the segment. `intersect` moves it to the hit, `occluded` sets it to minus infinity.
    pub tfar: [f32; N],
    /// Mask: the ray meets geometries and instances whose mask has a bit in common.
    pub mask: [u32; N],
    /// Free for the caller, except that `occluded_past` writes the lane's number here.
    pub id: [u32; N],
    /// Reserved by Embree, 0.
    pub flags: [u32; N],
}

impl<const N: usize> Default for Ray<N> {
    /// Creates rays from the origin in no direction, from 0 to infinity, that meet every mask.
    fn default() -> Self {
        let zero = [0.0; N];
        Self {
            org_x: zero,
            org_y: zero,
            org_z: zero,
            tnear: zero,
            dir_x: zero,
            dir_y: zero,
            dir_z: zero,
            time: zero,
            tfar: [f32::INFINITY; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        }
    }
}

impl<const N: usize> Ray<N> {
    /// Sets one lane's segment and leaves its mask.
    #[inline]
    pub fn set(&mut self, lane: usize, org: [f32; 3], dir: [f32; 3], tnear: f32, tfar: f32) {
        [self.org_x[lane], self.org_y[lane], self.org_z[lane]] = org;
        [self.dir_x[lane], self.dir_y[lane], self.dir_z[lane]] = dir;
        self.tnear[lane] = tnear;
        self.tfar[lane] = tfar;
    }

    /// Returns true if `occluded` found that something blocks the ray in this lane.
    #[inline]
    pub fn is_occluded(&self, lane: usize) -> bool {
        self.tfar[lane] == f32::NEG_INFINITY
    }
}

/// Hits of N rays. A lane is written if its ray hits something, and left alone otherwise.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<const N: usize> {
    /// Normal of the triangle, not normalised, in the **object's** space: (v1 - v0) x (v2 - v0).
    pub ng_x: [f32; N],
    /// See `ng_x`.
    pub ng_y: [f32; N],
    /// See `ng_x`.
    pub ng_z: [f32; N],
    /// Barycentric weight of the triangle's second corner.
    pub u: [f32; N],
    /// Barycentric weight of the triangle's third corner.
    pub v: [f32; N],
    /// Number of the triangle in its mesh.
    pub prim_id: [u32; N],
    /// Number of the mesh in the scene that holds it, or [`INVALID`] for no hit.
    pub geom_id: [u32; N],
    /// Number of the instance in the scene that was traced, or [`INVALID`] for a mesh of that scene itself.
    pub inst_id: [u32; N],
    /// Number in an instance array. There are no such arrays here, so that it means nothing.
    pub inst_prim_id: [u32; N],
}

impl<const N: usize> Default for Hit<N> {
    /// Creates hits of nothing.
    fn default() -> Self {
        let zero = [0.0; N];
        let none = [INVALID; N];
        Self {
            ng_x: zero,
            ng_y: zero,
            ng_z: zero,
            u: zero,
            v: zero,
            prim_id: none,
            geom_id: none,
            inst_id: none,
            inst_prim_id: none,
        }
    }
}

impl<const N: usize> Hit<N> {
    /// Returns true if this lane's ray hit something.
    #[inline]
    pub fn is_hit(&self, lane: usize) -> bool {
        self.geom_id[lane] != INVALID
    }

    /// Forgets all hits, so that the packet can be used again.
    #[inline]
    pub fn clear(&mut self) {
        self.geom_id = [INVALID; N];
        self.inst_id = [INVALID; N];
    }
}

/// N rays and their hits.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayHit<const N: usize> {
    /// The rays.
    pub ray: Ray<N>,
    /// Their hits.
    pub hit: Hit<N>,
}

impl<const N: usize> RayHit<N> {
    /// Creates a packet of rays that have hit nothing yet.
    pub fn new(ray: Ray<N>) -> Self {
        Self { ray, hit: Hit::default() }
    }
}

/// Name of a triangle: all three ids of a [`Hit`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrimId {
    /// Number of the mesh.
    pub geom_id: u32,
    /// Number of the triangle.
    pub prim_id: u32,
    /// Number of the instance, [`INVALID`] for a mesh of the traced scene itself.
    pub inst_id: u32,
}

/// Checks that the fields of one of our structs have the offsets of Embree's. Ours may be longer, because of
/// its alignment.
macro_rules! same_layout {
    ($ours:ty, $embrees:ty, $($field:ident = $c_field:ident),+) => {
        const _: () = {
            assert!(size_of::<$ours>() >= size_of::<$embrees>(), "Embree was built with other options");
            $(assert!(offset_of!($ours, $field) == offset_of!($embrees, $c_field));)+
        };
    };
}
macro_rules! same_packets {
    ($($n:literal: $ray:ident, $hit:ident, $ray_hit:ident;)+) => {$(
        same_layout!(
            Ray<$n>,
            sys::$ray,
            org_x = org_x,
            org_y = org_y,
            org_z = org_z,
            tnear = tnear,
            dir_x = dir_x,
            dir_y = dir_y,
            dir_z = dir_z,
            time = time,
            tfar = tfar,
            mask = mask,
            id = id,
            flags = flags
        );
        same_layout!(
            Hit<$n>,
            sys::$hit,
            ng_x = Ng_x,
            ng_y = Ng_y,
            ng_z = Ng_z,
            u = u,
            v = v,
            prim_id = primID,
            geom_id = geomID,
            inst_id = instID,
            inst_prim_id = instPrimID
        );
        same_layout!(RayHit<$n>, sys::$ray_hit, ray = ray, hit = hit);
        // what Embree is given; it reads 4 * N bytes at a time
        const _: () = assert!(
            align_of::<Ray<$n>>() >= align_of::<sys::$ray>()
                && align_of::<RayHit<$n>>() >= align_of::<sys::$ray_hit>()
                && align_of::<Valid<$n>>() >= 4 * $n
                && size_of::<Ray<$n>>() == size_of::<sys::$ray>()
                && size_of::<Hit<$n>>() == size_of::<sys::$hit>()
        );
    )+};
}
same_packets!(
    4: RTCRay4, RTCHit4, RTCRayHit4;
    8: RTCRay8, RTCHit8, RTCRayHit8;
    16: RTCRay16, RTCHit16, RTCRayHit16;
);

#[cfg(test)]
mod tests {
    use super::PacketWidth::{self, Eight, Four, Sixteen};

    #[test]
    fn the_widest_native_packets_are_taken() {
        for (native, widest) in [
            (&[Four, Eight, Sixteen][..], Sixteen),
            (&[Four, Eight], Eight),
            (&[Four], Four),
            (&[Four, Sixteen], Sixteen),
            (&[], Four),
        ] {
            assert_eq!(PacketWidth::widest(|width| native.contains(&width)), widest, "{native:?}");
        }
        assert_eq!([Four, Eight, Sixteen].map(PacketWidth::lanes), [4, 8, 16]);
    }
}
