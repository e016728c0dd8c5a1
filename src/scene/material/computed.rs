//! What graphs compute of a material from place to place.

use std::ops::{Index, IndexMut};
use std::sync::Arc;

use crate::graph::Program;

/// Values of a surface that graphs compute at each place, by their numbers among those of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct Computed {
    /// Computes all of them.
    pub program: Program,
    /// Number of the value of each use.
    pub numbers: ByParameter<usize>,
    /// Computes its opacity alone, for rays that ask whether a place is there; a picture has a [mask](crate::scene::cutout) of its own.
    pub opacity: Option<Arc<Program>>,
}

/// Use of a value that graphs compute of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Computes {
    /// Factor of the reflectance, linear RGB from 0 to 1.
    Color,
    /// Factor of the roughness of its metal-rough layer, from 0 to 1; without one of the exponent of its highlight.
    Roughness,
    /// Factor of its share of metal, from 0 to 1; of [glass](super::UnevenGlass) of the share that is glass.
    Metalness,
    /// Share of it that is there, from 0 to 1.
    Opacity,
    /// Factor of its highlight, linear RGB from 0 to 1.
    Highlight,
    /// Factor of its emission, linear RGB.
    Emission,
}

/// Something for each use of computed values that has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByParameter<T>([Option<T>; Computes::ALL.len()]);

impl Computes {
    /// All uses.
    pub const ALL: [Self; 6] =
        [Self::Color, Self::Roughness, Self::Metalness, Self::Opacity, Self::Highlight, Self::Emission];
}

impl<T> Default for ByParameter<T> {
    fn default() -> Self {
        Self([const { None }; Computes::ALL.len()])
    }
}

impl<T> Index<Computes> for ByParameter<T> {
    type Output = Option<T>;

    fn index(&self, of: Computes) -> &Option<T> {
        &self.0[of as usize]
    }
}

impl<T> IndexMut<Computes> for ByParameter<T> {
    fn index_mut(&mut self, of: Computes) -> &mut Option<T> {
        &mut self.0[of as usize]
    }
}

/// Parameters of surfaces that vary from place to place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Varying {
    /// See [`Varied::roughness`](crate::scene::look::Varied::roughness).
    pub roughness: bool,
    /// See [`Varied::metalness`](crate::scene::look::Varied::metalness).
    pub metalness: bool,
    /// See [`Varied::opacity`](crate::scene::look::Varied::opacity).
    pub opacity: bool,
    /// See [`Varied::highlight`](crate::scene::look::Varied::highlight).
    pub highlight: bool,
    /// See [`Varied::emission`](crate::scene::look::Varied::emission).
    pub emission: bool,
}

impl Varying {
    /// Returns true if any parameter varies.
    pub fn is_any(self) -> bool {
        self != Self::default()
    }

    /// What varies of either.
    pub fn with(self, other: Self) -> Self {
        Self {
            roughness: self.roughness || other.roughness,
            metalness: self.metalness || other.metalness,
            opacity: self.opacity || other.opacity,
            highlight: self.highlight || other.highlight,
            emission: self.emission || other.emission,
        }
    }
}

/// Heights that a graph computes.
#[derive(Debug, Clone, PartialEq)]
pub struct Bump {
    /// The heights.
    pub height: Arc<Program>,
    /// Length for which a height of 1 stands, object space; below 0 it goes inwards.
    pub distance: f32,
    /// Share of the bent normal, from 0 to 1.
    pub strength: f32,
}

/// Displacement that a graph computes: vertices are moved by it, once a shot.
#[derive(Debug, Clone, PartialEq)]
pub struct Displacement {
    /// Heights or vectors.
    pub program: Arc<Program>,
    /// Length for which 1 stands, object space; below 0 it goes inwards.
    pub scale: f32,
    /// Value that moves nothing.
    pub middle: f32,
    /// Where to.
    pub along: Along,
}

/// Directions into which a displacement moves vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Along normals, by heights.
    Normal,
    /// By vectors in object space.
    ObjectSpace,
    /// By vectors whose first component is along the first texture coordinate, the second across that, and the third along the normal.
    TangentSpace,
}
