//! Serving: which kept sample each cell shows.
//!
//! Each cell has a target, its centre. It is *served* by the nearest kept sample that holds, in whatever cell that
//! sample lies, if it is within [`REACH`](super::candidates::REACH). One sample may serve two cells; those that serve
//! none are kept as spare samples, up to [`KEPT`] in a cell.
//!
//! At an [edge](super::edges) the nearest sample need not show what the target shows: silhouettes would lag behind, or
//! grow. An edge is where the samples in the cell and the eight around it show different surfaces, or where one of the
//! four quadrants around the target has none: there something new may have come into sight. There the target itself is
//! *probed*, by a ray from the eye ([`trace_missed`](super::trace_missed)): the server stays if the ray meets the
//! surface that it shows, and otherwise what the ray met takes its place. So each surface has the cells whose targets it
//! covers, as in a frame that is traced in full, however long a chain of inferred frames is and however densely the
//! surface happens to be sampled.
//!
//! The paper's own rule, for comparison, is [`nearest_to_eye`]: of the samples in a cell the one nearest to the eye
//! serves it, and the others go. Samples drift against the grid; two share a cell while the cell beside it is empty,
//! and a fifth of all true samples are lost that way every frame.

use super::candidates::{ACROSS, AROUND, Candidates, Rank, Sources, around};
use super::cells::CellSet;
use super::edges::Edges;
use super::grid::{Extent, cell_number};
use crate::samples::{CELLS, EMPTY, Flags, MOST_SPARES, Move, Status, Tile};
use crate::settings::Reuse;

/// Samples that are kept of those that lie in a cell, unless they serve: enough for those that share a cell by chance
/// while the cell beside it is empty. With three a frame traces a tenth less, and spare samples take half as much again.
pub const KEPT: u8 = 2;

/// What a worker needs to serve the cells of one tile. Keeps its memory from tile to tile.
#[derive(Debug, Default)]
pub struct Serving {
    candidates: Candidates,
    edges: Edges,
    /// For each cell who serves it, or was asked last.
    asked: Vec<Asked>,
    /// For each candidate, the cell that it serves.
    serves: Vec<u16>,
    /// Cells that are served by a candidate which has one already.
    again: Vec<(u16, u16)>,
    /// For each cell in and around the tile, how many of the samples in it are kept.
    kept: Vec<u8>,
    moves: Vec<Move>,
    /// Flags that any sample that serves has.
    flags: Flags,
}

/// Who serves a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Asked {
    /// Nobody is near enough.
    Nobody,
    /// Its own sample, which stays.
    Own,
    /// This candidate, and whether others are near enough, too.
    One(Rank, bool),
}

/// In place of a cell: none.
const NOWHERE: u16 = u16::MAX;

impl Serving {
    /// No candidates, for a new tile.
    pub fn begin(&mut self) {
        self.candidates.clear();
        self.flags = Flags::default();
    }

    /// Adds candidates: a run of the tile's bin, from tile number `source`.
    pub fn add(&mut self, source: u32, run: &[u64]) {
        self.candidates.add(source, run);
    }

    /// Flags that any sample that serves a cell has.
    pub fn flags(&self) -> Flags {
        self.flags
    }

    /// Chooses a server for each cell of the tile. Candidates are in the tiles that `sources` has.
    pub fn serve<'t>(&mut self, reuse: Reuse, extent: Extent, sources: &impl Sources<'t>) {
        let Self { candidates, edges, asked, .. } = self;
        asked.clear();
        asked.resize(CELLS, Asked::Nobody);
        match reuse {
            Reuse::Target => {
                edges.find(candidates, extent, sources);
                nearest_to_targets(candidates, extent, asked);
            }
            Reuse::Paper => {
                candidates.sort();
                for cell in cells(extent) {
                    asked[cell] = nearest_to_eye(candidates, cell);
                }
            }
        }
    }

    /// Fills `tile` with copies of the servers, and keeps as spare samples those that lie in it and serve nobody.
    pub fn fill<'t>(&mut self, reuse: Reuse, extent: Extent, tile: &mut Tile, sources: &impl Sources<'t>) {
        self.assign(tile);
        let Self { candidates, serves, again, kept, moves, flags, .. } = self;
        tile.spares.clear();
        for (source, numbers) in candidates.runs() {
            let Some(from) = sources(source) else { continue };
            moves.clear();
            for number in numbers {
                let (word, lies_in) = candidates.get(number);
                let is_own = is_within(extent, lies_in);
                let cell = serves[number];
                if cell != NOWHERE {
                    tile.set_copy(usize::from(cell), !is_own);
                    moves.push(Move { to: cell, from: word.slot() as u16 });
                } else if is_own && reuse == Reuse::Target && tile.spares.len() < MOST_SPARES {
                    let kept = &mut kept[lies_in];
                    if *kept < KEPT {
                        *kept += 1;
                        tile.spares.push(from, word.slot());
                    }
                }
            }
            *flags = flags.with(tile.copy_slots(from, moves));
        }
        // a sample that has a cell already is kept there
        for (cell, number) in &*again {
            let (cell, number) = (usize::from(*cell), usize::from(*number));
            let Some(from) = sources(candidates.source(number)) else { continue };
            *flags = flags.with(tile.copy_slot(cell, from, candidates.get(number).0.slot()));
            tile.set_copy(cell, true);
        }
    }

    /// Gives each candidate the first of the cells that it serves, and each cell its status.
    fn assign(&mut self, tile: &mut Tile) {
        let Self { candidates, asked, serves, again, kept, .. } = self;
        kept.clear();
        kept.resize(AROUND, 0);
        again.clear();
        serves.clear();
        serves.resize(candidates.len(), NOWHERE);
        for (cell, asked) in asked.iter().enumerate() {
            let Asked::One(rank, is_contested) = asked else {
                tile.clear(cell, Status::Missed);
                continue;
            };
            tile.status[cell] = if *is_contested { Status::Overlapped } else { Status::Good };
            let number = rank.number();
            if serves[number] == NOWHERE {
                serves[number] = cell as u16;
                kept[candidates.get(number).1] += 1;
            } else {
                again.push((cell as u16, number as u16));
            }
        }
    }

    /// Makes `tile` the tile `before` again, and fills those of its cells that have no sample with their servers.
    pub fn merge<'t>(&mut self, before: &Tile, tile: &mut Tile, sources: &impl Sources<'t>) {
        tile.clone_from(before);
        let Self { candidates, asked, serves, flags, .. } = self;
        serves.clear();
        serves.resize(candidates.len(), NOWHERE);
        for (cell, asked) in asked.iter_mut().enumerate() {
            if tile.model[cell] != EMPTY {
                *asked = Asked::Own;
                continue;
            }
            let Asked::One(rank, is_contested) = *asked else { continue };
            let number = rank.number();
            let Some(from) = sources(candidates.source(number)) else { continue };
            *flags = flags.with(tile.copy_slot(cell, from, candidates.get(number).0.slot()));
            let is_first = std::mem::replace(&mut serves[number], cell as u16) == NOWHERE;
            tile.set_copy(cell, !is_first);
            tile.status[cell] = if is_contested { Status::Overlapped } else { Status::Good };
        }
    }

    /// For those cells of `tile` that are hidden the next candidate in turn, if there is one near enough: it is to be
    /// verified. Which cells have one; `None` if no cell has.
    pub fn ask_next<'t>(
        &mut self,
        reuse: Reuse,
        tile: &mut Tile,
        sources: &impl Sources<'t>,
    ) -> Option<CellSet> {
        let Self { candidates, asked, flags, .. } = self;
        if candidates.len() == 0 || reuse == Reuse::Paper {
            return None;
        }
        let mut next = CellSet::default();
        if tile.status.contains(&Status::Obscured) {
            candidates.sort();
        }
        for (cell, asked) in asked.iter_mut().enumerate() {
            if tile.status[cell] != Status::Obscured {
                continue;
            }
            let after = match asked {
                Asked::Nobody => continue,
                Asked::Own => None,
                Asked::One(rank, _) => Some(*rank),
            };
            *asked = Asked::of(candidates.nearest(cell, after));
            let Asked::One(rank, _) = asked else { continue };
            let number = rank.number();
            let Some(from) = sources(candidates.source(number)) else { continue };
            *flags = flags.with(tile.copy_slot(cell, from, candidates.get(number).0.slot()));
            // whoever keeps it, it is not this cell
            tile.set_copy(cell, true);
            tile.status[cell] = Status::Overlapped;
            next.insert(cell);
        }
        (!next.is_empty()).then_some(next)
    }

    /// Cells at edges that are served: their targets are to be probed.
    pub fn probes(&self, extent: Extent, tile: &Tile) -> CellSet {
        let mut probes = CellSet::default();
        if self.candidates.len() == 0 {
            return probes;
        }
        for cell in cells(extent) {
            if self.edges.has(around(cell)) && tile.status[cell].is_reused() {
                probes.insert(cell);
            }
        }
        probes
    }
}

impl Asked {
    fn of((rank, is_contested): (Rank, bool)) -> Self {
        if rank == Rank::NONE { Self::Nobody } else { Self::One(rank, is_contested) }
    }
}

/// The candidate nearest to each cell's target.
fn nearest_to_targets(candidates: &mut Candidates, extent: Extent, asked: &mut [Asked]) {
    candidates.pair();
    let [columns, rows] = extent.cells;
    for row in 0..rows {
        candidates.nearest_in_row(row as usize, columns as usize, |column, rank, is_contested| {
            asked[cell_number([column as u32, row])] = Asked::of((rank, is_contested));
        });
    }
    if candidates.crowded().is_empty() {
        return;
    }
    // few: each cell beside a crowded one looks at all that are there
    candidates.sort();
    for crowded in candidates.crowded() {
        let [column, row] = [usize::from(*crowded) % ACROSS, usize::from(*crowded) / ACROSS];
        let beside = |at: usize, count: u32| at.saturating_sub(2)..(at + 1).min(count as usize);
        for row in beside(row, rows) {
            for column in beside(column, columns) {
                let cell = cell_number([column as u32, row as u32]);
                asked[cell] = Asked::of(candidates.nearest(cell, None));
            }
        }
    }
}

/// The paper's rule: of the candidates in a cell the one nearest to the eye.
fn nearest_to_eye(candidates: &Candidates, cell: usize) -> Asked {
    let (rank, count) = candidates.nearest_to_eye(around(cell));
    Asked::of((rank, count > 1))
}

/// The cells of a tile that are in the picture.
fn cells(extent: Extent) -> impl Iterator<Item = usize> {
    let [columns, rows] = extent.cells;
    (0..rows).flat_map(move |row| (0..columns).map(move |column| cell_number([column, row])))
}

/// Whether a cell in or around a tile is in it.
#[inline(always)]
fn is_within(extent: Extent, around: usize) -> bool {
    let within = |at: usize, count: u32| at >= 1 && at <= count as usize;
    within(around % ACROSS, extent.cells[0]) && within(around / ACROSS, extent.cells[1])
}
