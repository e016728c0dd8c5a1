//! Triangles with places that are not there: Embree asks before it counts a hit.

use embree4_sys as sys;
use std::ffi::c_void;
use std::fmt::Debug;
use std::sync::Arc;

/// Answers which places of triangles are there.
///
/// Embree asks from all threads, and a panic ends the program.
pub trait Cutout: Debug + Send + Sync {
    /// Keeps the hits with places that are there. One call for all rays of a packet that may meet a triangle.
    fn retain(&self, candidates: Candidates<'_>);
}

/// Hits of rays with triangles, which count unless they are rejected.
#[derive(Debug)]
pub struct Candidates<'a>(&'a sys::RTCFilterFunctionNArguments);

impl Candidates<'_> {
    /// Rejects the hits for which `is_there` is false: a function of the triangle's number, the weights of its second and third corner
    /// in the place, and the ray's mask.
    #[inline(always)]
    pub fn retain(self, is_there: impl Fn(u32, [f32; 2], u32) -> bool) {
        let arguments = self.0;
        let (count, hit, ray) =
            (arguments.N as usize, arguments.hit.cast::<u32>(), arguments.ray.cast::<u32>());
        for i in 0..count {
            // SAFETY: `valid` has N items, and a hit and a ray have rows of N values. Rows of lanes that are off are not read.
            unsafe {
                let valid = arguments.valid.add(i);
                if *valid == 0 {
                    continue;
                }
                let value = |row: usize| *hit.add(row * count + i);
                let weights =
                    [sys::RTC_HIT_N_U_ROW, sys::RTC_HIT_N_V_ROW].map(|row| f32::from_bits(value(row)));
                let mask = *ray.add(sys::RTC_RAY_N_MASK_ROW * count + i);
                if !is_there(value(sys::RTC_HIT_N_PRIM_ID_ROW), weights, mask) {
                    *valid = 0;
                }
            }
        }
    }
}

/// The cut-out that Embree's filter asks. It lives at one address, which Embree knows, longer than the geometry.
#[derive(Debug)]
pub(crate) struct Filter(Box<Arc<dyn Cutout>>);

impl Filter {
    pub fn new(cutout: Arc<dyn Cutout>) -> Self {
        Self(Box::new(cutout))
    }

    /// Makes `geometry` ask this cut-out about each hit, of whatever query. A query with a filter of its own asks that one
    /// afterwards, about the hits that are left.
    ///
    /// # Safety
    /// `geometry` is live, a mesh of triangles, and gone before `self`.
    pub unsafe fn set(&self, geometry: sys::RTCGeometry) {
        let address = (&raw const *self.0).cast_mut().cast::<c_void>();
        // SAFETY: by contract; the filter gets this address, and reads what is there.
        unsafe {
            sys::rtcSetGeometryUserData(geometry, address);
            sys::rtcSetGeometryIntersectFilterFunction(geometry, Some(reject_missing));
            sys::rtcSetGeometryOccludedFilterFunction(geometry, Some(reject_missing));
        }
    }
}

/// Rejects hits with places that are not there.
///
/// # Safety
/// Embree calls this for geometries that [`Filter::set`] has set up.
unsafe extern "C" fn reject_missing(arguments: *const sys::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the filter outlives the geometry.
    let cutout = unsafe { &**arguments.geometryUserPtr.cast::<Arc<dyn Cutout>>() };
    cutout.retain(Candidates(arguments));
}
