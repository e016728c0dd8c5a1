//! Reads the pictures of a shot, each file once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::{ImageReader, Limits};

use super::error::Findings;
use super::mtl::MapKd;
use super::paths::find_beside;
use super::{SceneError, Texture};

/// Texels along an edge at most.
const LONGEST_EDGE: u32 = 32_768;
/// Bytes that decoding one picture may take.
const MOST_BYTES: u64 = 2 << 30;

/// Width, height, texels.
type Decoded = (u32, u32, Arc<[[u8; 4]]>);

/// The textures that materials have asked for so far.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Their indices are what materials keep.
    pub textures: Vec<Texture>,
    decoded: HashMap<PathBuf, Decoded>,
    /// By file, and bits of scale, offset and clamp.
    indices: HashMap<(PathBuf, [u32; 5]), u32>,
}

impl Pictures {
    /// Index of the texture that `map` asks for in the file `asking`; names are relative to `folder`.
    ///
    /// # Errors
    /// A picture that is missing or unreadable, where `findings` is strict about stand-ins.
    pub fn index_of(
        &mut self,
        map: &MapKd,
        folder: &Path,
        asking: &Path,
        findings: &mut Findings,
    ) -> Result<u32, SceneError> {
        let found = find_beside(folder, &map.file);
        let path = found.clone().unwrap_or_else(|| folder.join(&map.file));
        let (width, height, texels) = match self.decoded.get(&path) {
            Some(known) => known.clone(),
            None => {
                let picture = match decode(found.as_deref()) {
                    Ok(picture) => picture,
                    Err(why) => {
                        let message = format!("the texture `{}` {why}; a checker stands in for it", map.file);
                        findings.stand_in(SceneError::new(asking, message).at_line(map.line))?;
                        checker()
                    }
                };
                self.decoded.insert(path.clone(), picture.clone());
                picture
            }
        };
        let texture =
            Texture { path, width, height, texels, scale: map.scale, offset: map.offset, clamp: map.clamp };
        Ok(self.place(texture))
    }

    fn place(&mut self, texture: Texture) -> u32 {
        let [sx, sy, ox, oy] =
            [texture.scale.x, texture.scale.y, texture.offset.x, texture.offset.y].map(f32::to_bits);
        let key = (texture.path.clone(), [sx, sy, ox, oy, u32::from(texture.clamp)]);
        *self.indices.entry(key).or_insert_with(|| {
            self.textures.push(texture);
            (self.textures.len() - 1) as u32
        })
    }
}

/// Why not, as the end of a sentence.
fn decode(path: Option<&Path>) -> Result<Decoded, String> {
    let path = path.ok_or("cannot be found")?;
    let unreadable = |error: &dyn std::fmt::Display| format!("cannot be read: {error}");
    let mut limits = Limits::default();
    limits.max_image_width = Some(LONGEST_EDGE);
    limits.max_image_height = Some(LONGEST_EDGE);
    limits.max_alloc = Some(MOST_BYTES);
    let mut reader = ImageReader::open(path).map_err(|e| unreadable(&e))?;
    reader.limits(limits);
    let reader = reader.with_guessed_format().map_err(|e| unreadable(&e))?;
    let picture = reader.decode().map_err(|e| unreadable(&e))?.into_rgba8();
    let (width, height) = picture.dimensions();
    if width == 0 || height == 0 {
        return Err(String::from("has no texels"));
    }
    Ok((width, height, picture.pixels().map(|pixel| pixel.0).collect()))
}

/// What nobody takes for the real picture.
fn checker() -> Decoded {
    const EDGE: u32 = 8;
    let texel = |i| if (i % EDGE + i / EDGE) % 2 == 0 { [255, 0, 255, 255] } else { [0, 0, 0, 255] };
    (EDGE, EDGE, (0..EDGE * EDGE).map(texel).collect())
}
