//! Rays of one worker, and their results.

use super::computed_hits::ComputedHits;
use super::ray_tally::RayTally;
use crate::trace::{HitBatch, RayBatch};

/// Scratch memory of one worker for the rays of the current phase. Kept from tile to tile and from frame to
/// frame.
#[derive(Debug, Default)]
pub struct TraceScratch {
    /// Rays of the current phase.
    pub rays: RayBatch,
    /// Nearest hits of the rays.
    pub hits: HitBatch,
    /// What graphs compute of the hits, for phases that ask for it.
    pub computed: ComputedHits,
    /// True bits for rays that are blocked, one a ray.
    pub blocked: Vec<u16>,
    /// Cell of each of `rays`.
    pub owners: Vec<u32>,
    /// True if samples of the tile at work were looked up in their textures anew: their light may be stale.
    pub has_looked_up: bool,
    /// Counts of the rays that were cast.
    pub tally: RayTally,
}

impl TraceScratch {
    /// Starts a list of rays.
    pub fn begin_rays(&mut self) {
        self.rays.clear();
        self.owners.clear();
    }

    /// Makes room for one bit for each of `rays`, none of them set.
    pub fn begin_answers(&mut self) {
        self.blocked.clear();
        self.blocked.resize(self.rays.packet_count(), 0);
    }
}
