//! One worker's list of rays, and their answers.

use super::ray_tally::RayTally;
use crate::trace::{HitBatch, RayBatch};

/// One worker's memory for the rays of the phase at work. Kept from tile to tile and from frame to frame.
#[derive(Debug, Default)]
pub struct TraceScratch {
    /// Of the phase at work.
    pub rays: RayBatch,
    /// Their answers.
    pub hits: HitBatch,
    /// Their answers, a bit a ray.
    pub blocked: Vec<u16>,
    /// Which cell each ray of `rays` is for.
    pub owners: Vec<u32>,
    /// What has been cast.
    pub tally: RayTally,
}

impl TraceScratch {
    /// Starts a list of rays.
    pub fn begin_rays(&mut self) {
        self.rays.clear();
        self.owners.clear();
    }

    /// Makes room for one bit a ray of `rays`, none of them set.
    pub fn begin_answers(&mut self) {
        self.blocked.clear();
        self.blocked.resize(self.rays.packet_count(), 0);
    }
}
