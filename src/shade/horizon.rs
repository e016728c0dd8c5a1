//! The horizon of the curved surface that a triangle whose corners have normals stands for: what is above it may send light there. See
//! [`terminator`](super::terminator).

use glam::Vec3;

use crate::lanes::{F32x8, Vec3x8};

/// The curved surface that a triangle stands for, at one of its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Horizon {
    /// Its normal, not bent by a normal map; unit length, on the side from which the point is seen.
    pub normal: Vec3,
    /// Way from the point to it; zero where the point is on it or above.
    pub lift: Vec3,
    /// True if a normal map may bend the shading normal away from its normal.
    pub is_bent: bool,
    /// True of a fibre, which light reaches from all around: rays start within it.
    pub is_fibre: bool,
}

impl Horizon {
    /// A surface that is as flat as the triangle, or is not told from it, with this normal.
    pub fn flat(normal: Vec3) -> Self {
        Self { normal, lift: Vec3::ZERO, is_bent: false, is_fibre: false }
    }

    /// Returns true if light may arrive from `direction`, and not from within: `geometric_normal` is that of the triangle.
    #[inline(always)]
    pub fn is_below(&self, direction: Vec3, geometric_normal: Vec3) -> bool {
        let is_above = geometric_normal.dot(direction) > 0.0 || self.lift != Vec3::ZERO;
        is_above && self.normal.dot(direction) > 0.0 || self.is_fibre
    }

    /// Origin of a ray to a direction that it [is below](Self::is_below); `origin` is off the triangle.
    #[inline(always)]
    pub fn origin(&self, origin: Vec3, direction: Vec3, geometric_normal: Vec3) -> Vec3 {
        if geometric_normal.dot(direction) > 0.0 && !self.is_fibre { origin } else { origin + self.lift }
    }

    /// Share of diffuse light from a direction that a surface with this shading `normal` shows: see [`fading`].
    #[inline(always)]
    pub fn fading(&self, normal: Vec3, direction: Vec3) -> f32 {
        if !self.is_bent {
            return 1.0;
        }
        let [normal, smooth, direction] = [normal, self.normal, direction].map(Vec3x8::splat);
        fading(normal, smooth, direction).lane(0)
    }
}

/// Shares of diffuse light from `directions` that surfaces with these shading normals show, where the curved surface has `smooth`
/// normals: g + g² - g³, where g = (s·d) / ((n·d) (s·n)), and 1 if g is larger (Chiang, Li and Burley, "Taming the Shadow Terminator",
/// SIGGRAPH 2019 Talks).
#[inline(always)]
pub fn fading(normal: Vec3x8, smooth: Vec3x8, direction: Vec3x8) -> F32x8 {
    let share = smooth.dot(direction) / (normal.dot(direction) * smooth.dot(normal));
    // in this order a NaN becomes 0
    let share = share.max(F32x8::ZERO).min(F32x8::ONE);
    share + share * share - share * share * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bent_normals_fade_towards_the_horizon_and_not_where_they_turn_away() {
        let (smooth, at) = (Vec3::Y, |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Vec3::new(sin, cos, 0.0)
        });
        let horizon = Horizon { is_bent: true, ..Horizon::flat(smooth) };
        let bent = at(40.0);
        let shares = [0.0, 30.0, 60.0, 80.0, 89.0].map(|degrees| horizon.fading(bent, at(degrees)));
        assert!(shares[0] > 0.99 && shares.is_sorted_by(|a, b| a >= b), "{shares:?}");
        assert!(shares[4] < 0.05 && horizon.fading(bent, at(91.0)) == 0.0, "{shares:?}");
        assert_eq!(horizon.fading(bent, at(-30.0)), 1.0, "away from the light nothing is lost");
        assert_eq!(
            Horizon::flat(smooth).fading(smooth, at(91.0)),
            1.0,
            "without a map the cosine does it all"
        );
    }
}
