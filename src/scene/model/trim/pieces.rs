//! Parts of triangles that were trimmed, and the mesh that they make.

use std::collections::HashMap;
use std::iter;
use std::ops::Range;
use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};
use half::f16;

use crate::scene::cutout::CutTriangles;
use crate::scene::cutout::outline::HalfPlane;
use crate::scene::details::{Details, Tangents};
use crate::scene::mesh::Groups;
use crate::scene::{Geometry, Mesh, Triangles};

/// Share of an island's area above which it is not trimmed: little would be saved.
const MOST_LEFT: f64 = 0.85;

/// Weights that differ by less are those of one place.
const ONE_PLACE: f64 = 1e-6;

/// A triangle that is cut out by a picture.
#[derive(Debug, Clone, Copy)]
pub struct Outlined {
    /// Its number in the mesh.
    pub number: usize,
    /// Its corners in the picture, in texels.
    pub texels: [DVec2; 3],
}

/// Corner of a part of a triangle.
#[derive(Debug, Clone, Copy)]
struct Corner {
    texel: DVec2,
    /// Weights of the triangle's corners.
    weights: DVec3,
    place: Place,
    /// Number of the triangle's edge that goes on from here to the next corner, if it is one: from that corner of the triangle on.
    edge: Option<usize>,
}

/// Place of a corner, by which triangles that share it know it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Place {
    /// Vertex of the mesh.
    Vertex(u32),
    /// Place on the edge between two vertices, the lower number first, at the border of a half plane of an island.
    Edge { ends: [u32; 2], island: u32, half: u32 },
    /// Place inside a triangle, at the crossing of two borders.
    Inside { triangle: u32, number: u32 },
}

/// A mesh that is being trimmed: its vertices, with those that were added, and parts of its triangles.
pub struct Pieces<'a> {
    mesh: &'a Mesh,
    all: &'a Triangles,
    /// What is left of triangles that were trimmed, by their number: corners by the numbers of vertices, with their weights.
    of: HashMap<usize, Vec<[(u32, DVec3); 3]>>,
    vertices: HashMap<Place, u32>,
    positions: Vec<[f32; 3]>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    colors: Vec<[f16; 3]>,
    second_uvs: Vec<Vec2>,
    alphas: Vec<f32>,
}

impl<'a> Pieces<'a> {
    /// Starts with `all` triangles of `mesh`.
    pub fn new(mesh: &'a Mesh, all: &'a Triangles) -> Self {
        let Details { colors, second_uvs, alphas, .. } = mesh.details.as_ref();
        Self {
            mesh,
            all,
            of: HashMap::new(),
            vertices: HashMap::new(),
            positions: all.positions.as_slice().to_vec(),
            normals: all.normals.clone(),
            uvs: all.uvs.clone(),
            colors: colors.clone(),
            second_uvs: second_uvs.clone(),
            alphas: alphas.clone(),
        }
    }

    /// Trims an island to what is within all `halves`, if that is worth it and there is room for more triangles.
    pub fn trim(&mut self, triangles: &[Outlined], island: u32, halves: &[HalfPlane], room: &mut usize) {
        let polygons: Vec<Vec<Corner>> =
            triangles.iter().map(|triangle| self.clipped(triangle, island, halves)).collect();
        let area = |triangle: &Outlined| {
            let [a, b, c] = self.all.positions_of(triangle.number as u32).map(|corner| corner.as_dvec3());
            (b - a).cross(c - a).length()
        };
        let areas = || triangles.iter().map(area);
        let left: f64 = areas().zip(&polygons).map(|(area, polygon)| area * share_of(polygon)).sum();
        let added = polygons.iter().map(|polygon| polygon.len().saturating_sub(2)).sum::<usize>();
        let added = added.saturating_sub(triangles.len());
        // without any area it is as good as it can be
        if left >= MOST_LEFT * areas().sum::<f64>() || added > *room {
            return;
        }
        *room -= added;
        for (triangle, polygon) in triangles.iter().zip(&polygons) {
            let corners: Vec<(u32, DVec3)> =
                polygon.iter().map(|corner| (self.vertex(triangle.number, corner), corner.weights)).collect();
            let fan = match corners.as_slice() {
                [first, others @ ..] => others.windows(2).map(|next| [*first, next[0], next[1]]).collect(),
                [] => Vec::new(),
            };
            self.of.insert(triangle.number, fan);
        }
    }

    /// Polygon of what is within all `halves` of a triangle; empty if nothing is.
    fn clipped(&self, triangle: &Outlined, island: u32, halves: &[HalfPlane]) -> Vec<Corner> {
        let ends = self.all.corners[triangle.number];
        let mut polygon: Vec<Corner> = (0..3)
            .map(|i| Corner {
                texel: triangle.texels[i],
                weights: DVec3::AXES[i],
                place: Place::Vertex(ends[i]),
                edge: Some(i),
            })
            .collect();
        let mut crossings = 0;
        for (number, half) in (0..).zip(halves) {
            let mut rest = Vec::with_capacity(polygon.len() + 1);
            for (i, from) in polygon.iter().enumerate() {
                let to = &polygon[(i + 1) % polygon.len()];
                let beyond = [from, to].map(|corner| half.beyond(corner.texel));
                let leaves = beyond[0] <= 0.0 && beyond[1] > 0.0;
                if beyond[0] <= 0.0 {
                    rest.push(*from);
                }
                if leaves || (beyond[0] > 0.0 && beyond[1] <= 0.0) {
                    // the border goes on where the polygon leaves; where it comes back, its edge does
                    let edge = if leaves { None } else { from.edge };
                    let crossing = match from.edge {
                        Some(edge) => on_edge((triangle, ends), edge, half, (island, number)),
                        None => {
                            let t = beyond[0] / (beyond[0] - beyond[1]);
                            crossings += 1;
                            let place = Place::Inside { triangle: triangle.number as u32, number: crossings };
                            let (texel, weights) =
                                (from.texel.lerp(to.texel, t), from.weights.lerp(to.weights, t));
                            Corner { texel, weights, place, edge: None }
                        }
                    };
                    rest.push(Corner { edge, ..crossing });
                }
            }
            polygon = rest;
        }
        without_twins(&polygon)
    }

    /// Number of the vertex at a corner of a part of a triangle: added if it is new.
    fn vertex(&mut self, triangle: usize, corner: &Corner) -> u32 {
        if let Place::Vertex(vertex) = corner.place {
            return vertex;
        }
        let next = self.positions.len() as u32;
        let vertex = *self.vertices.entry(corner.place).or_insert(next);
        if vertex == next {
            let ends = self.all.corners[triangle].map(|end| end as usize);
            let weights = corner.weights.to_array();
            let mixed3 = |of: &dyn Fn(usize) -> DVec3| -> DVec3 {
                ends.iter().zip(weights).map(|(end, weight)| of(*end) * weight).sum()
            };
            let mixed2 = |of: &[Vec2]| -> Vec2 {
                ends.iter()
                    .zip(weights)
                    .map(|(end, weight)| of[*end].as_dvec2() * weight)
                    .sum::<DVec2>()
                    .as_vec2()
            };
            let position = mixed3(&|end| Vec3::from(self.positions[end]).as_dvec3());
            self.positions.push(position.as_vec3().to_array());
            if !self.normals.is_empty() {
                let normal = mixed3(&|end| self.normals[end].as_dvec3());
                self.normals.push(normal.normalize_or(DVec3::ZERO).as_vec3());
            }
            if !self.uvs.is_empty() {
                self.uvs.push(mixed2(&self.uvs));
            }
            if !self.second_uvs.is_empty() {
                self.second_uvs.push(mixed2(&self.second_uvs));
            }
            if !self.colors.is_empty() {
                let color = mixed3(&|end| DVec3::from(self.colors[end].map(f64::from)));
                self.colors.push(color.to_array().map(f16::from_f64));
            }
            if !self.alphas.is_empty() {
                let alpha = mixed3(&|end| DVec3::splat(self.alphas[end].into()));
                self.alphas.push(alpha.x as f32);
            }
        }
        vertex
    }

    /// The trimmed mesh. `None` if nothing was trimmed, or nothing is left.
    pub fn finish(self, cut: &CutTriangles) -> Option<Mesh> {
        let Self { mesh, all, of, .. } = self;
        let count = all.corners.len();
        // number of the first part of each triangle, and that after the last
        let mut firsts = Vec::with_capacity(count + 1);
        firsts.push(0_u32);
        let (mut triangles, mut tangents): (Vec<[u32; 3]>, Vec<Tangents>) = Default::default();
        let has_tangents = !mesh.details.tangents.is_empty();
        for number in 0..count {
            match of.get(&number) {
                None => {
                    triangles.push(all.corners[number]);
                    tangents.extend(mesh.details.tangents.get(number));
                }
                Some(parts) => {
                    triangles.extend(parts.iter().map(|part| part.map(|(vertex, _)| vertex)));
                    let of_part = |part: &[(u32, DVec3); 3]| {
                        mesh.details.tangents[number].of_part(part.map(|(_, weights)| weights))
                    };
                    tangents.extend(parts.iter().filter(|_| has_tangents).map(of_part));
                }
            }
            firsts.push(triangles.len() as u32);
        }
        if of.is_empty() || triangles.is_empty() {
            return None;
        }
        let kept = renumber(self.positions.len(), &mut triangles);
        let parts_of = |number: usize| (firsts[number + 1] - firsts[number]) as usize;
        let of_parts = |numbers: Range<usize>, of: &[u16]| -> Vec<u16> {
            numbers.zip(of).flat_map(|(number, of)| iter::repeat_n(*of, parts_of(number))).collect()
        };
        let mask_of = of_parts(cut.range(), &cut.mask_of);
        let cut = CutTriangles { first: firsts[cut.range().start], mask_of, masks: cut.masks.clone() };
        let mut groups = Groups::named(mesh.groups.names().iter().cloned());
        let ends = mesh.groups.runs().iter().skip(1).map(|(first, _)| *first).chain([count as u32]);
        for ((first, group), end) in mesh.groups.runs().iter().zip(ends) {
            if firsts[*first as usize] < firsts[end as usize] {
                groups.begin(firsts[*first as usize], *group);
            }
        }
        Some(Mesh {
            geometry: Geometry::Triangles(Triangles {
                normals: of_vertices(&kept, &self.normals),
                uvs: of_vertices(&kept, &self.uvs),
                ..Triangles::new(of_vertices(&kept, &self.positions), triangles)
            }),
            shadow_casting: firsts[mesh.shadow_casting] as usize,
            material_of: of_parts(0..count, &mesh.material_of),
            groups: Arc::new(groups),
            cut: (!cut.mask_of.is_empty()).then(|| Arc::new(cut)),
            details: Arc::new(Details {
                colors: of_vertices(&kept, &self.colors),
                second_uvs: of_vertices(&kept, &self.second_uvs),
                alphas: of_vertices(&kept, &self.alphas),
                tangents,
                space: mesh.details.space,
                volume: mesh.details.volume.clone(),
                cage: None,
            }),
        })
    }
}

/// Leaves out vertices that no triangle has: returns the former numbers of those that are left, in order, and gives triangles their new
/// ones.
fn renumber(count: usize, triangles: &mut [[u32; 3]]) -> Vec<u32> {
    let mut numbers = vec![None; count];
    triangles.as_flattened().iter().for_each(|vertex| numbers[*vertex as usize] = Some(0));
    let mut kept = Vec::new();
    for (vertex, number) in (0..).zip(&mut numbers).filter(|(_, number)| number.is_some()) {
        *number = Some(kept.len() as u32);
        kept.push(vertex);
    }
    let number = |vertex: u32| numbers[vertex as usize].expect("what triangles have is kept");
    triangles.iter_mut().for_each(|triangle| *triangle = triangle.map(number));
    kept
}

/// Values of the vertices that are kept, if vertices have any.
fn of_vertices<T: Copy>(kept: &[u32], values: &[T]) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { kept.iter().map(|vertex| values[*vertex as usize]).collect() }
}

/// The crossing of a triangle's edge with the border of `half`, which is known by the number of its island and its own: the same whichever
/// triangle asks that has the edge. `ends`: the triangle's vertices.
fn on_edge(
    (triangle, ends): (&Outlined, [u32; 3]),
    edge: usize,
    half: &HalfPlane,
    (island, number): (u32, u32),
) -> Corner {
    let other = (edge + 1) % 3;
    let [a, b] = if ends[edge] < ends[other] { [edge, other] } else { [other, edge] };
    let beyond = [a, b].map(|corner| half.beyond(triangle.texels[corner]));
    let way = beyond[0] - beyond[1];
    // rounding alone has it cross an edge that is as far beyond all along
    let t = if way == 0.0 { 0.0 } else { (beyond[0] / way).clamp(0.0, 1.0) };
    Corner {
        texel: triangle.texels[a].lerp(triangle.texels[b], t),
        weights: DVec3::AXES[a] * (1.0 - t) + DVec3::AXES[b] * t,
        place: Place::Edge { ends: [ends[a], ends[b]], island, half: number },
        edge: Some(edge),
    }
}

/// The polygon with one corner for each place: of corners in one place that which more triangles know.
fn without_twins(polygon: &[Corner]) -> Vec<Corner> {
    let rank = |corner: &Corner| match corner.place {
        Place::Vertex(_) => (0, 0),
        Place::Edge { half, .. } => (1, half),
        Place::Inside { .. } => (2, 0),
    };
    let mut kept: Vec<Corner> = Vec::with_capacity(polygon.len());
    let is_twin = |a: &Corner, b: &Corner| (a.weights - b.weights).abs().max_element() < ONE_PLACE;
    for corner in polygon {
        match kept.last_mut() {
            Some(last) if is_twin(last, corner) => {
                if rank(corner) < rank(last) {
                    *last = *corner;
                }
            }
            _ => kept.push(*corner),
        }
    }
    while let [first, .., last] = kept.as_slice() {
        if !is_twin(first, last) {
            break;
        }
        let of_first = rank(first) <= rank(last);
        let last = kept.len() - 1;
        kept.swap_remove(if of_first { last } else { 0 });
    }
    if kept.len() < 3 { Vec::new() } else { kept }
}

/// Share of a triangle's area that a part of it has.
fn share_of(polygon: &[Corner]) -> f64 {
    let place = |corner: &Corner| DVec2::new(corner.weights.y, corner.weights.z);
    let [first, others @ ..] = polygon else { return 0.0 };
    let doubled = |next: &[Corner]| (place(&next[0]) - place(first)).perp_dot(place(&next[1]) - place(first));
    others.windows(2).map(doubled).sum()
}

impl Tangents {
    /// Tangents of a part of the triangle, with corners of these weights.
    fn of_part(&self, corners: [DVec3; 3]) -> Self {
        let place = |weights: DVec3| DVec2::new(weights.y, weights.z);
        let [a, b, c] = corners.map(place);
        let from_part = DMat2::from_cols(b - a, c - a);
        if from_part.determinant() == 0.0 {
            return *self;
        }
        let [first, second, third] = self.corners.map(|shares| shares.as_dvec2());
        let shares = |weights: DVec3| {
            let of_whole = first * weights.x + second * weights.y + third * weights.z;
            (from_part.inverse() * of_whole).as_vec2()
        };
        Self { corners: corners.map(shares), ..*self }
    }
}
