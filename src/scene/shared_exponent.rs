//! Colours of three numbers with one exponent: four bytes for any brightness.
//!
//! The format is that of `EXT_texture_shared_exponent` of OpenGL: nine bits for each channel, five for the exponent of all of them. The
//! brightest channel has an error of a five-hundredth at most, and the largest number is 65,408.

use glam::Vec3;

/// A colour, linear RGB; no channel is below 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SharedExponent([u8; 4]);

/// Bits of a channel.
const BITS: u32 = 9;
/// Exponent that is kept as 0, of the place before the first bit of a channel.
const LEAST_EXPONENT: i32 = -15;
/// The largest number: all bits are set.
const LARGEST: f32 = 511.0 * 128.0;

impl SharedExponent {
    /// White: 256 units of a 256th.
    pub const ONE: Self = Self((256 | 256 << BITS | 256 << (2 * BITS) | 16_u32 << (3 * BITS)).to_le_bytes());

    /// Rounds a colour. What is no number, and below 0, becomes 0.
    pub fn new(color: Vec3) -> Self {
        // in this order a NaN becomes 0
        let [r, g, b] = color.to_array().map(|channel| 0.0_f32.max(channel).min(LARGEST));
        let most = r.max(g).max(b);
        // exponent of the largest channel, one more than that of its first bit
        let own = (most.to_bits() >> 23) as i32 - 127 + 1;
        let mut exponent = own.max(LEAST_EXPONENT);
        if (most / unit(exponent)).round() >= (1 << BITS) as f32 {
            exponent += 1;
        }
        let channel = |value: f32| (value / unit(exponent)).round() as u32;
        let kept = (exponent - LEAST_EXPONENT) as u32;
        let bits = channel(r) | channel(g) << BITS | channel(b) << (2 * BITS) | kept << (3 * BITS);
        Self(bits.to_le_bytes())
    }

    /// The colour.
    #[inline]
    pub fn color(self) -> Vec3 {
        let bits = u32::from_le_bytes(self.0);
        let unit = unit((bits >> (3 * BITS)) as i32 + LEAST_EXPONENT);
        let channel = |number: u32| (bits >> (number * BITS) & ((1 << BITS) - 1)) as f32 * unit;
        Vec3::new(channel(0), channel(1), channel(2))
    }

    /// Its bytes, any four of which are a colour.
    pub fn to_bytes(self) -> [u8; 4] {
        self.0
    }

    /// The colour of these bytes.
    pub fn from_bytes(bytes: [u8; 4]) -> Self {
        Self(bytes)
    }
}

/// Value of a channel's last bit: a power of two.
#[inline]
fn unit(exponent: i32) -> f32 {
    f32::from_bits(((exponent - BITS as i32 + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_one() {
        assert_eq!(
            (SharedExponent::ONE.color(), SharedExponent::new(Vec3::ONE)),
            (Vec3::ONE, SharedExponent::ONE)
        );
    }

    #[test]
    fn the_brightest_channel_is_kept_to_a_five_hundredth() {
        for step in 0..4000 {
            let most = 2_f32.powf(step as f32 * 0.0077 - 14.8);
            let color = Vec3::new(0.3 * most, most, 0.001 * most);
            let kept = SharedExponent::new(color).color();
            assert!((kept - color).abs().max_element() <= most * 0.002, "{color}: {kept}");
            assert_eq!(SharedExponent::new(kept).color(), kept, "rounded twice");
        }
    }

    #[test]
    fn what_is_no_light_is_black() {
        for (color, kept) in [
            ([0.0; 3], [0.0; 3]),
            ([f32::NAN, -1.0, 2.0], [0.0, 0.0, 2.0]),
            ([f32::INFINITY, 0.0, 0.0], [LARGEST, 0.0, 0.0]),
            ([1e-30, 0.0, 0.0], [0.0; 3]),
        ] {
            assert_eq!(SharedExponent::new(Vec3::from(color)).color(), Vec3::from(kept), "{color:?}");
        }
    }
}
