//! Cages of subdivision surfaces (UsdGeomMesh with a `subdivisionScheme`).

use std::collections::BTreeSet;

use glam::DVec3;
use openusd::usd::Prim;

use super::file::UsdCage;
use super::geometry::{Corner, FaceSurfaces, Faces, Primvar, PrimvarSpread, Spreads, left_out_of};
use super::value::{Answer, numbers, value, whole_numbers, word};
use crate::scene::cage::{Cage, FaceVarying, Spread, SpreadKind};
use crate::subdivision::{Boundary, Scheme};

/// Rules by which a mesh says that it is subdivided. `None` if it is not, or by rules that are not known here: these are told.
pub fn scheme(prim: &Prim, code: f64, unused: &mut BTreeSet<String>) -> Answer<Option<Scheme>> {
    Ok(match word(prim, "subdivisionScheme", code)?.as_deref() {
        None | Some("catmullClark") => Some(Scheme::CatmullClark),
        Some("bilinear") => Some(Scheme::Bilinear),
        Some("loop") => Some(Scheme::Loop),
        Some("none") => None,
        Some(other) => {
            unused.insert(format!(
                "{} is shown as its control cage, with smooth normals: subdivision surfaces are those of the schemes catmullClark, loop and bilinear, and not of {other}",
                prim.path()
            ));
            None
        }
    })
}

/// Reads the cage of a mesh with these points and faces. `defects` grow by tags that do not fit them, which are left out.
pub(super) fn cage(
    (prim, code): (&Prim, f64),
    scheme: Scheme,
    (points, faces): (&[[f32; 3]], &Faces),
    (surfaces, spreads): (&FaceSurfaces, &Spreads),
    defects: &mut BTreeSet<String>,
) -> Answer<UsdCage> {
    let boundary = word(prim, "interpolateBoundary", code)?;
    let face_varying = match word(prim, "faceVaryingLinearInterpolation", code)?.as_deref() {
        Some("none") => FaceVarying::None,
        Some("cornersOnly") => FaceVarying::CornersOnly,
        Some("cornersPlus2") => FaceVarying::CornersPlus2,
        Some("boundaries") => FaceVarying::Boundaries,
        Some("all") => FaceVarying::All,
        _ => FaceVarying::CornersPlus1,
    };
    let mut all: Vec<Corner> = Vec::with_capacity(faces.corners.len());
    let mut begin = 0;
    for (face, count) in faces.counts.iter().enumerate() {
        let own = (begin..begin + count).map(|number| Corner { face, number, point: faces.corners[number] });
        begin += count;
        // the first corner stays the first
        let from = all.len();
        all.extend(own);
        if faces.is_left_handed && *count > 0 {
            all[from + 1..].reverse();
        }
    }
    let corners: Vec<u32> = all.iter().map(|corner| corner.point).collect();
    let surface_of: Vec<Option<usize>> = (0..faces.counts.len())
        .map(|face| surfaces.of_face.get(&(face as u32)).copied().unwrap_or(surfaces.of_mesh))
        .collect();
    let sets = |set: usize| {
        let of = |corner: &Corner| spreads.uvs.of(surface_of[corner.face])[set];
        let [u, v] = [0, 1].map(|i| move |pair: [f32; 2]| if pair[i].is_finite() { pair[i] } else { 0.0 });
        spread(&all, &corners, points.len(), of, |pair| [u(pair), v(pair), 0.0])
    };
    let [has_first, has_second] = spreads.uvs.has();
    let mut cage = Cage {
        scheme,
        points: points.to_vec(),
        counts: faces.counts.iter().map(|count| *count as u32).collect(),
        holes: faces.holes.iter().filter_map(|hole| u32::try_from(*hole).ok()).collect(),
        material_of: Vec::new(),
        creases: creases(prim, code, points.len(), defects)?,
        sharp_points: sharp_points(prim, code, points.len(), defects)?,
        boundary: if boundary.as_deref() == Some("edgeOnly") { Boundary::Edges } else { Boundary::default() },
        face_varying,
        uvs: has_first.then(|| sets(0)),
        second_uvs: has_second.then(|| sets(1)),
        colors: spreads.colors.as_ref().map(|colors| {
            let finite = |color: [f32; 3]| color.map(|share| if share.is_finite() { share } else { 0.0 });
            spread(&all, &corners, points.len(), |_| Some(colors), finite)
        }),
        normals: spreads.normals.as_ref().filter(|_| scheme == Scheme::Bilinear).map(|normals| {
            let unit = |normal: [f32; 3]| {
                DVec3::from(normal.map(f64::from)).normalize_or_zero().as_vec3().to_array()
            };
            spread(&all, &corners, points.len(), |_| Some(normals), unit)
        }),
        shapes: Vec::new(),
        corners,
    };
    if boundary.as_deref() == Some("none") && scheme != Scheme::Bilinear {
        cage.hide_boundary();
    }
    Ok(UsdCage { cage, surface_of })
}

/// Spreads values over a cage as they are spread over its file.
fn spread<'a, T: Copy + 'a>(
    all: &[Corner],
    corners: &[u32],
    points: usize,
    of: impl Fn(&Corner) -> Option<&'a Primvar<T>>,
    number: impl Fn(T) -> [f32; 3],
) -> Spread {
    let values: Vec<[f32; 3]> = all
        .iter()
        .map(|corner| of(corner).and_then(|values| values.at(*corner)).map_or([0.0; 3], &number))
        .collect();
    let has =
        |kind: PrimvarSpread| all.iter().all(|corner| of(corner).is_some_and(|values| values.spread == kind));
    if has(PrimvarSpread::Vertex) {
        let mut of_points = vec![[0.0; 3]; points];
        corners.iter().zip(&values).for_each(|(point, value)| of_points[*point as usize] = *value);
        return Spread { values: of_points, of_corner: corners.to_vec(), kind: SpreadKind::OfPoints };
    }
    let is_smooth = all.iter().any(|corner| {
        of(corner)
            .is_some_and(|values| matches!(values.spread, PrimvarSpread::FaceVarying | PrimvarSpread::Vertex))
    });
    let spread = Spread::of_corners(&values, corners);
    if is_smooth { spread } else { Spread { kind: SpreadKind::Linear, ..spread } }
}

/// Edges that are sharp.
fn creases(
    prim: &Prim,
    code: f64,
    points: usize,
    defects: &mut BTreeSet<String>,
) -> Answer<Vec<([u32; 2], f32)>> {
    let mut none = |name: &str, what: &str| {
        defects.insert(left_out_of(prim, name, what));
        Ok(Vec::new())
    };
    let indices = list(prim, "creaseIndices", code)?;
    let lengths = list(prim, "creaseLengths", code)?;
    let sharpness = sharpness(prim, "creaseSharpnesses", code)?;
    let mut creases = Vec::new();
    let (mut begin, mut edge) = (0, 0);
    let edges = lengths.iter().map(|length| (*length).max(1) as usize - 1).fold(0, usize::saturating_add);
    let is_by_edge = sharpness.len() == edges && sharpness.len() != lengths.len();
    for (number, length) in lengths.iter().enumerate() {
        let end = usize::try_from(*length).ok().and_then(|length| length.checked_add(begin));
        let Some(points_of) = end.and_then(|end| indices.get(begin..end)) else {
            return none("creaseLengths", "does not fit to its creaseIndices");
        };
        begin += points_of.len();
        for ends in points_of.windows(2) {
            let sharp = sharpness.get(if is_by_edge { edge } else { number }).copied().unwrap_or(0.0);
            edge += 1;
            let ends = [ends[0], ends[1]].map(|end| point(end, points));
            let [Some(a), Some(b)] = ends else {
                return none("creaseIndices", &format!("names a point that is not among its {points}"));
            };
            creases.push(([a, b], sharp));
        }
    }
    Ok(creases)
}

/// Points that are sharp.
fn sharp_points(
    prim: &Prim,
    code: f64,
    points: usize,
    defects: &mut BTreeSet<String>,
) -> Answer<Vec<(u32, f32)>> {
    let indices = list(prim, "cornerIndices", code)?;
    let sharpness = sharpness(prim, "cornerSharpnesses", code)?;
    let each = indices.iter().zip(sharpness);
    let all: Option<Vec<(u32, f32)>> =
        each.map(|(index, sharpness)| Some((point(*index, points)?, sharpness))).collect();
    if all.is_none() {
        let what = format!("names a point that is not among its {points}");
        defects.insert(left_out_of(prim, "cornerIndices", &what));
    }
    Ok(all.unwrap_or_default())
}

fn point(index: i64, points: usize) -> Option<u32> {
    u32::try_from(index).ok().filter(|index| (*index as usize) < points)
}

fn list(prim: &Prim, name: &str, code: f64) -> Answer<Vec<i64>> {
    Ok(value(prim, name, code)?.as_ref().and_then(whole_numbers).unwrap_or_default())
}

/// Sharpness, 0 and above; what is no number is none.
fn sharpness(prim: &Prim, name: &str, code: f64) -> Answer<Vec<f32>> {
    let stated = value(prim, name, code)?.as_ref().and_then(numbers).unwrap_or_default();
    Ok(stated.into_iter().map(|sharp| if sharp > 0.0 { sharp as f32 } else { 0.0 }).collect())
}
