//! Reads the shapes of a deforming model from their files: its mesh, and the times of the shapes.

use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;

use super::readers::Readers;
use crate::animation::ShapeTrack;
use crate::scene::import::meshes::shape_files::{Numbered, ReadShapes, ShapeSource};
use crate::scene::keys::shapes::ShapesTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::file_of;
use crate::scene::{Mesh, SceneError};

/// Largest number in a name: it is exact as a time.
const MOST_NUMBER: i64 = 1 << 53;

/// Range of the frames from a shape's number to the next one, or from key to key.
pub const STEPS: RangeInclusive<f64> = 1e-6..=1e6;

/// Reads the mesh of the OBJ file at `path` with the shapes that `table` names, and the times of the shapes.
///
/// # Errors With line and column: no such files, or values that make no sense. With its file: a shape that is
/// no shape of the mesh.
pub fn of_table(
    text: TomlText<'_>,
    table: &At<ShapesTable>,
    path: &Path,
    readers: &mut Readers,
) -> Result<(Arc<Mesh>, ShapeTrack), SceneError> {
    let ShapesTable { obj, cache, curves, first, every, repeat } = table.get_ref();
    if let Some(curves) = curves {
        return Err(text.bad("curves", curves, "in `shapes` goes with `curves` of the model: take it out"));
    }
    let source = match (obj, cache) {
        (Some(obj), None) => ShapeSource::Files(numbered_files(text, ("obj", "flag.####.obj"), obj)?),
        (None, Some(cache)) => ShapeSource::Cache(file_of(text, "cache", cache)?),
        (None, None) => {
            let message =
                "`shapes`: the key `obj` is missing: shapes are OBJ files, or a point cache (`cache`)";
            return Err(text.fault(table.span(), message));
        }
        (Some(_), Some(cache)) => {
            return Err(text.bad("cache", cache, "and `obj` exclude each other: take one of them out"));
        }
    };
    let (first, every) = times(text, (first.as_ref(), every.as_ref()))?;
    let ReadShapes { mesh, keys, says, .. } = readers.meshes.deforming(&mut readers.import, path, source)?;
    let (begins, _) = keys[0];
    let (says_first, says_every) = says.unwrap_or((begins, 1.0));
    let (first, every) = (first.unwrap_or(says_first), every.unwrap_or(says_every));
    if !STEPS.contains(&every) {
        let message =
            format!("`shapes`: the cache has a sample every {every} frames; say `every`, from 1e-6 to 1e6");
        return Err(text.fault(table.span(), message));
    }
    let frames = keys.iter().map(|(time, number)| (first + (time - begins) * every, *number));
    let track = ShapeTrack::through(frames.collect(), repeat.then_some(every));
    let track =
        track.ok_or_else(|| text.fault(table.span(), "`shapes`: the numbers of frames are too large"))?;
    Ok((mesh, track))
}

/// The frame of the first shape, and the frames from one to the next, where a table states them.
pub fn times(
    text: TomlText<'_>,
    (first, every): (Option<&At<f64>>, Option<&At<f64>>),
) -> Result<(Option<f64>, Option<f64>), SceneError> {
    let every = every
        .map(|every| text.number("every", every, "from 1e-6 to 1e6 frames", |every| STEPS.contains(&every)));
    let first = first.map(|first| {
        text.number("first", first, "a frame's number", |first| first.abs() <= f64::from(i32::MAX))
    });
    Ok((first.transpose()?, every.transpose()?))
}

/// Finds the files that a name with `#` for digits means, in the order of their numbers.
pub fn numbered_files(
    text: TomlText<'_>,
    (key, example): (&str, &str),
    name: &At<String>,
) -> Result<Vec<Numbered>, SceneError> {
    let bad = |message: &str| text.bad(key, name, message);
    let slashed = name.get_ref().replace('\\', "/");
    let (folder, pattern) = slashed.rsplit_once('/').unwrap_or(("", &slashed));
    let digits = pattern.bytes().filter(|byte| *byte == b'#').count();
    let Some((before, after)) = pattern.split_once(&"#".repeat(digits)).filter(|_| digits > 0) else {
        return Err(bad(&format!(
            "must have one group of `#` in the file's name, where the numbers are: \"{example}\""
        )));
    };
    let folder = text.path.parent().unwrap_or(Path::new("")).join(folder);
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
    let entries = here.read_dir().map_err(|error| {
        bad(&format!(
            "is in `{}`, which cannot be read: {error}; paths are relative to the shot file",
            here.display()
        ))
    })?;
    let numbered = |file: String| {
        let number = file.strip_prefix(before)?.strip_suffix(after)?;
        Some(Numbered { number: number_of(number, digits)?, path: folder.join(file) })
    };
    let names = entries.filter_map(Result::ok).filter_map(|entry| entry.file_name().into_string().ok());
    let mut files: Vec<Numbered> = names.filter_map(numbered).collect();
    files.sort_by_key(|file| file.number);
    // programs count the sign of a negative number as a digit, or not
    if let Some(pair) = files.windows(2).find(|pair| pair[0].number == pair[1].number) {
        let [one, other] =
            [0, 1].map(|i| pair[i].path.file_name().unwrap_or_default().to_string_lossy().into_owned());
        let number = pair[0].number;
        return Err(bad(&format!(
            "means two files with the number {number}, `{one}` and `{other}`: take one of them away"
        )));
    }
    if files.is_empty() {
        let wanted = format!("{before}{:0digits$}{after}", 1);
        return Err(bad(&format!(
            "means no file in `{}`: `#` stands for a digit, as in `{wanted}`; paths are relative to the shot file",
            here.display()
        )));
    }
    Ok(files)
}

/// Number that a name states with so many `digits`: as wide as that, or wider without zeros in front, so that no two files have one
/// number. The sign of a negative one may take the place of a digit.
fn number_of(text: &str, digits: usize) -> Option<i64> {
    let of_digits = |text: &str, widths: &[usize]| {
        let is_whole = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let is_wider = text.len() > digits && !text.starts_with('0');
        let number = text.parse().ok().filter(|_| is_whole && (widths.contains(&text.len()) || is_wider));
        number.filter(|number: &i64| *number <= MOST_NUMBER)
    };
    match text.strip_prefix('-') {
        Some(text) => of_digits(text, &[digits, digits.saturating_sub(1)])
            .filter(|number| *number > 0)
            .map(|number| -number),
        None => of_digits(text, &[digits]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_wide_as_the_pattern_or_wider() {
        for (text, number) in [("0007", 7), ("0000", 0), ("12345", 12345), ("-010", -10), ("-0010", -10)] {
            assert_eq!(number_of(text, 4), Some(number), "{text}");
        }
        assert_eq!(
            [number_of("-3", 1), number_of("-12", 1), number_of("-12", 2)],
            [Some(-3), Some(-12), Some(-12)]
        );
        for text in ["7", "00007", "-10", "-00010", "--10", "-0000", "", "-", "1-23", "99999999999999999999"]
        {
            assert_eq!(number_of(text, 4), None, "{text}");
        }
    }
}
