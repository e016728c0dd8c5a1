//! Pictures on surfaces.

mod image;
mod mapping;
mod pages;
mod texel;

use std::path::PathBuf;
use std::sync::{Arc, LazyLock};

use glam::{Vec2, Vec3};

use crate::logarithm::rough_log2;

pub use image::{Image, Level, Texels, Values};
pub use mapping::{Between, Mapping, Placement, UvSet, Wrap};
pub use pages::{PageCounts, PagedLevel, Pager};
pub use texel::Texel;

/// A picture: colours for `map_Kd`, and opacity in its alpha; or directions of normals.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// Path of the picture, for messages.
    pub path: PathBuf,
    /// The picture; shared by all textures made of the same file.
    pub image: Arc<Image>,
    /// Places of texture coordinates on it.
    pub mapping: Mapping,
}

/// Linear value of each sRGB byte, by IEC 61966-2-1.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_share(byte as f64 / 255.0)));

/// Linear value of an sRGB value from 0 to 1.
pub(crate) fn linear_share(encoded: f64) -> f32 {
    let linear = if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
    linear as f32
}

/// sRGB value of a linear value from 0 to 1.
pub(crate) fn srgb_share(linear: f64) -> f64 {
    if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of each sRGB byte.
#[inline]
fn linear_bytes() -> &'static [f32; 256] {
    &LINEAR
}

/// Linear value of an sRGB byte.
pub(crate) fn linear(byte: u8) -> f32 {
    LINEAR[usize::from(byte)]
}

impl Texture {
    /// Creates a texture of `width` x `height` sRGB-encoded bytes, rows from the top.
    pub fn of_bytes(
        path: PathBuf,
        [width, height]: [u32; 2],
        texels: Arc<[[u8; 4]]>,
        mapping: Mapping,
    ) -> Self {
        let image = Image::new(width, height, Texels::Bytes(texels), Values::Colors);
        Self { path, image: Arc::new(image), mapping }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.image.finest().width, self.image.finest().height]
    }

    /// Texels of the picture.
    pub fn texels(&self) -> &Texels {
        &self.image.finest().texels
    }

    /// Number of the level whose texels have the size of a place on a surface that covers `area` of the texture coordinates' plane; 0
    /// where those of the picture itself are larger than the place.
    #[inline]
    pub fn level_of(&self, area: f32) -> u32 {
        let [width, height] = self.size().map(|edge| edge as f32);
        let level = 0.5 * rough_log2(area * self.mapping.linear.determinant().abs() * width * height);
        // a cast of what is negative is 0
        (level + 0.5) as u32
    }

    /// Linear RGB in a `level` of the picture at `uv` (v upwards), bilinear between texel centres. Finite for any `uv`.
    #[inline]
    pub fn color(&self, uv: Vec2, level: u32) -> Vec3 {
        let (between, texels) = self.between_in(uv, level);
        texels.color_between(&between)
    }

    /// What a `level` of the picture holds at `uv` (v upwards): linear RGB, or the numbers of a picture of numbers. Bilinear between texel
    /// centres. Finite for any `uv`.
    pub fn value(&self, uv: Vec2, level: u32) -> Vec3 {
        let (between, texels) = self.between_in(uv, level);
        match self.image.values() {
            Values::Colors => texels.color_between(&between),
            Values::Numbers => texels.numbers_between(&between),
        }
    }

    /// Vector in a level of a picture of vectors, at `uv` (v upwards): values from 0 to 1 are components from -1 to 1. Bilinear
    /// between texel centres, of any length up to that of a diagonal. Finite for any `uv`.
    pub fn vector(&self, uv: Vec2, level: u32) -> Vec3 {
        let (between, texels) = self.between_in(uv, level);
        texels.numbers_between(&between) * 2.0 - 1.0
    }

    #[inline(always)]
    fn between_in(&self, uv: Vec2, level: u32) -> (Between, &Texels) {
        let level = self.image.level(level as usize);
        let placement = Placement { width: level.width, height: level.height, mapping: self.mapping };
        (placement.between(uv), &level.texels)
    }

    /// Place of the picture's texels on surfaces.
    pub fn placement(&self) -> Placement {
        let [width, height] = self.size();
        Placement { width, height, mapping: self.mapping }
    }

    /// Finds the texels between whose centres `uv` (v upwards) lies.
    #[inline]
    pub fn between(&self, uv: Vec2) -> Between {
        self.placement().between(uv)
    }

    /// Alpha at a place between four texels, 0 to 1, bilinear.
    pub fn alpha_between(&self, between: &Between) -> f32 {
        let [a, b, c, d] = between.texels.map(|texel| self.texels().get(texel).alpha());
        let [fx, fy] = between.shares;
        let (above, below) = (a + (b - a) * fx, c + (d - c) * fx);
        (above + (below - above) * fy) / 255.0
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat2;

    use super::*;

    /// 2 x 2: red, green over blue, white.
    fn texture(wrap: Wrap) -> Texture {
        let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
        let mapping = Mapping { wrap: [wrap; 2], ..Mapping::default() };
        Texture::of_bytes(PathBuf::new(), [2, 2], Arc::from(texels), mapping)
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
        assert_eq!(picture.color(Vec2::new(0.25, 0.75), 0), Vec3::X);
        assert_eq!(picture.color(Vec2::new(0.75, 0.75), 0), Vec3::Y);
        assert_eq!(picture.color(Vec2::new(0.25, 0.25), 0), Vec3::Z);
        assert_eq!(picture.color(Vec2::new(0.75, 0.25), 0), Vec3::ONE);
    }

    #[test]
    fn blends_in_linear_light() {
        assert_eq!(texture(Wrap::Repeat).color(Vec2::new(0.5, 0.5), 0), Vec3::splat(0.5));
        assert_eq!(texture(Wrap::Repeat).color(Vec2::new(0.5, 0.75), 0), Vec3::new(0.5, 0.5, 0.0));
    }

    #[test]
    fn repeats_or_clamps_at_the_border() {
        let corner = Vec2::new(0.0, 1.0);
        assert_eq!(texture(Wrap::Clamp).color(corner, 0), Vec3::X);
        assert_eq!(texture(Wrap::Repeat).color(corner, 0), Vec3::splat(0.5));
        assert_eq!(texture(Wrap::Clamp).color(Vec2::new(-7.0, 9.0), 0), Vec3::X);
        assert_eq!(texture(Wrap::Repeat).color(Vec2::new(-0.75, 3.75), 0), Vec3::X);
    }

    #[test]
    fn every_other_picture_is_mirrored() {
        let picture = texture(Wrap::Mirror);
        for (u, same) in [(1.25, 0.75), (-0.25, 0.25), (2.25, 0.25), (-1.75, 0.25), (3.5, 0.5)] {
            for v in [0.25, 0.6] {
                assert_eq!(picture.color(Vec2::new(u, v), 0), picture.color(Vec2::new(same, v), 0), "{u}");
                assert_eq!(picture.color(Vec2::new(v, u), 0), picture.color(Vec2::new(v, same), 0), "{u}");
            }
        }
        // at an edge a texel meets itself
        assert_eq!(picture.color(Vec2::new(0.0, 1.0), 0), Vec3::X);
    }

    #[test]
    fn texels_are_squares_where_nothing_is_interpolated() {
        let mapping = Mapping { is_nearest: true, ..Mapping::default() };
        let picture = Texture { mapping, ..texture(Wrap::Repeat) };
        for (u, v, expected) in
            [(0.01, 0.99, Vec3::X), (0.49, 0.51, Vec3::X), (0.51, 0.51, Vec3::Y), (0.49, 0.01, Vec3::Z)]
        {
            assert_eq!(picture.color(Vec2::new(u, v), 0), expected, "{u} {v}");
        }
    }

    #[test]
    fn each_direction_wraps_by_itself() {
        let mapping = Mapping { wrap: [Wrap::Repeat, Wrap::Clamp], ..Mapping::default() };
        let picture = Texture { mapping, ..texture(Wrap::Repeat) };
        assert_eq!(picture.color(Vec2::new(1.25, 1.75), 0), Vec3::X);
        assert_eq!(picture.color(Vec2::new(1.25, -1.75), 0), Vec3::Z);
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
        assert_eq!(picture.color(Vec2::new(0.25, 0.0), 0), Vec3::Y);
    }

    #[test]
    fn any_coordinate_gives_a_finite_colour() {
        let odd = [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN, -1e-9, 1e-45, 0.999_999_94];
        for picture in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(texture) {
            for (u, v) in odd.iter().flat_map(|u| odd.iter().map(move |v| (*u, *v))) {
                let color = picture.color(Vec2::new(u, v), 0);
                assert!(color.is_finite() && color.max_element() <= 1.0, "{u} {v}: {color}");
            }
        }
    }

    #[test]
    fn coarser_levels_show_means_of_the_light() {
        let picture = texture(Wrap::Repeat);
        let near = |color: Vec3, mean: f32| (color - mean).abs().max_element() < 0.003;
        assert!(near(picture.color(Vec2::new(0.1, 0.9), 1), 0.5));
        assert!(near(picture.color(Vec2::new(0.1, 0.9), 40), 0.5), "the coarsest one");
        assert_eq!(picture.color(Vec2::new(0.25, 0.75), 0), Vec3::X);
    }

    #[test]
    fn levels_have_texels_of_the_size_of_the_place() {
        let picture = texture(Wrap::Repeat);
        assert_eq!([0.25, 0.6, 1.0, 4.0].map(|area| picture.level_of(area)), [0, 1, 1, 2]);
        let mapping = Mapping::scaled(Vec2::splat(4.0), Vec2::ZERO, [Wrap::Repeat; 2]);
        assert_eq!(Texture { mapping, ..picture }.level_of(0.25), 2);
        assert_eq!(texture(Wrap::Repeat).level_of(0.0), 0);
    }
}
