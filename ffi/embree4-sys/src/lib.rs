//! Raw bindings to [Embree 4](https://www.embree.org), version 4.3 or newer.
//!
//! The bindings are made at build time from the headers that are installed, because the structs grew
//! between versions: a binding made from 4.2 headers lets a 4.3 library write past the end of an
//! `RTCRayHit`. The build looks in `EMBREE_DIR`, then in `/usr/local` and `/usr`, then in `.deps/embree`
//! of this workspace, and refuses versions below 4.3.
//!
//! Use the crate `afterimage-embree`; this one is for it alone. Names and meaning are those of Embree's manual.
//! What the headers define in a way that bindgen cannot see stands in this file by hand.
//!
//! A dependent crate's build script finds in `DEP_EMBREE4_VERSION` the version of the headers and in
//! `DEP_EMBREE4_RPATH` the folder to write into its programs as run path (empty if none is needed).

#[allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    unsafe_op_in_unsafe_fn,
    clippy::all,
    clippy::undocumented_unsafe_blocks,
    reason = "generated from C headers, names and all"
)]
mod bindings {
    include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
}
pub use bindings::*;

use std::ptr;

/// The id that means "no geometry", "no instance" or "no hit".
pub const RTC_INVALID_GEOMETRY_ID: u32 = u32::MAX;

// A callback gets its rays and hits as rows of N values each; value `i` of a row stands at `row * N + i`.
/// The row of `RTCRayN_org_x`; y and z follow.
pub const RTC_RAY_N_ORG_ROW: usize = 0;
/// The row of `RTCRayN_tnear`.
pub const RTC_RAY_N_TNEAR_ROW: usize = 3;
/// The row of `RTCRayN_dir_x`; y and z follow.
pub const RTC_RAY_N_DIR_ROW: usize = 4;
/// The row of `RTCRayN_time`.
pub const RTC_RAY_N_TIME_ROW: usize = 7;
/// The row of `RTCRayN_tfar`.
pub const RTC_RAY_N_TFAR_ROW: usize = 8;
/// The row of `RTCRayN_mask`.
pub const RTC_RAY_N_MASK_ROW: usize = 9;
/// The row of `RTCRayN_id`.
pub const RTC_RAY_N_ID_ROW: usize = 10;
/// Rows of a ray: where the rays of an `RTCRayHitN` end and the hits begin.
pub const RTC_RAY_N_ROWS: usize = 12;
/// The row of `RTCHitN_Ng_x`; y and z follow.
pub const RTC_HIT_N_NG_ROW: usize = 0;
/// The row of `RTCHitN_u`.
pub const RTC_HIT_N_U_ROW: usize = 3;
/// The row of `RTCHitN_v`.
pub const RTC_HIT_N_V_ROW: usize = 4;
/// The row of `RTCHitN_primID`.
pub const RTC_HIT_N_PRIM_ID_ROW: usize = 5;
/// The row of `RTCHitN_geomID`.
pub const RTC_HIT_N_GEOM_ID_ROW: usize = 6;
/// The row of `RTCHitN_instID` at the outermost level.
pub const RTC_HIT_N_INST_ID_ROW: usize = 7;
/// The row of `RTCHitN_instPrimID` at the outermost level.
pub const RTC_HIT_N_INST_PRIM_ID_ROW: usize = 8;

/// Creates the content that `rtcInitRayQueryContext` writes: a query that is inside of no instance.
pub const fn init_ray_query_context() -> RTCRayQueryContext {
    const LEVELS: usize = RTC_MAX_INSTANCE_LEVEL_COUNT as usize;
    RTCRayQueryContext {
        instID: [RTC_INVALID_GEOMETRY_ID; LEVELS],
        instPrimID: [RTC_INVALID_GEOMETRY_ID; LEVELS],
    }
}

/// Creates the content that `rtcInitIntersectArguments` writes: incoherent, no context, no callbacks.
pub const fn init_intersect_arguments() -> RTCIntersectArguments {
    RTCIntersectArguments {
        flags: RTC_RAY_QUERY_FLAG_INCOHERENT,
        feature_mask: RTC_FEATURE_FLAG_ALL,
        context: ptr::null_mut(),
        filter: None,
        intersect: None,
    }
}

/// Creates the content that `rtcInitOccludedArguments` writes: incoherent, no context, no callbacks.
pub const fn init_occluded_arguments() -> RTCOccludedArguments {
    RTCOccludedArguments {
        flags: RTC_RAY_QUERY_FLAG_INCOHERENT,
        feature_mask: RTC_FEATURE_FLAG_ALL,
        context: ptr::null_mut(),
        filter: None,
        occluded: None,
    }
}
