//! Serving: which kept sample each cell shows.
//!
//! Each cell has a target, its centre. It is *served* by the nearest kept sample that holds, in whatever cell that
//! sample lies, if it is within [`REACH`]. One sample may serve two cells; those that serve none are kept as spare
//! samples, up to [`KEPT`] in a cell.
//!
//! At an edge the nearest sample need not show what the target shows: silhouettes would lag behind, or grow. An edge is
//! where the samples in the cell and the eight around it show different surfaces, or where one of the four quadrants
//! around the target has none: there something new may have come into sight. There the target itself is *probed*, by a
//! ray from the eye ([`trace_missed`](super::trace_missed)): the server stays if the ray meets the surface that it
//! shows, and otherwise what the ray met takes its place. So each surface has the cells whose targets it covers, as in
//! a frame that is traced in full, however long a chain of inferred frames is and however densely the surface happens
//! to be sampled.
//!
//! The paper's own rule, for comparison, is [`Serving::nearest_to_eye`]: of the samples in a cell the one nearest to
//! the eye serves it, and the others go. Samples drift against the grid; two share a cell while the cell beside it is
//! empty, and a fifth of all true samples are lost that way every frame.

use super::bins::{Binned, STEPS, binned};
use super::grid::{Extent, cell_number, place};
use crate::samples::{BACKGROUND, CELLS, EMPTY, Flags, MOST_SPARES, Octahedral, Status, TILE, Tile};
use crate::settings::Reuse;

/// How far from its target, in cells, a sample may serve at most.
pub const REACH: f32 = RADIUS as f32 / STEPS as f32;

/// The same in [`STEPS`].
const RADIUS: i32 = 48;

/// Samples that are kept of those that lie in a cell, unless they serve: enough for those that share a cell by chance
/// while the cell beside it is empty. With three a frame traces a tenth less, and spare samples take half as much again.
const KEPT: u8 = 2;

/// Where surfaces beside each other differ so much in depth (a share of it), one is before the other.
pub const DEPTH_STEP: f32 = 0.1;

/// Cells along an edge of a tile and one around it.
const ACROSS: usize = TILE + 2;

/// All of them.
const AROUND: usize = ACROSS * ACROSS;

/// No candidate.
const NOBODY: u32 = u32::MAX;

/// In place of a server: the cell's own sample, which stays.
const STAYS: u64 = u64::MAX - 1;

/// What a worker needs to serve the cells of one tile. Keeps its memory from tile to tile.
#[derive(Debug, Default)]
pub struct Serving {
    /// Samples in and around the tile, by the number of the tile that they come from and their slot there.
    candidates: Vec<Candidate>,
    /// For each cell in and around the tile, where its candidates begin in `x`, `y` and `who`.
    starts: Vec<u32>,
    /// Places of the candidates, cell by cell; see [`Binned::place`].
    x: Vec<i32>,
    y: Vec<i32>,
    /// Their numbers.
    who: Vec<u32>,
    /// What the candidates in each cell in and around the tile show, and later those around it, too.
    shown: Vec<Shown>,
    /// The same for the row above and the cells beside.
    beside: Vec<Shown>,
    /// Which quarters of each cell in and around the tile have a candidate, a bit each.
    quarters: Vec<u8>,
    /// For each cell who serves it, or was asked last: nearness, and the place in `who`.
    asked: Vec<u64>,
    /// For each cell whether it is at an edge.
    is_edge: Vec<bool>,
    /// For each candidate, the cell that it serves.
    serves: Vec<u16>,
    /// For each cell in and around the tile, how many of the samples in it are kept.
    kept: Vec<u8>,
    /// Flags that any sample that serves has.
    flags: Flags,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    word: Binned,
    source: u32,
    /// The cell in or around the tile in which it lies.
    cell: u16,
}

/// The least of what some candidates show, and the complement of the greatest: surface, depth and normal.
#[derive(Debug, Clone, Copy)]
struct Shown {
    least: [u32; 4],
    most: [u32; 4],
}

impl Shown {
    const NOTHING: Self = Self { least: [u32::MAX; 4], most: [0; 4] };

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self {
            least: std::array::from_fn(|i| self.least[i].min(other.least[i])),
            most: std::array::from_fn(|i| self.most[i].max(other.most[i])),
        }
    }

    /// Whether all that is shown may be one surface.
    #[inline(always)]
    fn is_one_surface(&self) -> bool {
        let range = |i: usize| self.most[i].wrapping_sub(self.least[i]);
        (range(0) == 0)
            & (range(1) < depth_steps())
            & (range(2) < Octahedral::FOLD)
            & (range(3) < Octahedral::FOLD)
    }
}

/// [`DEPTH_STEP`] in steps of [`Binned::depth`].
const fn depth_steps() -> u32 {
    // as many as there are from a power of two on: at most twice as many for the same share elsewhere
    (DEPTH_STEP * (1 << 21) as f32) as u32
}

/// The number of the cell in or around a tile at a [place](Binned::place).
#[inline(always)]
fn cell_at([x, y]: [i32; 2]) -> usize {
    (y / STEPS) as usize * ACROSS + (x / STEPS) as usize
}

impl Serving {
    /// No candidates, for a new tile.
    pub fn begin(&mut self) {
        self.candidates.clear();
        self.flags = Flags::default();
    }

    /// Adds candidates: a run of the tile's bin, from tile number `source`.
    pub fn add(&mut self, source: u32, run: &[u64]) {
        self.candidates.extend(binned(run).map(|word| Candidate {
            word,
            source,
            cell: cell_at(word.place()) as u16,
        }));
    }

    /// Flags that any sample that serves a cell has.
    pub fn flags(&self) -> Flags {
        self.flags
    }

    /// Chooses a server for each cell of the tile. `tiles(source)` has the candidates.
    pub fn serve<'t>(&mut self, reuse: Reuse, extent: Extent, tiles: &impl Fn(u32) -> Option<&'t Tile>) {
        self.asked.clear();
        self.asked.resize(CELLS, u64::MAX);
        self.sort();
        match reuse {
            Reuse::Target => {
                self.find_edges(extent, tiles);
                self.nearest_to_targets(extent);
            }
            Reuse::Paper => self.nearest_to_eye(),
        }
    }

    /// Sorts the candidates by the cells in which they lie.
    fn sort(&mut self) {
        let Self { candidates, starts, x, y, who, .. } = self;
        starts.clear();
        starts.resize(AROUND + 1, 0);
        for candidate in &*candidates {
            starts[usize::from(candidate.cell) + 1] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += *start;
            *start = sum;
        }
        for column in [&mut *x, &mut *y] {
            column.resize(candidates.len(), 0);
        }
        who.resize(candidates.len(), 0);
        // each start moves to its end, which is the next one's start
        for (number, candidate) in (0..).zip(&*candidates) {
            let at = &mut starts[usize::from(candidate.cell)];
            [x[*at as usize], y[*at as usize]] = candidate.word.place();
            who[*at as usize] = number;
            *at += 1;
        }
        starts.rotate_right(1);
        starts[0] = 0;
    }

    /// Finds the cells at edges.
    fn find_edges<'t>(&mut self, extent: Extent, tiles: &impl Fn(u32) -> Option<&'t Tile>) {
        let Self { candidates, shown, beside, quarters, is_edge, .. } = self;
        shown.clear();
        shown.resize(AROUND, Shown::NOTHING);
        quarters.clear();
        quarters.resize(AROUND, 0);
        let mut from: (u32, Option<&Tile>) = (NOBODY, None);
        for candidate in &*candidates {
            if from.0 != candidate.source {
                from = (candidate.source, tiles(candidate.source));
            }
            let Some(tile) = from.1 else { continue };
            let sample = tile.slot(candidate.word.slot());
            let surface = match sample.model {
                BACKGROUND => u32::MAX,
                model => model.wrapping_mul(0x9e37_79b9) ^ u32::from(sample.record.material),
            };
            let [across, down] = sample.record.normal.steps();
            let values = [surface, candidate.word.depth(), across, down];
            let cell = usize::from(candidate.cell);
            shown[cell] = shown[cell].union(&Shown { least: values, most: values });
            let [right, below] = candidate.word.place().map(|at| at % STEPS >= STEPS / 2);
            quarters[cell] |= 1 << (u8::from(right) + 2 * u8::from(below));
        }
        mark_beyond(extent, quarters);
        is_edge.clear();
        is_edge.resize(AROUND, true);
        beside.clear();
        beside.resize(AROUND, Shown::NOTHING);
        let [columns, rows] = extent.cells.map(|count| count as usize);
        for row in 0..rows + 2 {
            let first = row * ACROSS;
            for cell in first + 1..=first + columns {
                beside[cell] = shown[cell - 1].union(&shown[cell]).union(&shown[cell + 1]);
            }
        }
        for row in 1..=rows {
            let first = row * ACROSS;
            for cell in first + 1..=first + columns {
                let all = beside[cell - ACROSS].union(&beside[cell]).union(&beside[cell + ACROSS]);
                is_edge[cell] = !(all.is_one_surface() & has_all_quadrants(quarters, cell));
            }
        }
    }

    /// The candidate nearest to each cell's target, if it is near enough.
    fn nearest_to_targets(&mut self, extent: Extent) {
        let [columns, rows] = extent.cells.map(|count| count as usize);
        for row in 0..rows {
            for column in 0..columns {
                let cell = cell_number([column as u32, row as u32]);
                self.asked[cell] = self.nearest_after(cell, None);
            }
        }
    }

    /// The candidate nearest to a cell's target of those that come after `after`.
    #[inline(always)]
    fn nearest_after(&self, cell: usize, after: Option<u64>) -> u64 {
        let [column, row] = place(cell).map(|at| at as usize + 1);
        let around = row * ACROSS + column;
        let target = [column, row].map(|at| at as i32 * STEPS + STEPS / 2);
        let least = after.map_or(0, |after| after + 1);
        let mut best = u64::MAX;
        for first in [around - ACROSS, around, around + ACROSS] {
            let range = self.starts[first - 1] as usize..self.starts[first + 2] as usize;
            let places = self.x[range.clone()].iter().zip(&self.y[range.clone()]);
            for (at, (x, y)) in range.zip(places) {
                let aside = [x - target[0], y - target[1]];
                let far = aside[0] * aside[0] + aside[1] * aside[1];
                let rank = (far as u64) << u32::BITS | at as u64;
                best = if rank >= least { best.min(rank) } else { best };
            }
        }
        if best >> u32::BITS <= (RADIUS * RADIUS) as u64 { best } else { u64::MAX }
    }

    /// Whether more than one candidate is near enough to the target of a cell.
    #[inline(always)]
    fn is_contested(&self, cell: usize) -> bool {
        let [column, row] = place(cell).map(|at| at as usize + 1);
        let around = row * ACROSS + column;
        let target = [column, row].map(|at| at as i32 * STEPS + STEPS / 2);
        let mut near = 0;
        for first in [around - ACROSS, around, around + ACROSS] {
            let range = self.starts[first - 1] as usize..self.starts[first + 2] as usize;
            for (x, y) in self.x[range.clone()].iter().zip(&self.y[range]) {
                let aside = [x - target[0], y - target[1]];
                near += i32::from(aside[0] * aside[0] + aside[1] * aside[1] <= RADIUS * RADIUS);
            }
        }
        near > 1
    }

    /// The paper's rule: of the candidates in each cell the one nearest to the eye.
    fn nearest_to_eye(&mut self) {
        for cell in 0..CELLS {
            let [column, row] = place(cell).map(|at| at as usize + 1);
            let around = row * ACROSS + column;
            let range = self.starts[around]..self.starts[around + 1];
            let ranks = range.map(|at| {
                let candidate = &self.candidates[self.who[at as usize] as usize];
                u64::from(candidate.word.depth()) << u32::BITS | u64::from(at)
            });
            self.asked[cell] = ranks.min().unwrap_or(u64::MAX);
        }
    }

    /// The candidate that serves `cell`, if any does.
    #[inline(always)]
    fn server(&self, cell: usize) -> Option<u32> {
        let asked = self.asked[cell];
        (asked < STAYS).then(|| self.who[asked as u32 as usize])
    }

    /// The status of a cell that is served.
    fn status(&self, reuse: Reuse, cell: usize) -> Status {
        let is_contested = match reuse {
            Reuse::Target => self.is_contested(cell),
            Reuse::Paper => {
                let [column, row] = place(cell).map(|at| at as usize + 1);
                let around = row * ACROSS + column;
                self.starts[around + 1] - self.starts[around] > 1
            }
        };
        if is_contested { Status::Overlapped } else { Status::Good }
    }

    /// Fills `tile` with copies of the servers, and keeps as spare samples those that lie in it and serve nobody.
    /// `spared(sample)` says what a sample is to be flagged with that serves nobody.
    pub fn fill<'t>(
        &mut self,
        reuse: Reuse,
        extent: Extent,
        tile: &mut Tile,
        tiles: &impl Fn(u32) -> Option<&'t Tile>,
    ) {
        tile.spares.clear();
        self.kept.clear();
        self.kept.resize(AROUND, 0);
        self.serves.clear();
        self.serves.resize(self.candidates.len(), u16::MAX);
        for cell in 0..CELLS {
            let Some(number) = self.server(cell) else {
                tile.clear(cell, Status::Missed);
                continue;
            };
            tile.status[cell] = self.status(reuse, cell);
            let serves = &mut self.serves[number as usize];
            if *serves == u16::MAX {
                *serves = cell as u16;
                self.kept[usize::from(self.candidates[number as usize].cell)] += 1;
            } else {
                // it has a cell already: that one keeps it
                let candidate = self.candidates[number as usize];
                if let Some(from) = tiles(candidate.source) {
                    tile.copy_slot(cell, from, candidate.word.slot());
                    tile.set_copy(cell, true);
                    self.flags = self.flags.with(tile.record[cell].flags);
                }
            }
        }
        let mut from: (u32, Option<&Tile>) = (NOBODY, None);
        for (candidate, serves) in self.candidates.iter().zip(&self.serves) {
            if from.0 != candidate.source {
                from = (candidate.source, tiles(candidate.source));
            }
            let Some(source) = from.1 else { continue };
            let (slot, lies_in) = (candidate.word.slot(), usize::from(candidate.cell));
            let is_own = is_within(extent, lies_in);
            if *serves != u16::MAX {
                let cell = usize::from(*serves);
                tile.copy_slot(cell, source, slot);
                tile.set_copy(cell, !is_own);
                self.flags = self.flags.with(tile.record[cell].flags);
            } else if is_own && reuse == Reuse::Target && tile.spares.len() < MOST_SPARES {
                let kept = &mut self.kept[lies_in];
                if *kept < KEPT {
                    *kept += 1;
                    tile.spares.push(source, slot);
                }
            }
        }
    }

    /// Makes `tile` the tile `before` again, and fills those of its cells that have no sample with their servers. Which of
    /// the candidates come from elsewhere says `tiles`.
    pub fn merge<'t>(
        &mut self,
        reuse: Reuse,
        before: &Tile,
        tile: &mut Tile,
        tiles: &impl Fn(u32) -> Option<&'t Tile>,
    ) {
        tile.clone_from(before);
        self.serves.clear();
        self.serves.resize(self.candidates.len(), u16::MAX);
        for cell in 0..CELLS {
            if tile.model[cell] != EMPTY {
                // it stays; should it be hidden, all are asked
                self.asked[cell] = STAYS;
                continue;
            }
            let Some(number) = self.server(cell) else { continue };
            let candidate = self.candidates[number as usize];
            let Some(from) = tiles(candidate.source) else { continue };
            tile.copy_slot(cell, from, candidate.word.slot());
            let is_own = std::mem::replace(&mut self.serves[number as usize], cell as u16) == u16::MAX;
            tile.set_copy(cell, !is_own);
            tile.status[cell] = self.status(reuse, cell);
        }
    }

    /// Cells at edges that are served: their targets are to be probed. A bit each.
    pub fn probes(&self, extent: Extent, tile: &Tile) -> [u16; CELLS / 16] {
        let mut probes = [0; CELLS / 16];
        let [columns, rows] = extent.cells.map(|count| count as usize);
        for row in 0..rows {
            for column in 0..columns {
                let at = [column as u32, row as u32];
                let cell = cell_number(at);
                if self.is_edge[(row + 1) * ACROSS + column + 1] && tile.status[cell].is_reused() {
                    probes[cell / 16] |= 1 << (cell % 16);
                }
            }
        }
        probes
    }

    /// For those cells of `tile` that are hidden the next candidate in turn, if there is one near enough: it is to be
    /// verified. Which cells have one, a bit each for each block of 16.
    pub fn ask_next<'t>(
        &mut self,
        reuse: Reuse,
        tile: &mut Tile,
        tiles: &impl Fn(u32) -> Option<&'t Tile>,
    ) -> Option<[u16; CELLS / 16]> {
        if self.candidates.is_empty() {
            return None;
        }
        let mut next = [0; CELLS / 16];
        for cell in 0..CELLS {
            if tile.status[cell] != Status::Obscured || self.asked[cell] == u64::MAX {
                continue;
            }
            self.asked[cell] = match reuse {
                Reuse::Target => {
                    let after = Some(self.asked[cell]).filter(|asked| *asked != STAYS);
                    self.nearest_after(cell, after)
                }
                Reuse::Paper => u64::MAX,
            };
            let Some(number) = self.server(cell) else { continue };
            let candidate = self.candidates[number as usize];
            let Some(from) = tiles(candidate.source) else { continue };
            tile.copy_slot(cell, from, candidate.word.slot());
            // whoever keeps it, it is not this cell
            tile.set_copy(cell, true);
            self.flags = self.flags.with(tile.record[cell].flags);
            tile.status[cell] = Status::Overlapped;
            next[cell / 16] |= 1 << (cell % 16);
        }
        (next != [0; CELLS / 16]).then_some(next)
    }
}

/// Whether a cell in or around a tile is in it.
#[inline(always)]
fn is_within(extent: Extent, around: usize) -> bool {
    let within = |at: usize, count: u32| at >= 1 && at <= count as usize;
    within(around % ACROSS, extent.cells[0]) && within(around / ACROSS, extent.cells[1])
}

/// Nothing is missing beyond the rim of the picture.
fn mark_beyond(extent: Extent, quarters: &mut [u8]) {
    const ALL: u8 = 15;
    let [columns, rows] = extent.cells.map(|count| count as usize + 1);
    let [left, top, right, bottom] = extent.goes_on;
    for at in 0..ACROSS {
        let column = |x: usize| at * ACROSS + x;
        let row = |y: usize| y * ACROSS + at;
        for (cell, goes_on) in
            [(column(0), left), (column(columns), right), (row(0), top), (row(rows), bottom)]
        {
            if !goes_on {
                quarters[cell] = ALL;
            }
        }
    }
}

/// Whether each of the four quadrants around the target of a cell has a sample, within a cell and a half.
#[inline(always)]
fn has_all_quadrants(quarters: &[u8], cell: usize) -> bool {
    // quarters: 1 left above, 2 right above, 4 left below, 8 right below
    let at = |offset: isize| quarters[(cell as isize + offset) as usize];
    const DOWN: isize = ACROSS as isize;
    let (own, left, right, above, below) = (at(0), at(-1), at(1), at(-DOWN), at(DOWN));
    let left_above = own & 1 | left & 3 | above & 5 | at(-DOWN - 1);
    let right_above = own & 2 | right & 3 | above & 10 | at(-DOWN + 1);
    let left_below = own & 4 | left & 12 | below & 5 | at(DOWN - 1);
    let right_below = own & 8 | right & 12 | below & 10 | at(DOWN + 1);
    (left_above != 0) & (right_above != 0) & (left_below != 0) & (right_below != 0)
}
