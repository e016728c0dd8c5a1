//! Pool of tiles: the new store of a frame grows out of the tiles that the old one no longer needs, so that
//! both together hold little more than one.

use rayon::prelude::*;

use super::{SampleStore, TagLayout, Tile};

/// Tiles whose samples are not needed any more, to be written over.
#[derive(Debug, Default)]
pub struct TilePool {
    tiles: Vec<Box<Tile>>,
}

impl TilePool {
    /// Takes all tiles of a store.
    pub fn take(&mut self, store: SampleStore) {
        self.tiles.extend(store.tiles);
    }

    /// Adds tiles to `store` until it has `count`; their contents mean nothing. All stores have one `layout`.
    pub fn grow(&mut self, store: &mut SampleStore, count: usize, layout: &TagLayout) {
        let wanted = count.saturating_sub(store.tiles.len());
        store.tiles.extend(self.tiles.drain(self.tiles.len().saturating_sub(wanted)..));
        // fresh memory costs time when it is touched first: all threads share it
        let fresh = store.tiles.len()..count;
        store.tiles.par_extend(fresh.into_par_iter().map(|_| Box::new(Tile::empty(layout))));
    }

    /// Memory held, in bytes.
    pub fn bytes(&self, layout: &TagLayout) -> usize {
        self.tiles.iter().map(|tile| tile.bytes(layout)).sum()
    }
}

/// Store of the frame before, while its samples go over to the new one. Each of its tiles is given back as
/// soon as no sample in it is wanted any more.
#[derive(Debug)]
pub struct LeavingStore {
    tiles: Vec<Option<Box<Tile>>>,
    /// Number of tiles of the new store that must be done until a tile can go, and the number of that tile.
    /// Sorted.
    order: Vec<(u32, u32)>,
    /// Number of entries of `order` whose tiles have gone.
    gone: usize,
}

impl LeavingStore {
    /// Creates the store from `store`. `until`: for each of its tiles, the number of tiles of the new store
    /// that must be done until it can go.
    pub fn new(store: SampleStore, until: &[u32]) -> Self {
        let mut order: Vec<(u32, u32)> = until.iter().copied().zip(0..).collect();
        order.sort_unstable();
        Self { tiles: store.tiles.into_iter().map(Some).collect(), order, gone: 0 }
    }

    /// Tile number `number`, if there is one and it has not gone.
    #[inline]
    pub fn tile(&self, number: u32) -> Option<&Tile> {
        self.tiles.get(number as usize)?.as_deref()
    }

    /// Gives back what nobody wants any more now that `done` tiles of the new store are done.
    pub fn let_go(&mut self, done: usize, pool: &mut TilePool) {
        let leaving = self.order[self.gone..].iter().take_while(|(until, _)| *until as usize <= done);
        for (_, number) in leaving {
            pool.tiles.extend(self.tiles[*number as usize].take());
            self.gone += 1;
        }
    }
}

/// The samples from which a picture is projected.
#[derive(Debug)]
pub enum OldStore<'s> {
    /// The picture's own store of the frame before, which ends with this frame.
    Leaving(LeavingStore),
    /// The store of another picture, which keeps it.
    Lent(&'s SampleStore),
}

impl OldStore<'_> {
    /// Tile number `number`, if it exists and has not been given back.
    #[inline]
    pub fn tile(&self, number: u32) -> Option<&Tile> {
        match self {
            Self::Leaving(store) => store.tile(number),
            Self::Lent(store) => store.tiles.get(number as usize).map(AsRef::as_ref),
        }
    }

    /// Gives tiles of a leaving store back to `pool` that are not wanted once `done` tiles of the new store are done.
    pub fn let_go(&mut self, done: usize, pool: &mut TilePool) {
        if let Self::Leaving(store) = self {
            store.let_go(done, pool);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_go_when_nothing_is_wanted_of_them() {
        let (mut pool, layout) = (TilePool::default(), TagLayout::new(std::iter::empty()));
        let mut old = SampleStore::default();
        pool.grow(&mut old, 4, &layout);
        for (tile, mark) in old.tiles.iter_mut().zip(100..) {
            tile.record[7].triangle = mark;
        }
        let mut old = LeavingStore::new(old, &[3, 0, 2, 3]);
        let there = |old: &LeavingStore| [0, 1, 2, 3].map(|number| old.tile(number).is_some());
        old.let_go(0, &mut pool);
        assert_eq!(there(&old), [true, false, true, true]);
        old.let_go(2, &mut pool);
        assert_eq!(there(&old), [true, false, false, true]);
        assert_eq!(
            old.tile(3).map(|tile| tile.record[7].triangle),
            Some(103),
            "the others keep their numbers"
        );
        old.let_go(3, &mut pool);
        assert_eq!(there(&old), [false; 4]);
        assert_eq!(pool.bytes(&layout), 4 * Tile::bytes_of_cells(&layout));
        let mut new = SampleStore::default();
        pool.grow(&mut new, 3, &layout);
        pool.grow(&mut new, 5, &layout);
        assert_eq!((new.tiles.len(), pool.bytes(&layout)), (5, 0), "four are used again, one is new");
    }

    #[test]
    fn a_store_that_is_lent_keeps_its_tiles() {
        let (mut pool, layout) = (TilePool::default(), TagLayout::new(std::iter::empty()));
        let mut store = SampleStore::default();
        pool.grow(&mut store, 3, &layout);
        let mut lent = OldStore::Lent(&store);
        lent.let_go(3, &mut pool);
        assert_eq!(pool.bytes(&layout), 0);
        assert!((0..3).all(|number| lent.tile(number).is_some()) && lent.tile(3).is_none());
    }
}
