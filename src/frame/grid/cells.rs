//! Sets of a tile's cells.

use crate::samples::saved::CellMask;
use crate::samples::{CELLS, Status};

/// Cells of a block, which is a packet.
pub const BLOCK: usize = crate::trace::LANES;

/// Cells of a tile, a bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellSet([u16; CELLS / BLOCK]);

impl CellSet {
    /// All cells.
    pub const ALL: Self = Self([u16::MAX; CELLS / BLOCK]);

    /// Those that `holds`.
    pub fn of(holds: impl Fn(usize) -> bool) -> Self {
        Self(std::array::from_fn(|block| {
            (0..BLOCK).fold(0, |bits, lane| bits | u16::from(holds(block * BLOCK + lane)) << lane)
        }))
    }

    /// As bytes.
    pub fn to_mask(self) -> CellMask {
        std::array::from_fn(|eight| self.eight(eight * 8))
    }

    /// What [`to_mask`](Self::to_mask) gave.
    pub fn from_mask(mask: &CellMask) -> Self {
        Self::of(|cell| mask[cell / 8] >> (cell % 8) & 1 != 0)
    }

    /// Those that are in both.
    pub fn and(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] & other.0[block]))
    }

    /// Those that are in either.
    pub fn or(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] | other.0[block]))
    }

    /// Those that are not in the other.
    pub fn without(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] & !other.0[block]))
    }

    /// Whether a cell is in it.
    #[inline(always)]
    pub fn has(&self, cell: usize) -> bool {
        self.0[cell / BLOCK] >> (cell % BLOCK) & 1 != 0
    }

    /// Their numbers, in order.
    pub fn numbers(&self) -> impl Iterator<Item = usize> {
        let blocks = (0..).step_by(BLOCK).zip(self.0);
        blocks.flat_map(|(first, block)| {
            std::iter::successors(Some(block), |left| Some(left & left.wrapping_sub(1)))
                .take_while(|left| *left != 0)
                .map(move |left| first + left.trailing_zeros() as usize)
        })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.iter().map(|block| block.count_ones() as usize).sum()
    }

    /// Adds a cell.
    #[inline(always)]
    pub fn insert(&mut self, cell: usize) {
        self.0[cell / BLOCK] |= 1 << (cell % BLOCK);
    }

    /// Of eight cells from `first` on, those in it, a bit each.
    #[inline(always)]
    pub fn eight(&self, first: usize) -> u8 {
        (self.0[first / BLOCK] >> (first % BLOCK)) as u8
    }

    /// Whether no cell is in it.
    pub fn is_empty(&self) -> bool {
        self.0 == [0; CELLS / BLOCK]
    }
}

impl Default for CellSet {
    fn default() -> Self {
        Self([0; CELLS / BLOCK])
    }
}

/// Whether a cell with this status has been traced in this frame, or is to be.
#[inline]
pub fn is_traced(status: Status) -> bool {
    matches!(status, Status::Missed | Status::Obscured | Status::Base)
}
