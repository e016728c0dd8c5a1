//! Packets of 16 rays, laid out as Embree reads them.

use embree4_sys as sys;
use std::mem::offset_of;

/// The id that means "no hit" as `geom_id`, and "not in an instance" as `inst_id`.
pub const INVALID: u32 = sys::RTC_INVALID_GEOMETRY_ID;

/// F32x8 in a packet.
pub const LANES: usize = 16;

/// Which of the 16 rays of a packet take part.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Valid16([i32; LANES]);

impl Valid16 {
    /// All rays.
    pub const ALL: Self = Self([-1; LANES]);
    /// No ray.
    pub const NONE: Self = Self([0; LANES]);

    /// The rays for which `is_on(lane)` holds.
    #[inline]
    pub fn from_fn(mut is_on: impl FnMut(usize) -> bool) -> Self {
        Self(std::array::from_fn(|lane| -i32::from(is_on(lane))))
    }

    /// The first `count` rays: the last packet of a list.
    #[inline]
    pub fn first(count: usize) -> Self {
        Self::from_fn(|lane| lane < count)
    }

    /// Bit `i` is ray `i`.
    #[inline]
    pub fn from_bits(bits: u16) -> Self {
        Self::from_fn(|lane| bits >> lane & 1 == 1)
    }

    /// Takes a ray in or out.
    #[inline]
    pub fn set(&mut self, lane: usize, on: bool) {
        self.0[lane] = -i32::from(on);
    }

    /// Whether a ray takes part.
    #[inline]
    pub fn is_on(&self, lane: usize) -> bool {
        self.0[lane] != 0
    }

    /// Whether any ray takes part.
    #[inline]
    pub fn any(&self) -> bool {
        self.0.iter().any(|&lane| lane != 0)
    }

    #[inline]
    pub(crate) fn as_ptr(&self) -> *const i32 {
        self.0.as_ptr()
    }
}

/// 16 ray segments: the points `org + t * dir` with `tnear <= t <= tfar`.
///
/// Nothing here needs to be normalised: `t` counts lengths of `dir`. What a ray hits that has a NaN or an
/// infinite origin or direction is undefined (and slow to find out), but harms nothing.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray16 {
    /// Origins, world space.
    pub org_x: [f32; LANES],
    /// Origins, world space.
    pub org_y: [f32; LANES],
    /// Origins, world space.
    pub org_z: [f32; LANES],
    /// Start of the segment, at least 0.
    pub tnear: [f32; LANES],
    /// Directions, world space, of any length.
    pub dir_x: [f32; LANES],
    /// Directions, world space, of any length.
    pub dir_y: [f32; LANES],
    /// Directions, world space, of any length.
    pub dir_z: [f32; LANES],
    /// Time for motion blur; unused here.
    pub time: [f32; LANES],
    /// End of the segment. `intersect16` moves it to the hit, `occluded16` sets it to minus infinity.
    pub tfar: [f32; LANES],
    /// Meets geometries and instances whose mask has a bit in common.
    pub mask: [u32; LANES],
    /// Free for the caller, except that `occluded16_past_own` writes the lane's number here.
    pub id: [u32; LANES],
    /// Reserved by Embree, 0.
    pub flags: [u32; LANES],
}

impl Default for Ray16 {
    /// Rays from the origin in no direction, 0 to infinity, that meet every mask.
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            org_x: zero,
            org_y: zero,
            org_z: zero,
            tnear: zero,
            dir_x: zero,
            dir_y: zero,
            dir_z: zero,
            time: zero,
            tfar: [f32::INFINITY; LANES],
            mask: [u32::MAX; LANES],
            id: [0; LANES],
            flags: [0; LANES],
        }
    }
}

impl Ray16 {
    /// Sets one lane's segment and leaves its mask.
    #[inline]
    pub fn set(&mut self, lane: usize, org: [f32; 3], dir: [f32; 3], tnear: f32, tfar: f32) {
        [self.org_x[lane], self.org_y[lane], self.org_z[lane]] = org;
        [self.dir_x[lane], self.dir_y[lane], self.dir_z[lane]] = dir;
        self.tnear[lane] = tnear;
        self.tfar[lane] = tfar;
    }

    /// Whether `occluded16` found something in this lane's way.
    #[inline]
    pub fn is_occluded(&self, lane: usize) -> bool {
        self.tfar[lane] == f32::NEG_INFINITY
    }
}

/// What 16 rays hit. A lane is written when something is hit and left alone otherwise.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit16 {
    /// Normal of the triangle, not normalised, in the **object's** space: (v1 - v0) x (v2 - v0).
    pub ng_x: [f32; LANES],
    /// See `ng_x`.
    pub ng_y: [f32; LANES],
    /// See `ng_x`.
    pub ng_z: [f32; LANES],
    /// Barycentric weight of the triangle's second corner.
    pub u: [f32; LANES],
    /// Barycentric weight of the triangle's third corner.
    pub v: [f32; LANES],
    /// Number of the triangle in its mesh.
    pub prim_id: [u32; LANES],
    /// Number of the mesh in the scene that holds it, or [`INVALID`] for no hit.
    pub geom_id: [u32; LANES],
    /// Number of the instance in the scene that was traced, or [`INVALID`] for a mesh of that scene itself.
    pub inst_id: [u32; LANES],
    /// Number in an instance array; there are none here, so that it says nothing.
    pub inst_prim_id: [u32; LANES],
}

impl Default for Hit16 {
    /// No hit.
    fn default() -> Self {
        let zero = [0.0; LANES];
        let none = [INVALID; LANES];
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

impl Hit16 {
    /// Whether this lane's ray hit something.
    #[inline]
    pub fn is_hit(&self, lane: usize) -> bool {
        self.geom_id[lane] != INVALID
    }

    /// Forgets all hits, so that the packet can be used again.
    #[inline]
    pub fn clear(&mut self) {
        self.geom_id = [INVALID; LANES];
        self.inst_id = [INVALID; LANES];
    }
}

/// 16 rays and their hits.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayHit16 {
    /// The rays.
    pub ray: Ray16,
    /// Their hits.
    pub hit: Hit16,
}

impl RayHit16 {
    /// Rays that have hit nothing yet.
    pub fn new(ray: Ray16) -> Self {
        Self { ray, hit: Hit16::default() }
    }
}

/// For each lane the primitive that must not occlude it, by all three ids of a [`Hit16`].
/// `prim_id` = [`INVALID`] excludes nothing.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnPrims16 {
    /// The mesh.
    pub geom_id: [u32; LANES],
    /// The triangle.
    pub prim_id: [u32; LANES],
    /// The instance, [`INVALID`] for a mesh of the traced scene itself.
    pub inst_id: [u32; LANES],
}

impl Default for OwnPrims16 {
    /// Excludes nothing.
    fn default() -> Self {
        Self { geom_id: [INVALID; LANES], prim_id: [INVALID; LANES], inst_id: [INVALID; LANES] }
    }
}

/// Where a field of one of ours stands must be where Embree's stands.
macro_rules! same_layout {
    ($ours:ty, $embrees:ty, $($field:ident = $c_field:ident),+) => {
        const _: () = {
            assert!(size_of::<$ours>() == size_of::<$embrees>(), "Embree was built with other options");
            assert!(align_of::<$ours>() >= align_of::<$embrees>());
            $(assert!(offset_of!($ours, $field) == offset_of!($embrees, $c_field));)+
        };
    };
}
same_layout!(
    Ray16,
    sys::RTCRay16,
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
    Hit16,
    sys::RTCHit16,
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
same_layout!(RayHit16, sys::RTCRayHit16, ray = ray, hit = hit);
