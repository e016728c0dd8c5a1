//! Pictures on surfaces.

use std::path::PathBuf;

use glam::{Vec2, Vec3};

/// A picture for `map_Kd`, as 8-bit sRGB texels.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// For messages.
    pub path: PathBuf,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Rows from the top, sRGB-encoded RGBA bytes.
    pub texels: Vec<[u8; 4]>,
    /// `-s`: factor on u and v.
    pub scale: Vec2,
    /// `-o`: added to u and v after the factor.
    pub offset: Vec2,
    /// `-clamp on`: the border's texels go on outside 0..1 instead of the whole repeating.
    pub clamp: bool,
}

impl Texture {
    /// Linear RGB at `uv` (v upwards), bilinear between texel centres.
    ///
    /// Full resolution at any distance: a filter that follows the distance would make a sample's
    /// colour depend on the eye, and it could not be kept from frame to frame. Anti-aliasing is the
    /// work of the samples of a pixel.
    pub fn sample(&self, _uv: Vec2) -> Vec3 {
        todo!()
    }
}
