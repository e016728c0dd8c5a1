//! Cells of a tile with a rim of one cell around it: samples in any of them may serve a cell of the tile.

use super::place;
use crate::samples::TILE;

/// Cells along an edge of a tile with its rim.
pub const ACROSS: usize = TILE + 2;

/// Length of a row of a tile with its rim: padded to a multiple of eight, so that eight cells may be loaded
/// from any cell of the tile on.
pub const ROW: usize = ACROSS.next_multiple_of(8);

/// Cells of a tile with its rim. They are numbered in rows of [`ROW`].
pub const AROUND: usize = ACROSS * ROW;

/// Number of a tile's cell among the [cells in and around](AROUND) the tile.
#[inline(always)]
pub fn around(cell: usize) -> usize {
    let [column, row] = place(cell).map(|at| at as usize + 1);
    row * ROW + column
}
