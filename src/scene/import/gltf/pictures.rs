//! Pictures of glTF files: beside the file, or in it.

use std::path::PathBuf;

use glam::DVec3;
use serde_json::Value;

use super::document::Document;
use super::json::{Texture, TextureInfo};
use super::reading::Reading;
use super::uri::Uri;
use crate::scene::import::pictures::decoded::Decoded;
use crate::scene::import::pictures::{Content, PictureUse, Wanted};
use crate::scene::{SceneError, texture};

/// Number of the image that a texture shows. `None` if it has none that can be read.
fn image_of(texture: &Texture) -> Option<usize> {
    let webp = texture.extensions.get("EXT_texture_webp").and_then(|webp| webp.get("source"));
    webp.and_then(Value::as_u64).map(|source| source as usize).or(texture.source)
}

impl Reading<'_> {
    /// Reads the picture that a texture shows. Returns the path by which it is known, and its texels.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn picture_of(
        &mut self,
        info: &TextureInfo,
        used: PictureUse,
    ) -> Result<(PathBuf, Decoded), SceneError> {
        let texture = self.document.get(&self.document.json.textures, info.index, "texture")?;
        if let Some(image) = image_of(texture) {
            return self.image(image, used);
        }
        let why = if texture.extensions.contains_key("KHR_texture_basisu") {
            "is packed with KHR_texture_basisu, which cannot be unpacked here: export it as PNG or JPEG"
        } else {
            "has no picture that can be read: export it as PNG or JPEG"
        };
        let (path, name) =
            (known_as(self.document, "texture", info.index), format!("texture {}", info.index));
        let asking = self.document.path.as_path();
        let content = Content::Unreadable(why);
        let wanted = Wanted { path: path.clone(), content, name: &name, asking, line: None, used };
        Ok((path, self.import.pictures.decoded(wanted, &mut self.import.findings)?))
    }

    /// Reads an image of a file. Returns the path by which it is known, and its texels.
    ///
    /// # Errors An image that is nowhere, or outside of the file's folder; in a strict load also one that is missing or unreadable.
    pub(super) fn image(
        &mut self,
        number: usize,
        used: PictureUse,
    ) -> Result<(PathBuf, Decoded), SceneError> {
        let image = self.document.get(&self.document.json.images, number, "image")?;
        let fault = |what: String| self.document.fault(format!("image {number} {what}"));
        let (known, label) = (known_as(self.document, "image", number), format!("image {number}"));
        let name = image.name.as_ref().map_or(label.clone(), |name| format!("{name} ({label})"));
        let asking = self.document.path.as_path();
        let wanted = |path, content, name| Wanted { path, content, name, asking, line: None, used };
        let data;
        let uri = image.uri.as_deref().map(Uri::read).transpose().map_err(fault)?;
        let (pictures, findings) = (&mut self.import.pictures, &mut self.import.findings);
        let (path, decoded) = match (uri, image.buffer_view) {
            (Some(Uri::File(file)), _) => {
                let (place, found) = self.document.beside(&file);
                let path = found.clone().unwrap_or(place);
                let content = Content::File(found.as_deref());
                (path.clone(), pictures.decoded(wanted(path, content, &file), findings)?)
            }
            (Some(Uri::Data(bytes)), _) => {
                data = bytes;
                (known.clone(), pictures.decoded(wanted(known, Content::Bytes(&data), &name), findings)?)
            }
            (None, Some(view)) => {
                let (_, bytes) = self.document.view(view)?;
                (known.clone(), pictures.decoded(wanted(known, Content::Bytes(bytes), &name), findings)?)
            }
            (None, None) => return Err(fault(String::from("has no bytes: export the file again"))),
        };
        Ok((path, decoded))
    }

    /// The mean of a texture's numbers, each from 0 to 1.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn mean_numbers(&mut self, info: &TextureInfo) -> Result<DVec3, SceneError> {
        let means = self.means_of(info, |_, byte| f64::from(byte) / 255.0)?;
        Ok(DVec3::from_slice(&means))
    }

    /// The mean of the colours of a texture's texels, linear RGB.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn mean(&mut self, info: &TextureInfo) -> Result<DVec3, SceneError> {
        Ok(DVec3::from_slice(&self.mean_and_alpha(info)?))
    }

    /// The mean of the colours of a texture's texels, linear RGB, and that of their alphas.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn mean_and_alpha(&mut self, info: &TextureInfo) -> Result<[f64; 4], SceneError> {
        const ALPHA: usize = 3;
        self.means_of(info, |channel, byte| match channel {
            ALPHA => f64::from(byte) / 255.0,
            _ => f64::from(texture::linear(byte)),
        })
    }

    fn means_of(
        &mut self,
        info: &TextureInfo,
        value: impl Fn(usize, u8) -> f64,
    ) -> Result<[f64; 4], SceneError> {
        let (_, decoded) = self.picture_of(info, PictureUse::Color)?;
        Ok(decoded.means(value))
    }
}

/// Path by which the part of a file with this number is known.
fn known_as(document: &Document, what: &str, number: usize) -> PathBuf {
    let mut known = document.path.clone().into_os_string();
    known.push(format!("#{what} {number}"));
    PathBuf::from(known)
}
