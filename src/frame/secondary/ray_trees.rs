//! The ray trees of samples before a camera at rest (Adelson and Hodges, "Storage Details": "Static camera
//! animations could use the information to reuse rays and colors to any depth").
//!
//! For the tree of rays that leaves a sample of mirrors or glass only its light is stored, the share of what is behind
//! the picture that it shows, and the first frame in which these may differ ([`tree_times`](super::tree_times)): 32 bytes,
//! however many rays the tree has. As long as the camera rests, the sample stays in its cell and that frame is not reached, none of the
//! tree's rays is cast. Otherwise all are.
//!
//! Trees are stored as far as the [budget](crate::settings::Settings::tree_memory) goes, tile by tile in
//! their order ([`allow`]); the choice depends on the frame before and on nothing else. For the others only
//! one frame number is kept, a tile: the first frame in which any of them may differ.

use glam::Vec3;

use super::tree_times::{TreeGrain, TreeTimes};
use crate::changes::Until;
use crate::frame::grid::bits::set_bits;
use crate::frame::shot::frame_view::FrameView;
use crate::frame::surface::radiance::Radiance;
use crate::layers::Layers;
use crate::samples::{CELLS, EMPTY, Tile};

/// Stored light of a sample's tree.
#[derive(Debug, Clone, Copy)]
struct RayTree {
    cell: u16,
    /// First frame in which its light may differ.
    until: Until,
    /// Reflected and refracted light. Linear RGB.
    light: [[f32; 3]; 2],
    /// Share of what is behind the picture, seen through veils.
    clear: f32,
}

impl RayTree {
    /// Creates a tree without light.
    fn new(cell: u16, until: Until) -> Self {
        Self { cell, until, light: [[0.0; 3]; 2], clear: 0.0 }
    }
}

/// Guides for denoisers that a sample has by way of its tree: albedo and normal.
type Guides = [[f32; 3]; 2];

/// Size of a stored tree, in bytes.
pub fn bytes_of_tree(layers: Layers) -> usize {
    size_of::<RayTree>() + if layers.has(Layers::GUIDES) { size_of::<Guides>() } else { 0 }
}

/// Stored trees of a tile. Empty by default.
#[derive(Debug)]
pub struct TileTrees {
    /// Trees that are kept, by rising cells.
    kept: Vec<RayTree>,
    /// Guides of each, if a layer shows them.
    guides: Vec<Guides>,
    /// Number of samples with a tree when the tile was last shown.
    wanted: u16,
    /// Number of trees that may be kept.
    allowed: u16,
    /// First frame in which the light of any of the tile's trees, kept or not, may differ.
    pub until: Until,
}

impl Default for TileTrees {
    fn default() -> Self {
        Self { kept: Vec::new(), guides: Vec::new(), wanted: 0, allowed: 0, until: Until::UNKNOWN }
    }
}

impl TileTrees {
    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        self.kept.capacity() * size_of::<RayTree>() + self.guides.capacity() * size_of::<Guides>()
    }

    /// Granularity at which the validity of traced trees is computed.
    pub fn asks(&self, frame: &FrameView) -> TreeGrain {
        match (frame.keeps_trees, self.allowed) {
            (false, _) => TreeGrain::Nothing,
            (true, 0) => TreeGrain::Tile,
            (true, _) => TreeGrain::Cells,
        }
    }

    /// Notes the roots of the kept trees, and drops the trees of cells that have lost their sample.
    pub fn note_roots(&mut self, tile: &Tile, roots: &mut Vec<Root>) {
        self.retain(|tree| tile.model[usize::from(tree.cell)] != EMPTY);
        roots.clear();
        roots.extend(self.kept.iter().map(|tree| Root::new(tile, tree.cell.into())));
    }

    /// Drops the trees of cells that have another sample now than when [noted](Self::note_roots).
    pub fn forget_others(&mut self, tile: &Tile, roots: &[Root]) {
        let mut roots = roots.iter();
        self.retain(|tree| roots.next() == Some(&Root::new(tile, tree.cell.into())));
    }

    fn retain(&mut self, mut holds: impl FnMut(&RayTree) -> bool) {
        let holds: Vec<bool> = self.kept.iter().map(&mut holds).collect();
        if holds.contains(&false) {
            let mut of_trees = holds.iter();
            self.kept.retain(|_| of_trees.next() == Some(&true));
            let mut of_guides = holds.iter();
            self.guides.retain(|_| of_guides.next() == Some(&true));
        }
    }

    /// Postpones the expiry of all trees by a frame. Returns the number of those that do expire. For tests of
    /// the audit.
    pub fn delay(&mut self) -> u64 {
        let until = self.kept.iter_mut().map(|tree| &mut tree.until).chain([&mut self.until]);
        until.map(|until| u64::from(until.delay())).sum()
    }

    /// Limits the number of kept trees to `count`.
    fn allow(&mut self, count: usize) {
        self.allowed = count as u16;
        if self.kept.capacity() > count {
            self.kept.truncate(count);
            self.kept.shrink_to(count);
        }
        if self.guides.capacity() > count {
            self.guides.truncate(count);
            self.guides.shrink_to(count);
        }
    }
}

/// Shares `budget` bytes among `tiles`, in order: each gets as many trees as it wanted last. The rest is
/// given out, in the same order, for trees that may come.
pub fn allow(tiles: &mut [&mut TileTrees], budget: u64, bytes_of_tree: usize) {
    let mut left = usize::try_from(budget / bytes_of_tree as u64).unwrap_or(usize::MAX);
    let mut take = |most: usize| {
        let count = most.min(left);
        left -= count;
        count
    };
    let wanted: Vec<usize> = tiles.iter().map(|trees| take(trees.wanted.into())).collect();
    for (trees, wanted) in tiles.iter_mut().zip(wanted) {
        trees.allow(wanted + take(CELLS - wanted));
    }
}

/// Identity of a sample, as far as it determines its tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// Point of the sample: see [`Tile::x`].
    point: Vec3,
    model: u32,
    triangle: u32,
}

impl Root {
    fn new(tile: &Tile, cell: usize) -> Self {
        Self { point: tile.point(cell), model: tile.model[cell], triangle: tile.record[cell].triangle }
    }
}

/// Scratch memory of a worker for the trees of the current tile.
#[derive(Debug, Default)]
pub struct TreeScratch {
    /// Trees of all samples that have one, by rising cells.
    trees: Vec<RayTree>,
    guides: Vec<Guides>,
    /// Cells whose trees are traced.
    traced: Vec<u16>,
    /// Index of the first kept tree that has not been looked for.
    next: usize,
}

impl TreeScratch {
    /// Clears the state for the next tile.
    pub fn begin(&mut self) {
        self.trees.clear();
        self.guides.clear();
        self.traced.clear();
        self.next = 0;
    }

    /// Writes the light of the `kept` trees that are valid into `radiance`, for those of the eight samples
    /// from cell `first` on whose bit is set in `goes_on`. Returns the bits of samples whose trees must be
    /// traced.
    pub fn show(
        &mut self,
        frame: &FrameView,
        kept: &TileTrees,
        (first, goes_on): (usize, u8),
        radiance: &mut Radiance,
    ) -> u8 {
        let mut traced = 0;
        for lane in set_bits(goes_on) {
            let cell = first + lane;
            let of_others = kept.kept[self.next..].iter().take_while(|tree| usize::from(tree.cell) < cell);
            self.next += of_others.count();
            let own = kept.kept.get(self.next).filter(|tree| usize::from(tree.cell) == cell);
            let guides = kept.guides.get(self.next);
            if let Some(tree) = own.filter(|tree| !frame.has_expired(tree.until)) {
                radiance.set_secondary(cell, tree.light);
                radiance.clear[cell] = tree.clear;
                self.trees.push(*tree);
                if let Some(guides) = guides {
                    radiance.set_guides(cell, *guides);
                    self.guides.push(*guides);
                }
                continue;
            }
            traced |= 1 << lane;
            self.traced.push(cell as u16);
            self.trees.push(RayTree::new(cell as u16, Until::UNKNOWN));
            if frame.layers.has(Layers::GUIDES) {
                self.guides.push(Guides::default());
            }
        }
        traced
    }

    /// Stores the trees that were traced, as far as that is allowed, once `radiance` has their light.
    pub fn keep(&mut self, frame: &FrameView, kept: &mut TileTrees, times: &TreeTimes, radiance: &Radiance) {
        kept.wanted = self.trees.len() as u16;
        let mut traced = self.traced.iter().peekable();
        kept.until = Until::FOREVER;
        for (number, tree) in self.trees.iter_mut().enumerate() {
            let cell = usize::from(tree.cell);
            if traced.next_if_eq(&&tree.cell).is_some() {
                (tree.until, tree.light) = (times.of(cell), radiance.secondary(cell));
                tree.clear = radiance.clear[cell];
                if let Some(guides) = self.guides.get_mut(number) {
                    *guides = radiance.guides(cell);
                }
            }
            kept.until = kept.until.min(tree.until);
        }
        let count = if frame.keeps_trees { self.trees.len().min(kept.allowed.into()) } else { 0 };
        replace(&mut kept.kept, &self.trees[..count]);
        replace(&mut kept.guides, &self.guides[..count.min(self.guides.len())]);
    }
}

/// Copies `now` into `list`, and fits the memory of the list to it.
fn replace<T: Copy>(list: &mut Vec<T>, now: &[T]) {
    list.clear();
    list.shrink_to(now.len());
    list.reserve_exact(now.len());
    list.extend_from_slice(now);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_tiles_get_what_they_want_and_the_rest_is_for_what_may_come() {
        let shared = |wanted: &[u16], trees: u64| {
            let of = |wanted: &u16| TileTrees { wanted: *wanted, ..TileTrees::default() };
            let mut tiles: Vec<TileTrees> = wanted.iter().map(of).collect();
            allow(&mut tiles.iter_mut().collect::<Vec<_>>(), trees * 32 + 31, 32);
            tiles.iter().map(|trees| trees.allowed).collect::<Vec<_>>()
        };
        assert_eq!(shared(&[100, 0, 50], 0), [0, 0, 0]);
        assert_eq!(shared(&[100, 0, 50], 120), [100, 0, 20]);
        assert_eq!(shared(&[100, 0, 50], 150), [100, 0, 50]);
        assert_eq!(shared(&[100, 0, 50], 1100), [1024, 26, 50]);
        assert_eq!(shared(&[100, 0, 50], 1 << 40), [1024; 3]);
        assert_eq!(bytes_of_tree(Layers::NONE), 32);
    }

    #[test]
    fn what_is_allowed_no_more_is_given_back() {
        let tree = RayTree::new(0, Until::FOREVER);
        let mut trees =
            TileTrees { kept: vec![tree; 64], guides: vec![Guides::default(); 64], ..TileTrees::default() };
        trees.allow(10);
        assert_eq!((trees.kept.len(), trees.guides.len(), trees.bytes()), (10, 10, 10 * (32 + 24)));
        trees.allow(100);
        assert_eq!(trees.kept.len(), 10);
    }

    #[test]
    fn a_tree_goes_with_its_sample() {
        let mut tile = Tile::empty(&crate::samples::TagLayout::default());
        tile.model[3..9].fill(2);
        let tree = |cell| RayTree::new(cell, Until::FOREVER);
        let mut trees = TileTrees { kept: (3..9).map(tree).collect(), ..TileTrees::default() };
        let cells = |trees: &TileTrees| trees.kept.iter().map(|tree| tree.cell).collect::<Vec<_>>();
        // one sample has been taken away, one is replaced by another, one changes its triangle
        tile.model[4] = EMPTY;
        let mut roots = Vec::new();
        trees.note_roots(&tile, &mut roots);
        assert_eq!(cells(&trees), [3, 5, 6, 7, 8]);
        (tile.model[4], tile.x[6], tile.record[8].triangle) = (2, 0.5, 7);
        trees.forget_others(&tile, &roots);
        assert_eq!(cells(&trees), [3, 5, 7]);
    }
}
