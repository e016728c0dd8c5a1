//! Sets of a tile's cells.

use crate::samples::saved::CellMask;
use crate::samples::{CELLS, Status};

/// Cells of a block, which makes one packet.
pub const BLOCK: usize = crate::trace::LANES;

/// Set of a tile's cells, a bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellSet([u16; CELLS / BLOCK]);

impl CellSet {
    /// All cells.
    pub const ALL: Self = Self([u16::MAX; CELLS / BLOCK]);

    /// Creates the set of cells for which `holds` returns true.
    pub fn new(holds: impl Fn(usize) -> bool) -> Self {
        Self(std::array::from_fn(|block| {
            (0..BLOCK).fold(0, |bits, lane| bits | u16::from(holds(block * BLOCK + lane)) << lane)
        }))
    }

    /// Converts the set to bytes.
    pub fn to_mask(self) -> CellMask {
        std::array::from_fn(|eight| self.eight(eight * 8))
    }

    /// Inverse of [`to_mask`](Self::to_mask).
    pub fn from_mask(mask: &CellMask) -> Self {
        Self::new(|cell| mask[cell / 8] >> (cell % 8) & 1 != 0)
    }

    /// Intersection of two sets.
    pub fn and(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] & other.0[block]))
    }

    /// Union of two sets.
    pub fn or(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] | other.0[block]))
    }

    /// Difference: cells of this set that are not in `other`.
    pub fn without(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|block| self.0[block] & !other.0[block]))
    }

    /// Returns true if `cell` is in the set.
    #[inline(always)]
    pub fn has(&self, cell: usize) -> bool {
        self.0[cell / BLOCK] >> (cell % BLOCK) & 1 != 0
    }

    /// Iterates over the numbers of the cells, in order.
    pub fn numbers(&self) -> impl Iterator<Item = usize> {
        let blocks = (0..).step_by(BLOCK).zip(self.0);
        blocks.flat_map(|(first, block)| {
            std::iter::successors(Some(block), |left| Some(left & left.wrapping_sub(1)))
                .take_while(|left| *left != 0)
                .map(move |left| first + left.trailing_zeros() as usize)
        })
    }

    /// Number of cells in the set.
    pub fn count(&self) -> usize {
        self.0.iter().map(|block| block.count_ones() as usize).sum()
    }

    /// Adds a cell.
    #[inline(always)]
    pub fn insert(&mut self, cell: usize) {
        self.0[cell / BLOCK] |= 1 << (cell % BLOCK);
    }

    /// Adds those of the eight cells from `first` on whose bit is set.
    #[inline(always)]
    pub fn insert_eight(&mut self, first: usize, bits: u8) {
        self.0[first / BLOCK] |= u16::from(bits) << (first % BLOCK);
    }

    /// Bit mask of those of the eight cells from `first` on that are in the set.
    #[inline(always)]
    pub fn eight(&self, first: usize) -> u8 {
        (self.0[first / BLOCK] >> (first % BLOCK)) as u8
    }

    /// Returns true if the set has no cell.
    pub fn is_empty(&self) -> bool {
        self.0 == [0; CELLS / BLOCK]
    }
}

impl Default for CellSet {
    fn default() -> Self {
        Self([0; CELLS / BLOCK])
    }
}

/// Returns true if a cell with this status has been traced in this frame, or is to be.
#[inline]
pub fn is_traced(status: Status) -> bool {
    matches!(status, Status::Missed | Status::Obscured | Status::Base)
}
