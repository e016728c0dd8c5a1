//! Vertices, edges and faces of a level, and how sharp they are.

use std::collections::HashMap;

use rayon::prelude::*;

use super::{ALWAYS_SHARP, Boundary, CageFaces, NONE, Scheme};

/// A level: faces by their corners. The faces of a cage are any polygons, those of all other levels quadrilaterals; by the rules of Loop all
/// are triangles.
#[derive(Debug)]
pub struct Topology {
    /// Number of vertices.
    pub vertices: usize,
    /// Vertex of each corner, counter-clockwise around each face.
    pub corners: Vec<u32>,
    /// Number of corners that all faces have.
    pub(super) sides: Sides,
    /// First corner of each face, and at the end the number of corners; empty where all have as many.
    begins: Vec<u32>,
    /// Face of each corner; empty where all have as many.
    faces_of: Vec<u32>,
    /// Edge from each corner to the next one of its face.
    pub edge_of: Vec<u32>,
    /// Ends of each edge.
    pub ends: Vec<[u32; 2]>,
    /// Corners at which the two faces of an edge begin it: the second is missing at a boundary, both are where more than two faces meet
    /// or two that turn the other way round.
    pub begun_at: Vec<[u32; 2]>,
    /// Sharpness of edges; boundaries are always sharp.
    pub edge_sharpness: Vec<f32>,
    /// Sharpness of vertices; those are always sharp around which faces are no single fan.
    pub vertex_sharpness: Vec<f32>,
    /// First entry of each vertex in `around`; at the end its length.
    around_begins: Vec<u32>,
    /// Corners at each vertex, in their order.
    around: Vec<u32>,
}

/// Number of corners that faces of a level have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sides {
    /// All are triangles, and are refined to triangles.
    Three,
    /// All are quadrilaterals.
    Four,
    /// Any.
    Any,
}

impl Topology {
    /// The level of a cage itself.
    pub fn new(cage: &CageFaces<'_>) -> Self {
        let mut begins = Vec::with_capacity(cage.counts.len() + 1);
        let mut sum = 0;
        begins.push(0);
        begins.extend(cage.counts.iter().map(|count| {
            sum += count;
            sum
        }));
        let corners = cage.corners[..sum as usize].to_vec();
        let sides = match cage.scheme {
            Scheme::Loop => Sides::Three,
            _ if cage.counts.iter().all(|count| *count == 4) => Sides::Four,
            _ => Sides::Any,
        };
        let faces_of = if sides != Sides::Any {
            Vec::new()
        } else {
            let each = cage.counts.iter().enumerate();
            each.flat_map(|(face, count)| std::iter::repeat_n(face as u32, *count as usize)).collect()
        };
        let (around_begins, around) = corners_around(cage.points, &corners);
        let mut level = Self {
            vertices: cage.points,
            edge_of: vec![NONE; corners.len()],
            corners,
            begins: if sides == Sides::Any { begins } else { Vec::new() },
            sides,
            faces_of,
            ends: Vec::new(),
            begun_at: Vec::new(),
            edge_sharpness: Vec::new(),
            vertex_sharpness: vec![0.0; cage.points],
            around_begins,
            around,
        };
        level.find_edges(cage);
        for (point, sharpness) in cage.sharp_points {
            let known = &mut level.vertex_sharpness[*point as usize];
            *known = known.max(*sharpness);
        }
        level.sharpen_ends(cage.boundary);
        level
    }

    /// Finds the edges of a cage, in the order of their ends.
    fn find_edges(&mut self, cage: &CageFaces<'_>) {
        let mut sharpness: HashMap<[u32; 2], f32> = HashMap::with_capacity(cage.creases.len());
        for ([a, b], sharp) in cage.creases {
            let known = sharpness.entry([*a.min(b), *a.max(b)]).or_insert(0.0);
            *known = known.max(*sharp);
        }
        let ends_of = |corner: u32| {
            let [a, b] = [corner, self.next(corner)].map(|corner| self.corners[corner as usize]);
            [a.min(b), a.max(b)]
        };
        let mut sorted: Vec<([u32; 2], u32)> =
            (0..self.corners.len() as u32).into_par_iter().map(|corner| (ends_of(corner), corner)).collect();
        sorted.par_sort_unstable();
        for same in sorted.chunk_by(|a, b| a.0 == b.0) {
            let ends = same[0].0;
            same.iter().for_each(|(_, corner)| self.edge_of[*corner as usize] = self.ends.len() as u32);
            let begins = |corner: u32| self.corners[corner as usize];
            let begun_at = match same {
                [(_, corner)] => [*corner, NONE],
                [(_, one), (_, other)] if begins(*one) != begins(*other) => [*one, *other],
                _ => [NONE; 2],
            };
            let stated = sharpness.get(&ends).copied().unwrap_or(0.0);
            let is_open = begun_at[1] == NONE;
            self.edge_sharpness.push(if is_open { f32::INFINITY } else { stated });
            self.begun_at.push(if ends[0] == ends[1] { [NONE; 2] } else { begun_at });
            self.ends.push(ends);
        }
    }

    /// Sharpens the vertices of a cage around which faces are no single fan, and corners of its boundary.
    fn sharpen_ends(&mut self, boundary: Boundary) {
        let always = |vertex: u32| {
            let around = self.around(vertex);
            let is_corner = boundary == Boundary::EdgesAndCorners
                && around.len() == 1
                && [around[0], self.previous(around[0])].iter().all(|corner| {
                    self.edge_sharpness[self.edge_of[*corner as usize] as usize] >= ALWAYS_SHARP
                });
            is_corner || !around.is_empty() && self.fan_length(vertex) != Some(around.len())
        };
        let sharp: Vec<u32> =
            (0..self.vertices as u32).into_par_iter().filter(|vertex| always(*vertex)).collect();
        sharp.into_iter().for_each(|vertex| self.vertex_sharpness[vertex as usize] = f32::INFINITY);
    }

    /// Number of corners in the fan of a vertex from its first corner on, or of that which begins at the boundary. `None`: it has several
    /// beginnings, or edges at which faces are no pair.
    fn fan_length(&self, vertex: u32) -> Option<usize> {
        let around = self.around(vertex);
        let edge = |corner: u32| self.edge_of[corner as usize] as usize;
        let is_pair = |corner: &u32| {
            [*corner, self.previous(*corner)].iter().all(|corner| self.begun_at[edge(*corner)][0] != NONE)
        };
        if !around.iter().all(is_pair) {
            return None;
        }
        let mut starts = around.iter().filter(|corner| self.begun_at[edge(**corner)][1] == NONE);
        let start = starts.next();
        if starts.next().is_some() {
            return None;
        }
        let first = *start.unwrap_or(&around[0]);
        let (mut at, mut length) = (first, 1);
        while let Some(next) = self.left_of(at)
            && next != first
            && length <= around.len()
        {
            (at, length) = (next, length + 1);
        }
        Some(length)
    }

    /// Number of faces.
    pub fn faces(&self) -> usize {
        match self.sides {
            Sides::Three => self.corners.len() / 3,
            Sides::Four => self.corners.len() / 4,
            Sides::Any => self.begins.len() - 1,
        }
    }

    /// Returns true if faces are as those of all finer levels are: quadrilaterals, or triangles.
    pub fn is_uniform(&self) -> bool {
        self.sides != Sides::Any
    }

    /// Number of faces of the next level.
    pub fn next_faces(&self) -> usize {
        match self.sides {
            Sides::Three => self.corners.len() / 3 * 4,
            Sides::Four | Sides::Any => self.corners.len(),
        }
    }

    /// Face of this level that a face of the next level is a part of.
    pub fn face_before(&self, next_face: u32) -> u32 {
        match self.sides {
            Sides::Three => next_face / 4,
            Sides::Four | Sides::Any => self.face_of(next_face),
        }
    }

    /// Vertex of the next level in the middle of a face. Triangles have none.
    pub fn vertex_of_face(&self, face: u32) -> Option<usize> {
        (self.sides != Sides::Three).then(|| self.vertices + face as usize)
    }

    /// Vertex of the next level in the middle of an edge.
    pub fn vertex_of_edge(&self, edge: u32) -> usize {
        let of_faces = if self.sides == Sides::Three { 0 } else { self.faces() };
        self.vertices + of_faces + edge as usize
    }

    /// Corners of a face.
    pub fn corners_of(&self, face: u32) -> std::ops::Range<u32> {
        match self.sides {
            Sides::Three => 3 * face..3 * face + 3,
            Sides::Four => 4 * face..4 * face + 4,
            Sides::Any => self.begins[face as usize]..self.begins[face as usize + 1],
        }
    }

    /// Face of a corner.
    #[inline]
    pub fn face_of(&self, corner: u32) -> u32 {
        match self.sides {
            Sides::Three => corner / 3,
            Sides::Four => corner / 4,
            Sides::Any => self.faces_of[corner as usize],
        }
    }

    /// The corner after one in its face.
    #[inline]
    pub fn next(&self, corner: u32) -> u32 {
        if self.sides == Sides::Four {
            return corner & !3 | (corner + 1) & 3;
        }
        let std::ops::Range { start, end } = self.corners_of(self.face_of(corner));
        if corner + 1 == end { start } else { corner + 1 }
    }

    /// The corner before one in its face.
    #[inline]
    pub fn previous(&self, corner: u32) -> u32 {
        if self.sides == Sides::Four {
            return corner & !3 | (corner + 3) & 3;
        }
        let std::ops::Range { start, end } = self.corners_of(self.face_of(corner));
        if corner == start { end - 1 } else { corner - 1 }
    }

    /// Corners at a vertex.
    #[inline]
    pub fn around(&self, vertex: u32) -> &[u32] {
        let [first, end] = [0, 1].map(|more| self.around_begins[vertex as usize + more] as usize);
        &self.around[first..end]
    }

    /// The corner at the same vertex in the next face, counter-clockwise around it; none beyond a boundary.
    #[inline]
    pub fn left_of(&self, corner: u32) -> Option<u32> {
        let before = self.previous(corner);
        self.other_side(before)
    }

    /// The corner at the same vertex in the next face, clockwise around it; none beyond a boundary.
    #[inline]
    pub fn right_of(&self, corner: u32) -> Option<u32> {
        self.other_side(corner).map(|beyond| self.next(beyond))
    }

    /// Corner at which the other face begins the edge that is begun at `corner`.
    fn other_side(&self, corner: u32) -> Option<u32> {
        let [one, other] = self.begun_at[self.edge_of[corner as usize] as usize];
        let beyond = if one == corner { other } else { one };
        (beyond != NONE && other != NONE).then_some(beyond)
    }

    /// The next level: vertices are those of this one, then one of each face, then one of each edge. Face number `c` is what corner `c` of
    /// this level has of its face, from its vertex on. Triangles are refined otherwise (`triangles.rs`).
    pub fn refined(&self) -> Self {
        if self.sides == Sides::Three {
            return self.refined_triangles();
        }
        let (faces, edges) = (self.faces(), self.ends.len());
        let of_face = |face: u32| self.vertices as u32 + face;
        let of_edge = |edge: u32| (self.vertices + faces) as u32 + edge;
        let count = self.corners.len();
        // edges are the halves of this level's, then one of each corner: from its edge to its face
        let half = |edge: u32, end: u32| 2 * edge + u32::from(self.ends[edge as usize][0] != end);
        let across = |corner: u32| (2 * edges) as u32 + corner;
        let child = |corner: u32| {
            let (vertex, before) = (self.corners[corner as usize], self.previous(corner));
            let [out, back] = [corner, before].map(|corner| self.edge_of[corner as usize]);
            let vertices = [vertex, of_edge(out), of_face(self.face_of(corner)), of_edge(back)];
            (vertices, [half(out, vertex), across(corner), across(before), half(back, vertex)])
        };
        let (mut corners, mut edge_of) = (vec![[0; 4]; count], vec![[0; 4]; count]);
        let each = corners.par_iter_mut().zip(edge_of.par_iter_mut()).enumerate();
        each.for_each(|(corner, (corners, edges))| (*corners, *edges) = child(corner as u32));
        let (corners, edge_of) = (corners.into_flattened(), edge_of.into_flattened());
        let ends = (0..edges as u32)
            .flat_map(|edge| self.ends[edge as usize].map(|end| [end, of_edge(edge)]))
            .chain(
                (0..count as u32)
                    .map(|corner| [of_edge(self.edge_of[corner as usize]), of_face(self.face_of(corner))]),
            )
            .collect::<Vec<_>>();
        self.next_level(Sides::Four, faces, (corners, edge_of, ends))
    }

    /// The next level by its corners, the edges from each of them and the ends of these: vertices of this level come first, then `inner` ones
    /// within faces, then those of edges; halves of this level's edges first, then those within faces.
    pub(super) fn next_level(
        &self,
        sides: Sides,
        inner: usize,
        (corners, edge_of, ends): (Vec<u32>, Vec<u32>, Vec<[u32; 2]>),
    ) -> Self {
        let edges = self.ends.len();
        let edge_sharpness = self.edge_sharpness.iter().flat_map(|sharpness| [softened(*sharpness); 2]);
        let edge_sharpness = edge_sharpness.chain(std::iter::repeat_n(0.0, ends.len() - 2 * edges)).collect();
        let is_odd = |edge: usize| self.begun_at[edge][0] == NONE;
        let of_edges = (0..edges).map(|edge| if is_odd(edge) { f32::INFINITY } else { 0.0 });
        let vertex_sharpness = self.vertex_sharpness.iter().map(|sharpness| softened(*sharpness));
        let vertex_sharpness =
            vertex_sharpness.chain(std::iter::repeat_n(0.0, inner)).chain(of_edges).collect();
        let vertices = self.vertices + inner + edges;
        let mut begun_at = vec![[NONE; 2]; ends.len()];
        for (corner, edge) in (0..).zip(&edge_of) {
            let edge = *edge as usize;
            if edge < 2 * edges && is_odd(edge / 2) {
                continue;
            }
            let [one, other] = &mut begun_at[edge];
            *(if *one == NONE { one } else { other }) = corner;
        }
        let (around_begins, around) = corners_around(vertices, &corners);
        Self {
            vertices,
            corners,
            sides,
            begins: Vec::new(),
            faces_of: Vec::new(),
            edge_of,
            ends,
            begun_at,
            edge_sharpness,
            vertex_sharpness,
            around_begins,
            around,
        }
    }

    /// Number of edges that are no pair of faces turning the same way, nor a boundary.
    pub fn odd_edges(&self) -> usize {
        self.begun_at.iter().filter(|begun| begun[0] == NONE).count()
    }
}

/// Sharpness one level further.
pub fn softened(sharpness: f32) -> f32 {
    if sharpness >= ALWAYS_SHARP { sharpness } else { (sharpness - 1.0).max(0.0) }
}

/// Corners at each vertex: where they begin in a list, and the list.
fn corners_around(vertices: usize, corners: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut begins = vec![0; vertices + 1];
    corners.iter().for_each(|vertex| begins[*vertex as usize + 1] += 1);
    let mut sum = 0;
    begins.iter_mut().for_each(|begin| {
        sum += *begin;
        *begin = sum;
    });
    let (mut next, mut around) = (begins.clone(), vec![0; corners.len()]);
    for (corner, vertex) in (0..).zip(corners) {
        let at = &mut next[*vertex as usize];
        around[*at as usize] = corner;
        *at += 1;
    }
    (begins, around)
}
