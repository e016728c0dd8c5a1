//! Pictures on surfaces.

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use glam::{Mat2, Vec2, Vec3};

/// A picture: colours for `map_Kd`, and opacity in its alpha.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Path of the picture, for messages.
    pub path: PathBuf,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Rows from the top, sRGB-encoded RGBA bytes; shared by all textures made of the same file.
    pub texels: Arc<[[u8; 4]]>,
    /// Where on it texture coordinates lie.
    pub mapping: Mapping,
}

/// From the texture coordinates of a surface to places of a picture, and what is beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapping {
    /// Map of u and v, v upwards: scales (`-s`), turns and mirrors.
    pub linear: Mat2,
    /// Added to u and v then (`-o`).
    pub offset: Vec2,
    /// Beyond the edges across, and beyond those up and down.
    pub wrap: [Wrap; 2],
}

/// Way in which a picture goes on beyond an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum Wrap {
    /// The whole repeats.
    #[default]
    Repeat,
    /// The texels of the edge go on (`-clamp on`).
    Clamp,
    /// The whole repeats, every other time mirrored.
    Mirror,
}

impl Default for Mapping {
    fn default() -> Self {
        Self { linear: Mat2::IDENTITY, offset: Vec2::ZERO, wrap: [Wrap::Repeat; 2] }
    }
}

impl Mapping {
    /// Creates a mapping that scales u and v by themselves.
    pub fn scaled(scale: Vec2, offset: Vec2, wrap: [Wrap; 2]) -> Self {
        Self { linear: Mat2::from_diagonal(scale), offset, wrap }
    }

    /// Place in the picture of texture coordinates, v upwards; beyond 0 and 1 it wraps.
    #[inline]
    pub fn at(&self, uv: Vec2) -> Vec2 {
        self.linear * uv + self.offset
    }

    /// Texture coordinates of a place in the picture: not finite where the picture is scaled to nothing.
    pub fn uv_of(&self, place: Vec2) -> Vec2 {
        self.linear.inverse() * (place - self.offset)
    }
}

/// Linear value of each sRGB byte, by IEC 61966-2-1.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_share(byte as f64 / 255.0)));

/// Linear value of an sRGB value from 0 to 1.
pub(crate) fn linear_share(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// Linear value of an sRGB byte.
pub(crate) fn linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

impl Texture {
    /// Linear RGB at `uv` (v upwards), bilinear between texel centres. Finite for any `uv`.
    ///
    /// Full resolution at any distance: a filter that follows the distance would make a sample's
    /// colour depend on the eye, and it could not be kept from frame to frame. Anti-aliasing is the
    /// work of the samples of a pixel.
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        let Between { texels: [a, b, c, d], shares: [fx, fy] } = self.between(uv);
        let above = self.linear(a).lerp(self.linear(b), fx);
        let below = self.linear(c).lerp(self.linear(d), fx);
        above.lerp(below, fy)
    }

    /// Vector in a picture of vectors, at `uv` (v upwards): bytes from 0 to 255 are components from -1 to 1.
    /// Bilinear between texel centres, of any length up to that of a diagonal. Finite for any `uv`.
    pub fn vector(&self, uv: Vec2) -> Vec3 {
        let Between { texels, shares: [fx, fy] } = self.between(uv);
        let value = |texel: usize| {
            let [x, y, z, _] = self.texels[texel].map(f32::from);
            Vec3::new(x, y, z)
        };
        let [a, b, c, d] = texels.map(value);
        a.lerp(b, fx).lerp(c.lerp(d, fx), fy) * (2.0 / 255.0) - 1.0
    }

    /// Place of the picture's texels on surfaces.
    pub fn placement(&self) -> Placement {
        let Self { width, height, mapping, .. } = *self;
        Placement { width, height, mapping }
    }

    /// Finds the texels between whose centres `uv` (v upwards) lies.
    #[inline]
    pub fn between(&self, uv: Vec2) -> Between {
        self.placement().between(uv)
    }

    /// Alpha at a place between four texels, 0 to 1, bilinear.
    pub fn alpha_between(&self, between: &Between) -> f32 {
        let [a, b, c, d] = between.texels.map(|texel| f32::from(self.texels[texel][3]));
        let [fx, fy] = between.shares;
        let (above, below) = (a + (b - a) * fx, c + (d - c) * fx);
        (above + (below - above) * fy) / 255.0
    }

    fn linear(&self, texel: usize) -> Vec3 {
        linear_color(self.texels[texel])
    }
}

/// Linear RGB of a texel.
pub(crate) fn linear_color([r, g, b, _]: [u8; 4]) -> Vec3 {
    let table = &*LINEAR;
    Vec3::new(table[r as usize], table[g as usize], table[b as usize])
}

/// Place of a picture's texels on surfaces: see [`Texture`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Where on them texture coordinates lie.
    pub mapping: Mapping,
}

impl Placement {
    /// Finds the texels between whose centres `uv` (v upwards) lies.
    #[inline]
    pub fn between(&self, uv: Vec2) -> Between {
        let uv = self.mapping.at(uv);
        let [across, down] = self.mapping.wrap;
        let (x0, x1, fx) = neighbours(uv.x, self.width, across);
        let (y0, y1, fy) = neighbours(1.0 - uv.y, self.height, down);
        let index = |x: u32, y: u32| y as usize * self.width as usize + x as usize;
        Between { texels: [index(x0, y0), index(x1, y0), index(x0, y1), index(x1, y1)], shares: [fx, fy] }
    }
}

/// Finds the two texels between whose centres `t` (0..1 over the picture) lies, and the position between
/// them, 0..1.
fn neighbours(t: f32, size: u32, wrap: Wrap) -> (u32, u32, f32) {
    let t = match (t.is_finite(), wrap) {
        (false, _) => 0.0,
        (true, Wrap::Clamp) => t.clamp(0.0, 1.0),
        (true, Wrap::Repeat) => t - t.floor(),
        (true, Wrap::Mirror) => {
            let twice = (t * 0.5 - (t * 0.5).floor()) * 2.0;
            1.0 - (1.0 - twice).abs()
        }
    };
    let at = t * size as f32 - 0.5;
    let low = at.floor();
    let fraction = at - low;
    let last = size - 1;
    // low is -1..=last: the cast stops at 0
    let first = if low >= 0.0 { (low as u32).min(last) } else { u32::MAX };
    let second = first.wrapping_add(1);
    if wrap == Wrap::Repeat {
        (first.min(last), if second > last { 0 } else { second }, fraction)
    } else {
        (if first == u32::MAX { 0 } else { first }, second.min(last), fraction)
    }
}

/// A place between the centres of four texels.
#[derive(Debug, Clone, Copy)]
pub struct Between {
    /// Indices of the texels: left and right above, left and right below.
    texels: [usize; 4],
    /// Shares of the way to the right, and down; 0 to 1.
    shares: [f32; 2],
}

impl Between {
    /// Index of the texel to the left above.
    pub fn first(&self) -> usize {
        self.texels[0]
    }

    /// Index of one of the texels, each as likely as interpolation weighs it: by two numbers below 1 and not
    /// below 0. The mean over all numbers is the interpolated value (Fajardo, Wronski, Salvi and Pharr, "Stochastic
    /// Texture Filtering", 2023).
    #[inline]
    pub fn chosen(&self, [across, down]: [f32; 2]) -> usize {
        let [right, below] = self.shares;
        self.texels[usize::from(across < right) + 2 * usize::from(down < below)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 x 2: red, green over blue, white.
    fn texture(wrap: Wrap) -> Texture {
        let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
        Texture {
            path: PathBuf::new(),
            width: 2,
            height: 2,
            texels: Arc::from(texels),
            mapping: Mapping { wrap: [wrap; 2], ..Mapping::default() },
        }
    }

    #[test]
    fn the_table_follows_the_standard() {
        assert_eq!((LINEAR[0], LINEAR[255]), (0.0, 1.0));
        assert!((LINEAR[10] - 10.0 / 255.0 / 12.92).abs() < 1e-7);
        assert!((LINEAR[188] - 0.502_886_5).abs() < 1e-6, "{}", LINEAR[188]);
        assert!(LINEAR.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn texel_centres_give_the_texel_with_v_upwards() {
        let picture = texture(Wrap::Repeat);
        assert_eq!(picture.sample(Vec2::new(0.25, 0.75)), Vec3::X);
        assert_eq!(picture.sample(Vec2::new(0.75, 0.75)), Vec3::Y);
        assert_eq!(picture.sample(Vec2::new(0.25, 0.25)), Vec3::Z);
        assert_eq!(picture.sample(Vec2::new(0.75, 0.25)), Vec3::ONE);
    }

    #[test]
    fn blends_in_linear_light() {
        assert_eq!(texture(Wrap::Repeat).sample(Vec2::new(0.5, 0.5)), Vec3::splat(0.5));
        assert_eq!(texture(Wrap::Repeat).sample(Vec2::new(0.5, 0.75)), Vec3::new(0.5, 0.5, 0.0));
    }

    #[test]
    fn repeats_or_clamps_at_the_border() {
        let corner = Vec2::new(0.0, 1.0);
        assert_eq!(texture(Wrap::Clamp).sample(corner), Vec3::X);
        assert_eq!(texture(Wrap::Repeat).sample(corner), Vec3::splat(0.5));
        assert_eq!(texture(Wrap::Clamp).sample(Vec2::new(-7.0, 9.0)), Vec3::X);
        assert_eq!(texture(Wrap::Repeat).sample(Vec2::new(-0.75, 3.75)), Vec3::X);
    }

    #[test]
    fn every_other_picture_is_mirrored() {
        let picture = texture(Wrap::Mirror);
        for (u, same) in [(1.25, 0.75), (-0.25, 0.25), (2.25, 0.25), (-1.75, 0.25), (3.5, 0.5)] {
            for v in [0.25, 0.6] {
                assert_eq!(picture.sample(Vec2::new(u, v)), picture.sample(Vec2::new(same, v)), "{u}");
                assert_eq!(picture.sample(Vec2::new(v, u)), picture.sample(Vec2::new(v, same)), "{u}");
            }
        }
        // at an edge a texel meets itself
        assert_eq!(picture.sample(Vec2::new(0.0, 1.0)), Vec3::X);
    }

    #[test]
    fn each_direction_wraps_by_itself() {
        let mapping = Mapping { wrap: [Wrap::Repeat, Wrap::Clamp], ..Mapping::default() };
        let picture = Texture { mapping, ..texture(Wrap::Repeat) };
        assert_eq!(picture.sample(Vec2::new(1.25, 1.75)), Vec3::X);
        assert_eq!(picture.sample(Vec2::new(1.25, -1.75)), Vec3::Z);
    }

    #[test]
    fn places_have_the_coordinates_that_lie_there() {
        let linear = Mat2::from_cols(Vec2::new(0.5, 2.0), Vec2::new(-3.0, 1.0));
        let mapping = Mapping { linear, offset: Vec2::new(0.25, -1.0), ..Mapping::default() };
        let uv = Vec2::new(0.75, -0.5);
        assert!(mapping.uv_of(mapping.at(uv)).distance(uv) < 1e-6);
    }

    #[test]
    fn scale_comes_before_offset() {
        let mapping = Mapping::scaled(Vec2::new(2.0, 1.0), Vec2::new(0.25, 0.75), [Wrap::Repeat; 2]);
        let picture = Texture { mapping, ..texture(Wrap::Repeat) };
        assert_eq!(picture.sample(Vec2::new(0.25, 0.0)), Vec3::Y);
    }

    #[test]
    fn any_coordinate_gives_a_finite_colour() {
        let odd = [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN, -1e-9, 1e-45, 0.999_999_94];
        for picture in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(texture) {
            for (u, v) in odd.iter().flat_map(|u| odd.iter().map(move |v| (*u, *v))) {
                let color = picture.sample(Vec2::new(u, v));
                assert!(color.is_finite() && color.max_element() <= 1.0, "{u} {v}: {color}");
            }
        }
    }
}
