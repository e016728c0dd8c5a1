//! A vertex and the faces around it, quadrilaterals or triangles: all that decides where it goes, and which way the surface faces there.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::ALWAYS_SHARP;
use super::refine::{Rule, Sharpness};
use super::topology::softened;
use super::triangles;

/// Number of steps after which the facets around a vertex lie as the surface does there.
const STEPS_TO_FACETS: usize = 16;

/// The same, at corners of several faces: there the plane of the surface turns on for ever, slowly, and what is near the vertex counts.
const STEPS_AT_CORNERS: usize = 2;

/// Number of steps after which the end of a sharp edge is where it goes, to the last bits: each halves the rest of the way.
const STEPS_TO_LIMIT: usize = 52;

/// A vertex and its neighbours, counter-clockwise: vertices along its edges, and those across its faces.
#[derive(Debug, Clone, Default)]
pub struct Ring {
    /// The vertex.
    pub middle: DVec3,
    /// Ends of its edges; of a fan that is not closed one more than it has faces.
    pub edges: Vec<DVec3>,
    /// Corners across its faces: that of face `i` lies between edges `i` and `i + 1`. Of a triangle the end of edge `i + 1` again.
    pub faces: Vec<DVec3>,
    /// True if its faces are triangles, by the rules of Loop.
    pub is_of_triangles: bool,
    /// Sharpness of its edges.
    pub sharpness: Vec<f32>,
    /// Sharpness of the vertex.
    pub own_sharpness: f32,
    /// Kept for steps.
    next: (Vec<DVec3>, Vec<DVec3>),
}

impl Ring {
    /// Empties it.
    pub fn clear(&mut self) {
        self.edges.clear();
        self.faces.clear();
        self.sharpness.clear();
    }

    fn is_closed(&self) -> bool {
        self.edges.len() == self.faces.len()
    }

    /// Refines it until nothing of it is sharp for a few levels only: where that ends the rules for limits hold.
    pub fn settle(&mut self) {
        let is_passing = |sharpness: &f32| *sharpness > 0.0 && *sharpness < ALWAYS_SHARP;
        while self.sharpness.iter().any(is_passing) || is_passing(&self.own_sharpness) {
            self.step();
        }
    }

    /// The vertex and its neighbours one level further.
    fn step(&mut self) {
        let Self { middle, edges, faces, sharpness, own_sharpness, next: (new_edges, new_faces), .. } = self;
        let (count, own, is_of_triangles) = (edges.len(), *middle, self.is_of_triangles);
        new_faces.clear();
        let quad = |face: usize| (own + edges[face] + faces[face] + edges[(face + 1) % count]) * 0.25;
        new_faces.extend((0..faces.len()).map(quad));
        new_edges.clear();
        let before = |edge: usize| if edge > 0 { edge - 1 } else { faces.len() - 1 };
        new_edges.extend((0..count).map(|edge| {
            let half = (own + edges[edge]) * 0.5;
            let sharp = f64::from(sharpness[edge]);
            if sharp >= 1.0 {
                return half;
            }
            let smooth = match is_of_triangles {
                true => triangles::of_edge(
                    [own, edges[edge]],
                    [before(edge) % count, edge + 1].map(|at| edges[at % count]),
                ),
                false => (own + edges[edge] + new_faces[before(edge)] + new_faces[edge]) * 0.25,
            };
            smooth + (half - smooth) * sharp
        }));
        if is_of_triangles {
            new_faces
                .iter_mut()
                .enumerate()
                .for_each(|(face, across)| *across = new_edges[(face + 1) % count]);
        }
        let rules = Sharpness { vertex: *own_sharpness, edges: sharpness.iter().copied() }.rules();
        let by = |rule: Rule, change: fn(f32) -> f32| match rule {
            Rule::Corner => own,
            Rule::Crease => {
                let sharp = edges.iter().zip(&*sharpness).filter(|(_, sharp)| change(**sharp) > 0.0);
                own * 0.75 + sharp.map(|(end, _)| *end).sum::<DVec3>() * 0.125
            }
            Rule::Smooth if is_of_triangles => triangles::of_vertex(own, count, edges.iter().sum()),
            Rule::Smooth => {
                let valence = count as f64;
                let sum: DVec3 = edges.iter().chain(&*new_faces).sum();
                own * ((valence - 2.0) / valence) + sum / (valence * valence)
            }
        };
        let ([now, then], share) = rules;
        let by_now = by(now, |sharpness| sharpness);
        *middle = if now == then {
            by_now
        } else {
            let by_then = by(then, softened);
            by_then + (by_now - by_then) * share
        };
        std::mem::swap(edges, new_edges);
        std::mem::swap(faces, new_faces);
        sharpness.iter_mut().for_each(|sharp| *sharp = softened(*sharp));
        *own_sharpness = softened(*own_sharpness);
    }

    fn is_sharp(&self, edge: usize) -> bool {
        self.sharpness[edge] >= ALWAYS_SHARP
    }

    fn sharp_edges(&self) -> usize {
        (0..self.edges.len()).filter(|edge| self.is_sharp(*edge)).count()
    }

    /// Rule of the vertex, once it is settled.
    fn rule(&self) -> Rule {
        Rule::new(self.own_sharpness > 0.0, self.sharp_edges())
    }

    /// The ring after so many steps.
    fn after(&self, steps: usize) -> Self {
        let mut ring = self.clone();
        (0..steps).for_each(|_| ring.step());
        ring
    }

    /// Place to which the vertex goes, once it is settled (M. Halstead, M. Kass and T. DeRose, "Efficient, fair interpolation using
    /// Catmull-Clark surfaces", 1993; on a crease that of a cubic B-spline).
    pub fn limit(&self) -> DVec3 {
        match self.rule() {
            Rule::Corner => self.middle,
            Rule::Crease => {
                let sharp = (0..self.edges.len()).filter(|edge| self.is_sharp(*edge));
                (self.middle * 4.0 + sharp.map(|edge| self.edges[edge]).sum::<DVec3>()) / 6.0
            }
            // a sharp edge that ends there moves it otherwise than the formula says
            Rule::Smooth if self.sharp_edges() > 0 => self.after(STEPS_TO_LIMIT).middle,
            Rule::Smooth if self.is_of_triangles => {
                triangles::limit(self.middle, self.edges.len(), self.edges.iter().sum())
            }
            Rule::Smooth => {
                let count = self.faces.len() as f64;
                let around = self.edges.iter().sum::<DVec3>() * 4.0 + self.faces.iter().sum::<DVec3>();
                (self.middle * (count * count) + around) / (count * (count + 5.0))
            }
        }
    }

    /// Its sectors, the parts between edges that stay sharp, once it is settled: the first edge and the number of faces of each; all of it
    /// where no two edges do.
    fn sectors(&self) -> Vec<[usize; 2]> {
        let count = self.faces.len();
        let begins: Vec<usize> = (0..count).filter(|edge| self.is_sharp(*edge)).collect();
        if begins.is_empty() || self.is_closed() && begins.len() == 1 {
            return vec![[0, count]];
        }
        let last = if self.is_closed() { count + begins[0] } else { count };
        let ends = begins.iter().skip(1).copied().chain([last]);
        begins.iter().zip(ends).map(|(first, end)| [*first, end - first]).collect()
    }

    /// Normals of the surface in each of its sectors, once it is settled: the first face, the number of faces, and a vector of unit length,
    /// or zero if there is no normal.
    pub fn normals(&self) -> Vec<([usize; 2], DVec3)> {
        let (rule, sharp) = (self.rule(), self.sharp_edges());
        // refined once for all sectors: there may be as many of these as faces
        let mut near: [Option<Self>; 2] = [None, None];
        let mut normal = |[first, faces]: [usize; 2]| {
            let is_whole = faces == self.faces.len() && self.is_closed();
            let of_tangents = match rule {
                Rule::Smooth if is_whole && sharp == 0 => self.smooth_normal(),
                Rule::Crease if faces > 1 && !is_whole => self.normal_beside_crease(first, faces),
                // between two straight edges
                Rule::Corner if faces == 1 && !is_whole => {
                    let next = (first + 1) % self.edges.len();
                    direction([first, next].map(|edge| self.edges[edge] - self.middle))
                }
                _ => None,
            };
            of_tangents.unwrap_or_else(|| {
                let is_corner = rule == Rule::Corner && faces > 1;
                let steps = if is_corner { STEPS_AT_CORNERS } else { STEPS_TO_FACETS };
                let near = near[usize::from(is_corner)].get_or_insert_with(|| self.after(steps));
                near.normal_of_facets(first, faces)
            })
        };
        self.sectors().into_iter().map(|sector| (sector, normal(sector))).collect()
    }

    /// Normal where nothing is sharp, of the two tangents (Halstead and others).
    fn smooth_normal(&self) -> Option<DVec3> {
        if self.is_of_triangles {
            return direction(triangles::tangents(&self.edges));
        }
        let count = self.faces.len();
        let turn = TAU / count as f64;
        let of_edge = 1.0 + turn.cos() + (PI / count as f64).cos() * (2.0 * (9.0 + turn.cos())).sqrt();
        let mut tangents = [DVec3::ZERO; 2];
        for i in 0..count {
            let [(sin, cos), (next_sin, next_cos)] = [i, i + 1].map(|i| (turn * i as f64).sin_cos());
            tangents[0] += self.edges[i] * (of_edge * cos) + self.faces[i] * (cos + next_cos);
            tangents[1] += self.edges[i] * (of_edge * sin) + self.faces[i] * (sin + next_sin);
        }
        direction(tangents)
    }

    /// Normal on one side of a crease, of the tangent along it and that across it (H. Biermann, A. Levin and D. Zorin, "Piecewise smooth
    /// subdivision surfaces with normal control", 2000).
    fn normal_beside_crease(&self, first: usize, faces: usize) -> Option<DVec3> {
        let count = self.edges.len();
        let edge = |i: usize| self.edges[(first + i) % count];
        if self.is_of_triangles {
            let ends: Vec<DVec3> = (0..=faces).map(edge).collect();
            return direction([edge(0) - edge(faces), triangles::tangent_across(self.middle, &ends)]);
        }
        let face = |i: usize| self.faces[(first + i) % self.faces.len()];
        let angle = PI / faces as f64;
        let (sin, cos) = angle.sin_cos();
        let ratio = (cos + 1.0) / sin;
        let along = edge(0) - edge(faces);
        let mut across =
            self.middle * (4.0 * ratio * (cos - 1.0)) - (edge(0) + edge(faces)) * (ratio * (1.0 + 2.0 * cos));
        for i in 0..faces {
            let [here, next] = [i, i + 1].map(|i| (angle * i as f64).sin());
            across += edge(i) * (4.0 * here) + face(i) * (here + next);
        }
        direction([along, across])
    }

    /// Sum of the normals of the facets in a sector, as a direction.
    fn normal_of_facets(&self, first: usize, faces: usize) -> DVec3 {
        unit((0..faces).map(|face| self.facet((first + face) % self.faces.len())).sum())
    }

    /// Normal of the facets of all its faces: twice the area that they have, as a vector.
    pub fn facets(&self) -> DVec3 {
        (0..self.faces.len()).map(|face| self.facet(face)).sum()
    }

    fn facet(&self, face: usize) -> DVec3 {
        let ends = [self.edges[face], self.faces[face], self.edges[(face + 1) % self.edges.len()]];
        let [a, b, c] = ends.map(|corner| corner - self.middle);
        a.cross(b) + b.cross(c)
    }
}

/// Normal of a plane with these two directions. `None` if they are one.
fn direction([one, other]: [DVec3; 2]) -> Option<DVec3> {
    let normal = one.cross(other);
    let is_flat = normal.length_squared() <= 1e-20 * one.length_squared() * other.length_squared();
    (!is_flat).then(|| unit(normal)).filter(|normal| *normal != DVec3::ZERO)
}

/// A direction of unit length; zero if it is none.
fn unit(vector: DVec3) -> DVec3 {
    // lengths of tiny facets must not vanish
    let largest = vector.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (vector / largest).normalize_or_zero() } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On both sides of a crease through a vertex of triangles, beside the facets far below it. Beside six triangles or more there is no plane
    /// to which these go.
    #[test]
    fn normals_beside_creases_of_triangles_are_those_of_facets() {
        for (count, other) in [(5, 2), (6, 3), (6, 4), (7, 5), (8, 4), (9, 5)] {
            let end = |i: usize| {
                let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
                let bend = (i * i) as f64;
                DVec3::new(cos + 0.1 * bend.sin(), sin + 0.1 * (2.0 * bend).cos(), 0.2 * (3.0 * bend).sin())
            };
            let edges: Vec<DVec3> = (0..count).map(end).collect();
            let ring = Ring {
                middle: DVec3::new(0.05, -0.1, 0.1),
                faces: (1..=count).map(|i| edges[i % count]).collect(),
                sharpness: (0..count).map(|i| if i == 0 || i == other { 10.0 } else { 0.0 }).collect(),
                edges,
                is_of_triangles: true,
                ..Ring::default()
            };
            let far = ring.after(26);
            let normals = ring.normals();
            assert_eq!(normals.len(), 2);
            for ([first, faces], normal) in normals {
                let facets = far.normal_of_facets(first, faces);
                assert!(normal.dot(facets) > 0.9999, "{count} {faces}: {normal} {facets}");
            }
            assert!(ring.after(40).middle.abs_diff_eq(ring.limit(), 1e-9));
        }
    }
}
