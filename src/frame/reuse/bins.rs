//! Bins: for each tile the samples of the frame before that are projected into it, or so near to it that they
//! may serve one of its cells.

use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::frame::grid::Grid;
use crate::frame::grid::bits::set_bits;
use crate::lanes::{F32x8, LANES, Mask};
use crate::samples::CELLS;

/// Number of steps of a cell in which bins store places. A power of two.
pub const STEPS: i32 = 64;

/// Projection of eight samples of a tile.
#[derive(Debug, Clone, Copy)]
pub struct Projected8 {
    /// Bit mask of the samples that fall into any tile.
    pub which: u8,
    /// Depths along the view axis, [ranked](crate::frame::grid::view::View::ranked_depth): positive; infinite
    /// for the background.
    pub depth: F32x8,
    /// Columns in [`STEPS`] of a cell from the left of the first tile. The values of samples that are in no
    /// tile mean nothing.
    pub x: [i32; LANES],
    /// Rows in [`STEPS`] of a cell from the top of the first tile.
    pub y: [i32; LANES],
}

/// Sample that is projected into a tile or beside it, in a word: depth, place and slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Binned(u64);

const _: () = assert!(2 * CELLS <= 1 << Binned::SLOT_BITS);

impl Binned {
    const SLOT_BITS: u32 = 11;
    const PLACE_BITS: u32 = 12;
    const DEPTH_SHIFT: u32 = Self::SLOT_BITS + 2 * Self::PLACE_BITS;
    /// Number of low bits of a depth that are dropped. Its bits are in the order of its values because it is
    /// positive.
    const DEPTH_LOST: u32 = 31 - (64 - Self::DEPTH_SHIFT);

    /// Packs a sample. `x` and `y`: from one cell left of and above the tile's corner, in [`STEPS`].
    #[inline(always)]
    pub fn new(depth: f32, [x, y]: [i32; 2], slot: usize) -> Self {
        let depth = u64::from(depth.to_bits() >> Self::DEPTH_LOST);
        let place = (y as u64) << Self::PLACE_BITS | x as u64;
        Self(depth << Self::DEPTH_SHIFT | place << Self::SLOT_BITS | slot as u64)
    }

    /// Packed word.
    pub fn word(self) -> u64 {
        self.0
    }

    /// Slot in the tile that the sample comes from.
    #[inline(always)]
    pub fn slot(self) -> usize {
        (self.0 % (1 << Self::SLOT_BITS)) as usize
    }

    /// Place of the sample: see [`new`](Self::new).
    #[inline(always)]
    pub fn place(self) -> [i32; 2] {
        let place = |shift: u32| ((self.0 >> shift) % (1 << Self::PLACE_BITS)) as i32;
        [place(Self::SLOT_BITS), place(Self::SLOT_BITS + Self::PLACE_BITS)]
    }

    /// Depth in steps: a step is at most a millionth of the depth.
    #[inline(always)]
    pub fn depth(self) -> u32 {
        (self.0 >> Self::DEPTH_SHIFT) as u32
    }
}

/// Bins of all tiles. A bin is a list of runs, one after the other, each of samples from the same tile: a
/// word with the number of that tile and the count, and a [`Binned`] for each sample.
#[derive(Debug, Default)]
pub struct Bins {
    tiles: Vec<Mutex<Vec<u64>>>,
}

/// Number of words for which a bin keeps its memory: when all is projected into few tiles, these need not
/// stay so large.
const MOST_KEPT: usize = 3 * CELLS;

impl Bins {
    /// Opens bins for `tiles` tiles; all must have been taken since the bins were opened before.
    pub fn open(&mut self, tiles: usize) {
        self.tiles.resize_with(tiles, Mutex::default);
    }

    fn tile(&self, number: usize) -> MutexGuard<'_, Vec<u64>> {
        self.tiles[number].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns true if the bin of tile number `number` is not empty.
    pub fn any(&self, number: usize) -> bool {
        !self.tile(number).is_empty()
    }

    /// Calls `each` with the runs in the bin of tile number `number`, ordered by the tiles that they come
    /// from, and empties the bin.
    pub fn take<R>(&self, number: usize, each: impl FnOnce(&[(u32, &[u64])]) -> R) -> R {
        let mut list = self.tile(number);
        // runs are in the order in which threads wrote them, which is random
        let mut runs: Vec<(u32, &[u64])> = runs(&list).collect();
        runs.sort_unstable_by_key(|(source, _)| *source);
        let result = each(&runs);
        list.clear();
        list.shrink_to(MOST_KEPT);
        result
    }

    /// Memory held, in bytes.
    pub fn bytes(&self) -> usize {
        let words = |list: &Mutex<Vec<u64>>| list.lock().unwrap_or_else(PoisonError::into_inner).capacity();
        self.tiles.iter().map(|list| words(list) * size_of::<u64>() + size_of_val(list)).sum()
    }
}

/// Samples of a run.
pub fn binned(run: &[u64]) -> impl Iterator<Item = Binned> {
    run.iter().map(|word| Binned(*word))
}

/// Runs of a bin, with the numbers of the tiles that they come from.
fn runs(mut list: &[u64]) -> impl Iterator<Item = (u32, &[u64])> {
    std::iter::from_fn(move || {
        let (head, rest) = list.split_first()?;
        let (run, rest) = rest.split_at((*head as u32) as usize);
        list = rest;
        Some(((head >> u32::BITS) as u32, run))
    })
}

/// Distributes the samples of one tile over bins. Keeps its memory from tile to tile.
#[derive(Debug, Default)]
pub struct BinWriter {
    /// Piles, of which the first `used` belong to the current tile; the others keep their memory.
    piles: Vec<Pile>,
    used: usize,
    /// Index of the pile that was added to last.
    latest: usize,
}

/// Samples of the current tile for one bin.
#[derive(Debug, Default)]
struct Pile {
    /// Column and row of the bin's tile.
    tile: [i32; 2],
    number: u32,
    /// Corner that places are counted from, one cell left of and above the tile, in [`STEPS`] from the first
    /// tile's corner.
    origin: [i32; 2],
    /// Number of cells across and down the tile.
    extent: [i32; 2],
    words: Vec<u64>,
}

impl BinWriter {
    /// Adds eight samples of the current tile, those from `slot` on. With `halo` they go to the bins of
    /// neighbouring tiles as well, where they are within a cell of these.
    #[inline(always)]
    pub fn add(&mut self, grid: &Grid, slot: usize, samples: &Projected8, halo: bool) {
        let Projected8 { which, depth, x, y } = samples;
        let mut left = *which;
        // neighbours are mostly projected into the same tile, and away from its rim
        if self.used > 0 {
            let Pile { origin, extent, words, .. } = &mut self.piles[self.latest];
            let end = extent.map(|cells| cells * STEPS);
            let (x, y) = (x.map(|x| x - origin[0]), y.map(|y| y - origin[1]));
            let is_inner = |at: i32, end: i32| (at >= 2 * STEPS) & (at < end);
            let inner = Mask::new(|lane| is_inner(x[lane], end[0]) & is_inner(y[lane], end[1])).bits() & left;
            let new: [u64; LANES] =
                std::array::from_fn(|lane| Binned::new(depth.lane(lane), [x[lane], y[lane]], slot + lane).0);
            if inner == u8::MAX {
                words.extend_from_slice(&new);
                return;
            }
            words.extend(set_bits(inner).map(|lane| new[lane]));
            left &= !inner;
        }
        for lane in set_bits(left) {
            self.add_one(grid, slot + lane, depth.lane(lane), [x[lane], y[lane]], halo);
        }
    }

    fn add_one(&mut self, grid: &Grid, slot: usize, depth: f32, at: [i32; 2], halo: bool) {
        let pile = self.pile_at(grid, at);
        let Pile { tile, origin, extent, words, .. } = &mut self.piles[pile];
        let place = [at[0] - origin[0], at[1] - origin[1]];
        words.push(Binned::new(depth, place, slot).0);
        if !halo {
            return;
        }
        let (tile, extent) = (*tile, *extent);
        // directions of neighbours: -1, 0 or 1
        let [beside_x, beside_y] = [0, 1].map(|axis| match place[axis] / STEPS {
            1 if tile[axis] > 0 => -1,
            cell if cell == extent[axis] && tile[axis] + 1 < grid.tile_counts()[axis] as i32 => 1,
            _ => 0,
        });
        let neighbours = [[beside_x, 0], [0, beside_y], [beside_x, beside_y]];
        let is_new = [beside_x != 0, beside_y != 0, beside_x != 0 && beside_y != 0];
        for [x, y] in
            neighbours.into_iter().zip(is_new).filter_map(|(beside, is_new)| is_new.then_some(beside))
        {
            let neighbour = self.pile_of(grid, [tile[0] + x, tile[1] + y]);
            let Pile { origin, words, .. } = &mut self.piles[neighbour];
            words.push(Binned::new(depth, [at[0] - origin[0], at[1] - origin[1]], slot).0);
        }
    }

    /// Finds the pile for the bin of the tile that holds this place.
    #[inline(always)]
    fn pile_at(&mut self, grid: &Grid, at: [i32; 2]) -> usize {
        let holds = |pile: &Pile| {
            (0..2).all(|axis| {
                (STEPS..(pile.extent[axis] + 1) * STEPS).contains(&(at[axis] - pile.origin[axis]))
            })
        };
        if self.used == 0 || !holds(&self.piles[self.latest]) {
            self.latest = match self.piles[..self.used].iter().position(holds) {
                Some(known) => known,
                None => {
                    let number = grid.tile_at(at.map(|at| (at / STEPS) as u32));
                    self.open(grid, grid.place_of_tile(number).map(|at| at as i32))
                }
            };
        }
        self.latest
    }

    /// Finds the pile for the bin of the tile in this column and row.
    fn pile_of(&mut self, grid: &Grid, tile: [i32; 2]) -> usize {
        let known = self.piles[..self.used].iter().position(|pile| pile.tile == tile);
        known.unwrap_or_else(|| self.open(grid, tile))
    }

    #[cold]
    fn open(&mut self, grid: &Grid, tile: [i32; 2]) -> usize {
        if self.used == self.piles.len() {
            self.piles.push(Pile::default());
        }
        let pile = &mut self.piles[self.used];
        let number = tile[1] as u32 * grid.tiles_x + tile[0] as u32;
        (pile.tile, pile.number, pile.origin) = (tile, number, bin_origin(grid, number as usize));
        pile.extent = grid.extent(number as usize).map(|cells| cells as i32);
        self.used += 1;
        self.used - 1
    }

    /// Moves the piles of tile number `source` into the bins. Returns one more than the number of the last
    /// tile that any sample is for.
    pub fn send(&mut self, source: u32, bins: &Bins) -> u32 {
        let mut until = 0;
        for Pile { number, words, .. } in &mut self.piles[..self.used] {
            until = until.max(*number + 1);
            let mut list = bins.tile(*number as usize);
            // no more than needed: from frame to frame about as much goes into a bin
            if list.len() < MOST_KEPT {
                list.reserve_exact(words.len() + 1);
            }
            list.push(u64::from(source) << u32::BITS | words.len() as u64);
            list.append(words);
        }
        self.used = 0;
        until
    }
}

/// Corner that places in the bin of tile number `tile` are counted from, in [`STEPS`] from that of the first
/// tile: one cell left of and above the tile.
pub fn bin_origin(grid: &Grid, tile: usize) -> [i32; 2] {
    let corner = grid.tile_corner(tile);
    [0, 1].map(|axis| (corner[axis] - grid.first[axis] - 1) * STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::grid::tests::settings;

    #[test]
    fn a_word_keeps_depth_place_and_slot() {
        for (depth, place, slot) in
            [(1e-30, [0, 2175], 0), (1.0, [64, 64], 2047), (f32::INFINITY, [2175, 0], 7)]
        {
            let word = Binned::new(depth, place, slot);
            assert_eq!((word.place(), word.slot()), (place, slot));
        }
        let depths = [f32::MIN_POSITIVE, 0.1, 1.0, 1.000_002, 3e38, f32::INFINITY];
        let steps = depths.map(|depth| Binned::new(depth, [0, 0], 0).depth());
        assert!(steps.is_sorted_by(|a, b| a < b), "{steps:?}");
    }

    #[test]
    fn samples_go_to_the_bins_of_all_tiles_that_they_may_serve() {
        for samples in [1, 3] {
            let grid = Grid::new(&settings(100, 70, samples));
            let edge = grid.tile_edge() as i32;
            let mut bins = Bins::default();
            bins.open(grid.tiles());
            let mut writer = BinWriter::default();
            // one in the middle of a tile, one in its last column, one in its first corner
            let at = [[edge + 5, 5], [2 * edge - 1, 7], [edge, edge]];
            let place = |axis: usize| std::array::from_fn(|lane| at[lane % 3][axis] * STEPS + 9);
            let eight = Projected8 { which: 7, depth: F32x8::splat(2.0), x: place(0), y: place(1) };
            writer.add(&grid, 40, &eight, true);
            writer.send(3, &bins);
            let right = grid.tiles_x as usize;
            let wanted = [vec![40, 41], vec![41], vec![42], vec![42], vec![42]];
            for (tile, wanted) in [1, 2, 0, right, right + 1].into_iter().zip(wanted) {
                let slots = bins.take(tile, |runs| {
                    assert!(runs.iter().all(|(source, _)| *source == 3));
                    runs.iter().flat_map(|(_, run)| binned(run)).map(Binned::slot).collect::<Vec<_>>()
                });
                let wanted: Vec<usize> = if tile == 1 { vec![40, 41, 42] } else { wanted };
                assert_eq!(slots, wanted, "{samples}: tile {tile}");
            }
            assert!((0..grid.tiles()).all(|tile| !bins.any(tile)), "nothing is left");
        }
    }

    #[test]
    fn eight_at_once_are_binned_as_one_by_one() {
        let grid = Grid::new(&settings(64, 64, 1));
        let take = |bins: &Bins| {
            bins.take(3, |runs| runs.iter().flat_map(|(_, run)| run.iter().copied()).collect::<Vec<u64>>())
        };
        let mut bins = Bins::default();
        bins.open(grid.tiles());
        let mut writer = BinWriter::default();
        let place = |first: i32| std::array::from_fn(|lane| (first + lane as i32) * STEPS + 3 * lane as i32);
        let eight = Projected8 { which: u8::MAX, depth: F32x8::splat(2.0), x: place(40), y: place(44) };
        let only = |which: u8| Projected8 { which, depth: eight.depth, x: eight.x, y: eight.y };
        (0..LANES).for_each(|lane| writer.add(&grid, 16, &only(1 << lane), true));
        writer.send(0, &bins);
        let wanted = take(&bins);
        // the first opens the bin; the rest go at once
        writer.add(&grid, 16, &only(1), true);
        writer.add(&grid, 16, &eight, true);
        writer.send(0, &bins);
        assert_eq!(take(&bins)[1..], wanted);
    }
}
