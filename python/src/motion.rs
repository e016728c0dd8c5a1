//! Values that may change with the frame: one value, or a dict from frames to values.

use glam::{DAffine3, DMat4};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toml::{Table, Value};

use crate::arrays;
use crate::errors::error;
use crate::keys;

/// Reads a dict from frames to values, in the order of the frames.
pub fn by_frame<'py>(dict: &Bound<'py, PyDict>, what: &str) -> PyResult<Vec<(f64, Bound<'py, PyAny>)>> {
    let mut all = Vec::with_capacity(dict.len());
    // reading a key may call functions of the caller, which may change the dict: its values are those of now
    for (frame, value) in &dict.copy()? {
        let frame = frame.extract::<f64>().ok().filter(|frame| frame.is_finite());
        let frame = frame
            .ok_or_else(|| error(format!("`{what}`: the keys of the dict must be numbers of frames")))?;
        all.push((frame, value));
    }
    if all.is_empty() {
        return Err(error(format!("`{what}` is an empty dict: give it one frame at least")));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(all)
}

/// Reads a 4 x 4 matrix, or one by frame; without any the identity.
pub fn places(object: Option<&Bound<'_, PyAny>>, what: &str) -> PyResult<Vec<(f64, DAffine3)>> {
    let place = |object: &Bound<'_, PyAny>, what: &str| {
        let rows = arrays::matrix(object, what)?;
        Ok::<_, PyErr>(DAffine3::from_mat4(DMat4::from_cols_array_2d(&rows).transpose()))
    };
    match object {
        None => Ok(vec![(1.0, DAffine3::IDENTITY)]),
        Some(object) => match object.cast::<PyDict>() {
            Ok(dict) => {
                let all = by_frame(dict, what)?.into_iter();
                all.map(|(frame, object)| Ok((frame, place(&object, &format!("{what}[{frame}]"))?))).collect()
            }
            Err(_) => Ok(vec![(1.0, place(object, what)?)]),
        },
    }
}

/// Reads visibility of a model: that before the first frame, and those from frames on.
pub fn visible(object: &Bound<'_, PyAny>, of: &str) -> PyResult<(bool, Vec<(f64, bool)>)> {
    let said = |object: &Bound<'_, PyAny>| {
        object.extract::<bool>().map_err(|_| {
            error(format!("`visible` of `{of}` must be True or False, or a dict from frames to these"))
        })
    };
    match object.cast::<PyDict>() {
        Ok(dict) => {
            let all = by_frame(dict, &format!("visible of `{of}`"))?;
            let all: Vec<(f64, bool)> =
                all.iter().map(|(frame, object)| Ok((*frame, said(object)?))).collect::<PyResult<_>>()?;
            Ok((all[0].1, all))
        }
        Err(_) => Ok((said(object)?, Vec::new())),
    }
}

/// Makes the key tables of a camera or a light: of `transform`, of `keys` by frame, and of `values` that all of them share.
/// `of_place` writes the keys of a place. One table without a frame's number if nothing is stated by frame.
pub fn key_tables(
    transform: Option<&Bound<'_, PyAny>>,
    keys: Option<&Bound<'_, PyDict>>,
    of_place: impl Fn(&[(f64, DAffine3)]) -> Vec<Table>,
) -> PyResult<Vec<(f64, Table)>> {
    let places = transform.map(|transform| places(Some(transform), "transform")).transpose()?;
    let stated = keys.map(|keys| by_frame(keys, "keys")).transpose()?.unwrap_or_default();
    let mut all: Vec<(f64, Table)> = match &places {
        Some(places) => places.iter().map(|(frame, _)| *frame).zip(of_place(places)).collect(),
        None => Vec::new(),
    };
    for (frame, object) in stated {
        let dict = object.cast::<PyDict>().map_err(|_| error(format!("`keys[{frame}]` must be a dict")))?;
        let table = keys::table(dict)?;
        match all.iter_mut().find(|(known, _)| *known == frame) {
            Some((_, known)) => known.extend(table),
            // one matrix holds for all frames
            None => {
                let first =
                    places.as_ref().filter(|places| places.len() == 1).and_then(|_| all.first().cloned());
                let mut own = first.map_or_else(Table::new, |(_, first)| first);
                own.extend(table);
                all.push((frame, own));
            }
        }
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (frame, table) in &mut all {
        table.insert(String::from("frame"), Value::Float(*frame));
    }
    Ok(all)
}

/// Writes the place of a light of this type, which shines along -Z.
pub fn of_light(kind: &str, places: &[(f64, DAffine3)]) -> Vec<Table> {
    let list = |point: glam::DVec3| Value::Array(point.to_array().map(Value::Float).to_vec());
    let table = |(_, map): &(f64, DAffine3)| {
        let (place, along) = (map.translation, (-map.matrix3.z_axis).normalize_or(glam::DVec3::NEG_Z));
        let keys = match kind {
            "directional" => vec![("direction", list(along))],
            "point" | "sphere" => vec![("position", list(place))],
            "rectangle" | "disk" => {
                let up = map.matrix3.y_axis.normalize_or(glam::DVec3::Y);
                vec![("position", list(place)), ("target", list(place + along)), ("up", list(up))]
            }
            _ => vec![("position", list(place)), ("target", list(place + along))],
        };
        keys.into_iter().map(|(key, value)| (String::from(key), value)).collect()
    };
    places.iter().map(table).collect()
}
