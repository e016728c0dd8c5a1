//! Pool of tiles: the new store of a frame grows out of the tiles that the old one no longer needs, so that
//! both together hold little more than one.

use rayon::prelude::*;

use super::{SampleStore, TagLayout, Tile};

/// Tiles whose samples are not needed any more, to be written over.
#[derive(Debug)]
pub struct TilePool {
    tiles: Vec<Box<Tile>>,
    layout: TagLayout,
}

impl TilePool {
    /// Creates an empty pool, for stores with this `layout`.
    pub fn new(layout: TagLayout) -> Self {
        Self { tiles: Vec::new(), layout }
    }

    /// Takes all tiles of a store.
    pub fn take(&mut self, store: SampleStore) {
        self.tiles.extend(store.tiles);
    }

    /// Adds tiles to `store` until it has `count`; their contents mean nothing.
    pub fn grow(&mut self, store: &mut SampleStore, count: usize) {
        let wanted = count.saturating_sub(store.tiles.len());
        store.tiles.extend(self.tiles.drain(self.tiles.len().saturating_sub(wanted)..));
        // fresh memory costs time when it is touched first: all threads share it
        let fresh = store.tiles.len()..count;
        store.tiles.par_extend(fresh.into_par_iter().map(|_| Box::new(Tile::empty(&self.layout))));
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        self.tiles.iter().map(|tile| tile.bytes(&self.layout)).sum()
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

/// Lends a store: it keeps all of its tiles.
impl From<SampleStore> for LeavingStore {
    fn from(store: SampleStore) -> Self {
        Self { tiles: store.tiles.into_iter().map(Some).collect(), order: Vec::new(), gone: 0 }
    }
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

    /// Returns the tiles that are left: all of a store that was only lent.
    pub fn into_store(self) -> SampleStore {
        SampleStore { tiles: self.tiles.into_iter().flatten().collect() }
    }

    /// Gives back the tiles that are not wanted any more when `done` tiles of the new store are done.
    pub fn let_go(&mut self, done: usize, pool: &mut TilePool) {
        let leaving = self.order[self.gone..].iter().take_while(|(until, _)| *until as usize <= done);
        for (_, number) in leaving {
            pool.tiles.extend(self.tiles[*number as usize].take());
            self.gone += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_go_when_nothing_is_wanted_of_them() {
        let mut pool = TilePool::new(TagLayout::of(std::iter::empty()));
        let mut old = SampleStore::default();
        pool.grow(&mut old, 4);
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
        assert_eq!(pool.bytes(), 4 * Tile::bytes_of_cells(&pool.layout));
        assert!(old.into_store().tiles.is_empty());
        let mut new = SampleStore::default();
        pool.grow(&mut new, 3);
        pool.grow(&mut new, 5);
        assert_eq!((new.tiles.len(), pool.bytes()), (5, 0), "four are used again, one is new");
    }

    #[test]
    fn a_store_that_is_lent_comes_back_whole() {
        let mut pool = TilePool::new(TagLayout::of(std::iter::empty()));
        let mut store = SampleStore::default();
        pool.grow(&mut store, 3);
        for (tile, mark) in store.tiles.iter_mut().zip(100..) {
            tile.record[7].triangle = mark;
        }
        let mut lent = LeavingStore::from(store);
        lent.let_go(3, &mut pool);
        assert_eq!(pool.bytes(), 0);
        let marks: Vec<u32> = lent.into_store().tiles.iter().map(|tile| tile.record[7].triangle).collect();
        assert_eq!(marks, [100, 101, 102]);
    }
}
