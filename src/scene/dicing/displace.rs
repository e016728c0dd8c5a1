//! Moves vertices by what graphs of their materials compute: true displacement, of whatever triangles a mesh has.

use std::collections::HashMap;
use std::sync::Arc;

use embree::VertexBuffer;
use glam::{Affine3A, DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::vertex_normal::Face;
use crate::lanes::LANES;
use crate::scene::cage::in_doubles;
use crate::scene::import::Import;
use crate::scene::import::deformed::has_area;
use crate::scene::import::faces::LARGEST_COORDINATE;
use crate::scene::material::{Along, Displacement};
use crate::scene::on_mesh::{OnMesh, displacements};
use crate::scene::{Mesh, Model, Shapes, Texture, Triangles};

/// Number for vertices without a corner.
const NONE: u32 = u32::MAX;

/// Number of times that vertices of triangles without an area are put back before nothing is displaced.
const MOST_TRIES: usize = 8;

/// Returns true if a material of a mesh displaces it.
pub fn is_displaced(mesh: &Mesh, import: &Import) -> bool {
    let materials = &import.surfaces.materials;
    materials.iter().any(|material| material.displacement.is_some())
        && mesh.as_triangles().is_some()
        && mesh.material_of.iter().any(|material| materials[usize::from(*material)].displacement.is_some())
}

/// What moves a vertex.
#[derive(Debug, Clone, Copy, Default)]
struct Offset {
    /// Along its normal.
    height: f64,
    /// In object space.
    vector: DVec3,
}

/// The mesh, whose vertices are where its materials displace them, in all of its shapes; as it was, where none does. `model`: one that
/// shows it. Then why it is not displaced, if it should be.
pub fn displaced(mesh: Mesh, model: &Model, import: &Import) -> (Mesh, Option<String>) {
    if !is_displaced(&mesh, import) {
        return (mesh, None);
    }
    let of = Displacing { mesh: &mesh, model, import };
    let triangles = mesh.triangles();
    let places = places(triangles.positions.as_slice());
    let mut offsets = of.offsets(&places);
    for _ in 0..MOST_TRIES {
        let moved = Moved::of(triangles, &places, &offsets);
        let closed = triangles.corners.iter().filter(|corners| !has_area(&moved.rest, **corners));
        let closed: Vec<u32> = closed.flatten().copied().collect();
        if closed.is_empty() {
            return (moved.put_into(mesh, &places), None);
        }
        let mut stays = vec![false; offsets.len()];
        closed.iter().for_each(|vertex| stays[places.of_vertex[*vertex as usize] as usize] = true);
        offsets
            .iter_mut()
            .zip(&stays)
            .filter(|(_, stays)| **stays)
            .for_each(|(offset, _)| *offset = Offset::default());
    }
    (mesh, Some(String::from("it is not displaced: triangles of it would have no area")))
}

/// Places of vertices: those at one place move together, whatever their normals and texture coordinates are.
struct Places {
    of_vertex: Vec<u32>,
    count: usize,
}

fn places(positions: &[[f32; 3]]) -> Places {
    let mut known = HashMap::with_capacity(positions.len());
    // a zero has two signs
    let key = |position: &[f32; 3]| position.map(|x| (x + 0.0).to_bits());
    let number = |position: &[f32; 3]| {
        let next = known.len() as u32;
        *known.entry(key(position)).or_insert(next)
    };
    let of_vertex: Vec<u32> = positions.iter().map(number).collect();
    Places { count: known.len(), of_vertex }
}

/// A mesh that is being displaced.
struct Displacing<'a> {
    mesh: &'a Mesh,
    model: &'a Model,
    import: &'a Import,
}

impl Displacing<'_> {
    /// What moves each place: the mean of what the materials there say.
    fn offsets(&self, places: &Places) -> Vec<Offset> {
        let triangles = self.mesh.triangles();
        let mut materials: Vec<u16> = self.mesh.material_of.clone();
        materials.sort_unstable();
        materials.dedup();
        let (mut sums, mut counts) = (vec![Offset::default(); places.count], vec![0.0; places.count]);
        for material in materials {
            let mut corner_of = vec![NONE; places.of_vertex.len()];
            let own = triangles.corners.iter().zip(&self.mesh.material_of).enumerate();
            for (triangle, (corners, _)) in own.filter(|(_, (_, of))| **of == material) {
                for (number, vertex) in corners.iter().enumerate() {
                    let known = &mut corner_of[*vertex as usize];
                    if *known == NONE {
                        *known = (3 * triangle + number) as u32;
                    }
                }
            }
            let asked: Vec<u32> =
                (0..corner_of.len() as u32).filter(|at| corner_of[*at as usize] != NONE).collect();
            let corners: Vec<u32> = asked.iter().map(|vertex| corner_of[*vertex as usize]).collect();
            let displacement = self.import.surfaces.materials[usize::from(material)].displacement.as_ref();
            let values = displacement.map(|displacement| self.values(displacement, &corners));
            for (number, vertex) in asked.iter().enumerate() {
                let place = places.of_vertex[*vertex as usize] as usize;
                counts[place] += 1.0;
                if let Some(values) = &values {
                    sums[place].height += values[number].height;
                    sums[place].vector += values[number].vector;
                }
            }
        }
        for (sum, count) in sums.iter_mut().zip(counts) {
            if count > 0.0 {
                *sum = Offset { height: sum.height / count, vector: sum.vector / count };
            }
        }
        sums
    }

    /// What a displacement says at corners of triangles.
    fn values(&self, displacement: &Displacement, corners: &[u32]) -> Vec<Offset> {
        let triangles = self.mesh.triangles();
        let tangents = match displacement.along {
            Along::TangentSpace => tangents(triangles),
            Along::Normal | Along::ObjectSpace => Vec::new(),
        };
        let tangent_at = |corner: u32| {
            let vertex = triangles.corners[(corner / 3) as usize][(corner % 3) as usize];
            tangents.get(vertex as usize).copied().unwrap_or_default()
        };
        let textures: &[Texture] = &self.import.pictures.textures;
        let to_world = self.model.track.map_at(1.0).as_affine3a();
        let to_world = Some(&to_world).filter(|map: &&Affine3A| map.is_finite());
        let place = |corner: &u32| OnMesh {
            to_world,
            random: self.model.random,
            ..OnMesh::new(self.mesh, corner / 3, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]][(corner % 3) as usize])
        };
        let of_eight = |corners: &[u32]| {
            let all: Vec<OnMesh> = corners.iter().map(place).collect();
            let values = displacements(&all, textures, &displacement.program);
            let each = values.into_iter().zip(corners);
            each.map(|(value, corner)| offset(displacement, value, tangent_at(*corner))).collect::<Vec<_>>()
        };
        corners.par_chunks(LANES).flat_map_iter(of_eight).collect()
    }
}

/// What a value says at a place with this tangent and the direction across it.
fn offset(displacement: &Displacement, value: Vec3, [along, across]: [DVec3; 2]) -> Offset {
    let scale = f64::from(displacement.scale);
    let moved = (value.as_dvec3() - f64::from(displacement.middle)) * scale;
    if !moved.is_finite() {
        return Offset::default();
    }
    match displacement.along {
        Along::Normal => Offset { height: moved.x, vector: DVec3::ZERO },
        Along::ObjectSpace => Offset { height: 0.0, vector: moved },
        Along::TangentSpace => Offset { height: moved.z, vector: along * moved.x + across * moved.y },
    }
}

/// Directions in which the first texture coordinate grows at the vertices of a mesh, and those across them; zero where it has none.
fn tangents(triangles: &Triangles) -> Vec<[DVec3; 2]> {
    let mut sums = vec![[DVec3::ZERO; 2]; triangles.positions.as_slice().len()];
    if triangles.uvs.is_empty() {
        return sums;
    }
    let at = in_doubles(triangles.positions.as_slice());
    for corners in triangles.corners.iter() {
        let [a, b, c] = corners.map(|corner| corner as usize);
        let (first, second) = (at[b] - at[a], at[c] - at[a]);
        let [by_first, by_second] =
            [b, c].map(|corner| (triangles.uvs[corner] - triangles.uvs[a]).as_dvec2());
        let turn = by_first.perp_dot(by_second).signum();
        let along = (first * by_second.y - second * by_first.y) * turn;
        let normal = first.cross(second);
        for corner in [a, b, c] {
            sums[corner][0] += along;
            sums[corner][1] += normal.cross(along).normalize_or_zero() * normal.length() * turn;
        }
    }
    for ([along, across], normal) in sums.iter_mut().zip(triangles.normals.iter()) {
        let normal = normal.as_dvec3();
        *along = (*along - normal * normal.dot(*along)).normalize_or_zero();
        *across = (*across - normal * normal.dot(*across)).normalize_or_zero();
    }
    sums
}

/// Positions that were displaced.
struct Moved {
    rest: Vec<[f32; 3]>,
    shapes: Vec<Vec<[f32; 3]>>,
}

impl Moved {
    fn of(triangles: &Triangles, places: &Places, offsets: &[Offset]) -> Self {
        let rest = triangles.positions.as_slice();
        let of_rest = moved(rest, &normals_of_places(rest, &triangles.corners, places), places, offsets);
        let shapes = triangles.shapes.iter().flat_map(|shapes| shapes.list()).map(|shape| {
            moved(shape, &normals_of_places(shape, &triangles.corners, places), places, offsets)
        });
        Self { rest: of_rest, shapes: shapes.collect() }
    }

    fn put_into(self, mesh: Mesh, places: &Places) -> Mesh {
        mesh.with_triangles(|triangles| {
            let normals = std::mem::take(&mut triangles.normals);
            if !normals.is_empty() {
                let of_rest = vec![self.rest.clone()];
                let shared = Shapes::new(of_rest, &triangles.corners, &normals, &places.of_vertex);
                triangles.normals = shared.normals(&self.rest, &triangles.corners);
            }
            if !self.shapes.is_empty() {
                // who shares a normal is told by those before
                let shapes = Shapes::new(self.shapes, &triangles.corners, &normals, &places.of_vertex);
                triangles.shapes = Some(Arc::new(shapes));
            }
            triangles.positions = Arc::new(VertexBuffer::new(self.rest));
        })
    }
}

/// Normals of places: means of all that is around them, also where the surface has an edge.
fn normals_of_places(positions: &[[f32; 3]], triangles: &[[u32; 3]], places: &Places) -> Vec<DVec3> {
    let at = in_doubles(positions);
    let faces: Vec<Face> =
        triangles.par_iter().map(|corners| Face::new(corners.map(|corner| at[corner as usize]))).collect();
    let mut sums = vec![DVec3::ZERO; places.count];
    for (corners, face) in triangles.iter().zip(faces) {
        for (number, corner) in corners.iter().enumerate() {
            sums[places.of_vertex[*corner as usize] as usize] += face.share(number);
        }
    }
    sums.iter_mut().for_each(|sum| *sum = sum.normalize_or_zero());
    sums
}

fn moved(positions: &[[f32; 3]], normals: &[DVec3], places: &Places, offsets: &[Offset]) -> Vec<[f32; 3]> {
    let each = positions.iter().zip(&places.of_vertex);
    let moved = each.map(|(position, place)| {
        let Offset { height, vector } = offsets[*place as usize];
        let at = Vec3::from(*position).as_dvec3() + normals[*place as usize] * height + vector;
        let is_near = at.abs().max_element() <= f64::from(LARGEST_COORDINATE);
        if is_near { at.as_vec3().to_array() } else { *position }
    });
    moved.collect()
}
