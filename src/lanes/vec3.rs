//! Eight vectors.

use std::ops::{Add, Div, Mul, Neg, Sub};

use glam::Vec3;
use wide::{CmpEq, f32x8};

use super::{F32x8, Mask};

/// Eight vectors, or eight colours.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(missing_docs, reason = "coordinates")]
pub struct Vec3x8 {
    pub x: F32x8,
    pub y: F32x8,
    pub z: F32x8,
}

impl From<[F32x8; 3]> for Vec3x8 {
    #[inline(always)]
    fn from([x, y, z]: [F32x8; 3]) -> Self {
        Self { x, y, z }
    }
}

impl From<Vec3x8> for [F32x8; 3] {
    #[inline(always)]
    fn from(Vec3x8 { x, y, z }: Vec3x8) -> Self {
        [x, y, z]
    }
}

impl Vec3x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self { x: F32x8::ZERO, y: F32x8::ZERO, z: F32x8::ZERO };

    /// Sets all lanes to the same vector.
    #[inline(always)]
    pub fn splat(value: Vec3) -> Self {
        Self { x: F32x8::splat(value.x), y: F32x8::splat(value.y), z: F32x8::splat(value.z) }
    }

    /// Loads eight vectors from columns of coordinates, from `first` on.
    #[inline(always)]
    pub fn load([x, y, z]: [&[f32]; 3], first: usize) -> Self {
        Self { x: F32x8::load(x, first), y: F32x8::load(y, first), z: F32x8::load(z, first) }
    }

    /// Writes the eight vectors to columns of coordinates, from `first` on.
    #[inline(always)]
    pub fn store(self, [x, y, z]: [&mut [f32]; 3], first: usize) {
        self.x.store(x, first);
        self.y.store(y, first);
        self.z.store(z, first);
    }

    /// Vector of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x.lane(lane), self.y.lane(lane), self.z.lane(lane))
    }

    /// Sets the vector of one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, lane: usize, value: Vec3) {
        let axes = [&mut self.x, &mut self.y, &mut self.z];
        axes.into_iter().zip(value.to_array()).for_each(|(axis, value)| axis.set_lane(lane, value));
    }

    /// Scalar products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> F32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Smaller of each two coordinates.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self { x: self.x.min(other.x), y: self.y.min(other.y), z: self.z.min(other.z) }
    }

    /// Greater of each two coordinates.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { x: self.x.max(other.x), y: self.y.max(other.y), z: self.z.max(other.z) }
    }

    /// Scales to unit length. NaN where there is no length.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * (F32x8::splat(1.0) / self.dot(self).sqrt())
    }

    /// The same vector of three equal coordinates in each lane.
    #[inline(always)]
    pub fn all_of(value: F32x8) -> Self {
        Self { x: value, y: value, z: value }
    }

    /// A function of each coordinate.
    #[inline(always)]
    pub fn each(self, of: impl Fn(F32x8) -> F32x8) -> Self {
        Self { x: of(self.x), y: of(self.y), z: of(self.z) }
    }

    /// A function of each coordinate of two vectors.
    #[inline(always)]
    pub fn each_with(self, other: Self, of: impl Fn(F32x8, F32x8) -> F32x8) -> Self {
        Self { x: of(self.x, other.x), y: of(self.y, other.y), z: of(self.z, other.z) }
    }

    /// The vectors, with 0 for coordinates that are infinite or NaN.
    #[inline(always)]
    pub fn finite_or_zero(self) -> Self {
        self.each(F32x8::finite_or_zero)
    }

    /// Lengths.
    #[inline(always)]
    pub fn length(self) -> F32x8 {
        self.dot(self).sqrt()
    }

    /// Greatest coordinates.
    #[inline(always)]
    pub fn max_element(self) -> F32x8 {
        self.x.max(self.y).max(self.z)
    }

    /// Smallest coordinates.
    #[inline(always)]
    pub fn min_element(self) -> F32x8 {
        self.x.min(self.y).min(self.z)
    }

    /// True where any coordinate is not zero.
    #[inline(always)]
    pub fn is_some(self) -> Mask {
        // compared so that a NaN gives true on every processor
        let differs = |a: F32x8| !Mask(a.0.cmp_eq(f32x8::ZERO));
        differs(self.x) | differs(self.y) | differs(self.z)
    }
}

macro_rules! lane_by_lane {
    ($($op:ident $name:ident $sign:tt),+) => {$(
        impl $op for Vec3x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self { x: self.x $sign other.x, y: self.y $sign other.y, z: self.z $sign other.z }
            }
        }
        impl $op<f32> for Vec3x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: f32) -> Self {
                self $sign F32x8::splat(other)
            }
        }
        impl $op<F32x8> for Vec3x8 {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: F32x8) -> Self {
                Self { x: self.x $sign other, y: self.y $sign other, z: self.z $sign other }
            }
        }
    )+};
}
lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl Mask {
    /// Selects `yes` where the lane is true, `no` elsewhere.
    #[inline(always)]
    pub fn select3(self, yes: Vec3x8, no: Vec3x8) -> Vec3x8 {
        Vec3x8 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_those_of_each_lane() {
        let (a, b) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.5, 4.0, -1.0));
        let (x, y) = (Vec3x8::splat(a), Vec3x8::splat(b));
        assert_eq!(x.cross(y).lane(5), a.cross(b));
        assert_eq!(x.dot(y).lane(2), a.dot(b));
        assert!((x.normalize().lane(0) - a.normalize()).length() < 1e-6);
    }
}
