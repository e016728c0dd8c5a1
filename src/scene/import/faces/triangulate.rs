//! Cuts faces into triangles that have an area.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::Use;
use super::polygon::Cutter;
use super::run::{FaceRun, split};

/// Triangles of a file, in the order of its faces.
#[derive(Debug, Default)]
pub struct Triangles {
    /// Vertices of each triangle.
    pub corners: Vec<[u32; 3]>,
    /// Runs of consecutive triangles with the same material and group, as length and use; lengths are above
    /// 0.
    pub uses: Vec<(usize, Use)>,
    /// Number of faces without an area, which were dropped.
    pub flat: usize,
}

/// Triangles of one run of faces.
struct Triangulated {
    /// Vertices, three for each triangle.
    corners: Vec<u32>,
    /// Runs of consecutive triangles with the same use, as length and use, in order.
    uses: Vec<(usize, Use)>,
    flat: usize,
}

/// Cuts all faces into triangles. The corners are vertices by now.
pub fn triangulate(runs: Vec<FaceRun>, positions: &[[f32; 3]]) -> Triangles {
    let parts: Vec<Triangulated> =
        runs.into_par_iter().map(|run| Triangulated::new(run, positions)).collect();
    let flat = parts.iter().map(|part| part.flat).sum();
    let lengths = || parts.iter().map(|part| part.corners.len() / 3);
    let count = lengths().sum();
    let mut uses: Vec<(usize, Use)> = Vec::new();
    for (count, a_use) in parts.iter().flat_map(|part| &part.uses).filter(|(count, _)| *count > 0) {
        match uses.last_mut() {
            Some((sum, last)) if last == a_use => *sum += count,
            _ => uses.push((*count, *a_use)),
        }
    }
    let mut corners = vec![[0; 3]; count];
    let places = split(&mut corners, lengths());
    // each is freed once it is copied
    let copy = |(place, part): (&mut [[u32; 3]], Triangulated)| {
        place.as_flattened_mut().copy_from_slice(&part.corners)
    };
    places.into_par_iter().zip(parts).for_each(copy);
    Triangles { corners, uses, flat }
}

impl Triangulated {
    fn new(run: FaceRun, positions: &[[f32; 3]]) -> Self {
        let ends = run.uses.iter().skip(1).map(|(face, _)| *face as usize).chain([run.faces]);
        let uses = run.uses.iter().zip(ends);
        let mut faces = Faces::new(positions);
        if run.arities.is_empty() && run.positions.chunks_exact(3).all(|face| faces.has_area(face)) {
            // as most are: nothing has to be cut, and nothing goes
            let uses = uses.map(|((begin, a_use), end)| (end - *begin as usize, *a_use)).collect();
            return Self { corners: run.positions, uses, flat: 0 };
        }
        let mut part = Self { corners: Vec::with_capacity(run.positions.len()), uses: Vec::new(), flat: 0 };
        let mut rest = run.positions.as_slice();
        for ((begin, a_use), end) in uses {
            let before = part.corners.len();
            for face in *begin as usize..end {
                let arity = run.arities.get(face).map_or(3, |arity| usize::from(*arity));
                let (face, after) = rest.split_at(arity);
                rest = after;
                faces.cut(face, &mut part);
            }
            part.uses.push(((part.corners.len() - before) / 3, *a_use));
        }
        part
    }
}

/// Cuts faces one after the other, in the same memory.
struct Faces<'a> {
    positions: &'a [[f32; 3]],
    cutter: Cutter,
    places: Vec<DVec3>,
}

impl<'a> Faces<'a> {
    fn new(positions: &'a [[f32; 3]]) -> Self {
        Self { positions, cutter: Cutter::new(), places: Vec::new() }
    }

    fn has_area(&self, triangle: &[u32]) -> bool {
        has_area([0, 1, 2].map(|corner| self.place(triangle[corner])))
    }

    fn cut(&mut self, face: &[u32], part: &mut Triangulated) {
        let before = part.corners.len();
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        places.extend(face.iter().map(|vertex| self.place(*vertex)));
        self.cutter.cut(&places, |corners| {
            if has_area(corners.map(|corner| places[corner])) {
                part.corners.extend(corners.map(|corner| face[corner]));
            }
        });
        self.places = places;
        part.flat += usize::from(part.corners.len() == before);
    }

    fn place(&self, vertex: u32) -> DVec3 {
        Vec3::from(self.positions[vertex as usize]).as_dvec3()
    }
}

/// Returns true if a triangle has an area. One that is not finite counts as having one: the check of
/// coordinates finds it.
#[inline(always)]
fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    // one part of the cross product after the other: mostly the first tells
    u.x * v.y - v.x * u.y != 0.0 || u.y * v.z - v.y * u.z != 0.0 || u.z * v.x - v.z * u.x != 0.0
}
