//! From faces to triangles that have an area.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::join::{Run, concatenated};
use crate::scene::polygon::Cutter;

/// Triangles of a file, in the order of its faces.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    /// Vertices of each.
    pub corners: Vec<[u32; 3]>,
    /// Material of each.
    pub material_of: Vec<u32>,
    /// Faces without an area: nothing is left of those.
    pub flat: usize,
}

/// Cuts all faces up. The corners are vertices by now.
pub(super) fn cut(runs: Vec<Run>, positions: &[[f32; 3]]) -> Triangles {
    let parts: Vec<Triangles> = runs.into_par_iter().map(|run| Triangles::of(&run, positions)).collect();
    let flat = parts.iter().map(|part| part.flat).sum();
    let (corners, materials): (Vec<_>, Vec<_>) =
        parts.into_iter().map(|part| (part.corners, part.material_of)).unzip();
    Triangles {
        corners: concatenated(corners.into_iter()),
        material_of: concatenated(materials.into_iter()),
        flat,
    }
}

impl Triangles {
    fn of(run: &Run, positions: &[[f32; 3]]) -> Self {
        let mut triangles = Self {
            corners: Vec::with_capacity(run.positions.len() - 2 * run.faces),
            material_of: Vec::with_capacity(run.positions.len() - 2 * run.faces),
            flat: 0,
        };
        let mut rest = run.positions.as_slice();
        let mut faces = Faces::new(positions);
        let ends = run.uses.iter().skip(1).map(|(face, _)| *face as usize).chain([run.faces]);
        for ((begin, material), end) in run.uses.iter().zip(ends) {
            for face in *begin as usize..end {
                let arity = run.arities.get(face).map_or(3, |arity| usize::from(*arity));
                let (face, after) = rest.split_at(arity);
                rest = after;
                faces.cut(face, &mut triangles);
            }
            triangles.material_of.resize(triangles.corners.len(), *material);
        }
        triangles
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

    #[inline]
    fn cut(&mut self, face: &[u32], triangles: &mut Triangles) {
        let before = triangles.corners.len();
        if let [a, b, c] = *face {
            if has_area([a, b, c].map(|vertex| self.place(vertex))) {
                triangles.corners.push([a, b, c]);
            }
        } else {
            self.cut_polygon(face, triangles);
        }
        triangles.flat += usize::from(triangles.corners.len() == before);
    }

    fn cut_polygon(&mut self, face: &[u32], triangles: &mut Triangles) {
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        places.extend(face.iter().map(|vertex| self.place(*vertex)));
        self.cutter.cut(&places, |corners| {
            if has_area(corners.map(|corner| places[corner])) {
                triangles.corners.push(corners.map(|corner| face[corner]));
            }
        });
        self.places = places;
    }

    fn place(&self, vertex: u32) -> DVec3 {
        Vec3::from(self.positions[vertex as usize]).as_dvec3()
    }
}

/// Not finite counts as an area: the check of coordinates finds it.
#[inline(always)]
fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    (b - a).cross(c - a) != DVec3::ZERO
}
