//! Tolerances of the audit: all of them, each with its reason.

use crate::frame::reuse::sight::SEGMENT_END;
use crate::frame::secondary::ways::ONE_PLACE;

/// Displacement of a sample by rounding, at most, as a share of its distance from the eye. Single floats keep
/// 6e-8 of the largest coordinate at every step from the triangle's corners over the model's matrix to the
/// ray; this leaves room for a dozen steps and for coordinates ten times the distance. Not less than the gap
/// that the verification segment leaves open at its end (see [`SEGMENT_END`]).
pub const TOLERANCE: f32 = 2e-5;
const _: () = assert!(1.0 - SEGMENT_END <= TOLERANCE && ONE_PLACE <= TOLERANCE);

/// Rounding of positions themselves, as a share of the largest coordinate involved. It counts where the eye
/// is much nearer to a surface than both are to the origin.
pub const COORDINATE_TOLERANCE: f32 = 5e-7;

/// Shares of the greatest displacement by which a ray is moved: a needle may be thinner than that.
pub const DISPLACEMENTS: [f32; 3] = [1.0, 0.25, 0.0625];

/// Cosine between a geometric normal and the line of sight up to which a triangle may be seen from either
/// side: the rounding of its normal to four bytes.
pub const EDGE_ON_COSINE: f32 = 1e-4;

/// Cosine of the angle by which a stored normal may differ from the mesh's: rounding to four bytes.
pub const NORMAL_COSINE: f32 = 1.0 - 1e-5;

/// Error, in cells, with which a sample may be projected by rounding, that to the steps of places in bins
/// included.
pub const CELL_TOLERANCE: f32 = 0.03;

/// Factors by which the width of a sample's place may differ through rounding: it follows from a distance, and from the cosine of
/// an angle with a normal of four bytes.
pub const WIDTH_TOLERANCES: [f32; 3] = [1.0, 0.99, 1.01];

/// Largest ratio of the widths over which the textures of what a mirror shows were filtered, and would be now: less than between footprints of
/// samples, which are steps of the root of 2.
pub const WIDER: f32 = 1.2;

/// Tolerance of stored colours, as a share of their largest channel, or of 1 for reflectances: two roundings
/// to a half float.
pub const COLOR_TOLERANCE: f32 = 1e-3;

/// Least light to which [`COLOR_TOLERANCE`] is relative: darker light counts as black.
pub const DARKEST: f32 = 1e-4;

/// Largest distance of a sample from the tangent plane of what its cell's target sees, as a share of a cell's width there. It is the
/// renderer's promise ([`target::LAYER`](crate::frame::reuse::target::LAYER)), and stands here for itself: a promise is not to be
/// kept by promising less.
pub const LAYER: f32 = 0.25;

/// Least cosine of the angle between the normals of a sample and of what its cell's target sees: the renderer's promise
/// ([`target::ABOUT_PARALLEL`](crate::frame::reuse::target::ABOUT_PARALLEL)), less what rounding makes of an angle of 26 degrees.
pub const ABOUT_PARALLEL: f32 = 0.9 - 1e-3;
