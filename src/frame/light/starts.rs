//! Paths to be traced together, and what the surfaces at which they start have beside what all of them have.

use std::ops::Deref;

use super::path_ends::{Below, DrawnLayer, PathStart};
use super::scattering::SeenRay;

/// Starts of paths: of gathered ones, or of reflected ones. A surface has many paths, and one layer, or one thing below it: these lie in
/// lists of their own, and starts are small.
#[derive(Debug, Default)]
pub struct Starts {
    all: Vec<PathStart>,
    layers: Vec<DrawnLayer>,
    below: Vec<Below>,
    seen: Vec<SeenRay>,
}

/// Number of nothing in the lists.
pub const NOTHING: u32 = u32::MAX;

impl Deref for Starts {
    type Target = [PathStart];

    fn deref(&self) -> &[PathStart] {
        &self.all
    }
}

impl Starts {
    /// Takes all of them out.
    pub fn clear(&mut self) {
        self.all.clear();
        self.layers.clear();
        self.below.clear();
        self.seen.clear();
    }

    /// Adds paths with these numbers by which a surface gathers light, some of which go `below` it.
    pub fn gather(&mut self, start: &PathStart, below: Option<Below>, numbers: impl Iterator<Item = u32>) {
        let of_surface = if below.is_some() { self.below.len() as u32 } else { NOTHING };
        self.below.extend(below);
        self.all.extend(numbers.map(|index| PathStart { index, of_surface, ..*start }));
    }

    /// Adds paths with these numbers by which a `layer` reflects.
    pub fn reflect(&mut self, start: &PathStart, layer: DrawnLayer, numbers: impl Iterator<Item = u32>) {
        let of_surface = self.layers.len() as u32;
        self.layers.push(layer);
        self.all.extend(numbers.map(|index| PathStart { index, of_surface, ..*start }));
    }

    /// Adds paths with these numbers that bring what media scatter along a ray. They are not traced together with others.
    pub fn scatter(&mut self, start: &PathStart, seen: SeenRay, numbers: impl Iterator<Item = u32>) {
        let of_surface = self.seen.len() as u32;
        self.seen.push(seen);
        self.all.extend(numbers.map(|index| PathStart { index, of_surface, ..*start }));
    }

    /// The ray along which media scatter what a path brings; `None` if it starts at a surface.
    #[inline]
    pub fn seen(&self, start: &PathStart) -> Option<&SeenRay> {
        self.seen.get(start.of_surface as usize)
    }

    /// Returns true if they are reflected.
    pub fn are_reflected(&self) -> bool {
        !self.layers.is_empty()
    }

    /// The layer that reflects a path; `None` if it is gathered.
    #[inline]
    pub fn layer(&self, start: &PathStart) -> Option<&DrawnLayer> {
        self.layers.get(start.of_surface as usize)
    }

    /// What is below the surface at which a gathered path starts, if some of its paths go there.
    #[inline]
    pub fn below(&self, start: &PathStart) -> Option<&Below> {
        self.below.get(start.of_surface as usize)
    }
}
