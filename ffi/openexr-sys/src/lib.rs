//! Raw bindings to OpenEXR's C interface (OpenEXRCore), made from the installed headers.
//!
//! Nothing here is safe or convenient: see the crate `afterimage-openexr`. The bindings are made
//! when this crate is built, so structs have the size that the installed library expects, from 3.1.5
//! (Debian 12) over 3.1.13 (Debian 13) on; `tests/layout.rs` compares them with the C compiler's own
//! answer. Bindgen sees no macro that makes a struct: [`context_initializer`] is the Rust form of
//! `EXR_DEFAULT_CONTEXT_INITIALIZER`.

#![allow(missing_docs, non_camel_case_types, reason = "generated; names are C's")]

include!(concat!(env!("OUT_DIR"), "/bindings.rs"));

/// `zip_level` that stands for the library's own default.
pub const DEFAULT_ZIP_LEVEL: std::ffi::c_int = -2;

/// `dwa_quality` that stands for the library's own default.
pub const DEFAULT_DWA_QUALITY: f32 = -1.0;

/// Creates the struct of the C macro `EXR_DEFAULT_CONTEXT_INITIALIZER`: no callbacks, the library's defaults.
///
/// An all-zero struct is no substitute: its `zip_level` of 0 means "store, do not compress", and its
/// `size` of 0 is refused.
#[must_use]
pub fn context_initializer() -> exr_context_initializer_t {
    // SAFETY: every field is an integer, a float, a raw pointer or an `Option` of a function
    // pointer, for all of which zero bytes are a valid value.
    let mut all_zero: exr_context_initializer_t = unsafe { std::mem::zeroed() };
    all_zero.size = size_of::<exr_context_initializer_t>();
    all_zero.zip_level = DEFAULT_ZIP_LEVEL;
    all_zero.dwa_quality = DEFAULT_DWA_QUALITY;
    all_zero
}

/// Creates an empty encode pipeline, as the C macro `EXR_ENCODE_PIPELINE_INITIALIZER` does.
#[must_use]
pub fn encode_pipeline() -> exr_encode_pipeline_t {
    // SAFETY: integers, raw pointers and `Option`s of function pointers; zero bytes are valid.
    unsafe { std::mem::zeroed() }
}

/// Creates an empty decode pipeline, as the C macro `EXR_DECODE_PIPELINE_INITIALIZER` does.
#[must_use]
pub fn decode_pipeline() -> exr_decode_pipeline_t {
    // SAFETY: integers, raw pointers and `Option`s of function pointers; zero bytes are valid.
    unsafe { std::mem::zeroed() }
}
