//! Serving: the choice of the stored sample that each cell shows.
//!
//! Each cell has a target, its centre. It is *served* by the nearest stored sample that holds, in whatever
//! cell that sample lies, if it is within [`REACH`](super::candidates::REACH). One sample may serve two
//! cells; samples that serve none are kept as spare samples, up to [`KEPT`] in a cell.
//!
//! The nearest sample need not show the surface at the target: so each target is [asked](super::trace_missed) what it sees, and of the
//! samples near enough the nearest one that [shows it](super::target) serves. If there is none, what the target sees is traced.
//!
//! The paper's own rule, for comparison, is [`nearest_to_eye`](Candidates::nearest_to_eye): among the samples
//! in a cell the one nearest to the eye serves it, and the others are dropped. It asks no target. Samples drift against the
//! grid; two share a cell while the cell beside it is empty, and a fifth of all valid samples are lost that
//! way every frame.

use super::bins::{Binned, STEPS};
use super::candidates::{Candidate, Candidates, Rank, Server, Sources};
use crate::frame::grid::around::{AROUND, ROW};
use crate::frame::grid::bits::set_bits;
use crate::frame::grid::cell_number;
use crate::frame::grid::cells::CellSet;
use crate::lanes::LANES;
use crate::samples::{CELLS, EMPTY, Flags, MOST_SPARES, Move, Sample, Status, Tile};
use crate::settings::Reuse;

/// Largest number of samples in a cell that are kept, unless they serve: enough for those that share a cell
/// by chance while the cell beside it is empty. With three a frame traces a tenth less, and spare samples
/// take half as much again.
pub const KEPT: u8 = 2;

/// Like [`KEPT`], where not all cells are wanted: most cells that are not wanted hold a sample from when they
/// were, and those that are projected and never serve cost more than the others save.
pub const KEPT_OF_SOME: u8 = 1;

/// Scratch memory of a worker for serving the cells of one tile. Keeps its memory from tile to tile.
#[derive(Debug, Default)]
pub struct Serving {
    candidates: Candidates,
    /// Candidates that are [lent](super::beside).
    lent: Candidates,
    /// Bit mask of those of them that serve a cell.
    lending: Vec<u64>,
    /// Server of each cell, or the candidate that was tried last.
    servers: Vec<Server>,
    /// Bit mask of the candidates that serve a cell.
    serving: Vec<u64>,
    /// Number of kept samples in each cell in and around the tile.
    kept: Vec<u8>,
    moves: Vec<Move>,
    /// Candidates that would serve unwanted cells by the paper's rule.
    unused: Vec<usize>,
    /// Flags that any serving sample has.
    flags: Flags,
}

impl Serving {
    /// Removes all candidates, for a new tile.
    pub fn begin(&mut self) {
        self.candidates.clear();
        self.lent.clear();
        self.flags = Flags::default();
    }

    /// Adds candidates: a run of the tile's bin, from tile number `source`. `tile` is that tile if its
    /// samples have to be prefetched.
    pub fn add(&mut self, source: u32, run: &[u64], tile: Option<&Tile>) {
        self.candidates.add(source, run, tile);
    }

    /// Flags that any sample that serves a cell has.
    pub fn flags(&self) -> Flags {
        self.flags
    }

    /// Chooses a server for each `wanted` cell of the tile, of which `extent` is in the picture.
    /// `tile` is the one to be filled.
    pub fn serve(&mut self, reuse: Reuse, (extent, wanted): ([u32; 2], &CellSet), tile: &Tile) {
        let Self { candidates, servers, unused, .. } = self;
        servers.clear();
        servers.resize(CELLS, Server::NOBODY);
        unused.clear();
        if candidates.len() == 0 || reuse == Reuse::Target && wanted.is_empty() {
            return;
        }
        match reuse {
            Reuse::Target => nearest_to_targets(candidates, extent, servers, tile),
            Reuse::Paper => {
                candidates.sort();
                for cell in cells(extent) {
                    servers[cell] = candidates.nearest_to_eye(cell);
                }
            }
        }
        if *wanted != CellSet::ALL {
            for cell in CellSet::ALL.without(wanted).numbers() {
                let server = std::mem::replace(&mut servers[cell], Server::NOBODY);
                unused.extend(server.rank().filter(|_| reuse == Reuse::Paper).map(Rank::number));
            }
        }
    }

    /// Fills `tile` with copies of the servers, and keeps as spare samples those that lie in it and serve
    /// nobody, up to `most_kept` in a cell, servers included.
    pub fn fill<'t>(
        &mut self,
        reuse: Reuse,
        extent: [u32; 2],
        most_kept: u8,
        tile: &mut Tile,
        sources: &impl Sources<'t>,
    ) {
        let from: Vec<&Tile> = self.candidates.runs().filter_map(|(source, _)| sources(source)).collect();
        self.assign(extent, tile);
        let Self { candidates, serving, kept, moves, flags, unused, .. } = self;
        *flags = tile.copy_all(&from, moves);
        tile.spares.clear();
        if reuse == Reuse::Paper {
            for number in &*unused {
                let Candidate { word, run, .. } = candidates.get(*number);
                tile.spares.push(from[usize::from(run)], word.slot());
            }
            return;
        }
        for number in unset(serving, candidates.len()) {
            let Candidate { word, cell, run } = candidates.get(number);
            let kept = &mut kept[usize::from(cell)];
            if is_within(extent, word) && *kept < most_kept && tile.spares.len() < MOST_SPARES {
                *kept += 1;
                tile.spares.push(from[usize::from(run)], word.slot());
            }
        }
    }

    /// Gives each cell its status, and lists the samples to copy.
    fn assign(&mut self, extent: [u32; 2], tile: &mut Tile) {
        let Self { candidates, servers, serving, kept, moves, .. } = self;
        kept.clear();
        kept.resize(AROUND, 0);
        serving.clear();
        serving.resize(candidates.len().div_ceil(WORD), 0);
        moves.clear();
        for (first, servers) in (0..CELLS).step_by(LANES).zip(servers.chunks_exact(LANES)) {
            let mut copies = 0;
            for (lane, server) in servers.iter().enumerate() {
                let cell = first + lane;
                let Some(rank) = server.rank() else {
                    tile.clear(cell, Status::Missed);
                    continue;
                };
                let number = rank.number();
                let Candidate { word, cell: lies_in, run } = candidates.get(number);
                let is_first = set(serving, number);
                kept[usize::from(lies_in)] += u8::from(is_first);
                // a sample that has a cell already is kept there, and one beyond the tile is kept by another
                // tile
                copies |= u8::from(!(is_first & is_within(extent, word))) << lane;
                tile.status[cell] = server.status();
                moves.push(Move { to: cell as u16, source: run, from: word.slot() as u16 });
            }
            tile.copies[first / LANES] = copies;
        }
    }

    /// Makes `tile` the tile `before` again, and fills those of its cells that have no sample with their
    /// servers.
    pub fn merge<'t>(&mut self, before: &Tile, tile: &mut Tile, sources: &impl Sources<'t>) {
        tile.clone_from(before);
        let Self { candidates, servers, serving, flags, .. } = self;
        serving.clear();
        serving.resize(candidates.len().div_ceil(WORD), 0);
        for (cell, server) in servers.iter_mut().enumerate() {
            if tile.model[cell] != EMPTY {
                *server = Server::OWN;
                continue;
            }
            let Some(rank) = server.rank() else { continue };
            let number = rank.number();
            let Some(from) = sources(candidates.source(number)) else { continue };
            *flags = flags.with(tile.copy_slot(cell, from, candidates.get(number).word.slot()));
            tile.set_copy(cell, !set(serving, number));
            tile.status[cell] = server.status();
        }
    }

    /// Adds candidates that are [lent](super::beside): runs of the tile's bin of those.
    pub fn add_lent(&mut self, runs: &[(u32, &[u64])]) {
        runs.iter().for_each(|(source, run)| self.lent.add(*source, run, None));
        self.lending.clear();
        self.lending.resize(self.lent.len().div_ceil(WORD), 0);
    }

    /// Fills open cells of `tile`, of which `extent` is in the picture, with the nearest samples that are lent, by tiles of `lenders`.
    pub fn fill_open<'t>(&mut self, extent: [u32; 2], tile: &mut Tile, lenders: &impl Sources<'t>) {
        if self.lent.len() == 0 || !tile.status.contains(&Status::Missed) {
            return;
        }
        let [columns, rows] = extent;
        let eights = (0..rows).flat_map(|row| (0..columns).step_by(LANES).map(move |first| [first, row]));
        for [first, row] in eights {
            let cells = (first..columns).take(LANES).map(|column| cell_number([column, row]));
            let is_open = |tile: &Tile, cell: usize| tile.status[cell] == Status::Missed;
            if !cells.clone().any(|cell| is_open(tile, cell)) {
                continue;
            }
            // where cells are crowded, one near by does as well as the nearest
            let nearest = self.lent.nearest_to_eight(row as usize, first as usize);
            for (cell, server) in cells.zip(nearest) {
                let number = server.rank().map(Rank::number).filter(|_| is_open(tile, cell));
                let lender = number.and_then(|number| Some((number, lenders(self.lent.source(number))?)));
                if let Some((number, from)) = lender {
                    self.lend(cell, tile, (number, from));
                }
            }
        }
    }

    /// Gives a cell a copy of lent candidate number `number`, of the tile `from`: the first one is kept for later frames.
    fn lend(&mut self, cell: usize, tile: &mut Tile, (number, from): (usize, &Tile)) {
        let Self { lent, lending, flags, .. } = self;
        *flags = flags.with(give(tile, cell, from, lent.get(number).word.slot()));
        let record = &mut tile.record[cell];
        record.traced = record.traced.shared();
        tile.set_copy(cell, !set(lending, number));
    }

    /// Replaces hidden samples of `tile` by the next candidates in turn, where one is near enough: they have
    /// to be verified. Returns the cells that have one; `None` if no cell has.
    pub fn ask_next<'t>(
        &mut self,
        reuse: Reuse,
        tile: &mut Tile,
        sources: &impl Sources<'t>,
    ) -> Option<CellSet> {
        let Self { candidates, servers, flags, .. } = self;
        if candidates.len() == 0 || reuse == Reuse::Paper || !tile.status.contains(&Status::Obscured) {
            return None;
        }
        let mut next = CellSet::default();
        candidates.sort();
        for (cell, server) in servers.iter_mut().enumerate() {
            if tile.status[cell] != Status::Obscured || *server == Server::NOBODY {
                continue;
            }
            *server = candidates.nearest(cell, server.rank());
            let Some(rank) = server.rank() else { continue };
            let number = rank.number();
            let Some(from) = sources(candidates.source(number)) else { continue };
            *flags = flags.with(give(tile, cell, from, candidates.get(number).word.slot()));
            next.insert(cell);
        }
        (!next.is_empty()).then_some(next)
    }

    /// Replaces the sample of `cell` by the nearest candidate that `shows` what the cell's target sees, or else by the nearest such one that
    /// is lent, if there is any: it has to be verified. Returns true if there is.
    pub fn replace<'t>(
        &mut self,
        cell: usize,
        tile: &mut Tile,
        moved: impl Fn(u32) -> bool,
        (sources, lenders): (&impl Sources<'t>, &impl Sources<'t>),
        shows: impl Fn(&Sample) -> bool,
    ) -> bool {
        if let Some((server, number, from)) = nearest_that(&mut self.candidates, cell, sources, &shows) {
            tile.make_spare(cell, moved(tile.model[cell]));
            let slot = self.candidates.get(number).word.slot();
            self.flags = self.flags.with(give(tile, cell, from, slot));
            self.servers[cell] = server;
            return true;
        }
        let lender = nearest_that(&mut self.lent, cell, lenders, &shows);
        if let Some((_, number, from)) = lender {
            tile.make_spare(cell, moved(tile.model[cell]));
            self.lend(cell, tile, (number, from));
        }
        lender.is_some()
    }

    /// Cells of the tile that have been given another sample in this frame.
    pub fn given(&self, tile: &Tile) -> CellSet {
        if self.candidates.len() + self.lent.len() == 0 {
            return CellSet::default();
        }
        CellSet::new(|cell| self.servers[cell] != Server::OWN && tile.status[cell].is_reused())
    }
}

/// The candidate nearest to the target of a cell that `shows` what this sees, with its number and its tile.
fn nearest_that<'t>(
    candidates: &mut Candidates,
    cell: usize,
    sources: &impl Sources<'t>,
    shows: &impl Fn(&Sample) -> bool,
) -> Option<(Server, usize, &'t Tile)> {
    if candidates.len() == 0 {
        return None;
    }
    candidates.sort();
    let mut last = None;
    loop {
        let server = candidates.nearest(cell, last);
        let rank = server.rank()?;
        last = Some(rank);
        let slot = candidates.get(rank.number()).word.slot();
        let from = sources(candidates.source(rank.number())).filter(|from| shows(&from.sample(slot)));
        if let Some(from) = from {
            return Some((server, rank.number(), from));
        }
    }
}

/// Gives a cell the sample in a slot of `from`, which has to be verified. Returns the sample's flags.
fn give(tile: &mut Tile, cell: usize, from: &Tile, slot: usize) -> Flags {
    let flags = tile.copy_slot(cell, from, slot);
    // it was not looked at which of its proofs still hold
    tile.record[cell].flags = flags.with_proof(None);
    // another cell or tile keeps the sample, if any does
    tile.set_copy(cell, true);
    tile.status[cell] = Status::Overlapped;
    flags
}

/// Finds the candidate nearest to each cell's target. Meanwhile prefetches `tile`, to which they are copied.
fn nearest_to_targets(candidates: &mut Candidates, extent: [u32; 2], servers: &mut [Server], tile: &Tile) {
    let [columns, rows] = extent;
    for row in 0..rows {
        for first in (0..columns).step_by(LANES) {
            tile.prefetch_eight(cell_number([first, row]));
            let nearest = candidates.nearest_to_eight(row as usize, first as usize);
            for (column, server) in (first..columns).zip(nearest) {
                servers[cell_number([column, row])] = server;
            }
        }
    }
    if candidates.crowded().is_empty() {
        return;
    }
    // crowded cells are few: each cell beside one searches all candidates there
    candidates.sort();
    for crowded in candidates.crowded() {
        let [column, row] = [usize::from(*crowded) % ROW, usize::from(*crowded) / ROW];
        let beside = |at: usize, count: u32| at.saturating_sub(2)..(at + 1).min(count as usize);
        for row in beside(row, rows) {
            for column in beside(column, columns) {
                let cell = cell_number([column as u32, row as u32]);
                servers[cell] = candidates.nearest(cell, None);
            }
        }
    }
}

/// Number of bits of a word.
const WORD: usize = u64::BITS as usize;

/// Sets a bit. Returns true if it was not set.
#[inline(always)]
fn set(bits: &mut [u64], number: usize) -> bool {
    let (word, bit) = (&mut bits[number / WORD], 1 << (number % WORD));
    let was_unset = *word & bit == 0;
    *word |= bit;
    was_unset
}

/// Numbers below `count` whose bits are not set.
fn unset(bits: &[u64], count: usize) -> impl Iterator<Item = usize> {
    let words = bits.iter().zip((0..).step_by(WORD));
    words
        .flat_map(|(word, first)| set_bits(!*word).map(move |bit| first + bit))
        .take_while(move |number| *number < count)
}

/// Cells of a tile that are in the picture.
fn cells(extent: [u32; 2]) -> impl Iterator<Item = usize> {
    let [columns, rows] = extent;
    (0..rows).flat_map(move |row| (0..columns).map(move |column| cell_number([column, row])))
}

/// Returns true if a candidate lies in the tile, and in the picture.
#[inline(always)]
fn is_within(extent: [u32; 2], word: Binned) -> bool {
    let [x, y] = word.place().map(|at| (at - STEPS) as u32);
    let [columns, rows] = extent.map(|count| count * STEPS as u32);
    (x < columns) & (y < rows)
}
