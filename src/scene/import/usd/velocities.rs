//! Where velocities lead points that have one time alone.

use openusd::usd::Prim;

use super::file::Content;
use super::geometry::left_out_of;
use super::value::{Answer, points, value};
use crate::scene::import::curves::{CurveSet, CurveShape};

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
