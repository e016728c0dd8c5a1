//! Counts of the rays that a worker casts: by kind, and by cell.

use crate::samples::{CELLS, Column};
use crate::stats::RayCounts;

/// Rays cast for each cell of a tile in this frame, by kind.
#[derive(Debug)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct CellRays {
    pub primary: Column<u16>,
    pub verification: Column<u16>,
    pub shadow: Column<u16>,
    pub secondary: Column<u16>,
}

impl Default for CellRays {
    fn default() -> Self {
        Self { primary: [0; CELLS], verification: [0; CELLS], shadow: [0; CELLS], secondary: [0; CELLS] }
    }
}

impl CellRays {
    /// Clears the counts for a new tile.
    pub fn begin_tile(&mut self) {
        self.primary.fill(0);
        self.verification.fill(0);
        self.shadow.fill(0);
        self.secondary.fill(0);
    }
}

/// Counts of the rays that one worker has cast.
#[derive(Debug, Default)]
pub struct RayTally {
    /// Rays of the current tile, by cell.
    pub cells: Box<CellRays>,
    /// Rays of all its tiles in this frame, by kind.
    pub counts: RayCounts,
}
