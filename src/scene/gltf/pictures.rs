//! Pictures of glTF files: beside the file, or in it.

use std::path::PathBuf;

use glam::DVec3;
use serde_json::Value;

use super::document::Document;
use super::json::{Texture, TextureInfo};
use super::uri::Uri;
use crate::scene::model::assemble::Assembly;
use crate::scene::model::decoded::Decoded;
use crate::scene::model::pictures::{Content, PictureUse, Wanted};
use crate::scene::{SceneError, texture};

/// Number of the image that a texture shows.
pub fn image_of(document: &Document, texture: &Texture, number: usize) -> Result<usize, SceneError> {
    let webp = texture.extensions.get("EXT_texture_webp").and_then(|webp| webp.get("source"));
    let webp = webp.and_then(Value::as_u64).map(|source| source as usize);
    webp.or(texture.source).ok_or_else(|| {
        let message = "has no picture that can be read: export it with PNG or JPEG pictures";
        document.fault(format!("texture {number} {message}"))
    })
}

impl Assembly {
    /// Reads an image of a file. Returns the path by which it is known, and its texels.
    ///
    /// # Errors An image that is nowhere, or outside of the file's folder; in a strict load also one that is missing or unreadable.
    pub(super) fn image(
        &mut self,
        document: &Document,
        number: usize,
        used: PictureUse,
    ) -> Result<(PathBuf, Decoded), SceneError> {
        let image = document.get(&document.json.images, number, "image")?;
        let fault = |what: String| document.fault(format!("image {number} {what}"));
        let mut known = document.path.clone().into_os_string();
        known.push(format!("#image {number}"));
        let (known, label) = (PathBuf::from(known), format!("image {number}"));
        let name = image.name.as_ref().map_or(label.clone(), |name| format!("{name} ({label})"));
        let asking = document.path.as_path();
        let wanted = |path, content, name| Wanted { path, content, name, asking, line: None, used };
        let data;
        let uri = image.uri.as_deref().map(Uri::read).transpose().map_err(fault)?;
        let (pictures, findings) = (&mut self.pictures, &mut self.findings);
        let (path, decoded) = match (uri, image.buffer_view) {
            (Some(Uri::File(file)), _) => {
                let (place, found) = document.beside(&file);
                let path = found.clone().unwrap_or(place);
                let content = Content::File(found.as_deref());
                (path.clone(), pictures.decoded(wanted(path, content, &file), findings)?)
            }
            (Some(Uri::Data(bytes)), _) => {
                data = bytes;
                (known.clone(), pictures.decoded(wanted(known, Content::Bytes(&data), &name), findings)?)
            }
            (None, Some(view)) => {
                let (_, bytes) = document.view(view)?;
                (known.clone(), pictures.decoded(wanted(known, Content::Bytes(bytes), &name), findings)?)
            }
            (None, None) => return Err(fault(String::from("has no bytes: export the file again"))),
        };
        Ok((path, decoded))
    }

    /// The mean of a texture's numbers, each from 0 to 1.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn mean_numbers(
        &mut self,
        document: &Document,
        info: &TextureInfo,
    ) -> Result<DVec3, SceneError> {
        self.mean_of(document, info, |byte| f64::from(byte) / 255.0)
    }

    /// The mean of the colours of a texture's texels, linear RGB.
    ///
    /// # Errors Those of [`image`](Self::image).
    pub(super) fn mean(&mut self, document: &Document, info: &TextureInfo) -> Result<DVec3, SceneError> {
        self.mean_of(document, info, |byte| f64::from(texture::linear(byte)))
    }

    fn mean_of(
        &mut self,
        document: &Document,
        info: &TextureInfo,
        value: impl Fn(u8) -> f64,
    ) -> Result<DVec3, SceneError> {
        let texture = document.get(&document.json.textures, info.index, "texture")?;
        let image = image_of(document, texture, info.index)?;
        let (_, decoded) = self.image(document, image, PictureUse::Color)?;
        Ok(DVec3::from_slice(&decoded.means(|_, byte| value(byte))))
    }
}
