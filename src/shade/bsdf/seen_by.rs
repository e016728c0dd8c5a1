//! Who sees a surface: the eye, or paths, to which what is smooth is rougher.

/// Least alpha that paths see which have been scattered before.
pub const LEAST_ALPHA_OF_PATHS: f32 = 0.1;

/// Alpha that paths see (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition, 2023, "path
/// regularization").
pub fn regularized(alpha: f32) -> f32 {
    const ROUGH_ENOUGH: f32 = 0.3;
    if alpha < ROUGH_ENOUGH { (2.0 * alpha).clamp(LEAST_ALPHA_OF_PATHS, ROUGH_ENOUGH) } else { alpha }
}

/// Alpha that paths see of a layer; rays through rough glass bend by microfacets of its own width.
pub fn alpha_of_paths(alpha: f32, is_glass: bool) -> f32 {
    if is_glass { alpha } else { regularized(alpha) }
}

/// Kind of ray that sees a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeenBy {
    /// A ray that has been mirrored at most since it left the eye.
    Eye,
    /// A path that has been scattered before. Smooth surfaces focus lights and the sun; few paths find such
    /// light, each of which is a spark. To paths these surfaces are rougher.
    Path,
}
