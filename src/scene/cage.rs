//! Cages: what files state of meshes that are subdivided.

use std::collections::HashMap;
use std::mem;

use glam::DVec3;

use crate::subdivision::{ALWAYS_SHARP, Boundary, CageFaces, Hierarchy, Scheme};

/// A mesh that is diced before it is rendered, in its object space.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cage {
    /// Rules by which it is subdivided.
    pub scheme: Scheme,
    /// Points, finite; in the shape in which samples are kept, if it deforms.
    pub points: Vec<[f32; 3]>,
    /// Number of corners of each face.
    pub counts: Vec<u32>,
    /// Points of the corners, counter-clockwise seen from outside, face after face.
    pub corners: Vec<u32>,
    /// Faces that are not shown, by number, rising.
    pub holes: Vec<u32>,
    /// Index of each face's material among those of the shot.
    pub material_of: Vec<u16>,
    /// Edges that are sharp, by their ends.
    pub creases: Vec<([u32; 2], f32)>,
    /// Points that are sharp.
    pub sharp_points: Vec<(u32, f32)>,
    /// What becomes of its boundary.
    pub boundary: Boundary,
    /// What becomes of values that belong to corners of faces, where these differ.
    pub face_varying: FaceVarying,
    /// Texture coordinates.
    pub uvs: Option<Spread>,
    /// Second set of texture coordinates.
    pub second_uvs: Option<Spread>,
    /// Colours, linear RGB.
    pub colors: Option<Spread>,
    /// Normals, where its own are not those of the surface: of the bilinear scheme alone.
    pub normals: Option<Spread>,
    /// All points in each of its shapes, if it deforms.
    pub shapes: Vec<Vec<[f32; 3]>>,
}

/// Values that are spread over a cage, of which the first few elements count.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spread {
    /// Values.
    pub values: Vec<[f32; 3]>,
    /// Number of the value at each corner; of points that of its point.
    pub of_corner: Vec<u32>,
    /// What is between them.
    pub kind: SpreadKind,
}

/// What is between the values of a cage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SpreadKind {
    /// A value a point, smooth as the surface is.
    OfPoints,
    /// Values that belong to corners, smooth where those around a point are the same ([`FaceVarying`]).
    OfCorners,
    /// Within each face by itself.
    Linear,
}

/// What of values of corners is sharp, by the names that USD has for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(not(feature = "usd"), allow(dead_code, reason = "OBJ files say nothing of it"))]
pub(crate) enum FaceVarying {
    /// All: nothing is smooth.
    All,
    /// Nothing: seams are smooth curves.
    None,
    /// Corners of the areas that seams bound.
    CornersOnly,
    /// Those, and points at which three areas meet or more.
    #[default]
    CornersPlus1,
    /// Those, and ends of seams, and what meets corners.
    CornersPlus2,
    /// All seams.
    Boundaries,
}

impl Spread {
    /// Values of all corners, in order: equal ones at a point are one value.
    pub fn of_corners(values: &[[f32; 3]], corners: &[u32]) -> Self {
        let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
        let mut distinct = Vec::new();
        let of_corner = corners.iter().zip(values).map(|(point, value)| {
            *known.entry((*point, value.map(f32::to_bits))).or_insert_with(|| {
                distinct.push(*value);
                (distinct.len() - 1) as u32
            })
        });
        let of_corner = of_corner.collect();
        Self { values: distinct, of_corner, kind: SpreadKind::OfCorners }
    }
}

impl Cage {
    /// Its faces.
    pub fn faces(&self) -> CageFaces<'_> {
        CageFaces {
            scheme: self.scheme,
            points: self.points.len(),
            counts: &self.counts,
            corners: &self.corners,
            creases: &self.creases,
            sharp_points: &self.sharp_points,
            boundary: self.boundary,
        }
    }

    /// Takes out faces that are none: with fewer than three corners, or twice at one point. Returns their number.
    pub fn remove_degenerate(&mut self) -> usize {
        let mut begin = 0;
        let is_face = |count: &u32| {
            let corners = &self.corners[begin..begin + *count as usize];
            begin += *count as usize;
            // long faces are compared by neighbours alone: these are what exporters write twice
            let near = if corners.len() > 64 { 1 } else { corners.len() };
            let is_twice = |(i, corner): (usize, &u32)| {
                (1..=near.min(corners.len() - 1)).any(|by| corners[(i + by) % corners.len()] == *corner)
            };
            corners.len() >= 3 && !corners.iter().enumerate().any(is_twice)
        };
        let stays: Vec<bool> = self.counts.iter().map(is_face).collect();
        let gone = stays.iter().filter(|stays| !**stays).count();
        if gone > 0 {
            self.keep_faces(&stays);
        }
        gone
    }

    fn keep_faces(&mut self, stays: &[bool]) {
        let of_corners: Vec<bool> = stays
            .iter()
            .zip(&self.counts)
            .flat_map(|(stays, count)| std::iter::repeat_n(*stays, *count as usize))
            .collect();
        let spreads = [&mut self.uvs, &mut self.second_uvs, &mut self.colors, &mut self.normals];
        spreads.into_iter().flatten().for_each(|spread| keep(&mut spread.of_corner, &of_corners));
        keep(&mut self.corners, &of_corners);
        keep(&mut self.counts, stays);
        keep(&mut self.material_of, stays);
        let mut number = 0;
        let numbers: Vec<Option<u32>> = stays
            .iter()
            .map(|stays| {
                number += u32::from(*stays);
                stays.then(|| number - 1)
            })
            .collect();
        let holes = mem::take(&mut self.holes);
        self.holes = holes.into_iter().filter_map(|hole| *numbers.get(hole as usize)?).collect();
    }

    /// Hides faces at points of its boundary, whose edges are not sharp there: without a rule they have no surface.
    pub fn hide_boundary(&mut self) {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(self.corners.len());
        self.each_edge(|ends| {
            let [a, b] = ends.map(|corner| self.corners[corner]);
            *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        });
        let sharp = self.creases.iter().filter(|(_, sharpness)| *sharpness >= ALWAYS_SHARP);
        for ([a, b], _) in sharp {
            edges.remove(&[*a.min(b), *a.max(b)]);
        }
        let mut is_open = vec![false; self.points.len()];
        for (ends, _) in edges.iter().filter(|(_, count)| **count == 1) {
            ends.iter().for_each(|point| is_open[*point as usize] = true);
        }
        let mut begin = 0;
        let mut hidden = Vec::new();
        for (face, count) in (0..).zip(&self.counts) {
            let corners = &self.corners[begin..begin + *count as usize];
            begin += *count as usize;
            if corners.iter().any(|point| is_open[*point as usize]) {
                hidden.push(face);
            }
        }
        self.holes.extend(hidden);
        self.holes.sort_unstable();
        self.holes.dedup();
    }

    /// The levels of values that belong to corners.
    pub fn face_varying_hierarchy(&self, spread: &Spread) -> Hierarchy {
        let sharp = self.sharp_values(spread);
        // an edge of values is as sharp as that of the points
        let creases: HashMap<[u32; 2], f32> =
            self.creases.iter().map(|([a, b], sharpness)| ([*a.min(b), *a.max(b)], *sharpness)).collect();
        let mut of_values = Vec::new();
        if !creases.is_empty() {
            self.each_edge(|[one, other]| {
                let [a, b] = [one, other].map(|corner| self.corners[corner]);
                if let Some(sharpness) = creases.get(&[a.min(b), a.max(b)]) {
                    of_values.push(([one, other].map(|corner| spread.of_corner[corner]), *sharpness));
                }
            });
        }
        Hierarchy::new(&CageFaces {
            scheme: self.scheme,
            points: spread.values.len(),
            counts: &self.counts,
            corners: &spread.of_corner,
            creases: &of_values,
            sharp_points: &sharp,
            boundary: Boundary::Edges,
        })
    }

    /// Calls `each` with the corners at which each face's edges begin and end.
    fn each_edge(&self, mut each: impl FnMut([usize; 2])) {
        let mut begin = 0;
        for count in &self.counts {
            let count = *count as usize;
            (0..count).for_each(|corner| each([begin + corner, begin + (corner + 1) % count]));
            begin += count;
        }
    }

    /// Values that stay where they are, as OpenSubdiv has it.
    fn sharp_values(&self, spread: &Spread) -> Vec<(u32, f32)> {
        let count = spread.values.len();
        let (mut point_of, mut faces) = (vec![u32::MAX; count], vec![0_u32; count]);
        for (value, point) in spread.of_corner.iter().zip(&self.corners) {
            point_of[*value as usize] = *point;
            faces[*value as usize] += 1;
        }
        // ends of edges that only one face has, by its values and by its points: where there are as many of both no seam is
        let of_values = self.open_ends(count, |corner| spread.of_corner[corner]);
        let of_points = self.open_ends(self.points.len(), |corner| self.corners[corner]);
        let is_corner = |value: u32| faces[value as usize] == 1;
        // at each point the number of values, and whether one of them is a corner of its area
        let mut at = vec![(0_u32, false); self.points.len()];
        for (value, point) in (0..count as u32).zip(&point_of).filter(|(_, point)| **point != u32::MAX) {
            let (values, has_corner) = &mut at[*point as usize];
            *values += 1;
            *has_corner |= is_corner(value);
        }
        let stated: HashMap<u32, f32> = self.sharp_points.iter().copied().collect();
        let mut sharp: Vec<(u32, f32)> = Vec::new();
        for (value, point) in (0..count as u32).zip(&point_of).filter(|(_, point)| **point != u32::MAX) {
            let own = stated.get(point).copied().unwrap_or(0.0);
            let (values, has_corner) = at[*point as usize];
            let open = of_values[value as usize];
            let has_no_seam = values == 1 && open == of_points[*point as usize];
            let always = open > 0
                && match self.face_varying {
                    FaceVarying::All | FaceVarying::Boundaries => true,
                    // they go as the point does
                    _ if has_no_seam => self.boundary == Boundary::EdgesAndCorners && is_corner(value),
                    FaceVarying::None => false,
                    FaceVarying::CornersOnly => is_corner(value),
                    FaceVarying::CornersPlus1 => is_corner(value) || values > 2,
                    // of one value alone a seam ends there
                    FaceVarying::CornersPlus2 => has_corner || values != 2,
                };
            if always || own > 0.0 {
                sharp.push((value, if always { f32::INFINITY } else { own }));
            }
        }
        sharp
    }

    /// Number of ends of edges that only one face has, at each of `count` numbers that corners have.
    fn open_ends(&self, count: usize, number: impl Fn(usize) -> u32) -> Vec<u32> {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(self.corners.len());
        self.each_edge(|ends| {
            let [a, b] = ends.map(&number);
            *edges.entry([a.min(b), a.max(b)]).or_insert(0) += 1;
        });
        let mut open = vec![0; count];
        for (ends, _) in edges.iter().filter(|(_, faces)| **faces == 1) {
            ends.iter().for_each(|end| open[*end as usize] += 1);
        }
        open
    }
}

fn keep<T: Copy>(list: &mut Vec<T>, stays: &[bool]) {
    let mut number = 0;
    list.retain(|_| {
        number += 1;
        stays[number - 1]
    });
}

/// Values as they are computed with.
pub(super) fn in_doubles(values: &[[f32; 3]]) -> Vec<DVec3> {
    values.iter().map(|[x, y, z]| DVec3::new((*x).into(), (*y).into(), (*z).into())).collect()
}

/// A point as meshes keep it.
pub(super) fn in_floats(value: DVec3) -> [f32; 3] {
    value.as_vec3().to_array()
}
