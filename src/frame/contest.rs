//! Which of the samples that fall into a cell stays: the one nearest to the eye, as in the paper.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use crate::samples::CELLS;

/// One entry a cell. Samples enter from any number of threads in any order, and the winner is always the
/// same: entries are compared as one integer, depth before sample number.
#[derive(Debug, Default)]
pub struct Contest {
    entries: Vec<AtomicU64>,
    /// A bit for each cell that more than one sample fell into.
    crowded: Vec<AtomicU32>,
}

/// The winner of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Winner {
    /// Its number in the store of the frame before.
    pub sample: u32,
    /// Whether others fell into the cell.
    pub overlapped: bool,
}

const VACANT: u64 = u64::MAX;

impl Contest {
    /// Makes room for the cells of `tiles` tiles; all must have been taken since the contest before.
    pub fn open(&mut self, tiles: usize) {
        let cells = tiles * CELLS;
        if self.entries.len() != cells {
            self.entries = std::iter::repeat_with(|| AtomicU64::new(VACANT)).take(cells).collect();
            self.crowded = std::iter::repeat_with(AtomicU32::default).take(cells / 32).collect();
        }
    }

    /// `sample` falls into `cell` at `depth` (positive; infinite for the background).
    #[inline]
    pub fn enter(&self, cell: u32, depth: f32, sample: u32) {
        // the bits of positive floats are in the order of their values
        let entry = u64::from(depth.to_bits()) << 32 | u64::from(sample);
        let before = self.entries[cell as usize].fetch_min(entry, Relaxed);
        if before != VACANT {
            self.crowded[cell as usize / 32].fetch_or(1 << (cell % 32), Relaxed);
        }
    }

    /// Calls `each(cell, winner)` for every cell of tile number `tile`, and clears them for the next frame.
    #[inline(always)]
    pub fn take_tile(&self, tile: usize, mut each: impl FnMut(usize, Option<Winner>)) {
        const WORD: usize = u32::BITS as usize;
        let first = tile * CELLS;
        let entries = self.entries[first..first + CELLS].chunks_exact(WORD);
        for (i, (entries, word)) in entries.zip(&self.crowded[first / WORD..]).enumerate() {
            let crowded = word.load(Relaxed);
            if crowded != 0 {
                word.store(0, Relaxed);
            }
            for (lane, entry) in entries.iter().enumerate() {
                let won = entry.load(Relaxed);
                if won != VACANT {
                    entry.store(VACANT, Relaxed);
                }
                let overlapped = crowded >> lane & 1 != 0;
                let winner = (won != VACANT).then_some(Winner { sample: won as u32, overlapped });
                each(i * WORD + lane, winner);
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.entries.len() * size_of::<AtomicU64>() + self.crowded.len() * size_of::<AtomicU32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    /// The winners of the first cells of the first tile.
    fn take(contest: &Contest) -> Vec<Option<Winner>> {
        let mut winners = Vec::new();
        contest.take_tile(0, |cell, winner| {
            assert_eq!(cell, winners.len());
            winners.push(winner);
        });
        winners
    }

    #[test]
    fn the_nearest_wins_and_ties_go_to_the_first_sample() {
        let mut contest = Contest::default();
        contest.open(1);
        contest.enter(1, 5.0, 7);
        contest.enter(2, 5.0, 9);
        contest.enter(2, 0.5, 30);
        contest.enter(33, f32::INFINITY, 4);
        contest.enter(33, f32::INFINITY, 3);
        let winners = take(&contest);
        assert_eq!(winners[0], None);
        assert_eq!(winners[1], Some(Winner { sample: 7, overlapped: false }));
        assert_eq!(winners[2], Some(Winner { sample: 30, overlapped: true }));
        assert_eq!(winners[33], Some(Winner { sample: 3, overlapped: true }));
        assert!(take(&contest).iter().all(Option::is_none), "taking clears");
        contest.enter(2, 1.0, 5);
        assert_eq!(
            take(&contest)[2],
            Some(Winner { sample: 5, overlapped: false }),
            "that it was crowded, too"
        );
    }

    #[test]
    fn the_order_of_entry_does_not_matter() {
        let mut contest = Contest::default();
        contest.open(1);
        let enter = |i: u32| contest.enter(i % 64, ((i * 7919) % 1009) as f32 + 1.0, i);
        (0..10_000).for_each(enter);
        let one_by_one = take(&contest);
        (0..10_000_u32).into_par_iter().rev().for_each(enter);
        assert_eq!(one_by_one, take(&contest));
    }
}
