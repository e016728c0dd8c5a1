//! Reads the pictures of a shot, each file once.

pub mod decoded;
mod normals;

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use self::decoded::{ColorSpace, Decoded, Unusable, checker, decode_bytes, decode_file};
use crate::digest::Digest;
use crate::scene::error::Findings;
use crate::scene::material::{LARGEST_COLOR, NormalMap};
use crate::scene::paths::find_beside;
use crate::scene::texture::{Image, Mapping, Pager, UvSet, Wrap};
use crate::scene::{SceneError, Texture};

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
    /// Colours that are parameters of a material.
    ColorParameter,
    /// Colours of light, which may be brighter than 1.
    Light,
}

impl PictureUse {
    /// Consequence of a picture that cannot be used.
    fn without(self) -> &'static str {
        match self {
            Self::Color | Self::Opacity => "a checker stands in for it",
            Self::Normals | Self::Heights => "the surface is smooth without it",
            Self::Parameter | Self::ColorParameter | Self::Light => "the numbers of the material count alone",
        }
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

/// A file as a line of another one names it.
pub(crate) struct Named<'a> {
    /// Name as written.
    pub file: &'a str,
    /// Folder to which the name is relative.
    pub folder: &'a Path,
    /// File that asks for it, and the line in it.
    pub asking: &'a Path,
    pub line: usize,
    /// Encoding of its colours, if it is stated.
    pub space: Option<ColorSpace>,
}

/// Place of a picture's bytes.
pub(crate) enum Content<'a> {
    /// A file, if it was found.
    File(Option<&'a Path>),
    /// A part of a file that was read.
    Bytes(&'a [u8]),
    /// A part of a file that cannot be read, and why: the end of a sentence about it.
    Unreadable(&'a str),
}

/// Memory for textures: half of it for pictures that are held whole, and half for pages of the others.
struct TextureMemory {
    bytes: u64,
    /// Bytes of the pictures that are held whole.
    whole: u64,
}

/// Bytes of textures where the shot does not state them.
const DEFAULT_MEMORY: u64 = 1024 << 20;

impl Default for TextureMemory {
    fn default() -> Self {
        Self { bytes: DEFAULT_MEMORY, whole: 0 }
    }
}

/// Picture that was made of another one for a use.
struct Derived {
    image: Arc<Image>,
    /// True if some of its places are opaque enough to be there, and others are not.
    cuts: bool,
    /// Factor for its slopes, if it holds normals.
    slope: f32,
}

/// What tells textures apart: the address of the picture, which stays, and its mapping, numbers by their bits.
type TextureKey = (usize, [u32; 6], [Wrap; 2], UvSet, bool);

/// Textures of all materials so far.
#[derive(Default)]
pub(crate) struct Pictures {
    /// Textures. Materials keep their indices.
    pub textures: Vec<Texture>,
    /// Pictures as their files hold them.
    decoded: HashMap<PathBuf, Decoded>,
    /// Paths of pictures that are parts of other files.
    embedded: HashSet<PathBuf>,
    /// Paths of pictures for which a checker stands in.
    stand_ins: HashSet<PathBuf>,
    /// Pictures that were made of others for a use, with colours in a space.
    derived: HashMap<(PathBuf, PictureUse, ColorSpace), Derived>,
    /// Digests of their texels, in the order in which pictures were asked for.
    digests: Vec<Digest>,
    memory: TextureMemory,
    /// Pager of the pictures beyond that, once there are some.
    pager: Option<Arc<Pager>>,
    /// Indices of textures.
    indices: HashMap<TextureKey, u32>,
}

impl Pictures {
    /// Index of the texture of a file at these places.
    ///
    /// # Errors A picture that is missing or unreadable, where `findings` is strict about stand-ins; in any
    /// case one that does not fit into memory.
    pub fn index_at(
        &mut self,
        Named { file, folder, asking, line, space }: &Named<'_>,
        mapping: Mapping,
        findings: &mut Findings,
        used: PictureUse,
    ) -> Result<u32, SceneError> {
        let found = find_beside(folder, file);
        let path = found.clone().unwrap_or_else(|| folder.join(file));
        let content = Content::File(found.as_deref());
        let wanted = Wanted { path: path.clone(), content, name: file, asking, line: Some(*line), used };
        let picture = self.decoded(wanted, findings)?;
        let image = self.image_for(&path, &picture, used, *space)?;
        Ok(self.place(Texture { path, image, mapping }))
    }

    /// Makes of the `picture` at `path` that which a use takes, with colours in that `space` if it is stated.
    pub fn image_for(
        &mut self,
        path: &Path,
        picture: &Decoded,
        used: PictureUse,
        space: Option<ColorSpace>,
    ) -> Result<Arc<Image>, SceneError> {
        let space = space.unwrap_or(picture.space);
        let key = (path.to_path_buf(), used, space);
        if let Some(known) = self.derived.get(&key) {
            return Ok(Arc::clone(&known.image));
        }
        let mut derived = match used {
            PictureUse::Color | PictureUse::ColorParameter => {
                Derived { image: picture.as_colors(space, 1.0), cuts: picture.cuts, slope: 1.0 }
            }
            PictureUse::Light => {
                Derived { image: picture.as_colors(space, LARGEST_COLOR), cuts: picture.cuts, slope: 1.0 }
            }
            PictureUse::Normals | PictureUse::Parameter => {
                Derived { image: picture.as_numbers(), cuts: picture.cuts, slope: 1.0 }
            }
            PictureUse::Opacity => {
                let picture = picture.with_opacity();
                Derived { cuts: picture.cuts, image: picture.image, slope: 1.0 }
            }
            PictureUse::Heights => {
                let (picture, slope) = picture.with_normals();
                Derived { image: picture.as_numbers(), cuts: false, slope }
            }
        };
        if !Arc::ptr_eq(&derived.image, &picture.image) {
            derived.image = self.within_memory(path, derived.image)?;
        }
        let image = Arc::clone(&derived.image);
        self.derived.insert(key, derived);
        Ok(image)
    }

    /// Returns `image`, in pages if it does not fit into the memory for textures.
    fn within_memory(&mut self, path: &Path, image: Arc<Image>) -> Result<Arc<Image>, SceneError> {
        let whole = self.memory.whole + image.bytes();
        if image.pager().is_none() && whole <= self.memory.bytes / 2 {
            self.memory.whole = whole;
            return Ok(image);
        }
        let fault = |error: io::Error| {
            let remedy =
                "make room where temporary files are (TMPDIR), or state more texture_memory in [render]";
            SceneError::new(
                path,
                format!("the texture does not fit into the file of textures: {error}; {remedy}"),
            )
        };
        let pager = match &self.pager {
            Some(pager) => pager,
            None => self.pager.insert(Pager::new().map_err(fault)?),
        };
        pager.set_budget(self.memory.bytes / 2);
        image.paged(pager).map(Arc::new).map_err(fault)
    }

    /// Has textures take so many bytes at most.
    pub fn set_memory(&mut self, bytes: u64) {
        self.memory.bytes = bytes;
    }

    /// Size and texels of a picture.
    ///
    /// # Errors Those of [`index_at`](Self::index_at).
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
                decode_bytes(bytes, name)
            }
            Content::Unreadable(why) => {
                self.embedded.insert(path.clone());
                Err(Unusable::AsItIs(why.into()))
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
        let finest = picture.image.finest();
        self.digests.push(Digest::of_table(finest.width, finest.texels.bytes()));
        let image = self.within_memory(&path, Arc::clone(&picture.image))?;
        let picture = Decoded { image, ..picture };
        self.decoded.insert(path, picture.clone());
        Ok(picture)
    }

    /// The picture that is known by a path.
    #[cfg(feature = "usd")]
    pub fn known(&self, path: &Path) -> Option<Decoded> {
        self.decoded.get(path).cloned()
    }

    /// Keeps a picture that was made of others, by a path that no file has.
    #[cfg(feature = "usd")]
    pub fn keep(&mut self, path: PathBuf, picture: Decoded) -> Decoded {
        self.embedded.insert(path.clone());
        self.decoded.insert(path, picture.clone());
        picture
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
        self.derived(index).is_some_and(|derived| derived.cuts)
    }

    /// The picture that texture number `index` shows, as it was made.
    fn derived(&self, index: u32) -> Option<&Derived> {
        let image = &self.textures[index as usize].image;
        self.derived.values().find(|derived| Arc::ptr_eq(&derived.image, image))
    }

    /// Returns true if a checker stands in for texture number `index`.
    pub fn is_stand_in(&self, index: u32) -> bool {
        self.stand_ins.contains(&self.textures[index as usize].path)
    }

    /// The normal map that texture number `index` is, with this factor on its slopes, unless it is a stand-in.
    pub fn normal_map(&self, index: u32, slope: f32) -> Option<NormalMap> {
        let of_picture = self.derived(index).map_or(1.0, |derived| derived.slope);
        (!self.is_stand_in(index)).then_some(NormalMap { map: index, slope: slope * of_picture })
    }

    /// Returns true if the alpha of texture number `index` is below `least` anywhere.
    pub fn falls_below(&self, index: u32, least: f32) -> bool {
        let texels = self.textures[index as usize].texels();
        (0..texels.count()).any(|texel| texels.get(texel).alpha() / 255.0 < least)
    }

    /// Index of a texture: the same for equal ones.
    pub fn place(&mut self, texture: Texture) -> u32 {
        let Mapping { linear, offset, wrap, uvs, is_nearest } = texture.mapping;
        let [ux, uy, vx, vy] = linear.to_cols_array();
        let placed = [ux, uy, vx, vy, offset.x, offset.y].map(f32::to_bits);
        let key = (Arc::as_ptr(&texture.image).addr(), placed, wrap, uvs, is_nearest);
        *self.indices.entry(key).or_insert_with(|| {
            self.textures.push(texture);
            (self.textures.len() - 1) as u32
        })
    }
}
