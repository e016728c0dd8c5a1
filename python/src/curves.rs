//! Curves of what a program says of them.

use afterimage::scene::given::{CurveBasis, CurveSet, CurveShape, GivenMesh};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::errors::error;
use crate::motion;

/// What is said of curves, beside their name and what all models have.
pub struct Said<'a, 'py> {
    pub points: &'a Bound<'py, PyAny>,
    pub counts: &'a Bound<'py, PyAny>,
    pub radius: &'a Bound<'py, PyAny>,
    pub basis: &'a str,
    pub uv: Option<&'a Bound<'py, PyAny>>,
    pub colors: Option<&'a Bound<'py, PyAny>>,
    pub normals: Option<&'a Bound<'py, PyAny>>,
    pub points_by_frame: Option<&'a Bound<'py, PyDict>>,
}

/// The mesh of curves of one material.
pub fn mesh(name: &str, material: String, said: &Said<'_, '_>) -> PyResult<GivenMesh> {
    let whole = format!("curves `{name}`: ");
    let in_curves = |what: &str| format!("{whole}{what}");
    let points: Vec<[f32; 3]> = arrays::rows(said.points, &in_curves("points"))?;
    let radii = match said.radius.extract::<f32>() {
        Ok(radius) => vec![radius; points.len()],
        Err(_) => arrays::list(said.radius, &in_curves("radius"))?,
    };
    let three = |list: Option<&Bound<'_, PyAny>>, what: &str| {
        list.map_or(Ok(Vec::new()), |list| arrays::rows::<3>(list, &in_curves(what)))
    };
    let uvs = said.uv.map_or(Ok(Vec::new()), |uv| arrays::rows::<2>(uv, &in_curves("uv")))?;
    let mut shapes = Vec::new();
    if let Some(dict) = said.points_by_frame {
        let what = in_curves("points_by_frame");
        for (frame, points) in motion::by_frame(dict, &what)? {
            let points = arrays::rows(&points, &what)?;
            shapes.push(CurveShape { frame, points, radii: radii.clone(), normals: Vec::new() });
        }
    }
    let curves = CurveSet {
        counts: counts(said.counts, points.len(), &in_curves("counts"))?,
        basis: basis(said.basis, &in_curves("basis"))?,
        uvs: uvs.into_iter().map(Into::into).collect(),
        colors: three(said.colors, "colors")?,
        normals: three(said.normals, "normals")?,
        points,
        radii,
        shapes,
        ..CurveSet::default()
    };
    let materials = vec![material];
    Ok(GivenMesh {
        name: String::from(name),
        materials,
        curves: Some(Box::new(curves)),
        ..GivenMesh::default()
    })
}

/// Number of points of each curve: a list, or one number for all.
fn counts(counts: &Bound<'_, PyAny>, points: usize, what: &str) -> PyResult<Vec<u32>> {
    let Ok(same) = counts.extract::<u32>() else { return arrays::numbers(counts, None, what) };
    if same == 0 || points % same as usize != 0 {
        return Err(error(format!("`{what}`: {points} points are no curves of {same} points each")));
    }
    Ok(vec![same; points / same as usize])
}

fn basis(name: &str, what: &str) -> PyResult<CurveBasis> {
    let known = [
        ("linear", CurveBasis::Linear),
        ("bezier", CurveBasis::Bezier),
        ("bspline", CurveBasis::Bspline),
        ("catmull-rom", CurveBasis::CatmullRom),
    ];
    let names = known.map(|(name, _)| name).join("`, `");
    let found = known.into_iter().find(|(known, _)| *known == name);
    let none = || error(format!("`{what}` is one of `{names}`"));
    found.map(|(_, basis)| basis).ok_or_else(none)
}
