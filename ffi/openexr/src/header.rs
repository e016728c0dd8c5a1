//! The header of a new file: channels, windows, attributes.

use std::ffi::CString;
use std::path::Path;

use openexr_sys as sys;

use crate::library::check;
use crate::{Attribute, Channel, Compression, Error, Image, SampleType};

/// This crate writes one part.
pub(crate) const PART: i32 = 0;

/// Declares the part and writes the header; chunks may follow.
///
/// # Safety
/// `context` is open for writing, and nothing was declared in it yet.
pub(crate) unsafe fn write_header(
    path: &Path,
    context: sys::exr_context_t,
    image: &Image<'_>,
    channels: &[Channel<'_>],
) -> Result<(), Error> {
    let mut part = PART;
    let scanlines = sys::EXR_STORAGE_SCANLINE;
    // SAFETY: the caller's promise; a part needs no name, and `part` lives through the call.
    let code = unsafe { sys::exr_add_part(context, std::ptr::null(), scanlines, &mut part) };
    check(path, "begin the part", code)?;
    let (width, height) = (image.width as i32, image.height as i32); // `check_size` saw to it
    let compression = compression_code(image.compression);
    // SAFETY: the caller's promise.
    let code = unsafe { sys::exr_initialize_required_attr_simple(context, PART, width, height, compression) };
    check(path, "set the size", code)?;
    for channel in channels {
        // SAFETY: the caller's promise.
        unsafe { add_channel(path, context, channel)? };
    }
    for (name, value) in &image.attributes {
        // SAFETY: the caller's promise.
        unsafe { set_attribute(path, context, name, value)? };
    }
    // SAFETY: the caller's promise.
    check(path, "write the header", unsafe { sys::exr_write_header(context) })
}

fn compression_code(compression: Compression) -> sys::exr_compression_t {
    match compression {
        Compression::None => sys::EXR_COMPRESSION_NONE,
        Compression::Zips => sys::EXR_COMPRESSION_ZIPS,
        Compression::Zip => sys::EXR_COMPRESSION_ZIP,
        Compression::Piz => sys::EXR_COMPRESSION_PIZ,
    }
}

unsafe fn add_channel(path: &Path, context: sys::exr_context_t, channel: &Channel<'_>) -> Result<(), Error> {
    let name = c_string(path, channel.name)?;
    let kind = match channel.stored {
        SampleType::Half => sys::EXR_PIXEL_HALF,
        SampleType::Float => sys::EXR_PIXEL_FLOAT,
        SampleType::Uint => sys::EXR_PIXEL_UINT,
    };
    let perception = sys::EXR_PERCEPTUALLY_LOGARITHMIC; // matters to lossy methods only
    // SAFETY: the context is open for writing (the caller's promise); the name is copied.
    let code = unsafe { sys::exr_add_channel(context, PART, name.as_ptr(), kind, perception, 1, 1) };
    check(path, "add a channel", code)
}

/// One call of the library per type; every value is copied by it.
unsafe fn set_attribute(
    path: &Path,
    context: sys::exr_context_t,
    name: &str,
    value: &Attribute,
) -> Result<(), Error> {
    if let Some(fault) = crate::check::fault_of_name(name) {
        return Err(Error::image(path, format!("attribute {name:?}: {fault}")));
    }
    let name_in_c = c_string(path, name)?;
    let key = name_in_c.as_ptr();
    // SAFETY: the context is open for writing (the caller's promise); key and values live through
    // the calls, and the packed structs are plain numbers in the order that C declares.
    let code = unsafe {
        match value {
            Attribute::Text(text) => {
                let text = c_string(path, text)?;
                sys::exr_attr_set_string(context, PART, key, text.as_ptr())
            }
            Attribute::Float(number) => sys::exr_attr_set_float(context, PART, key, *number),
            Attribute::Int(number) => sys::exr_attr_set_int(context, PART, key, *number),
            Attribute::Rational { numerator, denominator } => {
                let value = sys::exr_attr_rational_t { num: *numerator, denom: *denominator };
                sys::exr_attr_set_rational(context, PART, key, &value)
            }
            Attribute::M44f(m) => sys::exr_attr_set_m44f(context, PART, key, &sys::exr_attr_m44f_t { m: *m }),
            Attribute::V2f(value) => {
                sys::exr_attr_set_v2f(context, PART, key, std::ptr::from_ref(value).cast())
            }
            Attribute::V2i(value) => {
                sys::exr_attr_set_v2i(context, PART, key, std::ptr::from_ref(value).cast())
            }
            Attribute::V3f(value) => {
                sys::exr_attr_set_v3f(context, PART, key, std::ptr::from_ref(value).cast())
            }
            Attribute::Chromaticities(value) => {
                let value = std::ptr::from_ref(value).cast();
                sys::exr_attr_set_chromaticities(context, PART, key, value)
            }
            Attribute::TimeCode { time_and_flags, user_data } => {
                let (time_and_flags, user_data) = (*time_and_flags, *user_data);
                let value = sys::exr_attr_timecode_t { time_and_flags, user_data };
                sys::exr_attr_set_timecode(context, PART, key, &value)
            }
            Attribute::Other(kind) => {
                let what = format!("attribute {name:?}: type {kind:?} cannot be written");
                return Err(Error::image(path, what));
            }
        }
    };
    check(path, "set an attribute", code)
}

fn c_string(path: &Path, text: &str) -> Result<CString, Error> {
    CString::new(text).map_err(|_| Error::image(path, format!("{text:?} holds a zero byte")))
}
