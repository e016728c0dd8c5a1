//! Decodes the pictures of a shot.

use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::Path;
use std::sync::Arc;

use half::f16;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::normals;
use crate::input::{self, Input, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::cutout::LEAST_OPACITY;
use crate::scene::texture::{Image, Texels, Values, linear_share};

/// Maximum number of texels along an edge.
const LONGEST_EDGE: u32 = 32_768;
/// Maximum number of texels that a byte of a file can hold: deflate makes one byte of 1032 at most, and a
/// byte of a PNG has 8 texels at most. Other formats pack less, except for the empty rows of a BMP.
const MOST_TEXELS_A_BYTE: u64 = 8 * 1032;

/// First bytes of an OpenEXR file.
const OPEN_EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Encoding of a picture's colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ColorSpace {
    /// That of IEC 61966-2-1, as screens show them.
    Srgb,
    /// Shares of the light.
    Linear,
}

impl ColorSpace {
    /// Finds the space that a file calls `name`: `sRGB`, `linear`, `raw`, `non-color`. `None` for other names.
    pub fn named(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "srgb" => Some(Self::Srgb),
            "linear" | "raw" | "non-color" => Some(Self::Linear),
            _ => None,
        }
    }
}

/// A picture as its file holds it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decoded {
    /// The picture. Bytes, and half floats in the encoding of `space`.
    pub image: Arc<Image>,
    /// Encoding of its colours, if nothing else is stated.
    pub space: ColorSpace,
    /// True if some of its places are opaque enough to be there, and others are not.
    pub cuts: bool,
}

impl Decoded {
    fn new([width, height]: [u32; 2], texels: Texels, space: ColorSpace) -> Self {
        let is_there = |texel: usize| texels.get(texel).alpha() >= 255.0 * LEAST_OPACITY;
        let first = texels.count() > 0 && is_there(0);
        let cuts = !(0..texels.count()).all(|texel| is_there(texel) == first);
        Self { image: Arc::new(Image::new(width, height, texels, Values::Colors)), space, cuts }
    }

    /// Creates a picture of bytes, colours in sRGB.
    #[cfg(feature = "usd")]
    pub fn of_bytes(size: [u32; 2], texels: Arc<[[u8; 4]]>) -> Self {
        Self::new(size, Texels::Bytes(texels), ColorSpace::Srgb)
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.image.finest().width, self.image.finest().height]
    }

    fn with_texels(&self, texels: Texels) -> Self {
        Self::new(self.size(), texels, self.space)
    }

    /// Means of what the values of the four channels stand for, as bytes: `value` of a channel's byte.
    pub fn means(&self, value: impl Fn(usize, u8) -> f64) -> [f64; 4] {
        // how often each byte occurs, so that the sum is exact
        let mut counts = [[0_u64; 256]; 4];
        let texels = &self.image.finest().texels;
        for texel in (0..texels.count()).map(|texel| texels.get(texel).bytes()) {
            (0..4).for_each(|channel| counts[channel][usize::from(texel[channel])] += 1);
        }
        std::array::from_fn(|channel| {
            let bytes = (0..=u8::MAX).zip(&counts[channel]);
            let sum: f64 = bytes.map(|(byte, count)| *count as f64 * value(channel, byte)).sum();
            sum / texels.count() as f64
        })
    }

    /// Returns the colours, which were encoded as `space` says: sRGB-encoded bytes, or linear half floats. What is brighter than `most` is
    /// cut: a surface reflects no more than all light.
    pub fn as_colors(&self, space: ColorSpace, most: f32) -> Arc<Image> {
        let finest = self.image.finest();
        let linear = |value: f32| match space {
            ColorSpace::Srgb => linear_share(f64::from(value.clamp(0.0, 1.0))),
            ColorSpace::Linear => value.clamp(0.0, most),
        };
        if finest.texels.are_bytes() && space == ColorSpace::Srgb {
            return Arc::clone(&self.image);
        }
        let texel = |texel: usize| {
            let [r, g, b, a] = finest.texels.get(texel).numbers().to_array();
            [linear(r), linear(g), linear(b), a.clamp(0.0, 1.0)].map(f16::from_f32)
        };
        let texels = Texels::Halves((0..finest.texels.count()).map(texel).collect());
        Arc::new(Image::new(finest.width, finest.height, texels, Values::Colors))
    }

    /// Returns the values as numbers.
    pub fn as_numbers(&self) -> Arc<Image> {
        let finest = self.image.finest();
        Arc::new(Image::new(finest.width, finest.height, finest.texels.clone(), Values::Numbers))
    }

    /// Returns the normals of a surface with these heights, and the factor for their slopes: see [`normals::of_heights`]. What
    /// holds normals already stays as it is.
    pub fn with_normals(&self) -> (Self, f32) {
        let finest = self.image.finest();
        if normals::are_normals(&finest.texels) {
            return (self.clone(), 1.0);
        }
        let (texels, slope) = normals::of_heights(&finest.texels, finest.width);
        (self.with_texels(Texels::Bytes(texels.into())), slope)
    }

    /// Returns the picture with its opacity in alpha.
    pub fn with_opacity(&self) -> Self {
        let texels = &self.image.finest().texels;
        if (0..texels.count()).any(|texel| texels.get(texel).alpha() < 255.0) {
            return self.clone();
        }
        // files of opacity are grey, and hold shares: sRGB means nothing for them
        let opacity = |[r, g, b, _]: [u8; 4]| ((u16::from(r) + u16::from(g) + u16::from(b)) / 3) as u8;
        let texel = |texel: usize| {
            let bytes = texels.get(texel).bytes();
            [bytes[0], bytes[1], bytes[2], opacity(bytes)]
        };
        self.with_texels(Texels::Bytes((0..texels.count()).map(texel).collect()))
    }
}

/// Reason why a picture is not used, as the end of a sentence.
#[derive(Debug, PartialEq)]
pub(super) enum Unusable {
    /// Fault of the file.
    AsItIs(String),
    /// Lack of memory on this machine.
    NoRoom(String),
}

/// Decodes the picture in a file.
pub(super) fn decode_file(path: Option<&Path>) -> Result<Decoded, Unusable> {
    let path = path.ok_or_else(|| Unusable::AsItIs("cannot be found".into()))?;
    let Input { mut file, length: file_bytes, .. } =
        input::open(path, Kind::Picture).map_err(|error| unreadable(&error))?;
    // some decoders hold the file
    let need = Need::new(Part::new("its file", file_bytes, "a smaller picture"));
    need.check(&memory::left()).map_err(|error| Unusable::NoRoom(format!("does not fit: {error}")))?;
    let mut begin = Vec::new();
    file.by_ref().take(4).read_to_end(&mut begin).map_err(|error| unreadable(&error))?;
    file.rewind().map_err(|error| unreadable(&error))?;
    if begin == OPEN_EXR {
        return open_exr(path, file_bytes);
    }
    // files of some kinds have no mark, and are known by their ending alone
    decode(BufReader::new(file), file_bytes, ImageFormat::from_path(path).ok())
}

/// Decodes a picture that is a part of another file, where it is called `name`.
pub(super) fn decode_bytes(bytes: &[u8], name: &str) -> Result<Decoded, Unusable> {
    if bytes.starts_with(&OPEN_EXR) {
        let why = "is an OpenEXR file within another file: only files of their own are read";
        return Err(Unusable::AsItIs(why.into()));
    }
    // as for files
    decode(Cursor::new(bytes), bytes.len() as u64, ImageFormat::from_path(name).ok())
}

fn unreadable(error: &dyn std::fmt::Display) -> Unusable {
    Unusable::AsItIs(format!("cannot be read: {error}"))
}

/// Decodes a picture of `file_bytes` bytes; `format`: by the name of its file.
fn decode(
    bytes: impl BufRead + Seek,
    file_bytes: u64,
    format: Option<ImageFormat>,
) -> Result<Decoded, Unusable> {
    let mut reader = ImageReader::new(bytes);
    if let Some(format) = format {
        reader.set_format(format);
    }
    let reader = reader.with_guessed_format().map_err(|e| unreadable(&e))?;
    let decoder = reader.into_decoder().map_err(|e| unreadable(&e))?;
    let (width, height) = decoder.dimensions();
    let is_of_bytes =
        matches!(decoder.color_type(), ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8);
    let as_texels = if is_of_bytes { BYTES } else { HALVES };
    check_size([width, height], [decoder.total_bytes(), as_texels], file_bytes, &memory::left())?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|e| unreadable(&e))?;
    let has_floats = matches!(picture, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let space = if has_floats { ColorSpace::Linear } else { ColorSpace::Srgb };
    let texels = if is_of_bytes {
        Texels::Bytes(Arc::from(bytemuck::cast_slice(picture.into_rgba8().as_raw())))
    } else {
        let texels = picture.into_rgba32f();
        Texels::Halves(texels.pixels().map(|texel| texel.0.map(half)).collect())
    };
    Ok(Decoded::new([width, height], texels, space))
}

/// Nearest half float to a value; what is no number is 0.
fn half(value: f32) -> f16 {
    if value.is_nan() { f16::ZERO } else { f16::from_f32(value.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())) }
}

/// Decodes an OpenEXR file: its channels R, G and B, or Y alone, and A if there is one.
fn open_exr(path: &Path, file_bytes: u64) -> Result<Decoded, Unusable> {
    let header = openexr::read_header(path).map_err(|error| worded(&error))?;
    let size = [header.width, header.height];
    let number = |name: &str| header.channels.iter().position(|channel| channel.name == name);
    let grey = number("Y");
    let [Some(red), Some(green), Some(blue)] = ["R", "G", "B"].map(|name| number(name).or(grey)) else {
        let names: Vec<&str> = header.channels.iter().map(|channel| channel.name.as_str()).take(16).collect();
        let names = names.join(", ");
        return Err(Unusable::AsItIs(format!("must have the channels R, G and B, or Y, and has {names}")));
    };
    let alpha = number("A");
    // a compressed part of a file says nothing of its texels
    check_size(size, [0, HALVES], file_bytes.max(u64::from(size[0]) * u64::from(size[1])), &memory::left())?;
    let mut texels = vec![[f16::ONE; 4]; size[0] as usize * size[1] as usize];
    let mut read = [0; 4];
    openexr::scan(path, |channel, values| {
        let targets = [Some(red), Some(green), Some(blue), alpha];
        for at in (0..4).filter(|at| targets[*at] == Some(channel)) {
            let places = texels.iter_mut().skip(read[at]);
            places.zip(values).for_each(|(texel, value)| texel[at] = half(*value));
            read[at] += values.len();
        }
    })
    .map_err(|error| worded(&error))?;
    Ok(Decoded::new(size, Texels::Halves(texels.into()), ColorSpace::Linear))
}

/// Words of an error without the name of the file, which stands in the message already.
fn worded(error: &openexr::Error) -> Unusable {
    match error {
        openexr::Error::File { source, .. } => unreadable(source),
        openexr::Error::Library { message, .. } => unreadable(message),
        other => unreadable(other),
    }
}

/// Bytes of a texel in memory, of bytes and of half floats.
const BYTES: u64 = 4;
const HALVES: u64 = 8;

/// Checks the size of a picture before it is decoded; `decoded`: bytes that its texels take as its decoder
/// has them; `texel`: bytes of one as it is kept.
fn check_size(
    [width, height]: [u32; 2],
    [decoded, texel]: [u64; 2],
    file_bytes: u64,
    left: &[memory::Headroom],
) -> Result<(), Unusable> {
    let texels = u64::from(width) * u64::from(height);
    let of_size = |why: String| format!("of {width}x{height} texels {why}");
    let refused = |why| Err(Unusable::AsItIs(of_size(why)));
    if texels == 0 {
        return refused(String::from("has none"));
    }
    if width.max(height) > LONGEST_EDGE {
        return refused(format!("is too large: an edge may have {LONGEST_EDGE}"));
    }
    if texels / MOST_TEXELS_A_BYTE > file_bytes {
        return refused(format!("cannot be in a file of {file_bytes} bytes"));
    }
    // as decoded, then with all channels, and copied to where it stays
    let bytes = decoded.max(texel * texels) + texel * texels;
    let need = Need::new(Part::new("decoding it", bytes, "a smaller picture"));
    need.check(left).map_err(|error| Unusable::NoRoom(of_size(format!("does not fit: {error}"))))
}

/// A checkerboard in magenta and black, which nobody takes for the real picture.
pub(super) fn checker() -> Decoded {
    const EDGE: u32 = 8;
    let texel = |i| if (i % EDGE + i / EDGE) % 2 == 0 { [255, 0, 255, 255] } else { [0, 0, 0, 255] };
    Decoded::new([EDGE; 2], Texels::Bytes((0..EDGE * EDGE).map(texel).collect()), ColorSpace::Srgb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Limit;

    #[test]
    fn sizes_are_looked_at_before_anything_is_decoded() {
        let mib = 1 << 20;
        let check = |width: u32, height: u32, file_bytes, left: u64| {
            let decoded = 3 * u64::from(width) * u64::from(height);
            check_size([width, height], [decoded, BYTES], file_bytes, &[(Limit::Machine, left)])
        };
        assert_eq!(check(1024, 1024, mib, 9 * mib), Ok(()));
        assert_eq!(check(1024, 1024, 128, 9 * mib), Ok(()), "one colour");
        let little = check(1024, 1024, mib, 6 * mib);
        let words = "does not fit: about 8 MiB of memory are needed";
        assert!(matches!(&little, Err(Unusable::NoRoom(why)) if why.contains(words)), "{little:?}");
        for (width, height, file_bytes, left, words) in [
            (25_000, 25_000, 1024, u64::MAX, "cannot be in a file of 1024 bytes"),
            (40_000, 1, mib, u64::MAX, "an edge may have 32768"),
            (0, 7, mib, u64::MAX, "has none"),
        ] {
            let why = check(width, height, file_bytes, left);
            assert!(matches!(&why, Err(Unusable::AsItIs(why)) if why.contains(words)), "{words}: {why:?}");
        }
    }
}
