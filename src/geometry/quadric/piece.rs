//! Pieces of a quadric's surface, in its own space.

use glam::DVec3;

/// Part of a quadric's surface, as a triangle is of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Kind of the piece, and its chart.
    pub kind: Kind,
    /// Coefficients A, B and C: the squared radius is A y² + B y + C.
    pub profile: [f64; 3],
    /// Least and greatest y.
    pub range: [f64; 2],
}

/// Kind of a piece, and the chart by which two weights are a point on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The unit sphere. Weights: the octahedral map.
    Ball,
    /// Surface with one radius at each height. Weights: y, and the [diamond angle](from_diamond) about the
    /// axis.
    Belt,
    /// Surface with one height at each x and z. Weights: x and z.
    Sheet {
        /// True for the upper one of two.
        is_upper: bool,
    },
    /// A disk at the only y of the range. Weights: x and z.
    Disk {
        /// True if up is outside.
        faces_up: bool,
    },
}

/// Overlap of pieces at rims, as a share of their size: no ray passes between a side and its cap.
pub const RIM: f64 = 1e-12;

impl Piece {
    /// Squared radius at a height.
    pub fn squared_radius(&self, y: f64) -> f64 {
        let [a, b, c] = self.profile;
        (a * y + b) * y + c
    }

    /// Heights and radii of two circles whose hull contains the piece.
    pub fn circles(&self) -> [(f64, f64); 2] {
        let radii = self.range.map(|y| self.squared_radius(y).max(0.0).sqrt());
        // the radius of a belt is greatest at an end of each part, and no greater than a cone's between
        let widest = radii[0].max(radii[1]);
        let is_within_cone = self.kind == Kind::Belt;
        let radius = |end: usize| if is_within_cone { radii[end] } else { widest };
        [(self.range[0], radius(0)), (self.range[1], radius(1))]
    }

    /// Point with these weights.
    pub fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        match self.kind {
            Kind::Ball => {
                let y = 1.0 - u.abs() - v.abs();
                let [x, z] = match y >= 0.0 {
                    true => [u, v],
                    false => [(1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v)],
                };
                DVec3::new(x, y, z).normalize_or(DVec3::Y)
            }
            Kind::Belt => {
                let (sin, cos) = from_diamond(v);
                let radius = self.squared_radius(u).max(0.0).sqrt();
                DVec3::new(radius * cos, u, radius * sin)
            }
            Kind::Sheet { is_upper } => {
                let [a, b, c] = self.profile;
                let square = u * u + v * v;
                let y = match a == 0.0 {
                    true => (square - c) / b,
                    false => ((square - c) / a).max(0.0).sqrt().copysign(if is_upper { 1.0 } else { -1.0 }),
                };
                DVec3::new(u, y, v)
            }
            Kind::Disk { .. } => DVec3::new(u, self.range[0], v),
        }
    }

    /// Implicit function (zero on the quadric) and its gradient at a point that is as high as the piece;
    /// `None` for disks, which are flat.
    pub fn implicit(&self, point: DVec3) -> Option<(f64, DVec3)> {
        let is_beside = (self.range[0]..=self.range[1]).contains(&point.y);
        if !is_beside || matches!(self.kind, Kind::Disk { .. }) {
            return None;
        }
        let [a, b, _] = self.profile;
        let value = point.x * point.x + point.z * point.z - self.squared_radius(point.y);
        Some((value, 2.0 * DVec3::new(point.x, -(a * point.y + 0.5 * b), point.z)))
    }

    /// Normal, outwards, of any length, at a point of the piece.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        if let Kind::Disk { faces_up } = self.kind {
            return if faces_up { DVec3::Y } else { DVec3::NEG_Y };
        }
        let [a, b, _] = self.profile;
        let gradient = DVec3::new(point.x, -(a * point.y + 0.5 * b), point.z);
        let is_above = point.y > 0.5 * (self.range[0] + self.range[1]);
        // a cone's tip has no gradient
        gradient.try_normalize().unwrap_or(if is_above { DVec3::Y } else { DVec3::NEG_Y })
    }
}

/// Sine and cosine of an angle that is given as a number from -2 to 2: its position along a square that
/// stands on its corner.
fn from_diamond(angle: f64) -> (f64, f64) {
    let x = 1.0 - angle.abs();
    let z = (1.0 - x.abs()).copysign(angle);
    let length = (x * x + z * z).sqrt();
    (z / length, x / length)
}
