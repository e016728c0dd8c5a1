//! The cells of a tile with a rim of one cell around it: those whose samples may serve a cell of the tile.

use super::place;
use crate::samples::TILE;

/// Cells along an edge of a tile and one around it.
pub const ACROSS: usize = TILE + 2;

/// Cells of a row in and around a tile: filled up to whole eights, so that eight may be loaded from any cell of the
/// tile.
pub const ROW: usize = ACROSS.next_multiple_of(8);

/// Cells in and around a tile. They are numbered in rows of [`ROW`].
pub const AROUND: usize = ACROSS * ROW;

/// The number, among the cells in and around a tile, of one of its cells.
#[inline(always)]
pub fn around(cell: usize) -> usize {
    let [column, row] = place(cell).map(|at| at as usize + 1);
    row * ROW + column
}
