//! Rays and boxes that cross the border to Embree by value.

use embree4_sys as sys;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least x, y, z.
    pub lower: [f32; 3],
    /// Greatest x, y, z.
    pub upper: [f32; 3],
}

/// One ray: the points `origin + t * direction` with `near <= t <= far`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// World space.
    pub origin: [f32; 3],
    /// World space, of any length.
    pub direction: [f32; 3],
    /// At least 0.
    pub near: f32,
    /// May be infinite.
    pub far: f32,
    /// Meets geometries and instances whose mask has a bit in common.
    pub mask: u32,
    /// From 0 to 1: see [`Ray::time`](crate::Ray::time).
    pub time: f32,
}

impl Segment {
    #[inline]
    pub(crate) fn to_embree(self) -> sys::RTCRay {
        let ([org_x, org_y, org_z], [dir_x, dir_y, dir_z]) = (self.origin, self.direction);
        let (tnear, tfar, mask, time) = (self.near, self.far, self.mask, self.time);
        sys::RTCRay { org_x, org_y, org_z, tnear, dir_x, dir_y, dir_z, time, tfar, mask, id: 0, flags: 0 }
    }
}
