//! The pieces of a quadric's surface, in its own space, and rays that meet them.

use glam::{DVec3, Vec3};

/// A part of a quadric's surface: what a triangle is of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// By which chart.
    pub kind: Kind,
    /// A, B and C: the squared radius is A y² + B y + C.
    pub profile: [f64; 3],
    /// Least and greatest y.
    pub range: [f64; 2],
}

/// What a piece is, and by which chart two weights are a place on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The unit sphere. Weights: the octahedral map.
    Ball,
    /// One radius at each height. Weights: y, and the [diamond angle](from_diamond) about the axis.
    Belt,
    /// One height at each x and z. Weights: x and z.
    Sheet {
        /// The upper one of two.
        is_upper: bool,
    },
    /// A disk at the only y of the range. Weights: x and z.
    Disk {
        /// Up is outside.
        faces_up: bool,
    },
}

/// Where a ray meets a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Meeting {
    /// In lengths of the ray's direction.
    pub t: f32,
    /// The place on the piece.
    pub weights: [f32; 2],
}

/// A ray in object space: `origin + t * direction`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Finite.
    pub origin: Vec3,
    /// Of any length but zero.
    pub direction: Vec3,
    /// t is more than this.
    pub near: f32,
    /// Greatest t.
    pub far: f32,
    /// Whether it ends at t = 1 in a place of the piece that it is tested against, which does not count.
    pub ends_here: bool,
}

/// By how much pieces overlap at rims, as a share of their size: no ray passes between a side and its cap.
pub const RIM: f64 = 1e-12;

impl Piece {
    /// At a height.
    pub fn squared_radius(&self, y: f64) -> f64 {
        let [a, b, c] = self.profile;
        (a * y + b) * y + c
    }

    /// Heights and radii of two circles whose hull holds the piece.
    pub fn circles(&self) -> [(f64, f64); 2] {
        let radii = self.range.map(|y| self.squared_radius(y).max(0.0).sqrt());
        // the radius of a belt is greatest at an end of each part, and no greater than a cone's between
        let widest = radii[0].max(radii[1]);
        let is_within_cone = self.kind == Kind::Belt;
        let radius = |end: usize| if is_within_cone { radii[end] } else { widest };
        [(self.range[0], radius(0)), (self.range[1], radius(1))]
    }

    /// The place with these weights.
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

    /// What is zero on the quadric, and its gradient, at a point that is as high as the piece; none for disks, which are flat.
    pub fn implicit(&self, point: DVec3) -> Option<(f64, DVec3)> {
        let is_beside = (self.range[0]..=self.range[1]).contains(&point.y);
        if !is_beside || matches!(self.kind, Kind::Disk { .. }) {
            return None;
        }
        let [a, b, _] = self.profile;
        let value = point.x * point.x + point.z * point.z - self.squared_radius(point.y);
        Some((value, 2.0 * DVec3::new(point.x, -(a * point.y + 0.5 * b), point.z)))
    }

    /// Outwards, of any length, at a point of the piece.
    pub fn normal(&self, point: DVec3) -> DVec3 {
        if let Kind::Disk { faces_up } = self.kind {
            return if faces_up { DVec3::Y } else { DVec3::NEG_Y };
        }
        let [a, b, _] = self.profile;
        let gradient = DVec3::new(point.x, -(a * point.y + 0.5 * b), point.z);
        let is_above = point.y > 0.5 * (self.range[0] + self.range[1]);
        // a cone's tip has none
        gradient.try_normalize().unwrap_or(if is_above { DVec3::Y } else { DVec3::NEG_Y })
    }
}

/// Sine and cosine of an angle as a number from -2 to 2: how far it is along a square that stands on its corner.
fn from_diamond(angle: f64) -> (f64, f64) {
    let x = 1.0 - angle.abs();
    let z = (1.0 - x.abs()).copysign(angle);
    let length = (x * x + z * z).sqrt();
    (z / length, x / length)
}
