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
    /// For each cell in and around the tile, in [rows](ROW), its first two candidates: as many as most have.
    pairs: [Pair; 2],
    /// How many candidates it has.
    counts: Vec<u8>,
    /// Cells in and around the tile that have more than two.
    crowded: Vec<u16>,
    /// For each cell in and around the tile, where its candidates begin in `sorted`; once they are sorted.
    starts: Vec<u16>,
    /// The numbers of the candidates, cell by cell.
    sorted: Vec<u16>,
    is_sorted: bool,
}

/// A candidate for each cell in and around a tile.
#[derive(Debug, Default)]
struct Pair {
    /// Its [place](Binned::place), or [`FAR`]: x in the low half, y in the high one.
    places: Vec<u32>,
    /// Its number.
    numbers: Vec<u32>,
}

/// A place far from all targets, in which there is no candidate.
const FAR: u32 = 16_000 << 16 | 16_000;

/// Cells of a row in and around a tile, in whole eights, and more, so that eight may be loaded from any of them.
pub const ROW: usize = ACROSS.next_multiple_of(8);

/// How a candidate is ranked for a cell: the square of its distance from the target, and its number. The least is the
/// nearest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rank(u32);

impl Rank {
    /// Of no candidate.
    pub const NONE: Self = Self(u32::MAX);

    /// Of what is as far from the target as a server may be.
    const FARTHEST: Self = Self((RADIUS * RADIUS) << u16::BITS | u16::MAX as u32);

    fn new(far: u32, number: u16) -> Self {
        Self(far.min(u32::from(u16::MAX)) << u16::BITS | u32::from(number))
    }

    /// The candidate's number.
    #[inline(always)]
    pub fn number(self) -> usize {
        (self.0 % (1 << u16::BITS)) as usize
    }
}

impl Candidates {
    /// None.
    pub fn clear(&mut self) {
        self.words.clear();
        self.cells.clear();
        self.runs.clear();
        self.is_sorted = false;
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

    /// Notes of each cell which candidates it has: needed for [`nearest_in_row`](Self::nearest_in_row).
    pub fn pair(&mut self) {
        let Self { words, cells, pairs, counts, crowded, .. } = self;
        for Pair { places, numbers } in &mut *pairs {
            places.clear();
            places.resize(ACROSS * ROW + 8, FAR);
            numbers.resize(ACROSS * ROW + 8, 0);
        }
        counts.clear();
        counts.resize(AROUND, 0);
        crowded.clear();
        for ((number, word), cell) in (0..).zip(&*words).zip(&*cells) {
            let count = &mut counts[usize::from(*cell)];
            let at = usize::from(*cell) + usize::from(*cell) / ACROSS * (ROW - ACROSS);
            if let Some(Pair { places, numbers }) = pairs.get_mut(usize::from(*count)) {
                let [x, y] = word.place();
                places[at] = (y as u32) << 16 | x as u32;
                numbers[at] = number;
                *count += 1;
            } else if *count == 2 {
                crowded.push(*cell);
                *count += 1;
            }
        }
    }

    /// Calls `each(column, rank, is_contested)` for the cells of a row of the tile: the candidate nearest to the target, if
    /// it is near enough, and whether others are, too. Right where no cell beside is [crowded](Self::crowded).
    #[inline(always)]
    pub fn nearest_in_row(&self, row: usize, columns: usize, mut each: impl FnMut(usize, Rank, bool)) {
        let down = (row + 1) as u32 * STEPS as u32 + STEPS as u32 / 2;
        for first in (0..columns).step_by(8) {
            let across = |lane: usize| (first + lane + 1) as u32 * STEPS as u32 + STEPS as u32 / 2;
            let targets: i16x16 =
                bytemuck::cast(u32x8::new(std::array::from_fn(|lane| (down << 16) | across(lane))));
            let (mut best, mut near) = (u32x8::splat(u32::MAX), u32x8::ZERO);
            for Pair { places, numbers } in &self.pairs {
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
            let (best, near) = (best.to_array(), near.to_array());
            for lane in 0..8.min(columns - first) {
                let rank = if best[lane] <= Rank::FARTHEST.0 { Rank(best[lane]) } else { Rank::NONE };
                // as many were subtracted from zero
                each(first + lane, rank, near[lane].wrapping_neg() > 1);
            }
        }
    }

    /// Cells in and around the tile with more candidates than [`nearest_in_row`](Self::nearest_in_row) looks at.
    pub fn crowded(&self) -> &[u16] {
        &self.crowded
    }

    /// Sorts them by the cells in which they lie: needed for [`nearest`](Self::nearest) and
    /// [`nearest_to_eye`](Self::nearest_to_eye).
    pub fn sort(&mut self) {
        if std::mem::replace(&mut self.is_sorted, true) {
            return;
        }
        let Self { words, cells, starts, sorted, .. } = self;
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
        sorted.resize(words.len(), 0);
        // each start moves to its end, which is the next one's start
        for (number, cell) in (0..).zip(&*cells) {
            let at = &mut starts[usize::from(*cell)];
            sorted[usize::from(*at)] = number;
            *at += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
    }

    /// Of the candidates that lie in a cell in or around the tile the one nearest to the eye, and how many there are.
    pub fn nearest_to_eye(&self, around: usize) -> (Rank, usize) {
        let all = self.lie_in(around..around + 1);
        let depth = |number: &&u16| (self.words[usize::from(**number)].depth(), **number);
        let nearest = all.iter().min_by_key(depth);
        (nearest.map_or(Rank::NONE, |number| Rank::new(0, *number)), all.len())
    }

    /// The numbers of the candidates that lie in cells in or around the tile.
    fn lie_in(&self, around: std::ops::Range<usize>) -> &[u16] {
        &self.sorted[usize::from(self.starts[around.start])..usize::from(self.starts[around.end])]
    }

    /// The candidate nearest to the target of `cell`, if it is near enough, of those that come `after` another one; and
    /// whether several are near enough.
    pub fn nearest(&self, cell: usize, after: Option<Rank>) -> (Rank, bool) {
        let target = place(cell).map(|at| (at as i32 + 1) * STEPS + STEPS / 2);
        let (middle, mut best, mut near) = (around(cell), Rank::NONE, 0);
        for first in [middle - ACROSS, middle, middle + ACROSS] {
            for number in self.lie_in(first - 1..first + 2) {
                let [x, y] = self.words[usize::from(*number)].place();
                let aside = [x - target[0], y - target[1]];
                let rank = Rank::new((aside[0] * aside[0] + aside[1] * aside[1]) as u32, *number);
                if after.is_none_or(|after| rank > after) && rank < Rank::FARTHEST {
                    best = best.min(rank);
                    near += 1;
                }
            }
        }
        (best, near > 1)
    }
}

/// Eight values from `at` on.
#[inline(always)]
fn eight(values: &[u32], at: usize) -> u32x8 {
    let values = &values[at..at + 8];
    u32x8::new(std::array::from_fn(|lane| values[lane]))
}

/// The number, among the cells in and around a tile, of one of its cells.
#[inline(always)]
pub fn around(cell: usize) -> usize {
    let [column, row] = place(cell).map(|at| at as usize + 1);
    row * ACROSS + column
}
