//! The planes of one finished frame.

/// How a plane is stored in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneKind {
    /// 16 bits: colours and fractions.
    Half,
    /// 32 bits: positions and distances.
    Float,
}

/// One channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// As in the EXR file.
    pub name: &'static str,
    /// As in the EXR file.
    pub kind: PlaneKind,
    /// `width * height` values in rows, the top one first. Finite.
    pub data: Vec<f32>,
}

/// A finished frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// In no promised order.
    pub planes: Vec<Plane>,
}

impl Film {
    /// The plane called `name`.
    pub fn plane(&self, name: &str) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.name == name)
    }
}
