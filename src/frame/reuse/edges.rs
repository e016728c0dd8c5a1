//! Edges: cells in which the nearest sample need not show the surface at the cell's target.

use wide::{u16x8, u16x16, u64x4};

use super::candidates::{Candidate, Candidates, Sources};
use crate::frame::grid::around::{ACROSS, AROUND, ROW};
use crate::frame::grid::cells::CellSet;
use crate::frame::grid::view::DEPTH_STEP;
use crate::frame::grid::{Extent, cell_number};
use crate::samples::{BACKGROUND, TILE};

/// Edges in a tile. Keeps its memory.
#[derive(Debug, Default)]
pub struct Edges {
    /// Surfaces and depths of the candidates in each cell in and around the tile.
    shown: Vec<SurfaceKey>,
    /// Bit masks of the quarters of each cell in and around the tile that have a candidate: 1 left above, 2
    /// right above, 4 left below, 8 right below.
    quarters: Vec<u8>,
    /// Cells of the tile that are at an edge.
    pub cells: CellSet,
}

/// Range of surfaces and depths of some candidates, four values of 16 bits: the least surface and the least
/// depth, and the complements of the greatest. Two ranges are joined by the least of each value.
type SurfaceKey = u64;

/// Bit mask of all quarters of a cell.
const ALL_QUARTERS: u8 = 15;

/// Range of no candidates.
const NOTHING: SurfaceKey = u64::MAX;

#[inline(always)]
fn shown(surface: u16, depth: u16) -> SurfaceKey {
    let least = u64::from(depth) << 16 | u64::from(surface);
    !least << 32 | least
}

#[inline(always)]
fn join(a: SurfaceKey, b: SurfaceKey) -> SurfaceKey {
    let [a, b]: [u16x8; 2] = [[a, 0], [b, 0]].map(bytemuck::cast);
    let [least, _]: [SurfaceKey; 2] = bytemuck::cast(a.min(b));
    least
}

/// Returns true for each cell of the tile, in the middle one of three rows, around which all candidates may
/// show one surface.
#[inline(always)]
fn one_surface(rows: [&[SurfaceKey]; 3]) -> [bool; TILE] {
    // largest difference of greatest and least; the first two of four values are compared
    const MOST: [u16; 4] = [0, DEPTH_STEPS - 1, u16::MAX, u16::MAX];
    let most: u16x16 = bytemuck::cast([MOST; 4]);
    let mut is_one = [true; TILE];
    for (first, is_one) in (0..).step_by(4).zip(is_one.chunks_exact_mut(4)) {
        let mut joined = u16x16::splat(u16::MAX);
        for row in rows {
            for left in first..first + 3 {
                let four: [SurfaceKey; 4] = std::array::from_fn(|cell| row[left + cell]);
                joined = joined.min(bytemuck::cast(four));
            }
        }
        let complements: u16x16 = bytemuck::cast(bytemuck::cast::<_, u64x4>(joined) >> 32);
        let range = !complements - joined;
        let beyond: [u64; 4] = bytemuck::cast(range.saturating_sub(most));
        is_one.iter_mut().zip(beyond).for_each(|(is_one, beyond)| *is_one = beyond == 0);
    }
    is_one
}

/// Number of low bits of a [depth](super::bins::Binned::depth) that are ignored: 16 are left, 8 of them below
/// the point.
const DEPTH_LOST: u32 = 13;

/// [`DEPTH_STEP`] in steps of such a depth, from a power of two on: elsewhere it is up to twice as much.
const DEPTH_STEPS: u16 = (DEPTH_STEP * 256.0) as u16;

/// Number for the surface of a sample: other models and materials have other numbers, but for chance.
#[inline(always)]
fn surface(model: u32, material: u16) -> u16 {
    if model == BACKGROUND {
        return u16::MAX;
    }
    // the golden section of a word
    let mixed = (model << 16 ^ model >> 16 ^ u32::from(material)).wrapping_mul(0x9e37_79b9);
    (mixed >> 16) as u16
}

impl Edges {
    /// Finds the edges among `candidates`, which are in the tiles that `sources` has. `endless`: true for
    /// each model that is an endless plane. `unwanted` calls its argument for each cell in and around the
    /// tile that is not wanted, as
    /// [`Wanted::unwanted_around`](crate::frame::grid::wanted::Wanted::unwanted_around) does.
    pub fn find<'t>(
        &mut self,
        candidates: &Candidates,
        extent: Extent,
        endless: &[bool],
        sources: &impl Sources<'t>,
        unwanted: impl FnOnce(&mut dyn FnMut(usize)),
    ) {
        self.take(candidates, endless, sources);
        mark_beyond(extent, &mut self.quarters);
        let Self { shown, quarters, cells } = self;
        // no sample is missing in cells that a coarser level makes
        unwanted(&mut |cell| quarters[cell] = ALL_QUARTERS);
        *cells = CellSet::default();
        let [columns, count] = extent.cells;
        for row in 1..=count as usize {
            let is_one = one_surface([row - 1, row, row + 1].map(|row| &shown[row * ROW..(row + 1) * ROW]));
            let is_round = has_all_quadrants(quarters, row);
            let is_inner = is_one.iter().zip(&is_round).map(|(is_one, is_round)| *is_one & *is_round);
            for (column, is_inner) in (0..columns).zip(is_inner) {
                if !is_inner {
                    cells.insert(cell_number([column, row as u32 - 1]));
                }
            }
        }
    }

    /// Notes the surfaces and depths of the candidates, and their quarters.
    fn take<'t>(&mut self, candidates: &Candidates, endless: &[bool], sources: &impl Sources<'t>) {
        let Self { shown: cells, quarters, .. } = self;
        cells.clear();
        cells.resize(AROUND, NOTHING);
        quarters.clear();
        quarters.resize(AROUND, 0);
        for (source, numbers) in candidates.runs() {
            let Some(tile) = sources(source) else { continue };
            for number in numbers {
                let Candidate { word, cell, .. } = candidates.get(number);
                let cell = usize::from(cell);
                let (model, record) = tile.surface_in(word.slot());
                // a plane hides nothing of itself, however steeply it recedes
                let is_endless = endless.get(model as usize) == Some(&true);
                let depth = if is_endless { 0 } else { (word.depth() >> DEPTH_LOST) as u16 };
                cells[cell] = join(cells[cell], shown(surface(model, record.material), depth));
                quarters[cell] |= word.quarter();
            }
        }
    }
}

/// Marks the cells beyond the rim of the picture, where no sample is missing.
fn mark_beyond(extent: Extent, quarters: &mut [u8]) {
    let [columns, rows] = extent.cells.map(|count| count as usize + 1);
    let [left, top, right, bottom] = extent.goes_on;
    for at in 0..ACROSS {
        let column = |x: usize| at * ROW + x;
        let row = |y: usize| y * ROW + at;
        for (cell, goes_on) in
            [(column(0), left), (column(columns), right), (row(0), top), (row(rows), bottom)]
        {
            if !goes_on {
                quarters[cell] = ALL_QUARTERS;
            }
        }
    }
}

/// Returns true for each cell of the tile in a row if each of the four quadrants around its target has a
/// sample, within a cell and a half.
#[inline(always)]
fn has_all_quadrants(quarters: &[u8], row: usize) -> [bool; TILE] {
    let of_row = |row: usize| -> [u8; ROW] {
        let quarters = &quarters[row * ROW..(row + 1) * ROW];
        std::array::from_fn(|at| quarters[at])
    };
    let (above, own, below) = (of_row(row - 1), of_row(row), of_row(row + 1));
    std::array::from_fn(|column| {
        let (left, at, right) = (column, column + 1, column + 2);
        let left_above = own[at] & 1 | own[left] & 3 | above[at] & 5 | above[left];
        let right_above = own[at] & 2 | own[right] & 3 | above[at] & 10 | above[right];
        let left_below = own[at] & 4 | own[left] & 12 | below[at] & 5 | below[left];
        let right_below = own[at] & 8 | own[right] & 12 | below[at] & 10 | below[right];
        (left_above != 0) & (right_above != 0) & (left_below != 0) & (right_below != 0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::reuse::bins::{Binned, STEPS};
    use crate::samples::{TagLayout, Tile};

    #[test]
    fn an_empty_quadrant_is_seen_whichever_it_is() {
        let middle = 5 * ROW + 5;
        let has_all_quadrants =
            |quarters: &[u8], cell: usize| has_all_quadrants(quarters, cell / ROW)[cell % ROW - 1];
        assert!(has_all_quadrants(&[15; AROUND], middle));
        // each quadrant: a quarter of the own cell, halves of two beside it, and all of the one at the corner
        let quadrants = [
            [(0, 1), (-1, 3), (-(ROW as isize), 5), (-(ROW as isize) - 1, 15)],
            [(0, 2), (1, 3), (-(ROW as isize), 10), (-(ROW as isize) + 1, 15)],
            [(0, 4), (-1, 12), (ROW as isize, 5), (ROW as isize - 1, 15)],
            [(0, 8), (1, 12), (ROW as isize, 10), (ROW as isize + 1, 15)],
        ];
        for quadrant in quadrants {
            let mut quarters = [15; AROUND];
            for (offset, quarter) in quadrant {
                quarters[(middle as isize + offset) as usize] &= !quarter;
            }
            assert!(!has_all_quadrants(&quarters, middle), "{quadrant:?}");
            for (offset, quarter) in quadrant {
                let mut one = quarters;
                one[(middle as isize + offset) as usize] |= quarter;
                assert!(has_all_quadrants(&one, middle), "{offset}");
            }
        }
    }

    #[test]
    fn one_surface_has_one_material_and_one_depth() {
        let is_one = |other: SurfaceKey| {
            let mut rows = [[shown(7, 1000); ROW]; 3];
            rows[2][17] = other;
            let is_one = one_surface(rows.each_ref().map(|row| &row[..]));
            // cell 17 is in column 16 of the tile
            assert!(is_one[..15].iter().chain(&is_one[18..]).all(|is_one| *is_one));
            assert!(is_one[15] == is_one[16] && is_one[16] == is_one[17]);
            is_one[16]
        };
        assert!(is_one(shown(7, 1000)) && is_one(shown(7, 1000 + DEPTH_STEPS / 2)) && is_one(NOTHING));
        assert!(!is_one(shown(8, 1000)) && !is_one(shown(6, 1000)), "another material");
        assert!(!is_one(shown(7, 1000 + 2 * DEPTH_STEPS)), "a step");
        assert!(surface(0, 1) != surface(1, 0) && surface(3, 9) != surface(BACKGROUND, 9));
    }

    #[test]
    fn nothing_is_missing_in_cells_that_nobody_asks_for() {
        // one surface, and no sample in two by two cells
        let (hole, extent) = (8..10_usize, Extent { cells: [TILE as u32; 2], goes_on: [true; 4] });
        let is_in_hole = |cell: &usize| hole.contains(&(cell % ROW)) && hole.contains(&(cell / ROW));
        let middle = |cell: usize| [cell % ROW, cell / ROW].map(|at| at as i32 * STEPS + STEPS / 2);
        let words: Vec<u64> = (0..AROUND)
            .filter(|cell| !is_in_hole(cell))
            .map(|cell| Binned::new(1.0, middle(cell), 0).word())
            .collect();
        let mut candidates = Candidates::default();
        candidates.add(0, &words, None);
        let mut tile = Tile::empty(&TagLayout::new(std::iter::empty()));
        tile.model[0] = 0;
        let mut edges = Edges::default();
        let mut count = |unwanted: &[usize]| {
            let name = |each: &mut dyn FnMut(usize)| unwanted.iter().for_each(|cell| each(*cell));
            edges.find(&candidates, extent, &[false], &|_| Some(&tile), name);
            edges.cells.count()
        };
        let all: Vec<usize> = (0..AROUND).filter(is_in_hole).collect();
        assert!(count(&[]) >= 4, "all cells of the hole");
        assert_eq!(count(&all), 0);
    }
}
