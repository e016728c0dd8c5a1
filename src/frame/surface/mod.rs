//! Surfaces and samples as the phases handle them: eight at a time.

pub mod computed_hits;
pub mod facing;
pub mod footprints;
pub mod hits;
pub mod placed;
pub mod radiance;
pub mod ray_tally;
pub mod tangents;
pub mod trace_scratch;
