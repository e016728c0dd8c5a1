//! Which of the samples that fall into a cell stays: the one nearest to the eye, as in the paper.
//!
//! Samples go to lists first, one for each tile that they fall into ([`Falls`]), and meet when that tile is made
//! ([`Contest`]): what they are compared in is as large as a tile, stays in the cache, and is one worker's own.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::stage::set_bits;
use crate::lanes::{F32x8, LANES};
use crate::samples::{CELLS, Column, Move};

/// A sample that falls from a cell of one tile into a cell of another, in a word: its depth, whose bits are in
/// the order of its values because it is positive, its old and its new cell.
#[derive(Debug, Clone, Copy)]
struct Fall(u64);

const _: () = assert!(CELLS == 1 << Fall::CELL_BITS);

impl Fall {
    const CELL_BITS: u32 = 10;
    const DEPTH_SHIFT: u32 = 32;

    fn new(depth: f32, way: Move) -> Self {
        let cells = u64::from(way.from) << Self::CELL_BITS | u64::from(way.to);
        Self(u64::from(depth.to_bits()) << Self::DEPTH_SHIFT | cells)
    }

    fn way(self) -> Move {
        let cell = |bits: u64| (bits % CELLS as u64) as u16;
        Move { to: cell(self.0), from: cell(self.0 >> Self::CELL_BITS) }
    }

    /// The least of those that fall into a cell wins: depth before the sample's number.
    fn rank(self, source: u32) -> u64 {
        let sample = u64::from(source) * CELLS as u64 + u64::from(self.way().from);
        self.0 >> Self::DEPTH_SHIFT << Self::DEPTH_SHIFT | sample
    }
}

/// Where eight samples of a tile fall.
#[derive(Debug, Clone, Copy)]
pub struct LanesFall {
    /// Those that fall into a cell of the picture, a bit each.
    pub which: u8,
    /// Positive; infinite for the background.
    pub depth: F32x8,
    /// Numbers of the cells in the store; of lanes that fall into none they mean nothing.
    pub cells: [u32; LANES],
}

/// What falls, for each tile that it falls into: sheaves of what comes from the same tile, one after the other.
/// A sheaf is a word with the number of that tile and the count, and a [`Fall`] each.
#[derive(Debug, Default)]
pub struct Falls {
    tiles: Vec<Mutex<Vec<u64>>>,
}

/// Words of a list that keep their memory: when all falls on few tiles, these need not stay so large.
const MOST_KEPT: usize = 2 * CELLS;

impl Falls {
    /// For `tiles` tiles; all must have been taken since it was opened before.
    pub fn open(&mut self, tiles: usize) {
        self.tiles.resize_with(tiles, Mutex::default);
    }

    fn tile(&self, number: usize) -> MutexGuard<'_, Vec<u64>> {
        self.tiles[number].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether anything falls into tile number `number`.
    pub fn any(&self, number: usize) -> bool {
        !self.tile(number).is_empty()
    }

    /// Calls `each` with what falls into tile number `number`, and forgets it.
    pub fn take<R>(&self, number: usize, each: impl FnOnce(&[u64]) -> R) -> R {
        let mut list = self.tile(number);
        let result = each(&list);
        list.clear();
        list.shrink_to(MOST_KEPT);
        result
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let words = |list: &Mutex<Vec<u64>>| list.lock().unwrap_or_else(PoisonError::into_inner).capacity();
        self.tiles.iter().map(|list| words(list) * size_of::<u64>() + size_of_val(list)).sum()
    }
}

/// The sheaves of a list: what falls, and the number of the tile that it falls from.
fn sheaves(mut list: &[u64]) -> impl Iterator<Item = (u32, &[u64])> {
    std::iter::from_fn(move || {
        let (head, rest) = list.split_first()?;
        let (sheaf, rest) = rest.split_at((*head as u32) as usize);
        list = rest;
        Some(((head >> u32::BITS) as u32, sheaf))
    })
}

/// Sorts what falls from one tile by the tiles that it falls into. Keeps its memory from tile to tile.
#[derive(Debug, Default)]
pub struct Sorter {
    /// The first `used` are of the tile at work; the others keep their memory.
    piles: Vec<(u32, Vec<u64>)>,
    used: usize,
    /// The one that was added to last.
    latest: usize,
}

impl Sorter {
    /// Eight samples of the tile at work, those from cell `first` on, fall.
    #[inline(always)]
    pub fn add(&mut self, first: usize, fall: LanesFall) {
        let LanesFall { which, depth, cells } = fall;
        let in_tile = |lane: usize| (cells[lane] % CELLS as u32) as u16;
        let falls: [u64; LANES] = std::array::from_fn(|lane| {
            Fall::new(depth.lane(lane), Move { to: in_tile(lane), from: (first + lane) as u16 }).0
        });
        // neighbours fall into the same tile, mostly
        let latest = self.piles.get_mut(self.latest).filter(|_| self.used > 0);
        match latest {
            Some((tile, pile))
                if which == u8::MAX && cells.iter().all(|cell| cell / CELLS as u32 == *tile) =>
            {
                pile.extend_from_slice(&falls);
            }
            _ => {
                for lane in set_bits(which) {
                    self.pile(cells[lane] / CELLS as u32).push(falls[lane]);
                }
            }
        }
    }

    /// What falls into tile number `tile`.
    fn pile(&mut self, tile: u32) -> &mut Vec<u64> {
        if self.used == 0 || self.piles[self.latest].0 != tile {
            let known = self.piles[..self.used].iter().position(|(number, _)| *number == tile);
            self.latest = known.unwrap_or_else(|| self.open(tile));
        }
        &mut self.piles[self.latest].1
    }

    #[cold]
    fn open(&mut self, tile: u32) -> usize {
        if self.used == self.piles.len() {
            self.piles.push(Default::default());
        }
        self.piles[self.used].0 = tile;
        self.used += 1;
        self.used - 1
    }

    /// Hands over what fell from tile number `source`. Returns one more than the number of the last tile that
    /// any of it fell into.
    pub fn send(&mut self, source: u32, falls: &Falls) -> u32 {
        let mut until = 0;
        for (tile, pile) in &mut self.piles[..self.used] {
            until = until.max(*tile + 1);
            let mut list = falls.tile(*tile as usize);
            // no more than what is needed: from frame to frame about as much falls into a tile
            if list.len() < MOST_KEPT {
                list.reserve_exact(pile.len() + 1);
            }
            list.push(u64::from(source) << u32::BITS | pile.len() as u64);
            list.append(pile);
        }
        self.used = 0;
        until
    }
}

/// Who wins the cells of one tile. A worker's memory.
#[derive(Debug)]
pub struct Contest {
    /// The least rank in each cell.
    best: Column<u64>,
    /// How many samples fell into each cell; 2 stands for more.
    fallen: Column<u8>,
    /// Of a sheaf: those that won come first.
    moves: Column<Move>,
}

const VACANT: u64 = u64::MAX;

impl Default for Contest {
    fn default() -> Self {
        Self { best: [VACANT; CELLS], fallen: [0; CELLS], moves: [Move::default(); CELLS] }
    }
}

impl Contest {
    /// Lets all samples of a tile's list compete, and calls `take(source, moves)` with the ways of the winners,
    /// for each tile that any come from. Whoever is first in the list, the winners are the same.
    pub fn hold(&mut self, list: &[u64], mut take: impl FnMut(u32, &[Move])) {
        self.best.fill(VACANT);
        self.fallen.fill(0);
        for (source, sheaf) in sheaves(list) {
            for fall in sheaf.iter().map(|word| Fall(*word)) {
                let cell = usize::from(fall.way().to);
                let (best, fallen) = (&mut self.best[cell], &mut self.fallen[cell]);
                *best = fall.rank(source).min(*best);
                *fallen = (*fallen + 1).min(2);
            }
        }
        for (source, sheaf) in sheaves(list) {
            // no branch: who wins is hard to foretell. The remainder is the number itself: it spares a check
            let mut won = 0;
            for fall in sheaf.iter().map(|word| Fall(*word)) {
                self.moves[won % CELLS] = fall.way();
                won += usize::from(self.best[usize::from(fall.way().to)] == fall.rank(source));
            }
            take(source, &self.moves[..won]);
        }
    }

    /// For each cell how many samples fell into it; 2 stands for more.
    pub fn fallen(&self) -> &Column<u8> {
        &self.fallen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// Of the cells of tile 1: the numbers of the winners, and whether others fell there.
    fn take(falls: &Falls) -> Vec<Option<(u32, bool)>> {
        let mut contest = Contest::default();
        let mut winners = vec![None; CELLS];
        falls.take(1, |list| {
            contest.hold(list, |source, moves| {
                for way in moves {
                    winners[usize::from(way.to)] = Some(source * CELLS as u32 + u32::from(way.from));
                }
            });
        });
        let crowded = |fallen: &u8| [None, Some(false), Some(true)][usize::from(*fallen)];
        winners
            .into_iter()
            .zip(contest.fallen())
            .map(|(sample, fallen)| sample.zip(crowded(fallen)))
            .collect()
    }

    fn fall(falls: &Falls, cell: u32, depth: f32, sample: u32) {
        let (first, lane) = (sample as usize % CELLS / LANES * LANES, sample as usize % LANES);
        let cells = [CELLS as u32 + cell; LANES];
        let mut sorter = Sorter::default();
        sorter.add(first, LanesFall { which: 1 << lane, depth: F32x8::splat(depth), cells });
        assert_eq!(sorter.send(sample / CELLS as u32, falls), 2);
    }

    #[test]
    fn the_nearest_wins_and_ties_go_to_the_first_sample() {
        let mut falls = Falls::default();
        falls.open(2);
        fall(&falls, 1, 5.0, 7);
        fall(&falls, 2, 5.0, 9);
        fall(&falls, 2, 0.5, 3000);
        fall(&falls, 33, f32::INFINITY, 4000);
        fall(&falls, 33, f32::INFINITY, 3);
        let winners = take(&falls);
        assert_eq!(winners[0], None);
        assert_eq!(winners[1], Some((7, false)));
        assert_eq!(winners[2], Some((3000, true)));
        assert_eq!(winners[33], Some((3, true)));
        assert!(take(&falls).iter().all(Option::is_none), "taking clears");
        fall(&falls, 2, 1.0, 5);
        assert_eq!(take(&falls)[2], Some((5, false)), "that it was crowded, too");
    }

    #[test]
    fn the_order_of_falling_does_not_matter() {
        let mut falls = Falls::default();
        falls.open(2);
        let fall = |i: u32| fall(&falls, i % 64, ((i * 7919) % 1009) as f32 + 1.0, i);
        (0..10_000).for_each(fall);
        let one_by_one = take(&falls);
        (0..10_000_u32).into_par_iter().rev().for_each(fall);
        assert_eq!(one_by_one, take(&falls));
    }

    #[test]
    fn what_falls_is_sorted_by_where_it_falls() {
        let mut falls = Falls::default();
        falls.open(3);
        let mut sorter = Sorter::default();
        // eight by eight into one tile or another, then each lane into another than the one before
        let tile_of = |cell: usize| if cell < 64 { cell / 8 % 3 } else { cell % 3 };
        for first in (0..128).step_by(LANES) {
            let cells = std::array::from_fn(|lane| (tile_of(first + lane) * CELLS + first + lane) as u32);
            sorter.add(first, LanesFall { which: u8::MAX, depth: F32x8::splat(1.0), cells });
        }
        assert_eq!(sorter.send(8, &falls), 3);
        assert_eq!(sorter.send(9, &falls), 0, "all was sent");
        for tile in 0..3 {
            let mut moved = Vec::new();
            falls.take(tile, |list| {
                Contest::default().hold(list, |source, moves| {
                    assert_eq!(source, 8);
                    moved.extend(moves.iter().map(|way| (usize::from(way.from), usize::from(way.to))));
                });
            });
            let wanted: Vec<_> =
                (0..128).filter(|cell| tile_of(*cell) == tile).map(|cell| (cell, cell)).collect();
            assert_eq!(moved, wanted);
        }
    }
}
