//! Leaves of the hierarchy: boxes around parts of the models at each of their places, and the frames in which
//! these change.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::parts::{MOST_BOXES, PartBoxes, count_of_boxes};
use super::split::Leaf;
use crate::animation::Transform;
use crate::geometry::Bounds;
use crate::scene::{Mesh, Model};

/// A model that moves.
#[derive(Debug)]
pub struct Mover<'a> {
    pub model: &'a Model,
    /// True if a medium fills it: a ray changes that lies within it, far from all of its triangles.
    pub is_filled: bool,
    /// Frames in which it differs from the frame before; rising, at least one. Counted as
    /// [`Until`](super::Until) counts.
    pub changes: Vec<u16>,
}

/// Coarseness of leaves, which limits their number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Grain {
    /// Number of boxes of each mesh.
    boxes: usize,
    /// Number of successive places of a model that share a leaf.
    places: usize,
}

/// Creates all leaves of `movers`: `limit` at most, or one a mover if these are more. `at` gives the
/// transforms of a mover in a frame, counted as [`Until`](super::Until) counts.
///
/// Beyond the limit meshes have fewer boxes, and successive places share leaves. The frames of such a leaf
/// are never later than the true ones.
pub fn leaves(
    movers: &[Mover<'_>],
    at: impl Fn(&Mover<'_>, i64) -> Vec<Transform> + Sync,
    limit: usize,
) -> Vec<Leaf> {
    let grain = Grain::for_limit(movers, limit);
    let boxes = boxes_of_meshes(movers, grain.boxes);
    let of_mover = |mover: &Mover<'_>| mover.leaves(&boxes[&address(&mover.model.mesh)], &at, grain.places);
    movers.par_iter().flat_map_iter(of_mover).collect()
}

impl Grain {
    fn for_limit(movers: &[Mover<'_>], limit: usize) -> Self {
        let mut grain = Self { boxes: MOST_BOXES, places: 1 };
        while !grain.is_coarsest(movers) && grain.leaves(movers) > limit {
            // in turn: either makes a box larger
            if grain.boxes > 1 && MOST_BOXES / grain.boxes <= grain.places {
                grain.boxes /= 2;
            } else {
                grain.places *= 2;
            }
        }
        grain
    }

    fn leaves(self, movers: &[Mover<'_>]) -> usize {
        let of = |mover: &Mover<'_>| {
            mover.places().div_ceil(self.places) * count_of_boxes(&mover.model.mesh, mover.boxes(self.boxes))
        };
        movers.iter().map(of).sum()
    }

    fn is_coarsest(self, movers: &[Mover<'_>]) -> bool {
        self.boxes == 1 && movers.iter().all(|mover| mover.places() <= self.places)
    }
}

impl Mover<'_> {
    /// Number of boxes of its mesh, of which there are as many at `most`: one that has all of its inside, if that is filled.
    fn boxes(&self, most: usize) -> usize {
        if self.is_filled { 1 } else { most }
    }

    /// Number of its successive places.
    fn places(&self) -> usize {
        self.changes.len() + 1
    }

    /// A frame in which it is at a place.
    fn frame_at(&self, place: usize) -> i64 {
        // the first place is that of the frame before the first change
        if place == 0 { i64::from(self.changes[0]) - 1 } else { self.changes[place - 1].into() }
    }

    /// Frame in which it arrives at a place; of the first place, where it does not arrive, that in which it
    /// leaves it.
    fn arrives(&self, place: usize) -> u16 {
        self.changes[place.saturating_sub(1)]
    }

    /// Frame in which it leaves a place; of the last place, which it does not leave, that in which it
    /// arrives.
    fn leaves_at(&self, place: usize) -> u16 {
        self.changes[place.min(self.changes.len() - 1)]
    }

    /// Creates a leaf for each of `boxes` at each group of `together` successive places.
    fn leaves(
        &self,
        boxes: &PartBoxes,
        at: impl Fn(&Self, i64) -> Vec<Transform>,
        together: usize,
    ) -> Vec<Leaf> {
        let mut leaves = Vec::with_capacity(self.places().div_ceil(together) * boxes.count());
        for from in (0..self.places()).step_by(together) {
            let to = self.places().min(from + together);
            let frames = Leaf {
                bounds: Bounds::EMPTY,
                first: self.arrives(from),
                second: self.leaves_at(from),
                last: self.leaves_at(to - 1),
            };
            let group = leaves.len();
            leaves.resize(group + boxes.count(), frames);
            for place in from..to {
                for transform in at(self, self.frame_at(place)) {
                    for (leaf, bounds) in leaves[group..].iter_mut().zip(boxes.on(&transform.shape)) {
                        leaf.bounds = leaf.bounds.union(bounds.placed(&transform));
                    }
                }
            }
        }
        // a place where the model is not visible is neither reached nor left
        leaves.retain(|leaf| !leaf.bounds.is_empty());
        leaves
    }
}

/// Boxes around the parts of each mesh that moves, by its address.
fn boxes_of_meshes(movers: &[Mover<'_>], most: usize) -> HashMap<usize, PartBoxes> {
    let mut boxes = HashMap::new();
    for mover in movers {
        let mesh = &mover.model.mesh;
        boxes.entry(address(mesh)).or_insert_with(|| PartBoxes::new(mesh, mover.boxes(most)));
    }
    boxes
}

/// Identity of a mesh: models may share one.
fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh).addr()
}
