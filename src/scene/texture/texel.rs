//! One texel, as it is stored.

use std::sync::LazyLock;

use glam::Vec4;
use half::f16;

use super::{linear, linear_share};

/// A texel as it is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Texel {
    /// See [`Texels::Bytes`](super::Texels::Bytes).
    Bytes([u8; 4]),
    /// See [`Texels::Halves`](super::Texels::Halves).
    Halves([f16; 4]),
}

impl Texel {
    /// Values as bytes, without another encoding: half floats from 0 to 1 become bytes from 0 to 255.
    pub fn bytes(self) -> [u8; 4] {
        match self {
            Self::Bytes(bytes) => bytes,
            // a cast of NaN is 0
            Self::Halves(values) => values.map(|value| byte(value.to_f32().clamp(0.0, 1.0))),
        }
    }

    /// Colour as sRGB-encoded bytes; what is brighter than 1 is cut. Bytes stay as they are.
    pub fn srgb(self) -> [u8; 4] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Halves(values) => {
                let [r, g, b, a] = values.map(f16::to_f32);
                srgb_texel([r, g, b, a.clamp(0.0, 1.0)])
            }
        }
    }

    /// Values as they are stored; bytes from 0 to 255 are values from 0 to 1.
    #[inline]
    pub fn numbers(self) -> Vec4 {
        match self {
            Self::Bytes(bytes) => Vec4::from(bytes.map(f32::from)) / 255.0,
            Self::Halves(values) => Vec4::from(values.map(f16::to_f32)),
        }
    }

    /// Linear colour, and alpha.
    #[inline]
    pub fn color(self) -> Vec4 {
        match self {
            Self::Bytes([r, g, b, a]) => Vec4::new(linear(r), linear(g), linear(b), f32::from(a) / 255.0),
            Self::Halves(_) => self.numbers(),
        }
    }

    /// Alpha, 0 to 255.
    #[inline]
    pub fn alpha(self) -> f32 {
        match self {
            Self::Bytes([.., a]) => f32::from(a),
            Self::Halves([.., a]) => a.to_f32() * 255.0,
        }
    }
}

/// Nearest byte to a value from 0 to 1.
pub(super) fn byte(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// Nearest sRGB byte to each linear value, in steps.
static SRGB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let middles: Vec<f32> = (0..255).map(|byte| linear_share((f64::from(byte) + 0.5) / 255.0)).collect();
    let byte = |step: usize| middles.partition_point(|middle| *middle <= step as f32 / STEPS) as u8;
    (0..=STEPS as usize).map(byte).collect()
});

/// Number of steps from black to white: more than a hundred within the darkest byte.
const STEPS: f32 = 65535.0;

/// Nearest bytes to a linear colour and its alpha.
pub(super) fn srgb_texel([r, g, b, a]: [f32; 4]) -> [u8; 4] {
    [srgb_byte(r), srgb_byte(g), srgb_byte(b), byte(a)]
}

/// Nearest sRGB byte to a linear value; what is above 1 is cut.
fn srgb_byte(linear: f32) -> u8 {
    SRGB[(linear.clamp(0.0, 1.0) * STEPS + 0.5) as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        assert!((0..=255).all(|byte| srgb_byte(linear(byte)) == byte));
        assert_eq!([srgb_byte(-1.0), srgb_byte(7.0), srgb_byte(f32::NAN)], [0, 255, 0]);
    }
}
