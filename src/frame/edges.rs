//! Where the nearest sample need not show what a cell's target shows: at edges.

use wide::u16x8;

use super::candidates::{ACROSS, AROUND, Candidates, Sources};
use super::grid::Extent;
use crate::samples::{BACKGROUND, Octahedral, Tile};

/// Where surfaces beside each other differ so much in depth (a share of it), one is before the other.
pub const DEPTH_STEP: f32 = 0.1;

/// Edges in a tile. Keeps its memory.
#[derive(Debug, Default)]
pub struct Edges {
    /// For each cell in and around the tile, what its candidates show.
    shown: Vec<Shown>,
    /// The same of the cells beside each other, three at a time, in the three rows at hand.
    rows: [Vec<Shown>; 3],
    /// Which quarters of each cell in and around the tile have a candidate, a bit each: 1 left above, 2 right above, 4 left
    /// below, 8 right below.
    quarters: Vec<u8>,
    /// For each cell in and around the tile, whether it is at an edge.
    is_edge: Vec<bool>,
}

/// The least of what some candidates show, and the complement of the greatest: surface, depth, and the two coordinates
/// of the normal.
#[derive(Debug, Clone, Copy)]
struct Shown(u16x8);

impl Shown {
    const NOTHING: Self = Self(u16x8::MAX);

    #[inline(always)]
    fn of([surface, depth, across, down]: [u16; 4]) -> Self {
        Self(u16x8::new([surface, depth, across, down, !surface, !depth, !across, !down]))
    }

    #[inline(always)]
    fn with(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    /// Whether all that is shown may be one surface.
    #[inline(always)]
    fn is_one_surface(self) -> bool {
        let values = self.0.to_array();
        let range = |i: usize| (!values[i + 4]).wrapping_sub(values[i]);
        (range(0) == 0)
            & (range(1) < DEPTH_STEPS)
            & (range(2) < Octahedral::FOLD as u16)
            & (range(3) < Octahedral::FOLD as u16)
    }
}

/// Low bits of a [depth](super::bins::Binned::depth) that are not looked at: 16 are left, 8 of them below the point.
const DEPTH_LOST: u32 = 13;

/// [`DEPTH_STEP`] in steps of such a depth, from a power of two on: elsewhere it is up to twice as much.
const DEPTH_STEPS: u16 = (DEPTH_STEP * 256.0) as u16;

/// A number for what a sample shows: other models and materials have others, but for chance.
#[inline(always)]
fn surface(model: u32, material: u16) -> u16 {
    if model == BACKGROUND {
        return u16::MAX;
    }
    // the golden section's share of a word
    let mixed = (model << 16 ^ model >> 16 ^ u32::from(material)).wrapping_mul(0x9e37_79b9);
    (mixed >> 16) as u16
}

impl Edges {
    /// Finds the edges among `candidates`, which are in the tiles that `sources` has.
    pub fn find<'t>(&mut self, candidates: &Candidates, extent: Extent, sources: &impl Sources<'t>) {
        self.take(candidates, sources);
        mark_beyond(extent, &mut self.quarters);
        let Self { shown, rows, quarters, is_edge } = self;
        is_edge.clear();
        is_edge.resize(AROUND, false);
        let [columns, count] = extent.cells.map(|count| count as usize);
        let join_row = |row: usize, joined: &mut Vec<Shown>| {
            let shown = &shown[row * ACROSS..(row + 1) * ACROSS];
            joined.clear();
            joined.extend(shown.windows(3).map(|three| three[0].with(three[1]).with(three[2])));
        };
        join_row(0, &mut rows[0]);
        join_row(1, &mut rows[1]);
        for row in 1..=count {
            join_row(row + 1, &mut rows[(row + 1) % 3]);
            for column in 0..columns {
                let cell = row * ACROSS + column + 1;
                let all = rows[0][column].with(rows[1][column]).with(rows[2][column]);
                is_edge[cell] = !(all.is_one_surface() & has_all_quadrants(quarters, cell));
            }
        }
    }

    /// Notes what the candidates show, and where in their cells they are.
    fn take<'t>(&mut self, candidates: &Candidates, sources: &impl Sources<'t>) {
        let Self { shown, quarters, .. } = self;
        shown.clear();
        shown.resize(AROUND, Shown::NOTHING);
        quarters.clear();
        quarters.resize(AROUND, 0);
        for (source, numbers) in candidates.runs() {
            let Some(tile) = sources(source) else { continue };
            for number in numbers {
                let (word, cell) = candidates.get(number);
                let (model, record) = Tile::surface_in(tile, word.slot());
                let [across, down] = record.normal.steps().map(|step| step as u16);
                let depth = (word.depth() >> DEPTH_LOST) as u16;
                let values = [surface(model, record.material), depth, across, down];
                shown[cell] = shown[cell].with(Shown::of(values));
                quarters[cell] |= word.quarter();
            }
        }
    }

    /// Whether a cell in or around the tile is at an edge.
    #[inline(always)]
    pub fn has(&self, around: usize) -> bool {
        self.is_edge[around]
    }
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
    let row = |first: usize| [quarters[first - 1], quarters[first], quarters[first + 1]];
    let (above, own, below) = (row(cell - ACROSS), row(cell), row(cell + ACROSS));
    let left_above = own[1] & 1 | own[0] & 3 | above[1] & 5 | above[0];
    let right_above = own[1] & 2 | own[2] & 3 | above[1] & 10 | above[2];
    let left_below = own[1] & 4 | own[0] & 12 | below[1] & 5 | below[0];
    let right_below = own[1] & 8 | own[2] & 12 | below[1] & 10 | below[2];
    (left_above != 0) & (right_above != 0) & (left_below != 0) & (right_below != 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_quadrant_is_seen_whichever_it_is() {
        let middle = 5 * ACROSS + 5;
        assert!(has_all_quadrants(&[15; AROUND], middle));
        // each quadrant: a quarter of the own cell, halves of two beside it, and all of the one at the corner
        let quadrants = [
            [(0, 1), (-1, 3), (-(ACROSS as isize), 5), (-(ACROSS as isize) - 1, 15)],
            [(0, 2), (1, 3), (-(ACROSS as isize), 10), (-(ACROSS as isize) + 1, 15)],
            [(0, 4), (-1, 12), (ACROSS as isize, 5), (ACROSS as isize - 1, 15)],
            [(0, 8), (1, 12), (ACROSS as isize, 10), (ACROSS as isize + 1, 15)],
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
    fn one_surface_has_one_material_one_depth_and_one_normal() {
        let values = [7, 1000, 30000, 40000];
        let joined = |other: [u16; 4]| Shown::of(values).with(Shown::of(other)).is_one_surface();
        assert!(joined(values) && joined([7, 1000 + DEPTH_STEPS / 2, 31000, 39000]));
        assert!(!joined([8, 1000, 30000, 40000]), "another material");
        assert!(!joined([7, 1000 + 2 * DEPTH_STEPS, 30000, 40000]), "a step");
        assert!(!joined([7, 1000, 40000, 40000]) && !joined([7, 1000, 30000, 10000]), "a fold");
        assert!(surface(0, 1) != surface(1, 0) && surface(3, 9) != surface(BACKGROUND, 9));
    }
}
