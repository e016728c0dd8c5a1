//! Mask bits of rays, instances and geometries. Instances carry one of the first two, geometries one of the
//! others.

/// Instance that is not there: no ray meets it.
pub const HIDDEN: u32 = 0;
/// Instance that is where it was in the frame before, or always.
pub const RESTS: u32 = 1;
/// Instance that moved since the frame before.
pub const MOVED: u32 = 2;
/// Triangles that cast shadows.
pub const CASTS_SHADOW: u32 = 4;
/// Triangles that cast no shadows.
pub const CLEAR: u32 = 8;
/// Mask of a ray that meets everything.
pub const ALL: u32 = RESTS | MOVED | CASTS_SHADOW | CLEAR;
