//! Bits of rays and of what they meet. Instances carry one of the first two, geometries one of the others.

/// An instance that is not there: no ray meets it.
pub const HIDDEN: u32 = 0;
/// An instance that is where it was in the frame before, or always.
pub const RESTS: u32 = 1;
/// An instance that moved since the frame before.
pub const MOVED: u32 = 2;
/// Triangles that cast shadows.
pub const CASTS_SHADOW: u32 = 4;
/// Triangles that do not.
pub const CLEAR: u32 = 8;
/// Meets everything.
pub const ALL: u32 = RESTS | MOVED | CASTS_SHADOW | CLEAR;
