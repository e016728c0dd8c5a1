//! What a frame knows of proofs ([`clear`](crate::clear)) before any is looked for.

use crate::clear::Obstacles;
use crate::geometry::Bounds;
use crate::samples::ClearRegion;

/// Frames that a region looks ahead, unless tests have it look [less far](crate::frame::Renderer::prove_ahead): with more, fewer samples are clear; with
/// fewer, all are tried anew more often.
pub const FRAMES_AHEAD: i32 = 16;

/// Places that the eye takes.
#[derive(Debug, Clone, Copy)]
pub struct EyePath {
    /// Now and in half of the frames ahead.
    pub soon: Bounds,
    /// Now and in all frames ahead.
    pub ahead: Bounds,
    /// Largest angle of view in these frames over that of now, as tangents.
    pub zoom: f32,
}

/// What proofs need in a frame.
#[derive(Clone, Copy)]
pub struct Proofs<'a> {
    /// The models at rest.
    pub obstacles: &'a Obstacles,
    /// Bit mask of the numbers of regions that samples of the frame before keep, and that hold now.
    pub holding: u16,
    /// The region for which proofs are looked for, with its number.
    pub now: Option<(u8, ClearRegion)>,
}
