//! Reads the pictures of a shot, each file once.

use std::collections::{HashMap, HashSet};
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::map_statement::MapStatement;
use super::normals;
use crate::digest::Digest;
use crate::input::{self, Input, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::cutout::LEAST_OPACITY;
use crate::scene::error::Findings;
use crate::scene::material::NormalMap;
use crate::scene::paths::find_beside;
use crate::scene::texture::{Mapping, Wrap};
use crate::scene::{SceneError, Texture};

/// Maximum number of texels along an edge.
const LONGEST_EDGE: u32 = 32_768;
/// Maximum number of texels that a byte of a file can hold: deflate makes one byte of 1032 at most, and a
/// byte of a PNG has 8 texels at most. Other formats pack less, except for the empty rows of a BMP.
const MOST_TEXELS_A_BYTE: u64 = 8 * 1032;

/// Use of a picture by a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum PictureUse {
    /// Colours, and opacity in its alpha if it has any.
    Color,
    /// Opacity: alpha, or brightness in a picture without alpha.
    Opacity,
    /// Directions of normals.
    Normals,
    /// Heights, of which normals are made; or directions of normals, where it looks like that.
    Heights,
    /// Numbers that are parameters of a material.
    Parameter,
}

impl PictureUse {
    /// Consequence of a picture that cannot be used.
    fn without(self) -> &'static str {
        match self {
            Self::Color | Self::Opacity => "a checker stands in for it",
            Self::Normals | Self::Heights => "the surface is smooth without it",
            Self::Parameter => "the numbers of the material count alone",
        }
    }
}

/// A picture as textures hold it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decoded {
    pub width: u32,
    pub height: u32,
    pub texels: Arc<[[u8; 4]]>,
    /// True if some of its places are opaque enough to be there, and others are not.
    cuts: bool,
}

impl Decoded {
    fn new(width: u32, height: u32, texels: Arc<[[u8; 4]]>) -> Self {
        let is_there = |texel: &[u8; 4]| f32::from(texel[3]) >= 255.0 * LEAST_OPACITY;
        let cuts = texels.iter().any(is_there) && !texels.iter().all(is_there);
        Self { width, height, texels, cuts }
    }

    /// Means of what the bytes of the four channels stand for: `value` of a channel's byte.
    pub fn means(&self, value: impl Fn(usize, u8) -> f64) -> [f64; 4] {
        // how often each byte occurs, so that the sum is exact
        let mut counts = [[0_u64; 256]; 4];
        for texel in &*self.texels {
            (0..4).for_each(|channel| counts[channel][usize::from(texel[channel])] += 1);
        }
        std::array::from_fn(|channel| {
            let bytes = (0..=u8::MAX).zip(&counts[channel]);
            let sum: f64 = bytes.map(|(byte, count)| *count as f64 * value(channel, byte)).sum();
            sum / self.texels.len() as f64
        })
    }

    /// Returns the normals of a surface with these heights, and the factor for their slopes: see [`normals::of_heights`]. What
    /// holds normals already stays as it is.
    fn with_normals(&self) -> (Self, f32) {
        if normals::are_normals(&self.texels) {
            return (self.clone(), 1.0);
        }
        let (texels, slope) = normals::of_heights(&self.texels, self.width);
        (Self { texels: texels.into(), ..self.clone() }, slope)
    }

    /// Returns the picture with its opacity in alpha.
    fn with_opacity(&self) -> Self {
        if self.texels.iter().any(|texel| texel[3] != u8::MAX) {
            return self.clone();
        }
        // files of opacity are grey, and hold shares: sRGB means nothing for them
        let opacity = |[r, g, b, _]: &[u8; 4]| ((u16::from(*r) + u16::from(*g) + u16::from(*b)) / 3) as u8;
        let texels = self.texels.iter().map(|texel| [texel[0], texel[1], texel[2], opacity(texel)]).collect();
        Self::new(self.width, self.height, texels)
    }
}

/// Picture that is asked for.
pub(crate) struct Wanted<'a> {
    /// Path of the file, or of a file and a part of it, by which the picture is known.
    pub path: PathBuf,
    pub content: Content<'a>,
    /// Name for messages.
    pub name: &'a str,
    /// File that asks for it, and the line in it.
    pub asking: &'a Path,
    pub line: Option<usize>,
    pub used: PictureUse,
}

/// Place of a picture's bytes.
pub(crate) enum Content<'a> {
    /// A file, if it was found.
    File(Option<&'a Path>),
    /// A part of a file that was read.
    Bytes(&'a [u8]),
}

/// Textures of all materials so far.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Textures. Materials keep their indices.
    pub textures: Vec<Texture>,
    decoded: HashMap<PathBuf, Decoded>,
    /// Paths of pictures that are parts of other files.
    embedded: HashSet<PathBuf>,
    /// Paths of pictures for which a checker stands in.
    stand_ins: HashSet<PathBuf>,
    /// What was made of pictures for a use, with the factor for their slopes.
    derived: HashMap<(PathBuf, PictureUse), (Decoded, f32)>,
    /// Digests of their texels, in the order in which pictures were asked for.
    digests: Vec<Digest>,
    /// Use of each texture.
    uses: Vec<PictureUse>,
    /// Indices of textures, by file, use and the bits of scale, offset and clamp.
    indices: HashMap<(PathBuf, PictureUse, [u32; 6], [Wrap; 2]), u32>,
}

impl Pictures {
    /// Index of the texture for the statement `map` of the file `asking`; names are relative to `folder`.
    ///
    /// # Errors A picture that is missing or unreadable, where `findings` is strict about stand-ins; in any
    /// case one that does not fit into memory.
    pub fn index_of(
        &mut self,
        map: &MapStatement,
        folder: &Path,
        asking: &Path,
        findings: &mut Findings,
        used: PictureUse,
    ) -> Result<u32, SceneError> {
        let found = find_beside(folder, &map.file);
        let path = found.clone().unwrap_or_else(|| folder.join(&map.file));
        let content = Content::File(found.as_deref());
        let line = Some(map.line);
        let wanted = Wanted { path: path.clone(), content, name: &map.file, asking, line, used };
        let picture = self.decoded(wanted, findings)?;
        let key = (path.clone(), used);
        let derived = match used {
            PictureUse::Color | PictureUse::Normals | PictureUse::Parameter => picture,
            PictureUse::Opacity => {
                self.derived.entry(key).or_insert_with(|| (picture.with_opacity(), 1.0)).0.clone()
            }
            PictureUse::Heights => {
                self.derived.entry(key).or_insert_with(|| picture.with_normals()).0.clone()
            }
        };
        let Decoded { width, height, texels, .. } = derived;
        let wrap = if map.clamp { Wrap::Clamp } else { Wrap::Repeat };
        let mapping = Mapping::scaled(map.scale, map.offset, [wrap; 2]);
        Ok(self.place(Texture { path, width, height, texels, mapping }, used))
    }

    /// Size and texels of a picture.
    ///
    /// # Errors Those of [`index_of`](Self::index_of).
    pub fn decoded(&mut self, wanted: Wanted<'_>, findings: &mut Findings) -> Result<Decoded, SceneError> {
        let Wanted { path, content, name, asking, line, used } = wanted;
        if let Some(known) = self.decoded.get(&path) {
            return Ok(known.clone());
        }
        let told = |message: String| {
            let error = SceneError::new(asking, message);
            line.map_or(error.clone(), |line| error.at_line(line))
        };
        let read = match content {
            Content::File(path) => decode_file(path),
            Content::Bytes(bytes) => {
                self.embedded.insert(path.clone());
                decode(Cursor::new(bytes), bytes.len() as u64, None)
            }
        };
        let picture = match read {
            Ok(picture) => picture,
            Err(Unusable::AsItIs(why)) => {
                findings.stand_in(told(format!("the texture `{name}` {why}; {}", used.without())))?;
                self.stand_ins.insert(path.clone());
                checker()
            }
            // pictures must not depend on what else the machine does
            Err(Unusable::NoRoom(why)) => return Err(told(format!("the texture `{name}` {why}"))),
        };
        self.digests.push(Digest::of_table(picture.width, bytemuck::cast_slice(&picture.texels)));
        self.decoded.insert(path, picture.clone());
        Ok(picture)
    }

    /// Digest of the texels of all pictures.
    pub fn digest(&self) -> Digest {
        Digest::of_all(self.digests.iter().copied())
    }

    /// Files of the pictures, those that could not be read included.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.decoded.keys().filter(|path| !self.embedded.contains(*path))
    }

    /// Returns true if texture number `index` has places that are there and others that are not.
    pub fn cuts(&self, index: u32) -> bool {
        let (path, used) = (&self.textures[index as usize].path, self.uses[index as usize]);
        let derived = self.derived.get(&(path.clone(), used)).map(|(picture, _)| picture);
        derived.or_else(|| self.decoded.get(path)).is_some_and(|picture| picture.cuts)
    }

    /// Returns true if a checker stands in for texture number `index`.
    pub fn is_stand_in(&self, index: u32) -> bool {
        self.stand_ins.contains(&self.textures[index as usize].path)
    }

    /// The normal map that texture number `index` is, with this factor on its slopes, unless it is a stand-in.
    pub fn normal_map(&self, index: u32, slope: f32) -> Option<NormalMap> {
        let key = (self.textures[index as usize].path.clone(), self.uses[index as usize]);
        let of_picture = self.derived.get(&key).map_or(1.0, |(_, slope)| *slope);
        (!self.is_stand_in(index)).then_some(NormalMap { map: index, slope: slope * of_picture })
    }

    /// Returns true if the alpha of texture number `index` is below `least` anywhere.
    pub fn falls_below(&self, index: u32, least: f32) -> bool {
        self.textures[index as usize].texels.iter().any(|texel| f32::from(texel[3]) / 255.0 < least)
    }

    /// Index of a texture: the same for equal ones.
    pub fn place(&mut self, texture: Texture, used: PictureUse) -> u32 {
        let Mapping { linear, offset, wrap } = texture.mapping;
        let [ux, uy, vx, vy] = linear.to_cols_array();
        let placed = [ux, uy, vx, vy, offset.x, offset.y].map(f32::to_bits);
        let key = (texture.path.clone(), used, placed, wrap);
        *self.indices.entry(key).or_insert_with(|| {
            self.textures.push(texture);
            self.uses.push(used);
            (self.textures.len() - 1) as u32
        })
    }
}

/// Reason why a picture is not used, as the end of a sentence.
#[derive(Debug, PartialEq)]
enum Unusable {
    /// Fault of the file.
    AsItIs(String),
    /// Lack of memory on this machine.
    NoRoom(String),
}

fn decode_file(path: Option<&Path>) -> Result<Decoded, Unusable> {
    let path = path.ok_or_else(|| Unusable::AsItIs("cannot be found".into()))?;
    let Input { file, length: file_bytes, .. } =
        input::open(path, Kind::Picture).map_err(|error| unreadable(&error))?;
    // some decoders hold the file
    let need = Need::new(Part::new("its file", file_bytes, "a smaller picture"));
    need.check(&memory::left()).map_err(|error| Unusable::NoRoom(format!("does not fit: {error}")))?;
    // files of some kinds have no mark, and are known by their ending alone
    decode(BufReader::new(file), file_bytes, ImageFormat::from_path(path).ok())
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
    if reader.format() == Some(ImageFormat::Hdr) {
        // its values are linear and without a bound: as bytes they would be other colours
        let why = "is a Radiance picture, which only environments take: convert it to PNG";
        return Err(Unusable::AsItIs(why.into()));
    }
    let decoder = reader.into_decoder().map_err(|e| unreadable(&e))?;
    let (width, height) = decoder.dimensions();
    check_size([width, height], decoder.total_bytes(), file_bytes, &memory::left())?;
    let picture = DynamicImage::from_decoder(decoder).map_err(|e| unreadable(&e))?.into_rgba8();
    Ok(Decoded::new(width, height, Arc::from(bytemuck::cast_slice(picture.as_raw()))))
}

/// Checks the size of a picture before it is decoded; `decoded`: bytes that its texels take as its decoder
/// has them.
fn check_size(
    [width, height]: [u32; 2],
    decoded: u64,
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
    // as decoded, then with four bytes a texel, and copied to where it stays
    let bytes = decoded.max(4 * texels) + 4 * texels;
    let need = Need::new(Part::new("decoding it", bytes, "a smaller picture"));
    need.check(left).map_err(|error| Unusable::NoRoom(of_size(format!("does not fit: {error}"))))
}

/// A checkerboard in magenta and black, which nobody takes for the real picture.
fn checker() -> Decoded {
    const EDGE: u32 = 8;
    let texel = |i| if (i % EDGE + i / EDGE) % 2 == 0 { [255, 0, 255, 255] } else { [0, 0, 0, 255] };
    Decoded::new(EDGE, EDGE, (0..EDGE * EDGE).map(texel).collect())
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
            check_size([width, height], decoded, file_bytes, &[(Limit::Machine, left)])
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
