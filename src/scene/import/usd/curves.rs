//! Curves (UsdGeomBasisCurves): hair, fur, grass.

use glam::Vec2;
use openusd::sdf::Value;
use openusd::usd::Prim;

use super::file::{Content, UsdMesh};
use super::geometry::{FaceSurfaces, left_out_of};
use super::value::{self, Answer, codes_read, numbers, said, value, whole_numbers, word};
use super::velocities::{move_on, velocities};
use crate::animation::Visibility;
use crate::scene::import::curves::{Basis, CurveSet, CurveShape, Wrap};

/// Width of curves that state none.
const USUAL_WIDTH: f64 = 1.0;

/// Most times at which curves that deform are read.
const MOST_TIMES: usize = 2000;

/// Reads what a prim has at a time code; none if it has no curves then.
pub type At = fn(&Prim, f64, &FaceSurfaces, &mut Content) -> Answer<Option<CurveSet>>;

/// Curves, or what is read as such, that a prim has `at` its times, each with when they are there: one set that deforms, or several where their
/// number changes. None if there are none.
///
/// `content` gets to know what has no effect, and values that do not fit the curves and are left out.
///
/// # Errors What the library says.
pub fn curves(
    (prim, at): (&Prim, At),
    surfaces: &FaceSurfaces,
    content: &mut Content,
) -> Answer<Vec<(UsdMesh, Visibility)>> {
    let clock = &content.clock.clone();
    let mut times = Vec::new();
    for name in ["points", "widths", "primvars:widths", "normals", "primvars:normals"] {
        times.extend(codes_read(prim, name, clock)?);
    }
    times.sort_by(f64::total_cmp);
    times.dedup();
    if times.len() > MOST_TIMES {
        let message = format!("of the times of {} the first {MOST_TIMES} are shown", prim.path());
        content.unused.insert(message);
        times.truncate(MOST_TIMES);
    }
    if times.len() < 2 {
        let code = times.first().copied().unwrap_or_else(|| clock.code(clock.first()));
        let set = at(prim, code, surfaces, content)?;
        return Ok(set.map(|set| (mesh_of(set, surfaces), Visibility::ALWAYS)).into_iter().collect());
    }
    // runs of times at which as many curves have as many points, and the velocities of the first of each
    let mut runs: Vec<(f64, CurveSet)> = Vec::new();
    let mut speeds = Vec::new();
    for code in times {
        let Some(set) = at(prim, code, surfaces, content)? else { continue };
        let frame = clock.frame(code);
        let shape = CurveShape {
            frame,
            points: set.points.clone(),
            radii: set.radii.clone(),
            normals: set.normals.clone(),
        };
        match runs.last_mut() {
            Some((_, before)) if before.is_like(&set) => before.shapes.push(shape),
            _ => {
                runs.push((frame, CurveSet { shapes: vec![shape], ..set }));
                speeds.push(velocities(prim, code, content)?);
            }
        }
    }
    let begins: Vec<f64> = runs.iter().map(|(frame, _)| *frame).collect();
    if begins.len() > 1 {
        content.unused.insert(format!(
            "the number of points of {} changes with time: nothing of them is reused where it does",
            prim.path()
        ));
        for (number, ((begin, set), speeds)) in runs.iter_mut().zip(&speeds).enumerate() {
            // the last ones for a frame
            let next = begins.get(number + 1).copied().unwrap_or(*begin + 1.0);
            move_on(set, speeds, [*begin, next], clock.rate);
        }
    }
    let there = |number: usize| {
        let mut keys = vec![(begins[number], true)];
        keys.extend(begins.get(number + 1).map(|next| (*next, false)));
        let there = Visibility::through(number == 0, keys).filter(|_| begins.len() > 1);
        there.unwrap_or(Visibility::ALWAYS)
    };
    Ok(runs
        .into_iter()
        .enumerate()
        .map(|(number, (_, set))| (mesh_of(set, surfaces), there(number)))
        .collect())
}

fn mesh_of(set: CurveSet, surfaces: &FaceSurfaces) -> UsdMesh {
    UsdMesh { uses: vec![(0, surfaces.of_mesh)], curves: Some(set), ..UsdMesh::default() }
}

/// Curves at a time code.
///
/// # Errors What the library says.
pub fn at(
    prim: &Prim,
    code: f64,
    surfaces: &FaceSurfaces,
    content: &mut Content,
) -> Answer<Option<CurveSet>> {
    let Some(points) = value(prim, "points", code)?.as_ref().and_then(value::points) else { return Ok(None) };
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
            let message = format!("curves with the basis `{other}` are not shown: convert them to bspline");
            content.unused.insert(message);
            return Ok(None);
        }
    };
    let wrap = match word(prim, "wrap", code)?.as_deref() {
        Some("periodic") => Wrap::Periodic,
        Some("pinned") => Wrap::Pinned,
        _ => Wrap::Open,
    };
    let shape = Shape { counts: &counts, basis, wrap, points: points.len() };
    let Look { widths, colors } = look(prim, code, &shape, surfaces, content)?;
    let of = |name: &str| left_out_of(prim, name, "does not fit its curves");
    let normals = match spread(prim, "primvars:normals", code)? {
        Some(normals) => Some(normals),
        None => spread(prim, "normals", code)?,
    };
    let normals = normals.and_then(|(values, how)| {
        let read = shape.at_points::<3>(&values, how.as_deref().unwrap_or("vertex"));
        content.defects.extend(read.is_none().then(|| of("normals")));
        read
    });
    let is_left_handed = word(prim, "orientation", code)?.as_deref() == Some("leftHanded");
    let outwards = if is_left_handed { -1.0 } else { 1.0 };
    let mut uvs = Vec::new();
    for name in ["primvars:st", "primvars:UVMap"] {
        if let Some((values, how)) = spread(prim, name, code)?.filter(|_| uvs.is_empty()) {
            let of_curves = shape.of_curves::<2>(&values, how.as_deref().unwrap_or("constant"));
            content.defects.extend(of_curves.is_none().then(|| of(name)));
            uvs = of_curves.into_iter().flatten().map(|[u, v]| Vec2::new(u as f32, v as f32)).collect();
        }
    }
    Ok(Some(CurveSet {
        radii: radii(&widths),
        colors,
        uvs,
        points,
        counts,
        basis,
        wrap,
        normals: normals
            .into_iter()
            .flatten()
            .map(|normal| normal.map(|part| (part * outwards) as f32))
            .collect(),
        shapes: Vec::new(),
    }))
}

/// Widths and colours of points.
pub(super) struct Look {
    pub widths: Vec<f64>,
    /// None: they state none that count.
    pub colors: Vec<[f32; 3]>,
}

/// Radii of widths.
pub(super) fn radii(widths: &[f64]) -> Vec<f32> {
    widths.iter().map(|width| (0.5 * width) as f32).collect()
}

/// Reads widths and colours; what does not fit the points is told and left out.
pub(super) fn look(
    prim: &Prim,
    code: f64,
    shape: &Shape<'_>,
    surfaces: &FaceSurfaces,
    Content { unused, defects, .. }: &mut Content,
) -> Answer<Look> {
    let widths = match spread(prim, "primvars:widths", code)? {
        Some(widths) => Some(widths),
        None => spread(prim, "widths", code)?,
    };
    let has_widths = widths.is_some();
    let widths = match widths {
        Some((values, how)) => shape.at_points::<1>(&values, how.as_deref().unwrap_or("vertex")),
        None => None,
    };
    let of = |name: &str| left_out_of(prim, name, "does not fit its points");
    match (&widths, has_widths) {
        (None, true) => {
            let path = prim.path();
            defects.insert(format!("{path} has no widths that fit it: all of it is 1 wide; export it again"));
        }
        (None, false) => {
            unused.insert(format!("{} has no widths: all of it is 1 wide", prim.path()));
        }
        _ => {}
    }
    let widths = widths.map_or_else(|| vec![USUAL_WIDTH; shape.points], |widths| widths.concat());
    let colors = match spread(prim, "primvars:displayColor", code)?.filter(|_| surfaces.is_tinted) {
        Some((values, how)) => {
            let read = shape.at_points::<3>(&values, how.as_deref().unwrap_or("constant"));
            defects.extend(read.is_none().then(|| of("primvars:displayColor")));
            read
        }
        None => None,
    };
    let colors = colors.into_iter().flatten().map(|color| color.map(|part| part as f32)).collect();
    Ok(Look { widths, colors })
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
    let all = match indices.filter(|indices| !indices.is_empty()) {
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
pub(super) struct Shape<'a> {
    pub counts: &'a [u32],
    pub basis: Basis,
    pub wrap: Wrap,
    pub points: usize,
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
