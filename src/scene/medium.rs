//! What fills a closed mesh, or everything: fog, smoke, tinted water.

use glam::Vec3;

/// Largest coefficient: beyond it all light ends within any length at all.
const LARGEST: f32 = 1e18;

/// A medium that is the same everywhere: what becomes of light for each unit of length, space of the shot's files.
///
/// Where media overlap, or a mesh overlaps itself, their coefficients add up, as in Cycles: there is no order among them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Share of light that is scattered. Linear RGB, as all here.
    pub scatter: Vec3,
    /// Share that is absorbed.
    pub absorb: Vec3,
    /// Radiance that it emits.
    pub emit: Vec3,
    /// Where light is scattered to: mean cosine of the angle by which it is turned, from -1 (back) to 1 (straight on). Henyey and
    /// Greenstein, "Diffuse radiation in the Galaxy", 1941.
    pub anisotropy: f32,
}

impl Medium {
    /// Nothing.
    pub const NONE: Self =
        Self { scatter: Vec3::ZERO, absorb: Vec3::ZERO, emit: Vec3::ZERO, anisotropy: 0.0 };

    /// Share of light that does not go straight on.
    pub fn extinction(&self) -> Vec3 {
        self.scatter + self.absorb
    }

    /// Returns true if it does nothing to light.
    pub fn is_clear(&self) -> bool {
        self.extinction() == Vec3::ZERO && self.emit == Vec3::ZERO
    }

    /// The same without what is negative, no number, or beyond what can be kept.
    #[must_use]
    pub fn cleaned(self) -> Self {
        let clean = |value: f32| if value > 0.0 { value.min(LARGEST) } else { 0.0 };
        let of = |color: Vec3| Vec3::from_array(color.to_array().map(clean));
        let anisotropy = if self.anisotropy.is_finite() { self.anisotropy } else { 0.0 };
        Self { scatter: of(self.scatter), absorb: of(self.absorb), emit: of(self.emit), anisotropy }
    }

    /// The same in a space where lengths are `scale` times as large.
    #[must_use]
    pub fn scaled(self, scale: f32) -> Self {
        Self {
            scatter: self.scatter / scale,
            absorb: self.absorb / scale,
            emit: self.emit / scale,
            anisotropy: self.anisotropy,
        }
    }
}
