//! Primitives that are not triangles: callbacks ask for their intersections with rays.

use crate::segment::{Bounds, Segment};
use embree4_sys as sys;
use std::ffi::c_void;
use std::fmt::Debug;
use std::slice;
use std::sync::Arc;

/// Primitives that compute their intersections with rays, in object space: Embree's user geometry.
///
/// Count and boxes are asked for once, when a [`Geometry`](crate::Geometry) is made of them. Rays are asked about from all threads, and a
/// panic of these methods ends the program. Whatever they answer, and if it is another answer each time, a scene has wrong hits at worst.
pub trait Primitives: Debug + Send + Sync {
    /// Number of primitives.
    fn count(&self) -> u32;

    /// Number that hits have for a primitive: several may be parts of one, each with a box of its own. It is not above the primitive's.
    fn number(&self, primitive: u32) -> u32 {
        primitive
    }

    /// Bounding box of a primitive, which is less than the count. One that is not finite, or reaches beyond 1.8e18, takes the primitive
    /// out of the scene.
    fn bounds(&self, primitive: u32) -> Bounds;

    /// Finds the first intersection of `ray`, from `near` on and up to `far`, with a primitive. `ends_here`:
    /// the ray ends at t = 1 at a point of this primitive, which does not count.
    fn meet(&self, primitive: u32, ray: &Segment, ends_here: bool) -> Option<PrimitiveHit>;

    /// Answers [`meet`](Self::meet) for up to four rays. For primitives that handle four at a time with no
    /// more work than one.
    fn meet_four(&self, primitive: u32, rays: &[(Segment, bool)]) -> [Option<PrimitiveHit>; 4] {
        let mut hits = [None; 4];
        for (hit, (ray, ends_here)) in hits.iter_mut().zip(rays) {
            *hit = self.meet(primitive, ray, *ends_here);
        }
        hits
    }
}

/// Intersection of a ray with a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrimitiveHit {
    /// Distance in lengths of the direction, at most the ray's `far`.
    pub t: f32,
    /// First parameter, with a meaning that the primitives define.
    pub u: f32,
    /// Second parameter, with a meaning that the primitives define.
    pub v: f32,
}

/// Primitives, and their boxes as they were when the geometry was made. Embree asks for a box several times while it builds a scene, counts
/// those that are finite, and has room for as many: the answers must not differ.
#[derive(Clone, Debug)]
pub(crate) struct Boxed {
    primitives: Arc<dyn Primitives>,
    boxes: Arc<[Bounds]>,
}

impl Boxed {
    /// `None` if there are 2^32 - 1 or more: the last number means "no hit".
    pub fn new(primitives: Arc<dyn Primitives>) -> Option<Self> {
        let count = primitives.count();
        let boxes = || (0..count).map(|primitive| primitives.bounds(primitive)).collect();
        (count < u32::MAX).then(boxes).map(|boxes| Self { boxes, primitives })
    }
}

/// The primitives that Embree's callbacks ask. It lives at one address, which Embree knows, longer than the
/// geometry.
#[derive(Debug)]
pub(crate) struct Callbacks(Box<Boxed>);

impl Callbacks {
    pub fn new(boxed: Boxed) -> Self {
        Self(Box::new(boxed))
    }

    /// Makes `geometry` ask for these primitives.
    ///
    /// # Safety
    /// `geometry` is live, of the type for callbacks, and gone before `self`.
    pub unsafe fn set(&self, geometry: sys::RTCGeometry) {
        let address = (&raw const *self.0).cast_mut().cast::<c_void>();
        // SAFETY: by contract; the callbacks get this address, and read what is there.
        unsafe {
            // `Boxed` has fewer than 2^32 - 1
            sys::rtcSetGeometryUserPrimitiveCount(geometry, self.0.boxes.len() as u32);
            sys::rtcSetGeometryUserData(geometry, address);
            sys::rtcSetGeometryBoundsFunction(geometry, Some(say_bounds), address);
            sys::rtcSetGeometryIntersectFunction(geometry, Some(intersect));
            sys::rtcSetGeometryOccludedFunction(geometry, Some(occlude_all));
        }
    }
}

/// Returns the primitives of a callback.
///
/// # Safety
/// `address` is what [`Callbacks::set`] has told Embree, of a geometry that lives during `'a`.
unsafe fn boxed_at<'a>(address: *mut c_void) -> &'a Boxed {
    // SAFETY: by contract.
    unsafe { &*address.cast::<Boxed>() }
}

/// # Safety
/// Embree calls this for geometries that [`Callbacks::set`] has set up.
unsafe extern "C" fn say_bounds(arguments: *const sys::RTCBoundsFunctionArguments) {
    // SAFETY: Embree passes live arguments.
    let arguments = unsafe { &*arguments };
    // SAFETY: by contract.
    let boxed = unsafe { boxed_at(arguments.geometryUserPtr) };
    let Bounds { lower, upper } = boxed.boxes[arguments.primID as usize];
    // SAFETY: Embree passes room for one box.
    let bounds = unsafe { &mut *arguments.bounds_o };
    [bounds.lower_x, bounds.lower_y, bounds.lower_z] = lower;
    [bounds.upper_x, bounds.upper_y, bounds.upper_z] = upper;
}

/// The rays of a callback: rows of values, `count` each.
pub(crate) struct RaysN {
    values: *mut f32,
    count: usize,
}

impl RaysN {
    /// # Safety
    /// `lane` is less than the count and takes part, and the row is one of a ray.
    #[inline(always)]
    unsafe fn get(&self, row: usize, lane: usize) -> f32 {
        // SAFETY: by contract.
        unsafe { *self.values.add(row * self.count + lane) }
    }

    /// Value of `id` that the caller has written beside a ray that takes part.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> u32 {
        assert!(lane < self.count, "Embree numbers rays from 0");
        // SAFETY: checked just now; the row is one of a ray.
        unsafe { self.get(sys::RTC_RAY_N_ID_ROW, lane) }.to_bits()
    }

    /// # Safety
    /// As of [`get`](Self::get).
    #[inline(always)]
    unsafe fn segment(&self, lane: usize) -> Segment {
        // SAFETY: by contract, with rows of a ray.
        let three = |row: usize| [0, 1, 2].map(|axis| unsafe { self.get(row + axis, lane) });
        // SAFETY: as above.
        let [near, far, mask] = [sys::RTC_RAY_N_TNEAR_ROW, sys::RTC_RAY_N_TFAR_ROW, sys::RTC_RAY_N_MASK_ROW]
            .map(|row| unsafe { self.get(row, lane) });
        let (origin, direction) = (three(sys::RTC_RAY_N_ORG_ROW), three(sys::RTC_RAY_N_DIR_ROW));
        Segment { origin, direction, near, far, mask: mask.to_bits(), time: 0.0 }
    }

    /// # Safety
    /// As of [`get`](Self::get).
    #[inline(always)]
    unsafe fn end_at(&self, lane: usize, t: f32) {
        // SAFETY: by contract, with a row of a ray.
        unsafe { *self.values.add(sys::RTC_RAY_N_TFAR_ROW * self.count + lane) = t };
    }
}

/// Nearest hits.
///
/// # Safety
/// Embree calls this for geometries that [`Callbacks::set`] has set up.
unsafe extern "C" fn intersect(arguments: *const sys::RTCIntersectFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    unsafe { intersect_if(&*arguments, |_, t, _| Some(t)) };
}

/// Nearest hits that are kept: `end_at(id, t, name)` says where the ray ends then, by what the caller has written beside the ray, how
/// far away the hit is, and its instance, geometry and primitive.
///
/// # Safety
/// `arguments` are as Embree passes them, of a geometry that [`Callbacks::set`] has set up.
#[inline(always)]
pub(crate) unsafe fn intersect_if(
    arguments: &sys::RTCIntersectFunctionNArguments,
    mut end_at: impl FnMut(u32, f32, [u32; 3]) -> Option<f32>,
) {
    // SAFETY: by contract.
    let primitives = &*unsafe { boxed_at(arguments.geometryUserPtr) }.primitives;
    let count = arguments.N as usize;
    let rays = RaysN { values: arguments.rayhit.cast(), count };
    // SAFETY: the hits stand behind the rays.
    let hits: *mut u32 = unsafe { rays.values.add(sys::RTC_RAY_N_ROWS * count) }.cast();
    // SAFETY: Embree passes its own context or the caller's, which begins with Embree's part.
    let context = unsafe { &*arguments.context };
    let number = primitives.number(arguments.primID);
    let put_hit = |lane: usize, ray: &Segment, hit: PrimitiveHit| {
        let name = [context.instID[0], arguments.geomID, number];
        let Some(end) = end_at(rays.id(lane), hit.t, name) else { return };
        // SAFETY: the lane takes part, and the rows are those of a hit.
        let put = |row: usize, value: u32| unsafe { *hits.add(row * count + lane) = value };
        for (axis, part) in ray.direction.into_iter().enumerate() {
            // nobody here reads normals from Embree: any that is none of zero length
            put(sys::RTC_HIT_N_NG_ROW + axis, (-part).to_bits());
        }
        put(sys::RTC_HIT_N_U_ROW, hit.u.to_bits());
        put(sys::RTC_HIT_N_V_ROW, hit.v.to_bits());
        put(sys::RTC_HIT_N_PRIM_ID_ROW, number);
        put(sys::RTC_HIT_N_GEOM_ID_ROW, arguments.geomID);
        put(sys::RTC_HIT_N_INST_ID_ROW, context.instID[0]);
        put(sys::RTC_HIT_N_INST_PRIM_ID_ROW, context.instPrimID[0]);
        // SAFETY: the lane takes part.
        unsafe { rays.end_at(lane, end) };
    };
    // SAFETY: by contract.
    unsafe { for_each_met(primitives, arguments.primID, (&rays, arguments.valid), |_| false, put_hit) };
}

/// # Safety
/// Embree calls this for geometries that [`Callbacks::set`] has set up.
unsafe extern "C" fn occlude_all(arguments: *const sys::RTCOccludedFunctionNArguments) {
    // SAFETY: Embree passes live arguments.
    unsafe { occlude(&*arguments, |_, _, _| false) };
}

/// Ends the rays that the primitive blocks. `ends_here(rays, lane, number)`: whether a ray ends in a place of it, by its [number](Primitives::number).
///
/// # Safety
/// `arguments` are as Embree passes them, of a geometry that [`Callbacks::set`] has set up.
#[inline(always)]
pub(crate) unsafe fn occlude(
    arguments: &sys::RTCOccludedFunctionNArguments,
    ends_here: impl Fn(&RaysN, usize, u32) -> bool,
) {
    // SAFETY: by contract.
    let primitives = &*unsafe { boxed_at(arguments.geometryUserPtr) }.primitives;
    let count = arguments.N as usize;
    let rays = RaysN { values: arguments.ray.cast(), count };
    let end = |lane: usize, _: &Segment, _: PrimitiveHit| {
        // SAFETY: the lane takes part.
        unsafe { rays.end_at(lane, f32::NEG_INFINITY) };
    };
    let number = primitives.number(arguments.primID);
    let ends_here = |lane: usize| ends_here(&rays, lane, number);
    // SAFETY: by contract.
    unsafe { for_each_met(primitives, arguments.primID, (&rays, arguments.valid), ends_here, end) };
}

/// Calls `then` for each ray that takes part and meets the primitive, with its lane and the intersection.
/// Four rays are tested at a time, whichever take part.
///
/// # Safety
/// As of [`valid_lanes`], where there are as many as rays; a ray that takes part is there.
#[inline(always)]
unsafe fn for_each_met(
    primitives: &dyn Primitives,
    primitive: u32,
    (rays, valid): (&RaysN, *const i32),
    ends_here: impl Fn(usize) -> bool,
    mut then: impl FnMut(usize, &Segment, PrimitiveHit),
) {
    const NONE: Segment =
        Segment { origin: [0.0; 3], direction: [0.0; 3], near: 0.0, far: 0.0, mask: 0, time: 0.0 };
    // SAFETY: by contract.
    let mut open = unsafe { valid_lanes(valid, rays.count) };
    loop {
        let (mut lanes, mut four, mut count) = ([0; 4], [(NONE, false); 4], 0);
        for lane in open.by_ref().take(4) {
            // SAFETY: the lane takes part.
            four[count] = (unsafe { rays.segment(lane) }, ends_here(lane));
            lanes[count] = lane;
            count += 1;
        }
        if count == 0 {
            return;
        }
        let hits = primitives.meet_four(primitive, &four[..count]);
        for (lane, ((ray, _), hit)) in lanes.into_iter().zip(four.iter().zip(hits)).take(count) {
            if let Some(hit) = hit {
                then(lane, ray, hit);
            }
        }
    }
}

/// Lanes that take part.
///
/// # Safety
/// `valid` has `count` items, which nobody writes while the result lives.
#[inline(always)]
unsafe fn valid_lanes<'a>(valid: *const i32, count: usize) -> impl Iterator<Item = usize> + 'a {
    // SAFETY: by contract.
    let valid: &'a [i32] = unsafe { slice::from_raw_parts(valid, count) };
    valid.iter().enumerate().filter(|(_, valid)| **valid != 0).map(|(lane, _)| lane)
}
