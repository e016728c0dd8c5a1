//! Meshes of what a program says of them.

use afterimage::scene::given::GivenMesh;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::{arrays, motion};

/// What is said of a mesh, beside its name, its materials and what all models have.
pub struct Said<'a, 'py> {
    pub vertices: &'a Bound<'py, PyAny>,
    pub faces: &'a Bound<'py, PyAny>,
    pub normals: Option<&'a Bound<'py, PyAny>>,
    pub uv: Option<&'a Bound<'py, PyAny>>,
    pub colors: Option<&'a Bound<'py, PyAny>>,
    pub face_materials: Option<&'a Bound<'py, PyAny>>,
    pub vertices_by_frame: Option<&'a Bound<'py, PyDict>>,
}

/// A mesh of triangles and other polygons.
pub fn mesh(name: &str, materials: Vec<String>, said: &Said<'_, '_>) -> PyResult<GivenMesh> {
    let whole = format!("mesh `{name}`: ");
    let in_mesh = |what: &str| format!("{whole}{what}");
    let (corners, counts) = corners(said.faces, &in_mesh("faces"))?;
    let three = |list: Option<&Bound<'_, PyAny>>, what: &str| {
        list.map_or(Ok(Vec::new()), |list| arrays::rows::<3>(list, &in_mesh(what)))
    };
    let material_of = said
        .face_materials
        .map_or(Ok(Vec::new()), |of| arrays::numbers(of, None, &in_mesh("face_materials")))?;
    let mut shapes = Vec::new();
    if let Some(dict) = said.vertices_by_frame {
        let what = in_mesh("vertices_by_frame");
        for (frame, points) in motion::by_frame(dict, &what)? {
            shapes.push((frame, arrays::rows(&points, &what)?));
        }
    }
    Ok(GivenMesh {
        name: String::from(name),
        points: arrays::rows(said.vertices, &in_mesh("vertices"))?,
        corners,
        counts,
        normals: three(said.normals, "normals")?,
        uvs: said.uv.map_or(Ok(Vec::new()), |uv| arrays::rows(uv, &in_mesh("uv")))?,
        colors: three(said.colors, "colors")?,
        materials,
        material_of,
        shapes,
        curves: None,
    })
}

/// Reads faces: three corners each, or corners and counts.
fn corners(faces: &Bound<'_, PyAny>, what: &str) -> PyResult<(Vec<u32>, Option<Vec<u32>>)> {
    match faces.cast::<PyTuple>() {
        Ok(pair) if pair.len() == 2 => Ok((
            arrays::numbers(&pair.get_item(0)?, None, what)?,
            Some(arrays::numbers(&pair.get_item(1)?, None, what)?),
        )),
        _ => Ok((arrays::numbers(faces, Some(3), what)?, None)),
    }
}
