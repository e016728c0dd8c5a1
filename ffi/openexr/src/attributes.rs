//! The header's values, as read from a file.

use std::path::Path;

use openexr_sys as sys;

use crate::c_text::text;
use crate::library::{Context, check};
use crate::{Attribute, Error};

/// Names of attributes that every file has; they describe the file rather than the picture.
const STRUCTURAL: [&str; 12] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "lineOrder",
    "name",
    "pixelAspectRatio",
    "screenWindowCenter",
    "screenWindowWidth",
    "type",
    "version",
];

/// Reads all attributes but the structural ones, in the file's order.
pub(crate) fn read_attributes(
    path: &Path,
    context: &Context<'_>,
    part: i32,
) -> Result<Vec<(String, Attribute)>, Error> {
    const DOING: &str = "read the attributes";
    let mut count = 0;
    // SAFETY: the context is open, and the place for the answer lives through the call.
    let code = unsafe { sys::exr_get_attribute_count(context.raw(), part, &mut count) };
    check(path, DOING, code)?;
    let mut attributes = Vec::new();
    for index in 0..count {
        let mut found: *const sys::exr_attribute_t = std::ptr::null();
        let order = sys::EXR_ATTR_LIST_FILE_ORDER;
        // SAFETY: as above; the attribute belongs to the context.
        let attribute = unsafe {
            let raw = context.raw();
            let code = sys::exr_get_attribute_by_index(raw, part, order, index, &mut found);
            check(path, DOING, code)?;
            found.as_ref()
        };
        let Some(attribute) = attribute else { continue };
        // SAFETY: the library's names end with a zero.
        let name = unsafe { text(attribute.name) };
        if !STRUCTURAL.contains(&name.as_str()) {
            // SAFETY: an attribute of an open context.
            attributes.push((name, unsafe { value(attribute) }));
        }
    }
    Ok(attributes)
}

/// # Safety
/// The attribute belongs to an open context, so that its union holds what its type says.
unsafe fn value(attribute: &sys::exr_attribute_t) -> Attribute {
    let union = &attribute.__bindgen_anon_1;
    // SAFETY: the caller's promise. The packed structs are plain numbers, which may lie unaligned.
    unsafe {
        match attribute.type_ {
            sys::EXR_ATTR_STRING => Attribute::Text(text((*union.string).str_)),
            sys::EXR_ATTR_STRING_VECTOR => Attribute::Texts(texts(&*union.stringvector)),
            sys::EXR_ATTR_FLOAT => Attribute::Float(union.f),
            sys::EXR_ATTR_INT => Attribute::Int(union.i),
            sys::EXR_ATTR_RATIONAL => {
                let sys::exr_attr_rational_t { num, denom } = *union.rational;
                Attribute::Rational { numerator: num, denominator: denom }
            }
            sys::EXR_ATTR_M44F => Attribute::M44f((*union.m44f).m),
            sys::EXR_ATTR_V2F => Attribute::V2f(union.v2f.cast::<[f32; 2]>().read_unaligned()),
            sys::EXR_ATTR_V2I => Attribute::V2i(union.v2i.cast::<[i32; 2]>().read_unaligned()),
            sys::EXR_ATTR_V3F => Attribute::V3f(union.v3f.cast::<[f32; 3]>().read_unaligned()),
            sys::EXR_ATTR_CHROMATICITIES => {
                let numbers = union.chromaticities.cast::<[f32; 8]>();
                Attribute::Chromaticities(numbers.read_unaligned())
            }
            sys::EXR_ATTR_TIMECODE => {
                let sys::exr_attr_timecode_t { time_and_flags, user_data } = *union.timecode;
                Attribute::TimeCode { time_and_flags, user_data }
            }
            _ => Attribute::Other(text(attribute.type_name)),
        }
    }
}

/// # Safety
/// The list belongs to an open context: it has as many strings as it says.
unsafe fn texts(list: &sys::exr_attr_string_vector_t) -> Vec<String> {
    let count = usize::try_from(list.n_strings).unwrap_or(0);
    if list.strings.is_null() {
        return Vec::new();
    }
    // SAFETY: the caller's promise.
    let strings = unsafe { std::slice::from_raw_parts(list.strings, count) };
    // SAFETY: the library's strings end with a zero.
    strings.iter().map(|string| unsafe { text(string.str_) }).collect()
}
