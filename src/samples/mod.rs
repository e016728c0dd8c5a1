//! The sample store: data that a frame keeps for the next one.
//!
//! A picture of `width x height` pixels with N x N samples a pixel is a grid of *cells*, one sample in
//! each. Cells are stored in [tiles](Tile) of 32 x 32, a tile in blocks of 4 x 4: sixteen neighbours lie
//! side by side and make one packet of rays.
//!
//! Positions and normals are in the *object space* of the sample's model: however long a shot is, motion
//! adds no drift. A tile keeps them in columns: projection reads 16 bytes a sample, and each phase only what
//! it needs.

mod footprint;
mod gathered;
mod mirrored;
mod octahedral;
mod openness;
mod path_color;
mod path_list;
mod pool;
mod regions;
mod sample;
pub mod saved;
mod spare;
mod store;
mod tag;
mod varied;

pub use footprint::Footprint;
pub use gathered::{GatheredLight, PathLight, mean_of};
pub use mirrored::{MirroredOfTile, MirroredSample, MirroredSamples, octave_of};
pub use octahedral::Octahedral;
pub use openness::Openness;
pub use path_color::PathColor;
pub use path_list::{KeptPath, PathList};
pub use pool::{LeavingStore, OldStore, TilePool};
pub use regions::{Apart, ClearRegion, ClearRegions, RegionNumbers};
pub use sample::{Flags, HalfColor, Record, Sample, Traced};
pub use spare::{MOST_SPARES, Spares};
pub use store::{
    BACKGROUND, CELLS, Column, EMPTY, Move, SampleStore, Slot, TILE, Tile, full_color, half_colors,
};
pub use tag::{AREA_POINTS, AreaTag, Tag, TagLayout, TagSlot, Tags};
pub use varied::VariedColumn;

/// Result of reprojection for a cell's sample in this frame. `Empty` and `Outside` are states on the way and
/// beyond the picture's rim; the others are the contract's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Status {
    /// Beyond the picture's rim: no sample.
    Outside,
    /// No sample yet; or the cell is not wanted.
    #[default]
    Empty,
    /// Traced with the whole frame.
    Base,
    /// Served by a kept sample, the only one near enough.
    Good,
    /// Served by a kept sample; others were near enough, too.
    Overlapped,
    /// Traced, since no kept sample was near enough.
    Missed,
    /// Traced, since the samples near enough are hidden now.
    Obscured,
}

impl Status {
    /// All statuses, in the order of their numbers.
    pub const ALL: [Self; 7] =
        [Self::Outside, Self::Empty, Self::Base, Self::Good, Self::Overlapped, Self::Missed, Self::Obscured];

    /// Returns true if the sample comes from the frame before.
    pub fn is_reused(self) -> bool {
        matches!(self, Status::Good | Status::Overlapped)
    }
}
