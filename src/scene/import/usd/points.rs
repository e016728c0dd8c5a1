//! Points with a width (UsdGeomPoints): sparks, snow, beads.

use openusd::usd::Prim;

use super::curves::{Look, Shape, look, radii};
use super::file::Content;
use super::geometry::FaceSurfaces;
use super::value::{Answer, points, value};
use crate::scene::import::curves::{Basis, CurveSet, Wrap};

/// Distance from the middle of a ball to its second point, in radii: within the ball, and elsewhere than the middle.
const SECOND: f32 = 0.5;

/// Points at a time code, as curves of two points each: the hull of a ball and of a point within it is the ball.
///
/// # Errors What the library says.
pub(super) fn at(
    prim: &Prim,
    code: f64,
    surfaces: &FaceSurfaces,
    content: &mut Content,
) -> Answer<Option<CurveSet>> {
    let Some(points) = value(prim, "points", code)?.as_ref().and_then(points) else { return Ok(None) };
    if points.is_empty() || u32::try_from(points.len()).is_err() {
        return Ok(None);
    }
    let counts = [points.len() as u32];
    let shape = Shape { counts: &counts, basis: Basis::Linear, wrap: Wrap::Open, points: points.len() };
    let Look { widths, colors } = look(prim, code, &shape, surfaces, content)?;
    let second = |([x, y, z], radius): (&[f32; 3], &f32)| [[*x, *y, *z], [*x, *y + SECOND * radius, *z]];
    let radii = radii(&widths);
    Ok(Some(CurveSet {
        points: points.iter().zip(&radii).flat_map(second).collect(),
        radii: radii.iter().flat_map(|radius| [*radius, 0.0]).collect(),
        counts: vec![2; points.len()],
        basis: Basis::Linear,
        colors: colors.into_iter().flat_map(|color| [color; 2]).collect(),
        ..CurveSet::default()
    }))
}
