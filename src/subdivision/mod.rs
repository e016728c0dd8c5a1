//! Subdivision surfaces by the rules of E. Catmull and J. Clark ("Recursively generated B-spline surfaces on arbitrary topological
//! meshes", 1978) or of C. Loop (`triangles.rs`), with semi-sharp creases (T. DeRose and others, "Subdivision surfaces in character animation", 1998): cages are refined
//! uniformly, level by level, and the vertices of the last level are put where they go in the end, on the limit surface.
//!
//! Whoever refines gives a cage's faces ([`CageFaces`]) and gets a [`Hierarchy`], by which any values of its points are refined: positions
//! in each shape, texture coordinates, colours. All is in double floats and in a fixed order: it is the same to the bit for any number of
//! threads.

mod faces;
mod limit;
mod refine;
mod ring;
mod topology;
mod triangles;

pub use faces::{Boundary, CageFaces, Scheme};
pub use limit::Limit;
pub use topology::Topology;

use glam::DVec3;

/// Sharpness from which on an edge or a point stays sharp at every level.
pub const ALWAYS_SHARP: f32 = 10.0;

/// Number for what is not there.
const NONE: u32 = u32::MAX;

/// The levels of a cage, from itself on.
#[derive(Debug)]
pub struct Hierarchy {
    scheme: Scheme,
    levels: Vec<Topology>,
}

impl Hierarchy {
    /// Begins with a cage itself.
    pub fn new(cage: &CageFaces<'_>) -> Self {
        Self { scheme: cage.scheme, levels: vec![Topology::new(cage)] }
    }

    /// Adds a level: each face becomes as many quadrilaterals as it has corners; by the rules of Loop four triangles.
    pub fn refine(&mut self) {
        self.levels.push(self.last().refined());
    }

    /// Number of times that it was refined.
    pub fn depth(&self) -> usize {
        self.levels.len() - 1
    }

    /// The cage.
    pub fn first(&self) -> &Topology {
        &self.levels[0]
    }

    /// The finest level.
    pub fn last(&self) -> &Topology {
        &self.levels[self.depth()]
    }

    /// Values of the vertices of level `to`, of those of level `from`.
    pub fn values(&self, from: usize, to: usize, values: Vec<DVec3>) -> Vec<DVec3> {
        self.levels[from..to].iter().fold(values, |values, level| level.refined_values(self.scheme, &values))
    }

    /// Values at the corners of the last level, of those at the corners of the cage: each face is divided by itself.
    pub fn linear_values(&self, at_corners: Vec<DVec3>) -> Vec<DVec3> {
        self.levels[..self.depth()].iter().fold(at_corners, |values, level| level.divided_values(&values))
    }

    /// Where the vertices of the last level with these `values` go in the end.
    pub fn limit(&self, values: &[DVec3]) -> Vec<DVec3> {
        match self.scheme {
            Scheme::CatmullClark | Scheme::Loop => self.last().limits(values),
            Scheme::Bilinear => values.to_vec(),
        }
    }

    /// Where the vertices of the last level with these positions go in the end, and the normals of the surface there.
    pub fn limit_with_normals(&self, positions: &[DVec3]) -> Limit {
        Limit::of(self.last(), self.scheme, positions)
    }

    /// Takes the last level away, which is not the cage itself.
    pub fn coarsen(&mut self) {
        if self.depth() > 0 {
            self.levels.pop();
        }
    }

    /// The level before the finest; the cage, where that is the finest.
    pub fn before_last(&self) -> &Topology {
        &self.levels[self.depth().saturating_sub(1)]
    }

    /// Cage face of each face of the last level.
    pub fn cage_faces(&self) -> Vec<u32> {
        self.cage_faces_of(self.depth())
    }

    /// Cage face of each face of a level.
    pub fn cage_faces_of(&self, depth: usize) -> Vec<u32> {
        let mut of: Vec<u32> = (0..self.first().faces() as u32).collect();
        for level in &self.levels[..depth] {
            of = (0..level.next_faces() as u32).map(|face| of[level.face_before(face) as usize]).collect();
        }
        of
    }
}

#[cfg(test)]
mod tests;
