//! One worker's memory for all phases.

use crate::frame::film::filter::Filtering;
use crate::frame::light::direct::Lighting;
use crate::frame::light::light_paths::PathScratch;
use crate::frame::light::occlusion::OcclusionScratch;
use crate::frame::reuse::proofs::ProofScratch;
use crate::frame::reuse::serve::Serving;
use crate::frame::secondary::bounce::Bounces;
use crate::frame::secondary::ray_trees::Root;
use crate::frame::surface::placed::PlacedTile;
use crate::frame::surface::radiance::Radiance;
use crate::frame::surface::trace_scratch::TraceScratch;
use crate::samples::Tile;

/// Seconds that a worker spent in each phase of its tiles.
#[derive(Debug, Clone, Copy, Default)]
#[allow(missing_docs, reason = "the phases, by name")]
pub struct PhaseSeconds {
    pub resolve: f64,
    pub verify: f64,
    pub trace: f64,
    pub light: f64,
    pub filter: f64,
}

impl std::ops::AddAssign for PhaseSeconds {
    fn add_assign(&mut self, other: Self) {
        self.resolve += other.resolve;
        self.verify += other.verify;
        self.trace += other.trace;
        self.light += other.light;
        self.filter += other.filter;
    }
}

/// One worker's memory for the tile at work: kept from tile to tile and from frame to frame, so that the loop
/// allocates nothing. Each phase is given its own part.
#[derive(Debug, Default)]
pub struct ThreadScratch {
    /// Scratch of the phase that finds servers.
    pub serving: Box<Serving>,
    /// The tile at work as it was in the frame before.
    pub before: Option<Box<Tile>>,
    /// Rays of all phases that trace any.
    pub trace: TraceScratch,
    /// Scratch of proofs.
    pub proofs: ProofScratch,
    /// Scratch of light paths.
    pub paths: PathScratch,
    /// Scratch of ambient occlusion.
    pub occlusion: OcclusionScratch,
    /// Scratch of direct light.
    pub lighting: Lighting,
    /// The tile's surfaces in world space.
    pub placed: Box<PlacedTile>,
    /// Scratch of rays beyond the first surface.
    pub bounces: Bounces,
    /// Whose trees were kept when the tile at work was begun.
    pub roots: Vec<Root>,
    /// Radiance of each cell in this frame.
    pub radiance: Box<Radiance>,
    /// Scratch of the filter.
    pub filtering: Box<Filtering>,
    /// Time by phase.
    pub seconds: PhaseSeconds,
}

impl ThreadScratch {
    /// Clears what belongs to a tile.
    pub fn begin_tile(&mut self) {
        self.trace.tally.cells.begin_tile();
        self.trace.has_looked_up = false;
        self.placed.begin_tile();
    }
}
