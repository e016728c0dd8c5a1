//! Reads the pictures of a shot, each file once.

use std::collections::HashMap;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};

use super::map_statement::MapKd;
use crate::digest::Digest;
use crate::input::{self, Input, Kind};
use crate::memory::{self, Need, Part};
use crate::scene::cutout::LEAST_OPACITY;
use crate::scene::error::Findings;
use crate::scene::paths::find_beside;
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
}

/// A picture as textures hold it.
#[derive(Debug, Clone, PartialEq)]
struct Decoded {
    width: u32,
    height: u32,
    texels: Arc<[[u8; 4]]>,
    /// True if some of its places are opaque enough to be there, and others are not.
    cuts: bool,
}

impl Decoded {
    fn new(width: u32, height: u32, texels: Arc<[[u8; 4]]>) -> Self {
        let is_there = |texel: &[u8; 4]| f32::from(texel[3]) >= 255.0 * LEAST_OPACITY;
        let cuts = texels.iter().any(is_there) && !texels.iter().all(is_there);
        Self { width, height, texels, cuts }
    }

    /// Returns the picture with its opacity in alpha.
    fn with_opacity(self) -> Self {
        if self.texels.iter().any(|texel| texel[3] != u8::MAX) {
            return self;
        }
        // files of opacity are grey, and hold shares: sRGB means nothing for them
        let opacity = |[r, g, b, _]: &[u8; 4]| ((u16::from(*r) + u16::from(*g) + u16::from(*b)) / 3) as u8;
        let texels = self.texels.iter().map(|texel| [texel[0], texel[1], texel[2], opacity(texel)]).collect();
        Self::new(self.width, self.height, texels)
    }
}

/// Textures of all materials so far.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Textures. Materials keep their indices.
    pub textures: Vec<Texture>,
    decoded: HashMap<(PathBuf, PictureUse), Decoded>,
    /// Digests of their texels, in the order in which pictures were asked for.
    digests: Vec<Digest>,
    /// True for each texture that cuts parts out.
    cuts: Vec<bool>,
    /// Indices of textures, by file, use and the bits of scale, offset and clamp.
    indices: HashMap<(PathBuf, PictureUse, [u32; 5]), u32>,
}

impl Pictures {
    /// Index of the texture for the statement `map` of the file `asking`; names are relative to `folder`.
    ///
    /// # Errors A picture that is missing or unreadable, where `findings` is strict about stand-ins; in any
    /// case one that does not fit into memory.
    pub fn index_of(
        &mut self,
        map: &MapKd,
        folder: &Path,
        asking: &Path,
        findings: &mut Findings,
        used: PictureUse,
    ) -> Result<u32, SceneError> {
        let found = find_beside(folder, &map.file);
        let path = found.clone().unwrap_or_else(|| folder.join(&map.file));
        let key = (path.clone(), used);
        let Decoded { width, height, texels, cuts } = match self.decoded.get(&key) {
            Some(known) => known.clone(),
            None => {
                let picture = match decode(found.as_deref()) {
                    Ok(picture) => picture,
                    Err(Unusable::AsItIs(why)) => {
                        let message = format!("the texture `{}` {why}; a checker stands in for it", map.file);
                        findings.stand_in(SceneError::new(asking, message).at_line(map.line))?;
                        checker()
                    }
                    // pictures must not depend on what else the machine does
                    Err(Unusable::NoRoom(why)) => {
                        let message = format!("the texture `{}` {why}", map.file);
                        return Err(SceneError::new(asking, message).at_line(map.line));
                    }
                };
                let picture = match used {
                    PictureUse::Color => picture,
                    PictureUse::Opacity => picture.with_opacity(),
                };
                let texels = bytemuck::cast_slice(&picture.texels);
                self.digests.push(Digest::of_table(picture.width, texels));
                self.decoded.insert(key, picture.clone());
                picture
            }
        };
        let texture =
            Texture { path, width, height, texels, scale: map.scale, offset: map.offset, clamp: map.clamp };
        Ok(self.place(texture, used, cuts))
    }

    /// Digest of the texels of all pictures.
    pub fn digest(&self) -> Digest {
        Digest::of_all(self.digests.iter().copied())
    }

    /// Files of the pictures, those that could not be read included.
    pub fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.decoded.keys().map(|(path, _)| path)
    }

    /// Returns true if texture number `index` has places that are there and others that are not.
    pub fn cuts(&self, index: u32) -> bool {
        self.cuts[index as usize]
    }

    fn place(&mut self, texture: Texture, used: PictureUse, cuts: bool) -> u32 {
        let [sx, sy, ox, oy] =
            [texture.scale.x, texture.scale.y, texture.offset.x, texture.offset.y].map(f32::to_bits);
        let key = (texture.path.clone(), used, [sx, sy, ox, oy, u32::from(texture.clamp)]);
        *self.indices.entry(key).or_insert_with(|| {
            self.textures.push(texture);
            self.cuts.push(cuts);
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

fn decode(path: Option<&Path>) -> Result<Decoded, Unusable> {
    let path = path.ok_or_else(|| Unusable::AsItIs("cannot be found".into()))?;
    let unreadable = |error: &dyn std::fmt::Display| Unusable::AsItIs(format!("cannot be read: {error}"));
    let Input { file, length: file_bytes, .. } =
        input::open(path, Kind::Picture).map_err(|e| unreadable(&e))?;
    // some decoders hold the file
    let need = Need::new(Part::new("its file", file_bytes, "a smaller picture"));
    need.check(&memory::left()).map_err(|error| Unusable::NoRoom(format!("does not fit: {error}")))?;
    let mut reader = ImageReader::new(BufReader::new(file));
    // files of some kinds have no mark, and are known by their ending alone
    if let Ok(format) = ImageFormat::from_path(path) {
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
