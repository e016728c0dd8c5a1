//! Rules for cages of triangles, each of which becomes four (C. Loop, "Smooth subdivision surfaces based on triangles", 1987). Sharp edges and
//! points follow the rules of quadrilaterals. Weights are as in OpenSubdiv, but for the normal beside a crease where four triangles or more meet: here it
//! is that of the surface to which these weights lead.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::NONE;
use super::topology::{Sides, Topology};

/// Weight of each neighbour of a vertex at the next level, by their number.
fn weight(valence: usize) -> f64 {
    let valence = valence as f64;
    let part = 0.375 + 0.25 * (TAU / valence).cos();
    (0.625 - part * part) / valence
}

/// Value of a vertex at the next level, of its own and the sum of its neighbours'.
pub fn of_vertex(own: DVec3, valence: usize, sum: DVec3) -> DVec3 {
    let weight = weight(valence);
    own * (1.0 - weight * valence as f64) + sum * weight
}

/// Value in the middle of an edge at the next level, of those at its ends and of those across its two triangles.
pub fn of_edge(ends: [DVec3; 2], across: [DVec3; 2]) -> DVec3 {
    (ends[0] + ends[1]) * 0.375 + (across[0] + across[1]) * 0.125
}

/// Where a vertex goes in the end: the steady state of [`of_vertex`].
pub fn limit(own: DVec3, valence: usize, sum: DVec3) -> DVec3 {
    let of_own = 0.375 / weight(valence);
    (own * of_own + sum) / (of_own + valence as f64)
}

/// Two directions along the surface at a smooth vertex, of the ends of its edges.
pub fn tangents(ends: &[DVec3]) -> [DVec3; 2] {
    let turn = TAU / ends.len() as f64;
    let mut tangents = [DVec3::ZERO; 2];
    for (number, end) in ends.iter().enumerate() {
        let (sin, cos) = (turn * number as f64).sin_cos();
        tangents[0] += *end * cos;
        tangents[1] += *end * sin;
    }
    tangents
}

/// The direction across a crease, into the part of the surface between the first and the last of these edges: what a step from level to level
/// makes shorter by a factor and does not turn. Weights of the inner edges are half a wave; those of the others follow.
pub fn tangent_across(middle: DVec3, ends: &[DVec3]) -> DVec3 {
    let faces = ends.len() - 1;
    let both = ends[0] + ends[faces];
    if faces == 1 {
        return both - middle * 2.0;
    }
    let angle = PI / faces as f64;
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (number, end) in ends.iter().enumerate().take(faces).skip(1) {
        let weight = (angle * number as f64).sin();
        (sum, weights) = (sum + *end * weight, weights + weight);
    }
    // the factor is 3/8 + cos(angle)/4
    let of_both = (angle.sin() - weights) / (1.0 + 2.0 * angle.cos());
    sum + both * of_both - middle * (weights + 2.0 * of_both)
}

impl Topology {
    /// The next level of triangles: vertices are those of this one, then one of each edge. Triangle `t` becomes the triangles from `4 t` on:
    /// what each of its corners has of it, from its vertex on, and the one in the middle, from its first edge on.
    pub(super) fn refined_triangles(&self) -> Self {
        let edges = self.ends.len() as u32;
        let of_edge = |edge: u32| self.vertices as u32 + edge;
        // edges are the halves of this level's, then one of each corner: across its triangle
        let half = |edge: u32, end: u32| 2 * edge + u32::from(self.ends[edge as usize][0] != end);
        let across = |corner: u32| 2 * edges + corner;
        let around =
            |corner: u32| [corner, self.previous(corner)].map(|corner| self.edge_of[corner as usize]);
        let (mut corners, mut edge_of) = (vec![[0; 12]; self.faces()], vec![[0; 12]; self.faces()]);
        let each = corners.par_iter_mut().zip(edge_of.par_iter_mut()).enumerate();
        each.for_each(|(face, (corners, edges))| {
            for (number, corner) in self.corners_of(face as u32).enumerate() {
                let (vertex, [out, back]) = (self.corners[corner as usize], around(corner));
                let at = 3 * number;
                corners[at..at + 3].copy_from_slice(&[vertex, of_edge(out), of_edge(back)]);
                edges[at..at + 3].copy_from_slice(&[half(out, vertex), across(corner), half(back, vertex)]);
                // around the middle one: from this corner's edge to that of the next one
                (corners[9 + number], edges[9 + number]) = (of_edge(out), across(self.next(corner)));
            }
        });
        let of_halves = (0..edges).flat_map(|edge| self.ends[edge as usize].map(|end| [end, of_edge(edge)]));
        let of_corners = (0..self.corners.len() as u32).map(|corner| around(corner).map(of_edge));
        let ends = of_halves.chain(of_corners).collect();
        self.next_level(Sides::Three, 0, (corners.into_flattened(), edge_of.into_flattened(), ends))
    }

    /// Values of the vertices of the next level.
    pub(super) fn refined_values_of_triangles(&self, values: &[DVec3]) -> Vec<DVec3> {
        let value = |corner: u32| values[self.corners[corner as usize] as usize];
        let smooth = |own: DVec3, around: &[u32]| {
            of_vertex(own, around.len(), around.iter().map(|corner| value(self.next(*corner))).sum())
        };
        let on_edge = |edge: usize| {
            let ends = self.ends[edge].map(|end| values[end as usize]);
            let (middle, sharpness) = ((ends[0] + ends[1]) * 0.5, f64::from(self.edge_sharpness[edge]));
            let begun_at = self.begun_at[edge];
            if sharpness >= 1.0 || begun_at[1] == NONE {
                return middle;
            }
            let smooth = of_edge(ends, begun_at.map(|corner| value(self.previous(corner))));
            smooth + (middle - smooth) * sharpness
        };
        let mut refined = Vec::with_capacity(self.vertices + self.ends.len());
        let vertices = (0..self.vertices as u32).into_par_iter();
        refined.par_extend(vertices.map(|vertex| self.refined_vertex(vertex, values, smooth)));
        refined.par_extend((0..self.ends.len()).into_par_iter().map(on_edge));
        refined
    }
}

/// Values at the corners of the next level, of those at the corners of triangles, each of which is divided by itself.
pub fn divided_triangles(at_corners: &[DVec3]) -> Vec<DVec3> {
    let divided = |corners: &[DVec3]| {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        [a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca]
    };
    let all: Vec<[DVec3; 12]> = at_corners.par_chunks_exact(3).map(divided).collect();
    all.into_flattened()
}
