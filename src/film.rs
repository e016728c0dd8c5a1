//! The planes of one finished frame.

/// How a plane is stored in a file. In memory every plane is `f32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneKind {
    /// 16-bit float: colours, normals, fractions.
    Half,
    /// 32-bit float: distances, positions, motion, ids.
    Float,
}

/// One channel of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Its name in the EXR file: `R`, `Z`, `P.X`, `status.good`.
    pub name: &'static str,
    /// How it is stored.
    pub kind: PlaneKind,
    /// `width * height` finite values, row-major, top row first.
    pub data: Vec<f32>,
    /// Known to be zero throughout: a renderer need not clear it, nor a writer look at it.
    pub is_zero: bool,
}

/// A finished frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// In any order; no two of the same name.
    pub planes: Vec<Plane>,
    /// By which a renderer knows its last film again; 0 for films that no renderer made.
    pub stamp: u64,
}

impl Film {
    /// The plane of that name.
    #[must_use]
    pub fn plane(&self, name: &str) -> Option<&Plane> {
        self.planes.iter().find(|plane| plane.name == name)
    }

    /// The values of the plane of that name.
    #[must_use]
    pub fn values(&self, name: &str) -> Option<&[f32]> {
        self.plane(name).map(|plane| plane.data.as_slice())
    }
}
