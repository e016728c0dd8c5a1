//! The headers of a new file: parts, channels, windows, attributes.

use std::ffi::CString;
use std::path::Path;

use openexr_sys as sys;

use crate::library::check;
use crate::parts::Part;
use crate::{Attribute, Channel, Compression, Error, Image, Placed, SampleType};

/// Declares the parts and writes their headers, each with all attributes; chunks may follow.
///
/// # Safety
/// `context` is open for writing, and nothing was declared in it yet.
pub(crate) unsafe fn write_header(
    path: &Path,
    context: sys::exr_context_t,
    image: &Image<'_>,
    parts: &[Part<'_>],
) -> Result<(), Error> {
    for part in parts {
        // SAFETY: the caller's promise.
        unsafe { add_part(path, context, image, part)? };
    }
    // SAFETY: the caller's promise.
    check(path, "write the header", unsafe { sys::exr_write_header(context) })
}

/// # Safety
/// `context` is open for writing, and its header is not written yet.
unsafe fn add_part(
    path: &Path,
    context: sys::exr_context_t,
    image: &Image<'_>,
    part: &Part<'_>,
) -> Result<(), Error> {
    let name = part.name.as_ref().map(|name| c_string(path, name)).transpose()?;
    let name = name.as_ref().map_or(std::ptr::null(), |name| name.as_ptr());
    let mut number = 0;
    let scanlines = sys::EXR_STORAGE_SCANLINE;
    // SAFETY: the caller's promise; the name is copied, and `number` lives through the call.
    let code = unsafe { sys::exr_add_part(context, name, scanlines, &mut number) };
    check(path, "begin a part", code)?;
    // SAFETY: the caller's promise.
    unsafe { set_windows(path, context, number, image)? };
    for channel in &part.channels {
        // SAFETY: the caller's promise.
        unsafe { add_channel(path, context, number, channel)? };
    }
    for (name, value) in part.attributes.iter() {
        // SAFETY: the caller's promise.
        unsafe { set_attribute(path, context, number, (name, value))? };
    }
    Ok(())
}

/// # Safety
/// `context` is open for writing, and its header is not written yet.
unsafe fn set_windows(
    path: &Path,
    context: sys::exr_context_t,
    part: i32,
    image: &Image<'_>,
) -> Result<(), Error> {
    let window = |[left, top]: [i32; 2], [width, height]: [u32; 2]| {
        // `check_size` saw to it that they fit
        [left, top, left + width as i32 - 1, top + height as i32 - 1]
    };
    let size = [image.width, image.height];
    let Placed { first, picture } = image.placed.unwrap_or(Placed { first: [0, 0], picture: size });
    let (display, data) = (window([0, 0], picture), window(first, size));
    let center = [0.0_f32; 2];
    let compression = compression_code(image.compression);
    let (display, data, center) = (display.as_ptr().cast(), data.as_ptr().cast(), center.as_ptr().cast());
    let order = sys::EXR_LINEORDER_INCREASING_Y;
    // SAFETY: the caller's promise; windows and centre, plain numbers in the order that C declares, live through the call, and
    // are copied.
    let code = unsafe {
        sys::exr_initialize_required_attr(context, part, display, data, 1.0, center, 1.0, order, compression)
    };
    check(path, "set the size", code)
}

fn compression_code(compression: Compression) -> sys::exr_compression_t {
    match compression {
        Compression::None => sys::EXR_COMPRESSION_NONE,
        Compression::Zips => sys::EXR_COMPRESSION_ZIPS,
        Compression::Zip => sys::EXR_COMPRESSION_ZIP,
        Compression::Piz => sys::EXR_COMPRESSION_PIZ,
    }
}

unsafe fn add_channel(
    path: &Path,
    context: sys::exr_context_t,
    part: i32,
    channel: &Channel<'_>,
) -> Result<(), Error> {
    let name = c_string(path, channel.name)?;
    let kind = match channel.stored {
        SampleType::Half => sys::EXR_PIXEL_HALF,
        SampleType::Float => sys::EXR_PIXEL_FLOAT,
        SampleType::Uint => sys::EXR_PIXEL_UINT,
    };
    let perception = sys::EXR_PERCEPTUALLY_LOGARITHMIC; // matters to lossy methods only
    // SAFETY: the context is open for writing (the caller's promise); the name is copied.
    let code = unsafe { sys::exr_add_channel(context, part, name.as_ptr(), kind, perception, 1, 1) };
    check(path, "add a channel", code)
}

/// One call of the library per type; every value is copied by it.
unsafe fn set_attribute(
    path: &Path,
    context: sys::exr_context_t,
    part: i32,
    (name, value): (&str, &Attribute),
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
                sys::exr_attr_set_string(context, part, key, text.as_ptr())
            }
            Attribute::Texts(texts) => {
                let texts: Vec<CString> =
                    texts.iter().map(|text| c_string(path, text)).collect::<Result<_, _>>()?;
                let mut places: Vec<*const std::ffi::c_char> =
                    texts.iter().map(|text| text.as_ptr()).collect();
                let count = texts.len() as i32;
                sys::exr_attr_set_string_vector(context, part, key, count, places.as_mut_ptr())
            }
            Attribute::Float(number) => sys::exr_attr_set_float(context, part, key, *number),
            Attribute::Int(number) => sys::exr_attr_set_int(context, part, key, *number),
            Attribute::Rational { numerator, denominator } => {
                let value = sys::exr_attr_rational_t { num: *numerator, denom: *denominator };
                sys::exr_attr_set_rational(context, part, key, &value)
            }
            Attribute::M44f(m) => sys::exr_attr_set_m44f(context, part, key, &sys::exr_attr_m44f_t { m: *m }),
            Attribute::V2f(value) => {
                sys::exr_attr_set_v2f(context, part, key, std::ptr::from_ref(value).cast())
            }
            Attribute::V2i(value) => {
                sys::exr_attr_set_v2i(context, part, key, std::ptr::from_ref(value).cast())
            }
            Attribute::V3f(value) => {
                sys::exr_attr_set_v3f(context, part, key, std::ptr::from_ref(value).cast())
            }
            Attribute::Chromaticities(value) => {
                let value = std::ptr::from_ref(value).cast();
                sys::exr_attr_set_chromaticities(context, part, key, value)
            }
            Attribute::TimeCode { time_and_flags, user_data } => {
                let (time_and_flags, user_data) = (*time_and_flags, *user_data);
                let value = sys::exr_attr_timecode_t { time_and_flags, user_data };
                sys::exr_attr_set_timecode(context, part, key, &value)
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
