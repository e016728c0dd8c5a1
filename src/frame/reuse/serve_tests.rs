//! Properties of the choice of servers and of the samples that are kept, tested with many random candidates.

use std::collections::HashMap;

use super::bins::{Binned, STEPS};
use super::candidates::{Candidate, Candidates, REACH, Rank, Server};
use super::serve::{KEPT, Serving};
use crate::frame::grid::around::ROW;
use crate::frame::grid::cells::CellSet;
use crate::frame::grid::{holds, place};
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, MOST_SPARES, Status, TILE, TagLayout, Tile};
use crate::settings::Reuse;

/// Numbers that look random, the same in each run (SplitMix64).
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ mixed >> 31) % end
    }
}

/// A candidate: the tile and slot that it comes from, and its place in [`STEPS`], from one cell left of and
/// above the tile.
#[derive(Debug, Clone, Copy)]
struct Thrown {
    source: u32,
    slot: usize,
    at: [i32; 2],
}

impl Thrown {
    /// Column and row of its cell, in and around the tile.
    fn lies_in(&self) -> [i32; 2] {
        self.at.map(|at| at / STEPS)
    }

    /// Returns true if that cell is in the tile and in the picture.
    fn is_own(&self, extent: Extent) -> bool {
        let within = |axis: usize| (1..=extent.cells[axis] as i32).contains(&self.lies_in()[axis]);
        within(0) && within(1)
    }

    /// Number that identifies its sample.
    fn mark(&self) -> u32 {
        mark(self.source, self.slot)
    }
}

fn mark(source: u32, slot: usize) -> u32 {
    source * 2 * CELLS as u32 + slot as u32
}

/// Distribution of candidates.
#[derive(Debug, Clone, Copy)]
struct Throw {
    /// Reciprocal of the probability that a slot of a source has a candidate.
    one_in: u64,
    /// Grid of places, in steps: where it is coarse, many are equally far from a target.
    coarse: u64,
    /// Reciprocal of the probability that a candidate falls into the cell in the middle.
    heap: u64,
}

const THROWS: [Throw; 6] = [
    Throw { one_in: 2, coarse: 1, heap: u64::MAX },
    Throw { one_in: 40, coarse: 1, heap: u64::MAX },
    Throw { one_in: 2, coarse: 16, heap: 4 },
    Throw { one_in: 3, coarse: 32, heap: u64::MAX },
    Throw { one_in: 1, coarse: 8, heap: 20 },
    Throw { one_in: u64::MAX, coarse: 1, heap: u64::MAX },
];

/// Rendered part of a tile, and where there are tiles beside it: to the left, above, to the right and below.
#[derive(Debug, Clone, Copy)]
struct Extent {
    cells: [u32; 2],
    goes_on: [bool; 4],
}

/// Extents of a tile within the picture, and of one in which it ends.
const EXTENTS: [Extent; 2] = [
    Extent { cells: [TILE as u32; 2], goes_on: [true; 4] },
    Extent { cells: [21, 6], goes_on: [true, false, false, false] },
];

const SOURCES: u32 = 2;

/// Number of spare samples of each source.
const SPARES: usize = 100;

/// Random candidates in the order of the tiles that they come from and of their slots, all of them within the
/// picture.
fn strew(throw: Throw, extent: Extent, dice: &mut Dice) -> Vec<Thrown> {
    let range = [0, 1].map(|axis| {
        let [before, after] = [extent.goes_on[axis], extent.goes_on[axis + 2]].map(u64::from);
        let steps = STEPS as u64;
        ((1 - before) * steps, (1 + u64::from(extent.cells[axis]) + after) * steps)
    });
    let mut thrown = Vec::new();
    for (source, slot) in (0..SOURCES).flat_map(|source| (0..CELLS + SPARES).map(move |slot| (source, slot)))
    {
        if dice.below(throw.one_in) == 0 {
            let is_heaped = throw.heap != u64::MAX && dice.below(throw.heap) == 0;
            let at = range.map(|(start, end)| {
                let (start, end) = match is_heaped {
                    true => ((start + end) / 2, (start + end) / 2 + STEPS as u64),
                    false => (start, end),
                };
                (start + dice.below(end - start)).next_multiple_of(throw.coarse).min(end - 1) as i32
            });
            thrown.push(Thrown { source, slot, at });
        }
    }
    thrown
}

/// Calls `each` with a run of words for each source.
fn for_each_run(thrown: &[Thrown], mut each: impl FnMut(u32, &[u64])) {
    for run in thrown.chunk_by(|a, b| a.source == b.source) {
        let words: Vec<u64> = run.iter().map(|one| Binned::new(1.0, one.at, one.slot).word()).collect();
        each(run[0].source, &words);
    }
}

/// Numbers of all candidates that are near enough to serve `cell`, the nearest first; those that are equally
/// far in the order of their numbers.
fn by_distance(thrown: &[Thrown], cell: usize) -> Vec<usize> {
    let target = place(cell).map(|at| (at as i32 + 1) * STEPS + STEPS / 2);
    let far = |one: &Thrown| (0..2).map(|axis| (one.at[axis] - target[axis]).pow(2)).sum::<i32>();
    let is_near = |one: &Thrown| (far(one) as f32).sqrt() <= REACH * STEPS as f32;
    let mut near: Vec<usize> = (0..thrown.len()).filter(|number| is_near(&thrown[*number])).collect();
    near.sort_by_key(|number| (far(&thrown[*number]), *number));
    near
}

#[test]
fn one_after_the_other_candidates_come_from_near_to_far() {
    let mut dice = Dice(1);
    let (mut most, mut ties, mut none) = (0, 0, 0);
    for (throw, extent) in THROWS.into_iter().flat_map(|throw| EXTENTS.map(|extent| (throw, extent))) {
        let thrown = strew(throw, extent, &mut dice);
        let mut candidates = Candidates::default();
        for_each_run(&thrown, |source, run| candidates.add(source, run, None));
        candidates.sort();
        for (number, one) in thrown.iter().enumerate() {
            assert_eq!(candidates.source(number), one.source);
            let Candidate { word, cell, .. } = candidates.get(number);
            let [x, y] = one.lies_in();
            assert_eq!((word.slot(), word.place()), (one.slot, one.at));
            assert_eq!(usize::from(cell), y as usize * ROW + x as usize);
        }
        for cell in (0..CELLS).filter(|cell| holds(extent.cells, *cell)) {
            let near = by_distance(&thrown, cell);
            let mut after = None;
            for (place, number) in near.iter().enumerate() {
                let server = candidates.nearest(cell, after);
                let found = server.rank().map(Rank::number);
                assert_eq!(found, Some(*number), "{throw:?}, cell {cell}: {place} of {near:?}");
                let status = if place + 1 < near.len() { Status::Overlapped } else { Status::Good };
                assert_eq!(server.status(), status, "{throw:?}, cell {cell}, {place}");
                after = server.rank();
            }
            assert_eq!(candidates.nearest(cell, after), Server::NOBODY, "{throw:?}, cell {cell}");
            most = most.max(near.len());
            none += usize::from(near.is_empty());
            let at = |number: &usize| thrown[*number].at;
            ties += near.windows(2).filter(|two| at(&two[0]) == at(&two[1])).count();
        }
    }
    assert!(most > 100 && ties > 1000 && none > 1000, "all sorts were there: {most} {ties} {none}");
}

/// Tiles whose samples all have a [`mark`].
fn sources() -> Vec<Tile> {
    let tile = |source: u32| {
        let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
        tile.model = [0; CELLS];
        for slot in (0..SPARES).map(|number| CELLS + number) {
            tile.record[0].triangle = mark(source, slot);
            let spare = tile.sample(0);
            tile.spares.push_untagged(spare, &tile.gathered, 0);
        }
        (0..).zip(&mut tile.record).for_each(|(cell, record)| record.triangle = mark(source, cell));
        tile
    };
    (0..SOURCES).map(tile).collect()
}

#[test]
fn each_sample_is_kept_once_and_the_nearest_one_serves() {
    let mut dice = Dice(2);
    let from = sources();
    let tiles = |source: u32| from.get(source as usize);
    let mut serving = Serving::default();
    let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
    let (mut copies, mut spares, mut dropped) = (0, 0, 0);
    for (throw, extent) in THROWS.into_iter().flat_map(|throw| EXTENTS.map(|extent| (throw, extent))) {
        let thrown = strew(throw, extent, &mut dice);
        serving.begin();
        for_each_run(&thrown, |source, run| serving.add(source, run, None));
        serving.serve(Reuse::Target, (extent.cells, &CellSet::ALL), &tile);
        // over what the tile had before
        serving.fill(Reuse::Target, extent.cells, KEPT, &mut tile, &tiles);

        // by mark: the cells that show a sample, and how often it is kept
        let (mut shown, mut kept) = (HashMap::<u32, usize>::new(), HashMap::<u32, usize>::new());
        for cell in 0..CELLS {
            let near = if holds(extent.cells, cell) { by_distance(&thrown, cell) } else { Vec::new() };
            let Some(server) = near.first().map(|number| thrown[*number]) else {
                assert_eq!((tile.model[cell], tile.status[cell]), (EMPTY, Status::Missed), "cell {cell}");
                continue;
            };
            let status = if near.len() > 1 { Status::Overlapped } else { Status::Good };
            let found = (tile.model[cell], tile.status[cell], tile.record[cell].triangle);
            assert_eq!(found, (0, status, server.mark()), "{throw:?}, cell {cell}");
            *shown.entry(server.mark()).or_default() += 1;
            let is_copy = tile.copies[cell / LANES] >> (cell % LANES) & 1 != 0;
            copies += usize::from(is_copy);
            *kept.entry(server.mark()).or_default() += usize::from(!is_copy);
        }
        for spare in &tile.spares.samples {
            assert!(!shown.contains_key(&spare.record.triangle), "{throw:?}: it serves a cell");
            *kept.entry(spare.record.triangle).or_default() += 1;
        }
        spares += tile.spares.len();
        assert!(tile.spares.len() < MOST_SPARES, "the cap of the tile plays no part here");

        // by cell: its samples, those of them that serve, and those that are kept
        let mut cells = HashMap::<[i32; 2], [usize; 3]>::new();
        for one in &thrown {
            let (serves, times) =
                (shown.contains_key(&one.mark()), kept.get(&one.mark()).copied().unwrap_or(0));
            if one.is_own(extent) {
                assert!(times <= 1 && (times == 1 || !serves), "{throw:?}, {one:?}: kept {times} times");
                let [all, serving, kept] = cells.entry(one.lies_in()).or_default();
                *all += 1;
                *serving += usize::from(serves);
                *kept += times;
            } else {
                assert_eq!(times, 0, "{throw:?}, {one:?}: the tile in which it lies keeps it");
            }
        }
        for (cell, [all, serving, kept]) in cells {
            assert_eq!(
                kept,
                serving.max(all.min(usize::from(KEPT))),
                "{throw:?}, {cell:?}: {all}, {serving}"
            );
            dropped += all - kept;
        }
    }
    assert!(copies > 100 && spares > 100 && dropped > 100, "all sorts: {copies} {spares} {dropped}");
}

#[test]
fn by_the_papers_rule_what_would_serve_cells_that_nobody_asks_for_stays_as_a_spare_sample() {
    let (mut dice, from) = (Dice(3), sources());
    let tiles = |source: u32| from.get(source as usize);
    let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
    let mut serving = Serving::default();
    for (throw, extent) in THROWS.into_iter().flat_map(|throw| EXTENTS.map(|extent| (throw, extent))) {
        let (thrown, wanted) = (strew(throw, extent, &mut dice), CellSet::new(|cell| cell % 3 == 0));
        serving.begin();
        for_each_run(&thrown, |source, run| serving.add(source, run, None));
        serving.serve(Reuse::Paper, (extent.cells, &wanted), &tile);
        serving.fill(Reuse::Paper, extent.cells, KEPT, &mut tile, &tiles);
        let mut unused = Vec::new();
        for cell in (0..CELLS).filter(|cell| holds(extent.cells, *cell)) {
            let lies_in = place(cell).map(|at| at as i32 + 1);
            // all are equally far from the eye
            let server = thrown.iter().find(|one| one.lies_in() == lies_in).map(Thrown::mark);
            match wanted.has(cell) {
                true => {
                    let shown = (tile.model[cell] != EMPTY).then_some(tile.record[cell].triangle);
                    assert_eq!(shown, server, "{throw:?}, cell {cell}");
                }
                false => unused.extend(server),
            }
        }
        let spares: Vec<u32> = tile.spares.samples.iter().map(|spare| spare.record.triangle).collect();
        assert_eq!(spares, unused, "{throw:?}");
    }
}
