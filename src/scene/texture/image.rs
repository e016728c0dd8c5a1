//! The texels of a picture, and coarser levels of it, each with half as many texels along an edge.

use std::io;
use std::sync::{Arc, OnceLock};

use glam::{Vec3, Vec4};
use half::f16;

use super::pages::{PagedLevel, Pager};
use super::texel::{Texel, byte, srgb_texel};
use super::{Between, linear_bytes};

/// Texels, rows from the top: red, green, blue and alpha.
#[derive(Debug, Clone, PartialEq)]
pub enum Texels {
    /// Bytes; of colours they are sRGB-encoded.
    Bytes(Arc<[[u8; 4]]>),
    /// Half floats; of colours they are linear.
    Halves(Arc<[[f16; 4]]>),
    /// Either, in pages of a file.
    Paged(Arc<PagedLevel>),
}

/// Meaning of a picture's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Values {
    /// Colours: means are those of the light.
    #[default]
    Colors,
    /// Numbers, or components of vectors.
    Numbers,
}

/// A picture, with the coarser levels that were asked for.
#[derive(Debug, Clone)]
pub struct Image {
    finest: Level,
    values: Values,
    coarser: OnceLock<Vec<Level>>,
}

/// A level of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Texels.
    pub texels: Texels,
}

/// Equal pictures have the same levels, whether they were asked for or not.
impl PartialEq for Image {
    fn eq(&self, other: &Self) -> bool {
        self.finest == other.finest && self.values == other.values
    }
}

impl Texels {
    /// Number of texels.
    pub fn count(&self) -> usize {
        match self {
            Self::Bytes(all) => all.len(),
            Self::Halves(all) => all.len(),
            Self::Paged(all) => all.count(),
        }
    }

    /// Bytes in memory; none of pages.
    pub fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(all) => all.as_flattened(),
            Self::Halves(all) => bytemuck::cast_slice(all),
            Self::Paged(_) => &[],
        }
    }

    /// Bytes of a texel.
    pub fn bytes_of_texel(&self) -> usize {
        match self {
            Self::Bytes(_) => size_of::<[u8; 4]>(),
            Self::Halves(_) => size_of::<[f16; 4]>(),
            Self::Paged(all) => all.bytes_of_texel(),
        }
    }

    /// Returns true if the values are bytes, in pages or not.
    pub fn are_bytes(&self) -> bool {
        self.bytes_of_texel() == size_of::<[u8; 4]>()
    }

    /// A texel, by its number.
    #[inline]
    pub fn get(&self, texel: usize) -> Texel {
        match self {
            Self::Bytes(all) => Texel::Bytes(all[texel]),
            Self::Halves(all) => Texel::Halves(all[texel]),
            Self::Paged(all) => all.get(texel),
        }
    }

    /// All texels, in their order.
    pub fn iter(&self) -> impl Iterator<Item = Texel> {
        (0..self.count()).map(|texel| self.get(texel))
    }

    /// Linear colour between four texels.
    #[inline]
    pub fn color_between(&self, between: &Between) -> Vec3 {
        match self {
            Self::Bytes(all) => {
                let table = linear_bytes();
                between.of(|texel| {
                    let [r, g, b, _] = all[texel];
                    Vec3::new(table[usize::from(r)], table[usize::from(g)], table[usize::from(b)])
                })
            }
            _ => between.of(|texel| self.get(texel).color().truncate()),
        }
    }

    /// Values between four texels, 0 to 1.
    #[inline]
    pub fn numbers_between(&self, between: &Between) -> Vec3 {
        between.of(|texel| self.get(texel).numbers().truncate())
    }
}

impl Image {
    /// Creates a picture of `width` x `height` texels.
    pub fn new(width: u32, height: u32, texels: Texels, values: Values) -> Self {
        Self { finest: Level { width, height, texels }, values, coarser: OnceLock::new() }
    }

    /// Meaning of its values.
    pub fn values(&self) -> Values {
        self.values
    }

    /// The picture itself.
    #[inline]
    pub fn finest(&self) -> &Level {
        &self.finest
    }

    /// Level number `number`, made now if nobody has asked for it before; the coarsest one if there are fewer.
    #[inline]
    pub fn level(&self, number: usize) -> &Level {
        if number == 0 {
            return &self.finest;
        }
        let coarser = self.coarser.get_or_init(|| self.make_coarser());
        coarser.get(number - 1).or(coarser.last()).unwrap_or(&self.finest)
    }

    /// Bytes that all levels take, whether they were made or not.
    pub fn bytes(&self) -> u64 {
        let texels = u64::from(self.finest.width) * u64::from(self.finest.height);
        texels * self.finest.texels.bytes_of_texel() as u64 * 4 / 3
    }

    /// Returns the same picture, all levels of which are in pages.
    ///
    /// # Errors Those of the system: a full disk.
    pub fn paged(&self, pager: &Arc<Pager>) -> io::Result<Self> {
        let coarser =
            self.make_coarser().iter().map(|level| level.paged(pager)).collect::<io::Result<Vec<Level>>>()?;
        let finest = if self.pager().is_some() { self.finest.clone() } else { self.finest.paged(pager)? };
        Ok(Self { finest, values: self.values, coarser: OnceLock::from(coarser) })
    }

    /// Pager of its texels, if they are in pages.
    pub fn pager(&self) -> Option<&Arc<Pager>> {
        match &self.finest.texels {
            Texels::Paged(all) => Some(all.pager()),
            _ => None,
        }
    }

    /// Levels down to one of a single texel. On the thread that asks alone: other workers may wait for the same levels.
    fn make_coarser(&self) -> Vec<Level> {
        let mut levels: Vec<Level> = Vec::new();
        loop {
            let last = levels.last().unwrap_or(&self.finest);
            if last.width <= 1 && last.height <= 1 {
                return levels;
            }
            let next = last.half(self.values);
            levels.push(next);
        }
    }
}

impl Level {
    fn paged(&self, pager: &Arc<Pager>) -> io::Result<Self> {
        let Self { width, height, ref texels } = *self;
        let paged = pager.store([width, height], texels.bytes_of_texel(), texels.bytes())?;
        Ok(Self { width, height, texels: Texels::Paged(paged) })
    }

    /// This level with half as many texels along each edge, rounded down: each has the mean of the area that it covers.
    fn half(&self, values: Values) -> Self {
        let [width, height] = [self.width, self.height].map(|edge| (edge / 2).max(1));
        let mean = |texel: u32| {
            let [across, down] =
                [covered(texel % width, self.width, width), covered(texel / width, self.height, height)];
            let mut sum = Vec4::ZERO;
            for (y, of_row) in &down {
                for (x, of_column) in &across {
                    let texel = *y as usize * self.width as usize + *x as usize;
                    let value = match values {
                        Values::Colors => self.texels.get(texel).color(),
                        Values::Numbers => self.texels.get(texel).numbers(),
                    };
                    sum += value * (of_row * of_column);
                }
            }
            sum
        };
        let means = (0..width * height).map(mean);
        let texels = match (self.texels.are_bytes(), values) {
            (true, Values::Colors) => Texels::Bytes(means.map(|mean| srgb_texel(mean.to_array())).collect()),
            (true, Values::Numbers) => Texels::Bytes(means.map(|mean| mean.to_array().map(byte)).collect()),
            (false, _) => Texels::Halves(means.map(|mean| mean.to_array().map(f16::from_f32)).collect()),
        };
        Self { width, height, texels }
    }
}

/// Texels of a row of `fine` that texel number `coarse` of a row of `count` covers, with their shares of it: two, or three if the
/// numbers do not go into each other.
fn covered(coarse: u32, fine: u32, count: u32) -> Vec<(u32, f32)> {
    // in units of 1 / (fine * count) of the edge
    let (from, to) = (u64::from(coarse * fine), u64::from((coarse + 1) * fine));
    let texel = u64::from(count);
    let (first, end) = (from / texel, to.div_ceil(texel));
    let share = |x: u64| (to.min((x + 1) * texel) - from.max(x * texel)) as f32 / (to - from) as f32;
    (first..end).map(|x| (x as u32, share(x))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(width: u32, texels: &[[u8; 4]], values: Values) -> Image {
        Image::new(width, texels.len() as u32 / width, Texels::Bytes(texels.into()), values)
    }

    #[test]
    fn means_of_colours_are_those_of_light() {
        let texels = [[0, 0, 0, 0], [255, 255, 255, 255]];
        let mean = |values| bytes(2, &texels, values).level(1).texels.get(0).bytes();
        // sRGB's 188 is half of the light
        assert_eq!(mean(Values::Colors), [188, 188, 188, 128]);
        assert_eq!(mean(Values::Numbers), [128; 4]);
    }

    #[test]
    fn levels_end_with_a_single_texel() {
        let image = bytes(5, &[[10, 20, 30, 255]; 15], Values::Colors);
        let sizes: Vec<_> =
            (0..4).map(|number| (image.level(number).width, image.level(number).height)).collect();
        assert_eq!(sizes, [(5, 3), (2, 1), (1, 1), (1, 1)]);
        assert_eq!(image.level(7).texels.get(0).bytes(), [10, 20, 30, 255], "what is even stays");
    }

    #[test]
    fn odd_edges_are_shared() {
        assert_eq!(covered(0, 5, 2), [(0, 0.4), (1, 0.4), (2, 0.2)]);
        assert_eq!(covered(1, 5, 2), [(2, 0.2), (3, 0.4), (4, 0.4)]);
        assert_eq!(covered(3, 8, 4), [(6, 0.5), (7, 0.5)]);
        assert_eq!(covered(0, 1, 1), [(0, 1.0)]);
    }

    #[test]
    fn half_floats_keep_what_is_brighter_than_white() {
        let texel = |value: f32| [f16::from_f32(value); 4];
        let texels = Texels::Halves(Arc::from([texel(1.0), texel(7.0)]));
        let image = Image::new(2, 1, texels, Values::Colors);
        assert_eq!(image.level(1).texels.get(0).color(), Vec4::splat(4.0));
        assert_eq!(image.finest().texels.get(1).bytes(), [255; 4]);
    }
}
