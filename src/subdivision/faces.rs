//! Faces of a cage, as they are given.

/// Rules by which a cage is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Scheme {
    /// Smooth everywhere but at creases: faces of any number of corners become quadrilaterals.
    CatmullClark,
    /// The same of triangles alone, which stay triangles (C. Loop, "Smooth subdivision surfaces based on triangles", 1987).
    Loop,
    /// Faces are divided and stay where they are.
    Bilinear,
}

/// The surface at edges that only one face has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boundary {
    /// A smooth curve that begins and ends at corners: points that one face has.
    #[default]
    EdgesAndCorners,
    /// A smooth curve without corners.
    Edges,
}

/// Faces of a cage: any polygons.
#[derive(Debug, Clone, Copy)]
pub struct CageFaces<'a> {
    /// Rules.
    pub scheme: Scheme,
    /// Number of points.
    pub points: usize,
    /// Number of corners of each face, at least 3; of the scheme `Loop` 3.
    pub counts: &'a [u32],
    /// Points of the corners, face after face.
    pub corners: &'a [u32],
    /// Edges by their ends, in either order, with their sharpness, 0 and above.
    pub creases: &'a [([u32; 2], f32)],
    /// Points with their sharpness, 0 and above.
    pub sharp_points: &'a [(u32, f32)],
    /// What becomes of its boundary.
    pub boundary: Boundary,
}
