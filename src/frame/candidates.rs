//! The kept samples in and around one tile, sorted by the cells in which they lie.

use wide::{i16x16, u32x8};

use super::bins::{Binned, STEPS, binned};
use super::grid::place;
use crate::samples::{TILE, Tile};

/// Cells along an edge of a tile and one around it.
pub const ACROSS: usize = TILE + 2;

/// All of them. They are numbered in rows.
pub const AROUND: usize = ACROSS * ACROSS;

/// Candidates of a tile at most, so that a number has 16 bits: those of the last tiles that they come from are dropped
/// when everything is projected into a few tiles.
const MOST: usize = u16::MAX as usize;

/// How far from its target, in cells, a sample may serve at most.
pub const REACH: f32 = RADIUS as f32 / STEPS as f32;

/// The same in [`STEPS`].
const RADIUS: u32 = 48;

/// Places beyond the last one, so that sixteen may be loaded anywhere.
const PADDING: usize = 16;

/// Where a tile with candidates is, by its number.
pub trait Sources<'t>: Fn(u32) -> Option<&'t Tile> {}
impl<'t, F: Fn(u32) -> Option<&'t Tile>> Sources<'t> for F {}

/// Candidates, by number: in the order of the tiles that they come from, and of their slots. Keeps its memory.
#[derive(Debug, Default)]
pub struct Candidates {
    words: Vec<Binned>,
    /// For each candidate the cell in or around the tile in which it lies.
    cells: Vec<u16>,
    /// The tiles that they come from, with the number of the first candidate of each.
    runs: Vec<(u32, u32)>,
    /// For each cell in or around the tile, where its candidates begin in `places` and `numbers`.
    starts: Vec<u16>,
    /// x and y of the candidates, cell by cell; see [`Binned::place`].
    places: Vec<[i16; 2]>,
    /// Their numbers.
    numbers: Vec<u16>,
}

/// How a candidate is ranked for a cell: the square of its distance from the target, and its place in the order of
/// cells. The least is the nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank(u32);

impl Rank {
    /// Of no candidate.
    pub const NONE: Self = Self(u32::MAX);

    /// Of what is as far from the target as a server may be.
    const FARTHEST: Self = Self((RADIUS * RADIUS) << u16::BITS | u16::MAX as u32);

    /// Where the candidate is in the order of cells.
    fn at(self) -> usize {
        (self.0 % (1 << u16::BITS)) as usize
    }
}

impl Candidates {
    /// None.
    pub fn clear(&mut self) {
        self.words.clear();
        self.cells.clear();
        self.runs.clear();
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.words.len()
    }

    /// Adds a run of the tile's bin, from tile number `source`.
    pub fn add(&mut self, source: u32, run: &[u64]) {
        self.runs.push((source, self.words.len() as u32));
        let room = MOST - self.words.len();
        self.words.extend(binned(run).take(room));
        let [x, y] = [0, 1].map(|axis| move |word: Binned| (word.place()[axis] / STEPS) as u16);
        self.cells.extend(binned(run).take(room).map(|word| y(word) * ACROSS as u16 + x(word)));
    }

    /// The tiles that they come from, with their candidates' numbers.
    pub fn runs(&self) -> impl Iterator<Item = (u32, std::ops::Range<usize>)> {
        let ends = self.runs.iter().skip(1).map(|(_, first)| *first as usize).chain([self.len()]);
        self.runs.iter().zip(ends).map(|((source, first), end)| (*source, *first as usize..end))
    }

    /// What is known of a candidate, and the cell in or around the tile in which it lies.
    #[inline(always)]
    pub fn get(&self, number: usize) -> (Binned, usize) {
        (self.words[number], usize::from(self.cells[number]))
    }

    /// The tile that a candidate comes from.
    pub fn source(&self, number: usize) -> u32 {
        let after = self.runs.partition_point(|(_, first)| *first as usize <= number);
        self.runs[after - 1].0
    }

    /// Sorts them by the cells in which they lie.
    pub fn sort(&mut self) {
        let Self { words, cells, starts, places, numbers, .. } = self;
        starts.clear();
        starts.resize(AROUND + 1, 0);
        for cell in &*cells {
            starts[usize::from(*cell) + 1] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        places.resize(words.len() + PADDING, [0; 2]);
        numbers.resize(words.len(), 0);
        // each start moves to its end, which is the next one's start
        for ((number, word), cell) in (0..).zip(&*words).zip(&*cells) {
            let at = &mut starts[usize::from(*cell)];
            places[usize::from(*at)] = word.place().map(|at| at as i16);
            numbers[usize::from(*at)] = number;
            *at += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
    }

    /// The number of the candidate with this rank.
    #[inline(always)]
    pub fn number(&self, rank: Rank) -> usize {
        usize::from(self.numbers[rank.at()])
    }

    /// Of the candidates that lie in a cell in or around the tile the one nearest to the eye, and how many there are.
    pub fn nearest_to_eye(&self, around: usize) -> (Rank, usize) {
        let range = usize::from(self.starts[around])..usize::from(self.starts[around + 1]);
        let depth = |at: &usize| (self.words[usize::from(self.numbers[*at])].depth(), *at);
        let nearest = range.clone().min_by_key(depth).map_or(Rank::NONE, |at| Rank(at as u32));
        (nearest, range.len())
    }

    /// The candidate nearest to the target of `cell`, if it is near enough, of those that come `after` another one; and
    /// whether several are near enough.
    #[inline(always)]
    pub fn nearest(&self, cell: usize, after: Option<Rank>) -> (Rank, bool) {
        let [x, y] = place(cell).map(|at| at as i16 + 1);
        let around = y as usize * ACROSS + x as usize;
        let target = [x, y].map(|at| at * STEPS as i16 + STEPS as i16 / 2);
        let target = i16x16::new(std::array::from_fn(|i| target[i % 2]));
        let least = u32x8::splat(after.map_or(0, |after| after.0 + 1));
        let lanes = u32x8::new(std::array::from_fn(|lane| lane as u32));
        let mut best = u32x8::splat(u32::MAX);
        let mut near = u32x8::ZERO;
        for first in [around - ACROSS, around, around + ACROSS] {
            // the cells beside each other are one range
            let [start, end] = [first - 1, first + 2].map(|cell| usize::from(self.starts[cell]));
            for at in (start..end).step_by(8) {
                let some: &[[i16; 2]] = &self.places[at..at + 8];
                let places = i16x16::new(std::array::from_fn(|i| some[i / 2][i % 2]));
                let aside = places - target;
                let far = aside.dot(aside).to_array();
                let far = u32x8::new(std::array::from_fn(|lane| far[lane] as u32));
                let rank = (far << 16_u32) | (u32x8::splat(at as u32) + lanes);
                // lanes beyond the end, and those that were asked already, come last
                let is_beyond = !lanes.cmp_lt(u32x8::splat((end - at) as u32));
                let is_over = is_beyond | rank.cmp_lt(least);
                let rank = rank | is_over;
                best = best.min(rank);
                near = near + (rank.cmp_lt(u32x8::splat(Rank::FARTHEST.0)) & u32x8::splat(1));
            }
        }
        let best = best.to_array().into_iter().fold(u32::MAX, u32::min);
        let near: u32 = near.to_array().into_iter().sum();
        let best = if best <= Rank::FARTHEST.0 { Rank(best) } else { Rank::NONE };
        (best, near > 1)
    }
}

/// The number, among the cells in and around a tile, of one of its cells.
#[inline(always)]
pub fn around(cell: usize) -> usize {
    let [column, row] = place(cell).map(|at| at as usize + 1);
    row * ACROSS + column
}
