//! Points with a width (UsdGeomPoints): sparks, snow, beads. And where velocities lead points that have no other time.

use openusd::usd::Prim;

use super::curves::{Look, Shape, look, radii};
use super::file::Content;
use super::geometry::{FaceSurfaces, left_out_of};
use super::value::{Answer, points, value};
use crate::scene::import::curves::{Basis, CurveSet, CurveShape, Wrap};

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

/// Velocities of points at a time code, in units of the prim a second; none where there are none.
///
/// # Errors What the library says.
pub(super) fn velocities(prim: &Prim, code: f64, content: &mut Content) -> Answer<Vec<[f32; 3]>> {
    let count = value(prim, "points", code)?.as_ref().and_then(points).map_or(0, |points| points.len());
    let stated = value(prim, "velocities", code)?.as_ref().and_then(points).unwrap_or_default();
    if stated.is_empty() || stated.len() == count && stated.iter().flatten().all(|speed| speed.is_finite()) {
        return Ok(stated);
    }
    content.defects.insert(left_out_of(prim, "velocities", "does not fit its points"));
    Ok(Vec::new())
}

/// Lets the points of a set that has one time alone move on from there by their `velocities`, until the next set is there.
pub(super) fn move_on(set: &mut CurveSet, velocities: &[[f32; 3]], frames: [f64; 2], rate: f64) {
    let ([only], Some(each)) = (&set.shapes[..], set.points.len().checked_div(velocities.len())) else {
        return;
    };
    let seconds = ((frames[1] - frames[0]) / rate) as f32;
    let moved = |(number, point): (usize, &[f32; 3])| {
        let velocity = velocities[number / each];
        [0, 1, 2].map(|axis| point[axis] + velocity[axis] * seconds)
    };
    let points = only.points.iter().enumerate().map(moved).collect();
    let later = CurveShape { frame: frames[1], points, ..only.clone() };
    set.shapes.push(later);
}
