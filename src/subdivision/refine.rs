//! Values of a level's vertices, of those of the level before.

use glam::DVec3;
use rayon::prelude::*;

use super::topology::{Sides, Topology, softened};
use super::triangles::divided_triangles;
use super::{NONE, Scheme};

/// What a vertex follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// All around it.
    Smooth,
    /// The two sharp edges at it.
    Crease,
    /// Nothing: it stays.
    Corner,
}

impl Rule {
    /// Rule of a vertex that is sharp itself or not, with so many sharp edges.
    pub fn new(is_sharp: bool, sharp_edges: usize) -> Self {
        match (is_sharp, sharp_edges) {
            (false, 0 | 1) => Self::Smooth,
            (false, 2) => Self::Crease,
            _ => Self::Corner,
        }
    }
}

/// Sharpness of a vertex and of the edges at it, from which its rules now and at the next level follow.
pub struct Sharpness<E> {
    /// Of the vertex itself.
    pub vertex: f32,
    /// Of its edges.
    pub edges: E,
}

impl<E: Iterator<Item = f32> + Clone> Sharpness<E> {
    /// Its rule at this level and at the next one, and the share of the first of the two where they differ: the mean of the sharpness that
    /// is gone at the next level.
    pub fn rules(self) -> ([Rule; 2], f64) {
        let Self { vertex, edges } = self;
        let rule = |change: fn(f32) -> f32| {
            let sharp = edges.clone().filter(|sharpness| change(*sharpness) > 0.0).count();
            Rule::new(change(vertex) > 0.0, sharp)
        };
        let rules = [rule(|sharpness| sharpness), rule(softened)];
        if rules[0] == rules[1] {
            return (rules, 1.0);
        }
        let goes = edges.chain([vertex]).filter(|sharpness| *sharpness > 0.0 && softened(*sharpness) == 0.0);
        let (sum, count) =
            goes.fold((0.0, 0.0), |(sum, count), sharpness| (sum + f64::from(sharpness), count + 1.0));
        (rules, if count > 0.0 { (sum / count).min(1.0) } else { 0.0 })
    }
}

impl Topology {
    /// Values of the vertices of the next level.
    pub fn refined_values(&self, scheme: Scheme, values: &[DVec3]) -> Vec<DVec3> {
        if scheme == Scheme::Loop {
            return self.refined_values_of_triangles(values);
        }
        let value = |corner: u32| values[self.corners[corner as usize] as usize];
        let of_face = |face: u32| {
            let corners = self.corners_of(face);
            corners.clone().map(value).sum::<DVec3>() / f64::from(corners.end - corners.start)
        };
        let of_faces: Vec<DVec3> = (0..self.faces() as u32).into_par_iter().map(of_face).collect();
        let of_edge = |edge: usize| {
            let [a, b] = self.ends[edge].map(|end| values[end as usize]);
            let (middle, sharpness) = ((a + b) * 0.5, f64::from(self.edge_sharpness[edge]));
            let begun_at = self.begun_at[edge];
            if scheme == Scheme::Bilinear || sharpness >= 1.0 || begun_at[1] == NONE {
                return middle;
            }
            let [one, other] = begun_at.map(|corner| of_faces[self.face_of(corner) as usize]);
            let smooth = (a + b + one + other) * 0.25;
            smooth + (middle - smooth) * sharpness
        };
        let smooth = |own: DVec3, around: &[u32]| {
            let count = around.len() as f64;
            let of_corner =
                |corner: &u32| value(self.next(*corner)) + of_faces[self.face_of(*corner) as usize];
            let sum: DVec3 = around.iter().map(of_corner).sum();
            own * ((count - 2.0) / count) + sum / (count * count)
        };
        let of_vertex = |vertex: usize| match scheme {
            Scheme::Bilinear => values[vertex],
            _ => self.refined_vertex(vertex as u32, values, smooth),
        };
        let mut refined = Vec::with_capacity(self.vertices + of_faces.len() + self.ends.len());
        refined.par_extend((0..self.vertices).into_par_iter().map(of_vertex));
        refined.extend_from_slice(&of_faces);
        refined.par_extend((0..self.ends.len()).into_par_iter().map(of_edge));
        refined
    }

    /// Values at the corners of the next level, of those at the corners of this one.
    pub fn divided_values(&self, at_corners: &[DVec3]) -> Vec<DVec3> {
        if self.sides == Sides::Three {
            return divided_triangles(at_corners);
        }
        let value = |corner: u32| at_corners[corner as usize];
        let of_corner = |corner: u32| {
            let all = self.corners_of(self.face_of(corner));
            let mean = all.clone().map(value).sum::<DVec3>() / f64::from(all.end - all.start);
            let own = value(corner);
            [own, (own + value(self.next(corner))) * 0.5, mean, (own + value(self.previous(corner))) * 0.5]
        };
        let all: Vec<[DVec3; 4]> = (0..at_corners.len() as u32).into_par_iter().map(of_corner).collect();
        all.into_flattened()
    }

    /// Value of a vertex at the next level. `smooth`: where nothing at it is sharp, of its own value and its corners.
    pub(super) fn refined_vertex(
        &self,
        vertex: u32,
        values: &[DVec3],
        smooth: impl Fn(DVec3, &[u32]) -> DVec3,
    ) -> DVec3 {
        let own = values[vertex as usize];
        let around = self.around(vertex);
        if around.is_empty() || self.vertex_sharpness[vertex as usize].is_infinite() {
            return own;
        }
        let sharpness = Sharpness {
            vertex: self.vertex_sharpness[vertex as usize],
            edges: self.edges_around(vertex).map(|edge| self.edge_sharpness[edge]),
        };
        let by = |rule: Rule, change: fn(f32) -> f32| match rule {
            Rule::Corner => own,
            Rule::Crease => {
                let sharp = self.edges_around(vertex).filter(|edge| change(self.edge_sharpness[*edge]) > 0.0);
                own * 0.75 + sharp.map(|edge| values[self.other_end(edge, vertex)]).sum::<DVec3>() * 0.125
            }
            Rule::Smooth => smooth(own, around),
        };
        let ([now, next], share) = sharpness.rules();
        let by_now = by(now, |sharpness| sharpness);
        if now == next {
            return by_now;
        }
        let by_next = by(next, softened);
        by_next + (by_now - by_next) * share
    }

    /// Edges at a vertex whose faces are one fan, each once.
    pub fn edges_around(&self, vertex: u32) -> impl Iterator<Item = usize> + Clone {
        self.around(vertex).iter().flat_map(|corner| {
            let out = self.edge_of[*corner as usize] as usize;
            let back = self.edge_of[self.previous(*corner) as usize] as usize;
            // an edge between two faces leaves the vertex in one of them
            let last = (self.begun_at[back][1] == NONE).then_some(back);
            [Some(out), last].into_iter().flatten()
        })
    }

    fn other_end(&self, edge: usize, vertex: u32) -> usize {
        let [one, other] = self.ends[edge];
        (if one == vertex { other } else { one }) as usize
    }
}
