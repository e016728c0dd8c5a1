//! The arithmetic of shader nodes, as pure functions: what Blender's nodes of numbers, vectors, and colours make of their inputs.
//!
//! The reference is Cycles, as it renders Blender 5: `beside_blender.csv` holds what it makes of given inputs, and the tests compare.
//! Everything is deterministic, and computed in `f32`.
//!
//! Values come eight at a time, and what a lane gives depends on what is in it alone, to the bit.
//!
//! Finite inputs give finite results. What has no value, such as a division by zero, is 0, as in Blender. Where Cycles itself would
//! make an infinity or NaN, such as the exponential of 100, we give 0. A colour or vector has that for each of its components.
pub mod color;
pub mod curve;
pub mod fresnel;
pub mod hue;
pub mod map_range;
pub mod math;
pub mod mix;
pub mod ramp;
pub mod spectrum;
pub mod vector;
pub mod vector_math;

#[cfg(test)]
mod properties;
#[cfg(test)]
mod tests;

use glam::Vec3;

use crate::lanes::{F32x8, Vec3x8};

/// Defines an enum of what one option of a node can be, each with the identifier that Blender has for it, in small letters.
macro_rules! named {
    ($(#[$about:meta])* $kind:ident { $($(#[$doc:meta])* $variant:ident = $name:literal,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $kind {
            $($(#[$doc])* $variant,)+
        }

        impl $kind {
            /// All of them, in the order of their definition.
            pub const ALL: &[Self] = &[$(Self::$variant,)+];

            /// The one with Blender's identifier in small letters; `None` for any other name.
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($name => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// Blender's identifier, in small letters.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}
use named;

/// The number, or 0 where it is infinite or NaN.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// The vector, with 0 for each component that is infinite or NaN.
fn finite_vector(value: Vec3) -> Vec3 {
    Vec3::from_array(value.to_array().map(finite))
}

/// A quotient: 0 where the divisor is 0.
#[inline(always)]
fn divided(dividend: F32x8, divisor: F32x8) -> F32x8 {
    divisor.is_zero().select(F32x8::ZERO, dividend / divisor)
}

/// A power: 1 for any base to the power of 0, and 0 for a negative base and an exponent that is no whole number.
fn power(base: F32x8, exponent: F32x8) -> F32x8 {
    base.each_with(exponent, |base, exponent| {
        if exponent == 0.0 {
            1.0
        } else if base == 0.0 || (base < 0.0 && exponent.trunc() != exponent) {
            0.0
        } else {
            base.powf(exponent)
        }
    })
}

/// -1, 0 or 1.
#[inline(always)]
fn sign(value: F32x8) -> F32x8 {
    let below = value.lt(F32x8::ZERO).select(-F32x8::ONE, F32x8::ZERO);
    value.gt(F32x8::ZERO).select(F32x8::ONE, below)
}

/// The vector at length 1. One without a length is given back as it is.
#[inline(always)]
fn normalized(vector: Vec3x8) -> Vec3x8 {
    let length = vector.length();
    length.is_zero().select3(vector, vector * (F32x8::ONE / length))
}

/// What a number exceeds the whole number below it by.
#[inline(always)]
fn fraction(value: F32x8) -> F32x8 {
    value - value.floor()
}

/// 1 less the number.
#[inline(always)]
fn rest_of(value: F32x8) -> F32x8 {
    F32x8::ONE - value
}
