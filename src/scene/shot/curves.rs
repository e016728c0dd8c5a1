//! Curves of a shot file.

use std::path::Path;

use glam::Vec2;

use super::shapes::{numbered_files, times};
use crate::animation::ShapeTrack;

use crate::scene::import::Import;
use crate::scene::import::curves::{self, CurveSet, CurveShape};
use crate::scene::import::npy;
use crate::scene::keys::curves::{Counts, CurvesTable};
use crate::scene::keys::shapes::ShapesTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::keys::values::{file_of, file_of_text};
use crate::scene::{Mesh, SceneError};

use super::quadric::material_named;

/// Reads the mesh of the curves that `table` names, object space, and the times of its `shapes`, if it deforms.
///
/// # Errors With line and column: values that make no sense, or a material that is not there. With its file: curves that cannot be read, or are
/// no shape of the others.
pub fn of_table(
    text: TomlText<'_>,
    (table, shapes): (&At<CurvesTable>, Option<&At<ShapesTable>>),
    path: &Path,
    import: &mut Import,
) -> Result<(Mesh, Option<ShapeTrack>), SceneError> {
    let keys = table.get_ref();
    let is_radius = |radius: f64| (0.0..=1e9).contains(&radius);
    let radius = |key, value: &Option<At<f64>>| {
        let read = |value| text.number(key, value, "a length from 0 to 1e9", is_radius);
        value.as_ref().map(read).transpose()
    };
    let (first, last) = (radius("radius", &keys.radius)?, radius("tip", &keys.tip)?);
    if let (None, Some(tip)) = (first, &keys.tip) {
        return Err(text.bad("tip", tip, "goes with `radius`, that of the first points"));
    }
    let radii = first.map(|first| [first, last.unwrap_or(first)].map(|radius| radius as f32));
    let is_length = |length: f64| (1e-9..=1e9).contains(&length);
    let tolerance = keys.tolerance.as_ref();
    let tolerance = tolerance
        .map(|off| text.number("tolerance", off, "a length from 1e-9 to 1e9", is_length))
        .transpose()?;
    let mut set = if is_array(path) {
        of_array(text, table, path, radii, import)?
    } else {
        let of_arrays = [
            ("counts", keys.counts.as_ref().map(At::span)),
            ("uvs", keys.uvs.as_ref().map(At::span)),
            ("normals", keys.normals.as_ref().map(At::span)),
        ];
        if let Some((key, span)) = of_arrays.into_iter().find_map(|(key, span)| Some((key, span?))) {
            return Err(text.fault(span, format!("`{key}` goes with an array of points (.npy): take it out")));
        }
        let basis = keys.basis.as_ref().map(|basis| *basis.get_ref());
        let (set, digest) = curves::read(path, basis, radii)?;
        import.inputs.add([path.to_path_buf()], digest);
        set
    };
    let material = material_named(text, table.span(), keys.material.as_ref(), import)?;
    let again =
        shapes.map(|shapes| read_shapes(text, shapes, (&mut set, radii), import)).transpose()?.flatten();
    curves::mesh_of(import, path, &set, (tolerance, again), material)
}

fn is_array(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy"))
}

/// Reads the shapes of a set from the files that `table` names. Returns after how many frames the first one comes again, if it does.
fn read_shapes(
    text: TomlText<'_>,
    table: &At<ShapesTable>,
    (set, radii): (&mut CurveSet, Option<[f32; 2]>),
    import: &mut Import,
) -> Result<Option<f64>, SceneError> {
    let ShapesTable { obj, cache, curves, first, every, repeat } = table.get_ref();
    if let Some((key, span)) = [("obj", obj), ("cache", cache)]
        .into_iter()
        .find_map(|(key, value)| Some((key, value.as_ref()?.span())))
    {
        return Err(text.fault(span, format!("`{key}` is for shapes of meshes: take it out")));
    }
    let Some(curves) = curves else {
        return Err(text.fault(table.span(), "`shapes`: the key `curves` is missing, a name of files"));
    };
    let (first, every) = times(text, (first.as_ref(), every.as_ref()))?;
    let files = numbered_files(text, ("curves", "hair.####.npy"), curves)?;
    let begin = files[0].number as f64;
    let (first, every) = (first.unwrap_or(begin), every.unwrap_or(1.0));
    for file in &files {
        let (points, radii) = points_of(&file.path, (set, radii), import)?;
        let frame = first + (file.number as f64 - begin) * every;
        set.shapes.push(CurveShape { frame, points, radii, normals: Vec::new() });
    }
    (set.points, set.radii) = (set.shapes[0].points.clone(), set.shapes[0].radii.clone());
    Ok(repeat.then_some(every))
}

/// Points and radii of a shape of curves. Points without radii have those that the curves have at rest.
fn points_of(
    path: &Path,
    (set, radii): (&CurveSet, Option<[f32; 2]>),
    import: &mut Import,
) -> Result<(Vec<[f32; 3]>, Vec<f32>), SceneError> {
    let (points, radii) = if is_array(path) {
        let array = npy::read(path)?;
        let [_, width @ (3 | 4)] = array.shape[..] else {
            let shape = &array.shape;
            let what =
                format!("the array's shape is {shape:?}: it must be (points, 3), or (points, 4) with radii");
            return Err(SceneError::new(path, what));
        };
        import.inputs.add([path.to_path_buf()], array.digest);
        let all = array.values.chunks_exact(width);
        let points: Vec<[f32; 3]> =
            all.clone().map(|point| [point[0], point[1], point[2]].map(|value| value as f32)).collect();
        let radii: Vec<f32> = all.filter_map(|point| point.get(3)).map(|radius| *radius as f32).collect();
        (points, if width == 3 { set.radii.clone() } else { radii })
    } else {
        let (other, digest) = curves::read(path, Some(set.basis), radii)?;
        import.inputs.add([path.to_path_buf()], digest);
        if other.counts != set.counts {
            return Err(SceneError::new(path, "its curves have other numbers of points than those at rest"));
        }
        (other.points, other.radii)
    };
    if points.len() != set.points.len() {
        let what = format!(
            "it has {} points, and the curves at rest have {}: shapes have as many",
            points.len(),
            set.points.len()
        );
        return Err(SceneError::new(path, what));
    }
    Ok((points, radii))
}

/// Path of the file that `table` names.
///
/// # Errors If it is not there.
pub fn path_of(text: TomlText<'_>, table: &At<CurvesTable>) -> Result<std::path::PathBuf, SceneError> {
    file_of(text, "file", &table.get_ref().file)
}

fn of_array(
    text: TomlText<'_>,
    table: &At<CurvesTable>,
    path: &Path,
    radii: Option<[f32; 2]>,
    import: &mut Import,
) -> Result<CurveSet, SceneError> {
    let keys = table.get_ref();
    let wrong = |what: String| SceneError::new(path, what);
    let array = npy::read(path)?;
    let [count, width @ (3 | 4)] = array.shape[..] else {
        let shape = &array.shape;
        return Err(wrong(format!(
            "the array's shape is {shape:?}: it must be (points, 3), or (points, 4) with radii"
        )));
    };
    import.inputs.add([path.to_path_buf()], array.digest);
    let Some(counts) = &keys.counts else {
        return Err(
            text.fault(table.span(), "the key `counts` is missing: an array does not say where curves begin")
        );
    };
    let counts = match counts.get_ref() {
        Counts::Same(same) => {
            if *same == 0 || count % *same as usize != 0 {
                let message = format!(
                    "`counts` is {same}, and the array has {count} points: they are no curves of so many points each"
                );
                return Err(text.fault(counts.span(), message));
            }
            vec![*same; count / *same as usize]
        }
        Counts::File(file) => counts_at(&file_of_text(text, "counts", (file, counts.span()))?, import)?,
    };
    let uvs = keys.uvs.as_ref().map(|uvs| uvs_at(&file_of(text, "uvs", uvs)?, import)).transpose()?;
    let normals = keys
        .normals
        .as_ref()
        .map(|normals| normals_at(&file_of(text, "normals", normals)?, import))
        .transpose()?;
    let mut set = CurveSet {
        counts,
        normals: normals.unwrap_or_default(),
        uvs: uvs.unwrap_or_default(),
        basis: keys.basis.as_ref().map(|basis| *basis.get_ref()).unwrap_or_default(),
        ..CurveSet::default()
    };
    for point in array.values.chunks_exact(width) {
        set.points.push([point[0], point[1], point[2]].map(|value| value as f32));
        set.radii.extend(point.get(3).map(|radius| *radius as f32));
    }
    if width == 3 {
        let Some([first, last]) = radii else {
            return Err(
                text.fault(table.span(), "the key `radius` is missing: the array has none (points x 4)")
            );
        };
        for count in &set.counts {
            let share = |at: u32| if *count > 1 { at as f32 / (count - 1) as f32 } else { 0.0 };
            set.radii.extend((0..*count).map(|at| first + (last - first) * share(at)));
        }
    }
    Ok(set)
}

fn uvs_at(path: &Path, import: &mut Import) -> Result<Vec<Vec2>, SceneError> {
    let array = npy::read(path)?;
    import.inputs.add([path.to_path_buf()], array.digest);
    let uvs: Vec<Vec2> =
        array.values.chunks_exact(2).map(|uv| Vec2::new(uv[0] as f32, uv[1] as f32)).collect();
    match array.shape[..] {
        [_, 2] if uvs.iter().all(|uv| uv.is_finite()) => Ok(uvs),
        _ => Err(SceneError::new(
            path,
            "texture coordinates must be two finite numbers a curve: an array of curves x 2",
        )),
    }
}

fn normals_at(path: &Path, import: &mut Import) -> Result<Vec<[f32; 3]>, SceneError> {
    let array = npy::read(path)?;
    import.inputs.add([path.to_path_buf()], array.digest);
    let normals: Vec<[f32; 3]> = array
        .values
        .chunks_exact(3)
        .map(|normal| [normal[0], normal[1], normal[2]].map(|part| part as f32))
        .collect();
    match array.shape[..] {
        [_, 3] if normals.as_flattened().iter().all(|part| part.is_finite()) => Ok(normals),
        _ => {
            Err(SceneError::new(path, "normals must be three finite numbers a point: an array of points x 3"))
        }
    }
}

fn counts_at(path: &Path, import: &mut Import) -> Result<Vec<u32>, SceneError> {
    let array = npy::read(path)?;
    import.inputs.add([path.to_path_buf()], array.digest);
    let count = |value: &f64| {
        let whole = value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(value);
        whole.then_some(*value as u32)
    };
    let counts: Option<Vec<u32>> = array.values.iter().map(count).collect();
    match (array.shape.len(), counts) {
        (1, Some(counts)) => Ok(counts),
        _ => Err(SceneError::new(path, "the counts must be whole numbers, one a curve")),
    }
}
