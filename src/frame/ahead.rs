//! Memory for the next tile, fetched while this one's rays are prepared.
//!
//! Samples are read and written once a frame, and a store is larger than any cache. Without this, reprojection waits
//! for memory for about an eighth of its time (kitchen, dolly, 960x540, 2x2).

use crate::samples::Tile;

/// The tiles that the next tile's work begins with.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ahead<'a> {
    /// Its samples in the frame before: most of those that it needs.
    pub before: Option<&'a Tile>,
    /// The tile that they are written to.
    pub now: Option<&'a Tile>,
}

impl Ahead<'_> {
    /// Fetches one block of cells, from `first` on: a little at a time leaves the processor free.
    #[inline(always)]
    pub fn fetch(&self, first: usize) {
        for tile in [self.before, self.now].into_iter().flatten() {
            tile.prefetch(first);
        }
    }
}
