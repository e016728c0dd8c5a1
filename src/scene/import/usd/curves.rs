//! Curves (UsdGeomBasisCurves): hair, fur, grass.

use std::collections::BTreeSet;

use glam::Vec2;
use openusd::sdf::Value;
use openusd::usd::Prim;

use super::clock::Clock;
use super::file::UsdMesh;
use super::geometry::FaceSurfaces;
use super::value::{Answer, codes_read, numbers, points, said, value, whole_numbers, word};
use crate::animation::Visibility;
use crate::scene::import::curves::{Basis, CurveSet, Wrap};

/// Width of curves that state none.
const USUAL_WIDTH: f64 = 1.0;

/// Most times at which curves that deform are read: each is a mesh of its own.
const MOST_TIMES: usize = 2000;

/// Curves as they are at one time after the other, each with when it is there. None if there are no curves.
///
/// # Errors Lists that do not fit each other, and what the library says.
pub fn curves(
    prim: &Prim,
    clock: &Clock,
    surfaces: &FaceSurfaces,
    unused: &mut BTreeSet<String>,
) -> Answer<Vec<(UsdMesh, Visibility)>> {
    let mut times = codes_read(prim, "points", clock)?;
    if times.len() > MOST_TIMES {
        unused.insert(format!("of the times of {} the first {MOST_TIMES} are shown", prim.path()));
        times.truncate(MOST_TIMES);
    }
    if times.len() < 2 {
        let code = times.first().copied().unwrap_or_else(|| clock.code(clock.first()));
        let set = at(prim, code, surfaces, unused)?;
        return Ok(set.map(|set| (mesh_of(set, surfaces), Visibility::ALWAYS)).into_iter().collect());
    }
    unused.insert(String::from(
        "curves that deform are shown as they are at each of their times, without those in between: nothing of them is reused from one to the next",
    ));
    let mut all = Vec::with_capacity(times.len());
    for (number, code) in times.iter().enumerate() {
        let Some(set) = at(prim, *code, surfaces, unused)? else { continue };
        let mut keys = vec![(clock.frame(*code), true)];
        keys.extend(times.get(number + 1).map(|next| (clock.frame(*next), false)));
        let there = Visibility::through(number == 0, keys).unwrap_or(Visibility::ALWAYS);
        all.push((mesh_of(set, surfaces), there));
    }
    Ok(all)
}

fn mesh_of(set: CurveSet, surfaces: &FaceSurfaces) -> UsdMesh {
    UsdMesh { uses: vec![(0, surfaces.of_mesh)], curves: Some(set), ..UsdMesh::default() }
}

/// Curves at a time code.
fn at(
    prim: &Prim,
    code: f64,
    surfaces: &FaceSurfaces,
    unused: &mut BTreeSet<String>,
) -> Answer<Option<CurveSet>> {
    let Some(points) = value(prim, "points", code)?.as_ref().and_then(points) else { return Ok(None) };
    let counts = value(prim, "curveVertexCounts", code)?.as_ref().and_then(whole_numbers).unwrap_or_default();
    let counts: Option<Vec<u32>> = counts.iter().map(|count| u32::try_from(*count).ok()).collect();
    let Some(counts) = counts.filter(|counts| !counts.is_empty()) else { return Ok(None) };
    let basis = match (word(prim, "type", code)?.as_deref(), word(prim, "basis", code)?.as_deref()) {
        (Some("linear"), _) => Basis::Linear,
        (_, None | Some("bezier")) => Basis::Bezier,
        (_, Some("bspline")) => Basis::Bspline,
        (_, Some("catmullRom")) => Basis::CatmullRom,
        (_, Some(other)) => {
            let other = crate::visible::visible(other);
            unused.insert(format!("curves with the basis `{other}` are not shown: convert them to bspline"));
            return Ok(None);
        }
    };
    let wrap = match word(prim, "wrap", code)?.as_deref() {
        Some("periodic") => Wrap::Periodic,
        Some("pinned") => Wrap::Pinned,
        _ => Wrap::Open,
    };
    let shape = Shape { counts: &counts, basis, wrap, points: points.len() };
    let widths = match spread(prim, "primvars:widths", code)? {
        Some(widths) => Some(widths),
        None => spread(prim, "widths", code)?,
    };
    let widths = match widths {
        Some((values, how)) => shape.at_points::<1>(&values, how.as_deref().unwrap_or("vertex")),
        None => None,
    };
    if widths.is_none() {
        unused.insert(format!("curves of {} have no widths that fit them: they are 1 wide", prim.path()));
    }
    let widths = widths.unwrap_or_else(|| vec![[USUAL_WIDTH]; points.len()]);
    let colors = match spread(prim, "primvars:displayColor", code)?.filter(|_| surfaces.is_tinted) {
        Some((values, how)) => shape.at_points::<3>(&values, how.as_deref().unwrap_or("constant")),
        None => None,
    };
    let mut uvs = Vec::new();
    for name in ["primvars:st", "primvars:UVMap"] {
        if let Some((values, how)) = spread(prim, name, code)?.filter(|_| uvs.is_empty()) {
            let of_curves = shape.of_curves::<2>(&values, how.as_deref().unwrap_or("constant"));
            uvs = of_curves.into_iter().flatten().map(|[u, v]| Vec2::new(u as f32, v as f32)).collect();
        }
    }
    Ok(Some(CurveSet {
        radii: widths.iter().map(|[width]| (0.5 * width) as f32).collect(),
        colors: colors.into_iter().flatten().map(|color| color.map(|part| part as f32)).collect(),
        uvs,
        points,
        counts,
        basis,
        wrap,
    }))
}

/// Numbers of an attribute, in order and by its indices, and how they are spread.
fn spread(prim: &Prim, name: &str, code: f64) -> Answer<Option<(Vec<f64>, Option<String>)>> {
    let Some(read) = value(prim, name, code)? else { return Ok(None) };
    let parts = match &read {
        Value::Vec2fVec(list) => {
            Some((2, list.iter().flat_map(|two| [f64::from(two.x), f64::from(two.y)]).collect()))
        }
        Value::Vec2dVec(list) => Some((2, list.iter().flat_map(|two| [two.x, two.y]).collect())),
        Value::Vec3fVec(_) | Value::Vec3dVec(_) | Value::Vec3hVec(_) => numbers(&read).map(|all| (3, all)),
        _ => numbers(&read).map(|all| (1, all)),
    };
    let Some((width, all)): Option<(usize, Vec<f64>)> = parts else { return Ok(None) };
    let indices = value(prim, &format!("{name}:indices"), code)?.as_ref().and_then(whole_numbers);
    let all = match indices {
        None => all,
        Some(indices) => indices
            .iter()
            .flat_map(|index| {
                let begin = usize::try_from(*index).unwrap_or(usize::MAX).saturating_mul(width);
                all.get(begin..begin.saturating_add(width)).map(<[f64]>::to_vec).unwrap_or_default()
            })
            .collect(),
    };
    let how = match said(prim.attribute(name).get_metadata::<Value>("interpolation"))? {
        Some(Value::Token(word)) => Some(word.to_string()),
        _ => None,
    };
    Ok(Some((all, how)))
}

/// What says how many values a list must have.
struct Shape<'a> {
    counts: &'a [u32],
    basis: Basis,
    wrap: Wrap,
    points: usize,
}

impl Shape<'_> {
    /// Values of all points, given those of all curves, of each, of the ends of all segments, or of all points. `None` if there are too few.
    fn at_points<const N: usize>(&self, values: &[f64], how: &str) -> Option<Vec<[f64; N]>> {
        let entry = |at: usize| -> Option<[f64; N]> { values.get(at * N..at * N + N)?.try_into().ok() };
        match how {
            "constant" => Some(vec![entry(0)?; self.points]),
            "uniform" => {
                let of = |(curve, count): (usize, &u32)| Some(vec![entry(curve)?; *count as usize]);
                let all: Option<Vec<Vec<[f64; N]>>> = self.counts.iter().enumerate().map(of).collect();
                all.map(|all| all.concat())
            }
            "varying" if self.basis != Basis::Linear => self.of_ends(entry),
            _ => (0..self.points).map(entry).collect(),
        }
    }

    /// Values of all points, given those of the ends of segments: in between they are on the straight way.
    fn of_ends<const N: usize>(&self, entry: impl Fn(usize) -> Option<[f64; N]>) -> Option<Vec<[f64; N]>> {
        let (mut all, mut first) = (Vec::with_capacity(self.points), 0);
        for count in self.counts.iter().map(|count| *count as usize) {
            let ends = match (self.basis, self.wrap) {
                (Basis::Bezier, Wrap::Periodic) => count / 3,
                (Basis::Bezier, _) => count / 3 + 1,
                (_, Wrap::Open) => count.saturating_sub(2),
                _ => count,
            };
            for point in 0..count {
                let at = match (self.basis, self.wrap) {
                    (Basis::Bezier, _) => point as f64 / 3.0,
                    (_, Wrap::Open) => point as f64 - 1.0,
                    _ => point as f64,
                };
                let at = at.clamp(0.0, ends.saturating_sub(1) as f64);
                let (low, share) = (at.floor() as usize, at.fract());
                let high = if low + 1 < ends {
                    low + 1
                } else if self.wrap == Wrap::Periodic {
                    0
                } else {
                    low
                };
                let (from, to) = (entry(first + low)?, entry(first + high)?);
                all.push(std::array::from_fn(|part| from[part] + (to[part] - from[part]) * share));
            }
            first += ends;
        }
        Some(all)
    }

    /// Values of all curves: the first one where there are more.
    fn of_curves<const N: usize>(&self, values: &[f64], how: &str) -> Option<Vec<[f64; N]>> {
        if how == "uniform" {
            let entry = |curve: usize| values.get(curve * N..curve * N + N)?.try_into().ok();
            return (0..self.counts.len()).map(entry).collect();
        }
        let points = self.at_points::<N>(values, how)?;
        let mut first = 0;
        let of = |count: &u32| {
            let value = points.get(first).copied();
            first += *count as usize;
            value
        };
        self.counts.iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_spread_over_points() {
        let counts = [4, 7];
        let of = |basis, wrap| Shape { counts: &counts, basis, wrap, points: 11 };
        let bezier = of(Basis::Bezier, Wrap::Open);
        let flat = |all: Option<Vec<[f64; 1]>>| all.map(|all| all.concat());
        assert_eq!(flat(bezier.at_points(&[2.0], "constant")), Some(vec![2.0; 11]));
        let uniform = flat(bezier.at_points(&[1.0, 3.0], "uniform"));
        assert_eq!(uniform, Some([vec![1.0; 4], vec![3.0; 7]].concat()));
        let varying = flat(bezier.at_points(&[0.0, 3.0, 3.0, 6.0, 0.0], "varying"));
        let wanted = [0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0, 6.0, 4.0, 2.0, 0.0];
        let near = varying
            .expect("they fit")
            .iter()
            .zip(wanted)
            .all(|(value, wanted)| (value - wanted).abs() < 1e-9);
        assert!(near);
        let spline = of(Basis::Bspline, Wrap::Open);
        let varying = flat(spline.at_points(&[1.0, 2.0, 1.0, 2.0, 3.0, 4.0, 5.0], "varying"));
        assert_eq!(varying, Some(vec![1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0]));
        assert_eq!(flat(bezier.at_points(&[0.0, 3.0], "varying")), None);
        assert_eq!(flat(bezier.at_points(&[0.0, 3.0], "vertex")), None);
        assert_eq!(bezier.of_curves::<1>(&[1.0, 3.0], "uniform"), Some(vec![[1.0], [3.0]]));
    }
}
