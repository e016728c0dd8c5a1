//! Tracing: the queries of a committed scene, and nothing that could change it.

use crate::packet::{INVALID, PrimId, Ray, RayHit, Valid};
use crate::primitives::{self, RaysN};
use crate::segment::{Bounds, Segment};
use embree4_sys as sys;
use std::ffi::c_void;
use std::marker::PhantomData;
use std::ptr;

/// Coherence of the rays of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// Rays of neighbouring pixels, or with ends near each other: up to 3 times as fast.
    Coherent,
    /// Any other rays.
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
        Self { scene, _borrowed: PhantomData }
    }

    /// The closest hit of each ray that takes part: `ray.tfar` and the lane of `packet.hit` are written, or
    /// left alone if nothing is hit. Begin with `hit.geom_id` [`INVALID`].
    ///
    /// `N` is 4, 8 or 16, and packets of [`Device::native_width`](crate::Device::native_width) are the fastest.
    #[inline]
    pub fn intersect<const N: usize>(&self, valid: &Valid<N>, packet: &mut RayHit<N>, coherence: Coherence) {
        const { assert!(is_width(N), "Embree has packets of 4, 8 and 16") }
        let mut arguments = sys::init_intersect_arguments();
        arguments.flags = coherence.flag();
        let (valid, packet, arguments) =
            (valid.as_ptr(), ptr::from_mut(packet).cast::<c_void>(), &raw mut arguments);
        // SAFETY: the scene is live and committed; packet and mask have the layout (checked when compiled) and
        // the alignment of Embree's for N rays; no callback is passed.
        unsafe {
            match N {
                4 => sys::rtcIntersect4(valid, self.scene, packet.cast(), arguments),
                8 => sys::rtcIntersect8(valid, self.scene, packet.cast(), arguments),
                _ => sys::rtcIntersect16(valid, self.scene, packet.cast(), arguments),
            }
        }
    }

    /// As [`intersect`](Self::intersect) of coherent rays, except that of several primitives that a ray meets at the same t, to the bit,
    /// the one with the least instance, geometry and number is hit. Otherwise one wins that is looked at early or late, and which
    /// that is depends on the other rays of the packet. So what a ray hits depends on it alone.
    ///
    /// What a ray has hit in another scene, of which `packet` tells, comes after what is as near in this one. Overwrites
    /// `packet.ray.id`. A panic of [`Primitives`](crate::Primitives) ends the program.
    #[inline]
    pub fn intersect_least<const N: usize>(&self, valid: &Valid<N>, packet: &mut RayHit<N>) {
        const { assert!(is_width(N), "Embree has packets of 4, 8 and 16") }
        // Embree may call back with fewer rays: the id tells the lane
        packet.ray.id = std::array::from_fn(|lane| lane as u32);
        let mut best = [Best::NONE; 16];
        for (lane, best) in best[..N].iter_mut().enumerate() {
            // met in another scene: what is as near in this one comes first
            if packet.hit.geom_id[lane] != INVALID {
                best.t = packet.ray.tfar[lane];
                packet.ray.tfar[lane] *= ROUNDING;
            }
        }
        let mut context = LeastContext { embrees: sys::init_ray_query_context(), best };
        let mut arguments = sys::init_intersect_arguments();
        arguments.flags = Coherence::Coherent.flag() | sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
        arguments.context = (&raw mut context).cast();
        arguments.filter = Some(keep_least);
        arguments.intersect = Some(meet_least);
        let (valid, both, arguments) =
            (valid.as_ptr(), ptr::from_mut(&mut *packet).cast::<c_void>(), &raw mut arguments);
        // SAFETY: as in `intersect`; the context begins with Embree's part and outlives the call, and filter and callback get
        // this context, of the type that they are made for.
        unsafe {
            match N {
                4 => sys::rtcIntersect4(valid, self.scene, both.cast(), arguments),
                8 => sys::rtcIntersect8(valid, self.scene, both.cast(), arguments),
                _ => sys::rtcIntersect16(valid, self.scene, both.cast(), arguments),
            }
        }
        for (end, best) in packet.ray.tfar.iter_mut().zip(&context.best) {
            *end = if best.t < f32::INFINITY { best.t } else { *end };
        }
    }

    /// The closest hit of one ray. What it meets depends on no other ray, to the bit: in packets it may, by a rounding.
    #[inline]
    pub fn intersect_one(&self, segment: &Segment, coherence: Coherence) -> Option<OneHit> {
        let mut arguments = sys::init_intersect_arguments();
        arguments.flags = coherence.flag();
        let mut both = sys::RTCRayHit {
            ray: segment.to_embree(),
            hit: sys::RTCHit {
                Ng_x: 0.0,
                Ng_y: 0.0,
                Ng_z: 0.0,
                u: 0.0,
                v: 0.0,
                primID: INVALID,
                geomID: INVALID,
                instID: [INVALID],
                instPrimID: [INVALID],
            },
        };
        // SAFETY: the scene is live and committed; ray and hit are Embree's own type; no callback is passed.
        unsafe { sys::rtcIntersect1(self.scene, &raw mut both, &raw mut arguments) };
        let sys::RTCRayHit { ray, hit } = both;
        (hit.geomID != INVALID).then_some(OneHit {
            t: ray.tfar,
            u: hit.u,
            v: hit.v,
            met: PrimId { geom_id: hit.geomID, prim_id: hit.primID, inst_id: hit.instID[0] },
        })
    }

    /// Returns true if anything blocks one ray.
    #[inline]
    pub fn occluded_one(&self, segment: &Segment, coherence: Coherence) -> bool {
        let mut arguments = sys::init_occluded_arguments();
        arguments.flags = coherence.flag();
        let mut ray = segment.to_embree();
        // SAFETY: as in `intersect_one`.
        unsafe { sys::rtcOccluded1(self.scene, &raw mut ray, &raw mut arguments) };
        ray.tfar == f32::NEG_INFINITY
    }

    /// Finds out whether anything blocks each ray that takes part: then its `tfar` becomes minus infinity.
    #[inline]
    pub fn occluded<const N: usize>(&self, valid: &Valid<N>, packet: &mut Ray<N>, coherence: Coherence) {
        let mut arguments = sys::init_occluded_arguments();
        arguments.flags = coherence.flag();
        // SAFETY: no callback is passed.
        unsafe { self.ask_occluded(valid, packet, &mut arguments) };
    }

    /// As [`occluded`](Self::occluded), except that a ray, known by its lane, passes those primitives for which
    /// `passes` holds. So a segment that passes the surface it belongs to may end on that very surface, and no
    /// occluder close to it is missed. Of other [`Primitives`](crate::Primitives) it passes the place that it ends in, and
    /// nothing else: these may hide themselves.
    ///
    /// Overwrites `packet.id`. A panic of `passes` ends the program.
    #[inline]
    pub fn occluded_past<const N: usize, F: Fn(usize, PrimId) -> bool>(
        &self,
        valid: &Valid<N>,
        packet: &mut Ray<N>,
        coherence: Coherence,
        passes: &F,
    ) {
        // Embree may call the filter with the rays in another order, or one by one: the id tells the lane.
        packet.id = std::array::from_fn(|lane| lane as u32);
        let mut context = PassContext { embrees: sys::init_ray_query_context(), passes };
        let mut arguments = sys::init_occluded_arguments();
        arguments.flags = coherence.flag() | sys::RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
        arguments.context = (&raw mut context).cast();
        arguments.filter = Some(let_pass::<F>);
        arguments.occluded = Some(occlude_past::<F>);
        // SAFETY: the context begins with Embree's part and outlives the call; filter and callback get this context, and
        // are made for its type.
        unsafe { self.ask_occluded(valid, packet, &mut arguments) };
    }

    /// # Safety
    /// The callbacks of `arguments`, if any, are sound with its context.
    #[inline]
    unsafe fn ask_occluded<const N: usize>(
        &self,
        valid: &Valid<N>,
        packet: &mut Ray<N>,
        arguments: &mut sys::RTCOccludedArguments,
    ) {
        const { assert!(is_width(N), "Embree has packets of 4, 8 and 16") }
        let (valid, packet) = (valid.as_ptr(), ptr::from_mut(packet).cast::<c_void>());
        // SAFETY: as in `intersect`, and by contract.
        unsafe {
            match N {
                4 => sys::rtcOccluded4(valid, self.scene, packet.cast(), arguments),
                8 => sys::rtcOccluded8(valid, self.scene, packet.cast(), arguments),
                _ => sys::rtcOccluded16(valid, self.scene, packet.cast(), arguments),
            }
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

/// Hit of one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneHit {
    /// Distance in lengths of the direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second corner.
    pub u: f32,
    /// Barycentric weight of the triangle's third corner.
    pub v: f32,
    /// Name of the triangle.
    pub met: PrimId,
}

const fn is_width(lanes: usize) -> bool {
    matches!(lanes, 4 | 8 | 16)
}

/// Context of [`let_pass`] and [`occlude_past`]: Embree's own part comes first.
#[repr(C)]
struct PassContext<'a, F> {
    embrees: sys::RTCRayQueryContext,
    passes: &'a F,
}

/// Occlusion filter: rejects the hits with primitives that their rays pass, so that traversal goes on.
///
/// # Safety
/// Embree calls this from `occluded_past` alone, with a [`PassContext`] of the same `F` as context.
unsafe extern "C" fn let_pass<F: Fn(usize, PrimId) -> bool>(
    arguments: *const sys::RTCFilterFunctionNArguments,
) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the context lives on the stack of the caller.
    let passes = unsafe { &*arguments.context.cast::<PassContext<'_, F>>() }.passes;
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
            let lane = *ray.add(sys::RTC_RAY_N_ID_ROW * count + i) as usize;
            let met = PrimId {
                geom_id: *hit.add(sys::RTC_HIT_N_GEOM_ID_ROW * count + i),
                prim_id: *hit.add(sys::RTC_HIT_N_PRIM_ID_ROW * count + i),
                inst_id: *hit.add(sys::RTC_HIT_N_INST_ID_ROW * count + i),
            };
            if passes(lane, met) {
                *valid = 0;
            }
        }
    }
}

/// Factor that covers the rounding of the distances of boxes and hits.
const ROUNDING: f32 = 1.0 + 6e-7;

/// The nearest hit of a ray so far, in the scene at hand.
#[derive(Clone, Copy)]
struct Best {
    t: f32,
    /// Instance, geometry and primitive.
    name: [u32; 3],
}

impl Best {
    const NONE: Self = Self { t: f32::INFINITY, name: [INVALID; 3] };

    /// Takes a hit at `t` if it is nearer than the best so far, or as near with a lesser name. Returns then
    /// where the ray is to end: slightly behind the hit, so that Embree still looks into boxes that begin
    /// where the ray ends, but for rounding. Another primitive may be as near.
    #[inline(always)]
    fn end_at(&mut self, t: f32, name: [u32; 3]) -> Option<f32> {
        let is_hit = t < self.t || t == self.t && name < self.name;
        is_hit.then(|| {
            *self = Self { t, name };
            t * ROUNDING
        })
    }
}

/// Context of [`keep_least`] and [`meet_least`]: Embree's own part comes first.
#[repr(C)]
struct LeastContext {
    embrees: sys::RTCRayQueryContext,
    /// Best hit of each lane.
    best: [Best; 16],
}

/// Filter of nearest hits: rejects those that are behind another, or as near and have a greater name.
///
/// # Safety
/// Embree calls this from `intersect_least` alone, with a [`LeastContext`] as context that no other thread knows.
unsafe extern "C" fn keep_least(arguments: *const sys::RTCFilterFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the context lives on the stack of the caller.
    let context = unsafe { &mut *arguments.context.cast::<LeastContext>() };
    let count = arguments.N as usize;
    let (ray, hit) = (arguments.ray.cast::<u32>(), arguments.hit.cast::<u32>());
    for i in 0..count {
        // SAFETY: as in `let_pass`; Embree lets a filter that keeps a hit say where the ray ends.
        unsafe {
            let valid = arguments.valid.add(i);
            if *valid == 0 {
                continue;
            }
            let lane = *ray.add(sys::RTC_RAY_N_ID_ROW * count + i) as usize;
            // Embree has put the end of the ray where the hit is
            let end = ray.add(sys::RTC_RAY_N_TFAR_ROW * count + i);
            let t = f32::from_bits(*end);
            let name = [sys::RTC_HIT_N_INST_ID_ROW, sys::RTC_HIT_N_GEOM_ID_ROW, sys::RTC_HIT_N_PRIM_ID_ROW]
                .map(|row| *hit.add(row * count + i));
            match context.best[lane].end_at(t, name) {
                Some(behind) => *end = behind.to_bits(),
                None => *valid = 0,
            }
        }
    }
}

/// Nearest hits with primitives that are no triangles, which Embree asks no filter about: see
/// [`Committed::intersect_least`].
///
/// # Safety
/// Embree calls this from `intersect_least` alone, with a [`LeastContext`] as context that no other thread knows, and for
/// geometries that [`primitives::Callbacks`] made.
unsafe extern "C" fn meet_least(arguments: *const sys::RTCIntersectFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the context lives on the stack of the caller.
    let best = unsafe { &mut (*arguments.context.cast::<LeastContext>()).best };
    // SAFETY: as Embree has passed them.
    unsafe { primitives::intersect_if(arguments, |id, t, name| best[id as usize].end_at(t, name)) };
}

/// Occlusion by primitives that are no triangles, which Embree asks no filter about: see
/// [`Committed::occluded_past`].
///
/// # Safety
/// Embree calls this from `occluded_past` alone, with a [`PassContext`] of the same `F` as context, and for geometries
/// that [`primitives::Callbacks`] made.
unsafe extern "C" fn occlude_past<F: Fn(usize, PrimId) -> bool>(
    arguments: *const sys::RTCOccludedFunctionNArguments,
) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract; the context lives on the stack of the caller.
    let context = unsafe { &*arguments.context.cast::<PassContext<'_, F>>() };
    // SAFETY: Embree has put the instance that it is in into the context that it was given.
    let inst_id = unsafe { (*arguments.context).instID[0] };
    let met = |prim_id: u32| PrimId { geom_id: arguments.geomID, prim_id, inst_id };
    let ends_here =
        |rays: &RaysN, lane: usize, number: u32| (context.passes)(rays.id(lane) as usize, met(number));
    // SAFETY: as Embree has passed them.
    unsafe { primitives::occlude(arguments, ends_here) };
}
