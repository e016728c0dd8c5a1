//! Unit vectors in four bytes.

use glam::Vec3;

/// A unit vector, folded onto an octahedron and flattened to a square of 65535 x 65535 steps: wrong by
/// less than 7e-5 radians (Cigolle et al., "A Survey of Efficient Representations for Independent Unit
/// Vectors", JCGT 2014, `oct32`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Octahedral(u32);

/// Steps from the centre of the square to its edge.
const STEPS: f32 = 32767.0;

impl Octahedral {
    /// Folds `unit`. A vector of zero length becomes +Z.
    pub fn fold(unit: Vec3) -> Self {
        let length = unit.x.abs() + unit.y.abs() + unit.z.abs();
        if length == 0.0 {
            return Self::fold(Vec3::Z);
        }
        let (mut x, mut y) = (unit.x / length, unit.y / length);
        if unit.z < 0.0 {
            (x, y) = ((1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y));
        }
        let step = |value: f32| ((value * STEPS).round() as i16) as u16 as u32;
        Self(step(x) | step(y) << 16)
    }

    /// The vector, of unit length.
    #[inline]
    pub fn unfold(self) -> Vec3 {
        let part = |bits: u32| f32::from(bits as u16 as i16) / STEPS;
        let (x, y) = (part(self.0), part(self.0 >> 16));
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_within_the_stated_angle() {
        let mut worst = 0.0_f32;
        for i in 0..20_000 {
            // a spiral over the sphere, both poles included
            let z = 1.0 - 2.0 * i as f32 / 19_999.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - z * z).max(0.0).sqrt();
            let unit = Vec3::new(ring * cos, ring * sin, z).normalize();
            worst = worst.max(unit.cross(Octahedral::fold(unit).unfold()).length());
        }
        assert!(worst < 7e-5, "{worst}");
    }

    #[test]
    fn axes_are_exact() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert_eq!(Octahedral::fold(axis).unfold(), axis);
        }
    }
}
