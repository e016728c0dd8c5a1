//! Stored samples in and around one tile, sorted by the cells in which they lie.

use std::ops::Range;

use wide::{i16x16, u32x8};

use super::bins::{Binned, STEPS, binned};
use crate::frame::grid::around::{AROUND, ROW, around};
use crate::frame::grid::place;
use crate::lanes::LANES;
use crate::samples::{Status, Tile};

/// Largest number of candidates of a tile, so that a number has 16 bits: those of the last tiles that they
/// come from are dropped when everything is projected into a few tiles.
const MOST: usize = u16::MAX as usize;

/// Largest distance from its target, in cells, at which a sample may serve.
pub const REACH: f32 = RADIUS as f32 / STEPS as f32;

/// Largest distance of a server in [`STEPS`].
const RADIUS: u32 = 48;

/// Lookup of tiles with candidates, by number.
pub trait Sources<'t>: Fn(u32) -> Option<&'t Tile> {}
impl<'t, F: Fn(u32) -> Option<&'t Tile>> Sources<'t> for F {}

/// Candidates, numbered in the order of the tiles that they come from, and of their slots. Keeps its memory.
#[derive(Debug, Default)]
pub struct Candidates {
    all: Vec<Candidate>,
    /// Tiles that they come from, each with the number of its first candidate.
    runs: Vec<(u32, u32)>,
    /// First candidates of each cell in and around the tile: the first layer has one of each cell that has
    /// any.
    layers: [Layer; LAYERS],
    /// Number of candidates of each cell, up to one more than there are layers.
    counts: Vec<u8>,
    /// Bit mask of the rows with a cell that has a candidate in the last layer.
    full_rows: u64,
    /// Cells in and around the tile that have more candidates than there are layers.
    crowded: Vec<u16>,
    /// Index in `sorted` of the first candidate of each cell in and around the tile; once they are sorted.
    starts: Vec<u16>,
    /// Numbers of the candidates, cell by cell.
    sorted: Vec<u16>,
    is_sorted: bool,
}

/// A sample that may serve cells of a tile.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Its word in the bin.
    pub word: Binned,
    /// Cell in or around the tile in which it lies.
    pub cell: u16,
    /// Number of the [run](Candidates::runs) that it came in.
    pub run: u16,
}

/// Number of layers of candidates: a cell keeps two samples, and more travel into it.
const LAYERS: usize = 3;

/// One candidate for each cell in and around a tile.
#[derive(Debug, Default)]
struct Layer {
    /// [Place](Binned::place) of each candidate, or [`FAR`]: x in the low half, y in the high one.
    places: Vec<u32>,
    /// Number of each candidate.
    numbers: Vec<u32>,
}

/// Place far from all targets, for cells without a candidate.
const FAR: u32 = 16_000 << 16 | 16_000;

/// Rank of a candidate for a cell: the square of its distance from the target, and its number. The least is
/// the nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank(u32);

impl Rank {
    /// Rank of no candidate.
    pub const NONE: Self = Self(u32::MAX);

    /// Rank at the maximum serving distance.
    const FARTHEST: Self = Self((RADIUS * RADIUS) << u16::BITS | u16::MAX as u32);

    fn new(far: u32, number: u16) -> Self {
        Self(far.min(u32::from(u16::MAX)) << u16::BITS | u32::from(number))
    }

    /// Number of the candidate.
    #[inline(always)]
    pub fn number(self) -> usize {
        (self.0 % (1 << u16::BITS)) as usize
    }
}

/// Server of a cell, in a word: a candidate's [`Rank`], with a bit if others are near enough, too; or nobody;
/// or the cell's own sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Server(u32);

impl Server {
    /// Server of a cell that no candidate is near enough to serve.
    pub const NOBODY: Self = Self(u32::MAX);

    /// The cell's own sample, which stays.
    pub const OWN: Self = Self(u32::MAX - 1);

    /// Bit above all ranks of servers: others are near enough, too.
    const CONTESTED: u32 = 1 << 31;

    fn new(rank: Rank, is_contested: bool) -> Self {
        match is_contested {
            _ if rank == Rank::NONE => Self::NOBODY,
            true => Self(rank.0 | Self::CONTESTED),
            false => Self(rank.0),
        }
    }

    /// Rank of the candidate, if it is one.
    #[inline(always)]
    pub fn rank(self) -> Option<Rank> {
        (self != Self::NOBODY && self != Self::OWN).then_some(Rank(self.0 & !Self::CONTESTED))
    }

    /// Status of a cell that a candidate serves.
    #[inline(always)]
    pub fn status(self) -> Status {
        if self.0 & Self::CONTESTED == 0 { Status::Good } else { Status::Overlapped }
    }
}

const _: () = assert!(Rank::FARTHEST.0 < Server::CONTESTED);

impl Candidates {
    /// Removes all candidates.
    pub fn clear(&mut self) {
        self.all.clear();
        self.runs.clear();
    }

    /// Empties all cells.
    fn clear_cells(&mut self) {
        for Layer { places, numbers } in &mut self.layers {
            places.clear();
            places.resize(AROUND + LANES, FAR);
            numbers.resize(AROUND + LANES, 0);
        }
        self.counts.clear();
        self.counts.resize(AROUND, 0);
        self.full_rows = 0;
        self.crowded.clear();
        self.is_sorted = false;
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Adds a run of the tile's bin, from tile number `source`. `tile` is that tile if its samples have to be
    /// prefetched.
    pub fn add(&mut self, source: u32, run: &[u64], tile: Option<&Tile>) {
        if self.runs.is_empty() {
            self.clear_cells();
        }
        let start = self.all.len();
        let run = &run[..run.len().min(MOST - start)];
        let number = self.runs.len() as u16;
        self.runs.push((source, start as u32));
        self.all.extend(binned(run).map(|word| Candidate { word, cell: cell_of(word), run: number }));
        let Self { all, layers, counts, full_rows, crowded, .. } = self;
        for (number, Candidate { word, cell, .. }) in (start as u32..).zip(&all[start..]) {
            if let Some(tile) = tile {
                tile.prefetch_record(word.slot());
            }
            let at = usize::from(*cell);
            let count = usize::from(counts[at]);
            if count < LAYERS {
                let Layer { places, numbers } = &mut layers[count];
                let [x, y] = word.place();
                places[at] = (y as u32) << 16 | x as u32;
                numbers[at] = number;
                if count + 1 == LAYERS {
                    *full_rows |= 1 << (at / ROW);
                }
            } else if count == LAYERS {
                crowded.push(*cell);
            } else {
                continue;
            }
            counts[at] += 1;
        }
    }

    /// Tiles that the candidates come from, with the ranges of their numbers.
    pub fn runs(&self) -> impl Iterator<Item = (u32, Range<usize>)> {
        let ends = self.runs.iter().skip(1).map(|(_, first)| *first as usize).chain([self.len()]);
        self.runs.iter().zip(ends).map(|((source, first), end)| (*source, *first as usize..end))
    }

    /// Candidate number `number`.
    #[inline(always)]
    pub fn get(&self, number: usize) -> Candidate {
        self.all[number]
    }

    /// Number of the tile that a candidate comes from.
    pub fn source(&self, number: usize) -> u32 {
        self.runs[usize::from(self.all[number].run)].0
    }

    /// Finds servers for eight cells of a row of the tile, from column `first` on: the candidate nearest to
    /// the target, if it is near enough, with a bit if others are, too. Valid where no cell beside is
    /// [crowded](Self::crowded).
    #[inline(always)]
    pub fn nearest_to_eight(&self, row: usize, first: usize) -> [Server; LANES] {
        // rows above, at and below
        let layers = if self.full_rows >> row & 7 != 0 { LAYERS } else { LAYERS - 1 };
        let down = (row + 1) as u32 * STEPS as u32 + STEPS as u32 / 2;
        let across = |lane: usize| (first + lane + 1) as u32 * STEPS as u32 + STEPS as u32 / 2;
        let targets: i16x16 =
            bytemuck::cast(u32x8::new(std::array::from_fn(|lane| (down << 16) | across(lane))));
        let (mut best, mut near) = (u32x8::splat(u32::MAX), u32x8::ZERO);
        for Layer { places, numbers } in &self.layers[..layers] {
            for beside in [0, 1, 2].map(|down| (row + down) * ROW + first) {
                for at in beside..beside + 3 {
                    let places: i16x16 = bytemuck::cast(eight(places, at));
                    let aside = places - targets;
                    let far: u32x8 = bytemuck::cast(aside.dot(aside));
                    let far = far.min(u32x8::splat(u32::from(u16::MAX)));
                    let rank = (far << 16_u32) | eight(numbers, at);
                    best = best.min(rank);
                    near += rank.cmp_lt(u32x8::splat(Rank::FARTHEST.0));
                }
            }
        }
        // each comparison that holds has subtracted 1 from zero
        let is_contested = near.cmp_gt(u32x8::ZERO) & near.cmp_lt(u32x8::MAX);
        let servers = best | (is_contested & u32x8::splat(Server::CONTESTED));
        let none = best.cmp_gt(u32x8::splat(Rank::FARTHEST.0));
        (servers | none).to_array().map(Server)
    }

    /// Cells in and around the tile with more candidates than [`nearest_to_eight`](Self::nearest_to_eight)
    /// looks at.
    pub fn crowded(&self) -> &[u16] {
        &self.crowded
    }

    /// Sorts the candidates by the cells in which they lie: needed for [`nearest`](Self::nearest) and
    /// [`nearest_to_eye`](Self::nearest_to_eye).
    pub fn sort(&mut self) {
        if std::mem::replace(&mut self.is_sorted, true) {
            return;
        }
        let Self { all, starts, sorted, .. } = self;
        starts.clear();
        starts.resize(AROUND + 1, 0);
        for Candidate { cell, .. } in &*all {
            starts[usize::from(*cell) + 1] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        sorted.resize(all.len(), 0);
        // each start moves to its end, which is the next one's start
        for (number, Candidate { cell, .. }) in (0..).zip(&*all) {
            let at = &mut starts[usize::from(*cell)];
            sorted[usize::from(*at)] = number;
            *at += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
    }

    /// Finds the candidate nearest to the eye among those that lie in `cell`, with a bit if there are
    /// several.
    pub fn nearest_to_eye(&self, cell: usize) -> Server {
        let around = around(cell);
        let all = self.lie_in(around..around + 1);
        let depth = |number: &&u16| (self.all[usize::from(**number)].word.depth(), **number);
        let nearest = all.iter().min_by_key(depth);
        Server::new(nearest.map_or(Rank::NONE, |number| Rank::new(0, *number)), all.len() > 1)
    }

    /// Numbers of the candidates that lie in these cells in or around the tile.
    fn lie_in(&self, around: Range<usize>) -> &[u16] {
        &self.sorted[usize::from(self.starts[around.start])..usize::from(self.starts[around.end])]
    }

    /// Finds the candidate nearest to the target of `cell`, if it is near enough, among those that come
    /// `after` another one; with a bit if several are near enough.
    pub fn nearest(&self, cell: usize, after: Option<Rank>) -> Server {
        let target = place(cell).map(|at| (at as i32 + 1) * STEPS + STEPS / 2);
        let (middle, mut best, mut near) = (around(cell), Rank::NONE, 0);
        for first in [middle - ROW, middle, middle + ROW] {
            for number in self.lie_in(first - 1..first + 2) {
                let [x, y] = self.all[usize::from(*number)].word.place();
                let aside = [x - target[0], y - target[1]];
                let rank = Rank::new((aside[0] * aside[0] + aside[1] * aside[1]) as u32, *number);
                if after.is_none_or(|after| rank > after) && rank < Rank::FARTHEST {
                    best = best.min(rank);
                    near += 1;
                }
            }
        }
        Server::new(best, near > 1)
    }
}

/// Eight values from `at` on.
#[inline(always)]
fn eight(values: &[u32], at: usize) -> u32x8 {
    let values = &values[at..at + 8];
    u32x8::new(std::array::from_fn(|lane| values[lane]))
}

/// Cell in or around a tile in which a candidate lies.
#[inline(always)]
fn cell_of(word: Binned) -> u16 {
    let [x, y] = word.place().map(|at| at / STEPS);
    (y * ROW as i32 + x) as u16
}
