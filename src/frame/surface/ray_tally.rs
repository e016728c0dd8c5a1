//! Counts of the rays that a worker casts: by kind, and by cell.

use crate::samples::{CELLS, Column};
use crate::stats::RayCounts;

/// Rays that the cells of a tile have cost in this frame, by kind. Each traced cell has cost one primary ray; those that
/// were probed before have cost it as a probe.
#[derive(Debug)]
#[allow(missing_docs, reason = "one count a kind, by name")]
pub struct CellRays {
    pub probes: Column<u16>,
    pub verification: Column<u16>,
    pub shadow: Column<u16>,
    pub secondary: Column<u16>,
}

impl Default for CellRays {
    fn default() -> Self {
        Self { probes: [0; CELLS], verification: [0; CELLS], shadow: [0; CELLS], secondary: [0; CELLS] }
    }
}

impl CellRays {
    /// No rays, for a new tile.
    pub fn begin_tile(&mut self) {
        self.probes.fill(0);
        self.verification.fill(0);
        self.shadow.fill(0);
        self.secondary.fill(0);
    }
}

/// The rays that one worker has cast.
#[derive(Debug, Default)]
pub struct RayTally {
    /// Of the tile at work, by cell.
    pub cells: Box<CellRays>,
    /// Of all its tiles in this frame, by kind.
    pub counts: RayCounts,
}
