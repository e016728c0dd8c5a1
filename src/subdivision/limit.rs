//! Where the vertices of a level go in the end, and the normals of the surface there.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::ring::Ring;
use super::topology::{Sides, Topology};
use super::{ALWAYS_SHARP, Scheme, triangles};

/// Points of the limit surface. Where edges stay sharp a vertex has several normals, one a side.
#[derive(Debug)]
pub struct Limit {
    /// Place of each vertex.
    pub positions: Vec<DVec3>,
    /// Normals: first one for each vertex, then more of those that have several. Unit length, or zero.
    pub normals: Vec<DVec3>,
    /// Vertex of each normal after those.
    pub more: Vec<u32>,
    /// Number of the normal at each corner of the level.
    pub normal_of: Vec<u32>,
}

/// What is found of a vertex.
struct Found {
    position: DVec3,
    normal: DVec3,
    /// Further normals, with their corners.
    more: Vec<(DVec3, Vec<u32>)>,
}

impl Topology {
    /// Returns true if nothing at a vertex is sharp.
    fn is_smooth(&self, vertex: u32) -> bool {
        self.vertex_sharpness[vertex as usize] == 0.0
            && self.edges_around(vertex).all(|edge| self.edge_sharpness[edge] == 0.0)
    }

    /// Where vertices with these values go. All faces are quadrilaterals, or triangles.
    pub(super) fn limits(&self, values: &[DVec3]) -> Vec<DVec3> {
        let limit = |ring: &mut Ring, vertex: u32| {
            let own = values[vertex as usize];
            let around = self.around(vertex);
            if around.is_empty() || self.vertex_sharpness[vertex as usize] >= ALWAYS_SHARP {
                return own;
            }
            if self.is_smooth(vertex) {
                let count = around.len() as f64;
                let value = |corner: u32| values[self.corners[corner as usize] as usize];
                if self.sides == Sides::Three {
                    let sum = around.iter().map(|corner| value(self.next(*corner))).sum();
                    return triangles::limit(own, around.len(), sum);
                }
                let of_corner = |corner: &u32| {
                    let next = self.next(*corner);
                    value(next) * 4.0 + value(self.next(next))
                };
                let sum: DVec3 = around.iter().map(of_corner).sum();
                return (own * (count * count) + sum) / (count * (count + 5.0));
            }
            self.take(vertex, around[0], values, ring);
            ring.settle();
            ring.limit()
        };
        (0..self.vertices as u32).into_par_iter().map_init(Ring::default, limit).collect()
    }

    /// Takes the fan of faces around a vertex that has a face at this corner. Returns its corners, in order.
    fn take(&self, vertex: u32, corner: u32, values: &[DVec3], ring: &mut Ring) -> Vec<u32> {
        let mut first = corner;
        while let Some(right) = self.right_of(first) {
            first = right;
            if right == corner {
                break;
            }
        }
        ring.clear();
        ring.is_of_triangles = self.sides == Sides::Three;
        ring.middle = values[vertex as usize];
        ring.own_sharpness = self.vertex_sharpness[vertex as usize];
        let value = |corner: u32| values[self.corners[corner as usize] as usize];
        let (mut at, mut corners) = (first, Vec::new());
        loop {
            let next = self.next(at);
            ring.edges.push(value(next));
            ring.faces.push(value(self.next(next)));
            ring.sharpness.push(self.edge_sharpness[self.edge_of[at as usize] as usize]);
            corners.push(at);
            match self.left_of(at) {
                Some(left) if left == first => break,
                Some(left) => at = left,
                None => {
                    let before = self.previous(at);
                    ring.edges.push(value(before));
                    ring.sharpness.push(self.edge_sharpness[self.edge_of[before as usize] as usize]);
                    break;
                }
            }
        }
        corners
    }
}

impl Limit {
    /// The limit of a level whose vertices have these `positions`. Of the bilinear scheme vertices are where they are, with the mean normal
    /// of what is around them.
    pub(super) fn of(level: &Topology, scheme: Scheme, positions: &[DVec3]) -> Self {
        let of_vertex = |ring: &mut Ring, vertex: u32| found(level, scheme, positions, (ring, vertex));
        let all: Vec<Found> =
            (0..level.vertices as u32).into_par_iter().map_init(Ring::default, of_vertex).collect();
        let mut limit = Self {
            positions: all.iter().map(|found| found.position).collect(),
            normals: all.iter().map(|found| found.normal).collect(),
            more: Vec::new(),
            normal_of: level.corners.clone(),
        };
        for (vertex, found) in (0..).zip(&all) {
            for (normal, corners) in &found.more {
                let number = limit.normals.len() as u32;
                limit.normals.push(*normal);
                limit.more.push(vertex);
                corners.iter().for_each(|corner| limit.normal_of[*corner as usize] = number);
            }
        }
        limit
    }

    /// Vertex of a normal.
    pub fn vertex_of(&self, normal: u32) -> u32 {
        let more = (normal as usize).checked_sub(self.positions.len());
        more.map_or(normal, |number| self.more[number])
    }
}

fn found(level: &Topology, scheme: Scheme, positions: &[DVec3], (ring, vertex): (&mut Ring, u32)) -> Found {
    let mut found = Found { position: positions[vertex as usize], normal: DVec3::ZERO, more: Vec::new() };
    let is_single = level.vertex_sharpness[vertex as usize].is_finite();
    let around = level.around(vertex);
    let (mut seen, mut is_first) = (HashSet::new(), true);
    for corner in around {
        if !seen.is_empty() && seen.contains(corner) {
            continue;
        }
        let corners = level.take(vertex, *corner, positions, ring);
        if scheme == Scheme::Bilinear {
            found.normal += ring.facets();
        } else {
            ring.settle();
            if is_single && is_first {
                found.position = ring.limit();
            }
            for ([first, faces], normal) in ring.normals() {
                if is_first {
                    (found.normal, is_first) = (normal, false);
                } else {
                    let of = (0..faces).map(|face| corners[(first + face) % corners.len()]);
                    found.more.push((normal, of.collect()));
                }
            }
        }
        if corners.len() == around.len() {
            break;
        }
        seen.extend(corners);
    }
    if scheme == Scheme::Bilinear {
        found.normal = found.normal.normalize_or_zero();
    }
    found
}
