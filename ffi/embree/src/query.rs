//! Tracing: the queries of a scene that is committed, and nothing that could change it.

use crate::packet::{LANES, OwnPrims16, Ray16, RayHit16, Valid16};
use embree4_sys as sys;
use std::marker::PhantomData;
use std::ptr;

/// Whether the rays of a packet run side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// Neighbouring pixels, or ends near each other: up to 3 times as fast.
    Coherent,
    /// Anything else.
    Incoherent,
}

impl Coherence {
    #[inline]
    fn flag(self) -> sys::RTCRayQueryFlags {
        match self {
            Self::Coherent => sys::RTC_RAY_QUERY_FLAG_COHERENT,
            Self::Incoherent => sys::RTC_RAY_QUERY_FLAG_INCOHERENT,
        }
    }
}

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least x, y, z.
    pub lower: [f32; 3],
    /// Greatest x, y, z.
    pub upper: [f32; 3],
}

/// A committed scene, borrowed for tracing. Copies go to as many threads as there are.
#[derive(Clone, Copy, Debug)]
pub struct Committed<'a> {
    scene: sys::RTCScene,
    _borrowed: PhantomData<&'a ()>,
}

// SAFETY: Embree's queries may run on many threads at once, and the scene can neither change nor end while
// it is borrowed.
unsafe impl Send for Committed<'_> {}
// SAFETY: as above.
unsafe impl Sync for Committed<'_> {}

impl Committed<'_> {
    /// # Safety
    /// `scene` is live and committed, and stays unchanged during the lifetime of the result.
    pub(crate) unsafe fn new(scene: sys::RTCScene) -> Self {
        Self {
            scene,
            _borrowed: PhantomData,
        }
    }

    /// The closest hit of each ray that takes part: `ray.tfar` and the lane of `packet.hit` are written, or
    /// left alone if nothing is hit. Begin with `hit.geom_id` [`INVALID`](crate::INVALID).
    #[inline]
    pub fn intersect16(&self, valid: &Valid16, packet: &mut RayHit16, coherence: Coherence) {
        let mut arguments = sys::init_intersect_arguments();
        arguments.flags = coherence.flag();
        // SAFETY: the scene is live and committed; packet and mask have the layout (checked when compiled) and
        // the alignment of Embree's; no callback is passed.
        unsafe {
            sys::rtcIntersect16(
                valid.as_ptr(),
                self.scene,
                ptr::from_mut(packet).cast(),
                &raw mut arguments,
            );
        }
    }

    /// Whether anything stands in the way of each ray that takes part: then its `tfar` becomes minus infinity.
    #[inline]
    pub fn occluded16(&self, valid: &Valid16, packet: &mut Ray16, coherence: Coherence) {
        let mut arguments = sys::init_occluded_arguments();
        arguments.flags = coherence.flag();
        // SAFETY: as in `intersect16`.
        unsafe {
            sys::rtcOccluded16(
                valid.as_ptr(),
                self.scene,
                ptr::from_mut(packet).cast(),
                &raw mut arguments,
            );
        }
    }

    /// As [`occluded16`](Self::occluded16), except that a ray is never occluded by its own primitive. So a
    /// segment may end on the very surface it belongs to, and no occluder close to that surface is missed.
    ///
    /// Overwrites `packet.id`.
    #[inline]
    pub fn occluded16_past_own(
        &self,
        valid: &Valid16,
        packet: &mut Ray16,
        own: &OwnPrims16,
        coherence: Coherence,
    ) {
        // Embree may call the filter with the rays in another order, or one by one: the id tells the lane.
        packet.id = LANE_NUMBERS;
        let mut context = OwnContext {
            embrees: sys::init_ray_query_context(),
            own,
        };
        let mut arguments = sys::init_occluded_arguments();
        arguments.flags = coherence.flag() | sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
        arguments.context = (&raw mut context).cast();
        arguments.filter = Some(let_own_pass);
        // SAFETY: as in `intersect16`; the context begins with Embree's part and outlives the call, and the
        // filter gets this context because this call passes it.
        unsafe {
            sys::rtcOccluded16(
                valid.as_ptr(),
                self.scene,
                ptr::from_mut(packet).cast(),
                &raw mut arguments,
            );
        }
    }

    /// The box around the whole scene, world space; `None` if nothing is in it.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut raw = sys::RTCBounds {
            lower_x: 0.0,
            lower_y: 0.0,
            lower_z: 0.0,
            align0: 0.0,
            upper_x: 0.0,
            upper_y: 0.0,
            upper_z: 0.0,
            align1: 0.0,
        };
        // SAFETY: the scene is live and committed, and Embree writes one RTCBounds.
        unsafe { sys::rtcGetSceneBounds(self.scene, &raw mut raw) };
        let lower = [raw.lower_x, raw.lower_y, raw.lower_z];
        let upper = [raw.upper_x, raw.upper_y, raw.upper_z];
        // Embree's empty box is inside out.
        let holds_something = lower.iter().zip(&upper).all(|(low, high)| low <= high);
        holds_something.then_some(Bounds { lower, upper })
    }
}

const LANE_NUMBERS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// What [`let_own_pass`] is told, behind what Embree itself needs.
#[repr(C)]
struct OwnContext<'a> {
    embrees: sys::RTCRayQueryContext,
    own: &'a OwnPrims16,
}

/// Occlusion filter: rejects the hits of rays with their own primitives, so that traversal goes on.
///
/// # Safety
/// Embree calls this from `occluded16_past_own` alone, with an [`OwnContext`] as context.
unsafe extern "C" fn let_own_pass(arguments: *const sys::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the context lives on the stack of the caller.
    let own = unsafe { &*arguments.context.cast::<OwnContext<'_>>() }.own;
    let count = arguments.N as usize;
    let (ray, hit) = (arguments.ray.cast::<u32>(), arguments.hit.cast::<u32>());
    for i in 0..count {
        // SAFETY: `valid` has N items; a ray has 12 rows of N values, a hit at least 8. Rows of lanes that are
        // off may not be initialised, and are not read.
        unsafe {
            let valid = arguments.valid.add(i);
            if *valid == 0 {
                continue;
            }
            let lane = *ray.add(sys::RTC_RAY_N_ID_ROW * count + i) as usize % LANES;
            let is_own = *hit.add(sys::RTC_HIT_N_PRIM_ID_ROW * count + i) == own.prim_id[lane]
                && *hit.add(sys::RTC_HIT_N_GEOM_ID_ROW * count + i) == own.geom_id[lane]
                && *hit.add(sys::RTC_HIT_N_INST_ID_ROW * count + i) == own.inst_id[lane];
            if is_own {
                *valid = 0;
            }
        }
    }
}
