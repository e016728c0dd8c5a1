//! Reads arrays as NumPy writes them (`numpy.save`): files of numbers that are too many for text.
//!
//! Source of the format: `numpy.lib.format` in NumPy's documentation, versions 1 to 3.

use std::path::Path;

use crate::digest::Digest;
use crate::input::{self, InputError, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::SceneError;

/// First bytes of a file.
const MARK: &[u8] = b"\x93NUMPY";

/// What to do with a file that is not read.
const SAVE: &str = "save it with numpy.save(file, numpy.ascontiguousarray(array, \"<f8\"))";

/// An array of numbers.
#[derive(Debug, PartialEq)]
pub struct Array {
    /// Extent along each axis; the last one is that along which neighbours in `values` lie.
    pub shape: Vec<usize>,
    /// As many as the product of the extents; perhaps not finite.
    pub values: Vec<f64>,
    /// Digest of the file.
    pub digest: Digest,
}

/// Reads the array at `path`.
///
/// # Errors
/// Where it cannot be read, is none, has other things than floating-point numbers, or is not as long as it says.
pub fn read(path: &Path) -> Result<Array, SceneError> {
    let unreadable = |error: InputError| SceneError::new(path, format!("the array cannot be read: {error}"));
    let input = input::open(path, Kind::Array).map_err(unreadable)?;
    // the text of it, and what is read of it, which may be twice as wide
    let need = Need::new(Part::new("the array", input.length.saturating_mul(3), "fewer copies, fewer keys"));
    need.check(&memory::left()).map_err(|error| SceneError::new(path, error.to_string()))?;
    let bytes = input.read_all().map_err(unreadable)?;
    of_bytes(&bytes).map_err(|message| SceneError::new(path, message))
}

fn of_bytes(bytes: &[u8]) -> Result<Array, String> {
    let none = || format!("this is no array of NumPy's (.npy): {SAVE}");
    let (header, content) = divided(bytes).ok_or_else(none)?;
    let (kind, order, shape) =
        (entry(header, "descr"), entry(header, "fortran_order"), entry(header, "shape"));
    let (Some(kind), Some(order), Some(shape)) = (kind.and_then(quoted), order, shape.and_then(extents))
    else {
        return Err(none());
    };
    if order.starts_with("True") && shape.len() > 1 {
        return Err(format!("the array is stored column by column: {SAVE}"));
    }
    let (width, number): (usize, fn(&[u8]) -> f64) = match kind {
        "<f8" => (8, |bytes| f64::from_le_bytes(bytes.try_into().expect("eight bytes"))),
        "<f4" => (4, |bytes| f64::from(f32::from_le_bytes(bytes.try_into().expect("four bytes")))),
        _ => {
            return Err(format!(
                "the array has elements of the type `{kind}`, and must have numbers `<f8` or `<f4`: {SAVE}"
            ));
        }
    };
    let count = shape.iter().try_fold(width, |bytes, extent| bytes.checked_mul(*extent));
    if count != Some(content.len()) {
        return Err(format!(
            "the array says that its shape is {shape:?} with numbers of {width} bytes, and it has {} bytes of them: it is cut off, or damaged; save it again",
            content.len()
        ));
    }
    let values = content.chunks_exact(width).map(number).collect();
    Ok(Array { shape, values, digest: Digest::new(bytes) })
}

/// Divides a file into the text that describes it and its elements.
fn divided(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let after = bytes.strip_prefix(MARK)?;
    let (version, after) = after.split_at_checked(2)?;
    let (length, after) = match version[0] {
        1 => after
            .split_first_chunk()
            .map(|(length, after)| (u32::from(u16::from_le_bytes(*length)), after))?,
        2 | 3 => after.split_first_chunk().map(|(length, after)| (u32::from_le_bytes(*length), after))?,
        _ => return None,
    };
    let (header, content) = after.split_at_checked(usize::try_from(length).ok()?)?;
    Some((std::str::from_utf8(header).ok()?, content))
}

/// What stands behind a key of the description, which is a dictionary as Python writes it.
fn entry<'t>(header: &'t str, key: &str) -> Option<&'t str> {
    let (_, after) = header.split_once(&format!("'{key}'"))?;
    after.trim_start().strip_prefix(':').map(str::trim_start)
}

/// The text within the quotes with which `text` begins.
fn quoted(text: &str) -> Option<&str> {
    text.strip_prefix('\'')?.split_once('\'').map(|(inner, _)| inner)
}

/// The numbers of the tuple with which `text` begins.
fn extents(text: &str) -> Option<Vec<usize>> {
    let (inner, _) = text.strip_prefix('(')?.split_once(')')?;
    let numbers = inner.split(',').map(str::trim).filter(|number| !number.is_empty());
    numbers.map(|number| number.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of this description and content.
    fn file(version: u8, header: &str, content: &[u8]) -> Vec<u8> {
        let length = header.len() as u32;
        let length =
            if version == 1 { (length as u16).to_le_bytes().to_vec() } else { length.to_le_bytes().to_vec() };
        [MARK, &[version, 0], &length, header.as_bytes(), content].concat()
    }

    #[test]
    fn what_numpy_writes_is_read() {
        let values = [1.5, -2.0, 3.0, 0.0, 0.25, 1e30];
        let doubles: Vec<u8> = values.iter().flat_map(|value: &f64| value.to_le_bytes()).collect();
        let singles: Vec<u8> = values.iter().flat_map(|value| (*value as f32).to_le_bytes()).collect();
        let header =
            |kind: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (2, 3), }}   \n");
        for version in 1..=3 {
            let read = of_bytes(&file(version, &header("<f8"), &doubles)).expect("an array");
            assert_eq!((&read.shape[..], &read.values[..]), (&[2, 3][..], &values[..]));
        }
        let read = of_bytes(&file(1, &header("<f4"), &singles)).expect("an array");
        assert_eq!(read.values, values.map(|value| f64::from(value as f32)));
        let one = "{'descr': '<f8', 'fortran_order': True, 'shape': (6,), }";
        assert_eq!(of_bytes(&file(1, one, &doubles)).expect("an array").shape, [6]);
        let none = "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 3, 4), }";
        assert!(of_bytes(&file(1, none, &[])).expect("an array").values.is_empty());
    }

    #[test]
    fn what_is_no_array_of_numbers_is_refused_with_what_to_do() {
        let header = |kind: &str, order: &str, shape: &str| {
            format!("{{'descr': {kind}, 'fortran_order': {order}, 'shape': {shape}, }}")
        };
        for (bytes, part) in [
            (Vec::new(), "no array"),
            (b"PK\x03\x04 an archive".to_vec(), "no array"),
            (MARK.to_vec(), "no array"),
            (file(4, "", &[]), "no array"),
            (file(1, "{}", &[]), "no array"),
            (file(1, &header("'<f8'", "False", "(-1,)"), &[]), "no array"),
            (file(1, &header("[('x', '<f8')]", "False", "(1,)"), &[0; 8]), "no array"),
            (file(1, &header("'<i8'", "False", "(1,)"), &[0; 8]), "`<i8`"),
            (file(1, &header("'|O'", "False", "(1,)"), &[0; 8]), "`|O`"),
            (file(1, &header("'<f8'", "True", "(1, 2)"), &[0; 16]), "column by column"),
            (file(1, &header("'<f8'", "False", "(3,)"), &[0; 16]), "cut off"),
            (file(1, &header("'<f8'", "False", "(9223372036854775807, 4)"), &[0; 16]), "cut off"),
        ] {
            let error = of_bytes(&bytes).expect_err("no array");
            assert!(error.contains(part) && error.contains("save it"), "{error}");
        }
        let whole = file(1, &header("'<f8'", "False", "(2,)"), &[0; 16]);
        for length in 0..whole.len() {
            assert!(of_bytes(&whole[..length]).is_err(), "{length}");
        }
    }
}
