//! Clear coats of glTF files (KHR_materials_clearcoat).

use serde::Deserialize;

use super::document::{Document, extension};
use super::json::{Material as Json, TextureInfo};
use super::reading::Reading;
use crate::scene::SceneError;
use crate::scene::import::statements::coat::StatedCoat;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Clearcoat {
    clearcoat_factor: f64,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: f64,
    clearcoat_roughness_texture: Option<TextureInfo>,
    clearcoat_normal_texture: Option<TextureInfo>,
}

impl Reading<'_> {
    /// The coat of a material, if it has one.
    ///
    /// # Errors An extension that makes no sense; those of its pictures.
    pub(super) fn coat(&mut self, json: &Json) -> Result<StatedCoat, SceneError> {
        let Some(coat) = clearcoat(self.document, json)? else { return Ok(StatedCoat::default()) };
        let textures = [&coat.clearcoat_texture, &coat.clearcoat_roughness_texture];
        if textures.into_iter().any(Option::is_some) {
            self.document.leave_out("textures of clearcoats (KHR_materials_clearcoat) count by their means");
        }
        if coat.clearcoat_normal_texture.is_some() {
            self.document.leave_out(
                "normal maps of clearcoats (clearcoatNormalTexture) are not used: a coat has the normals of its surface",
            );
        }
        let [of_coat, of_roughness] = textures.map(Option::as_ref);
        let factor = self.mean_of_channel(of_coat, 0)? * coat.clearcoat_factor.clamp(0.0, 1.0);
        let roughness = self.mean_of_channel(of_roughness, 1)? * coat.clearcoat_roughness_factor;
        Ok(StatedCoat {
            weight: Some(factor as f32),
            roughness: Some(roughness as f32),
            ..StatedCoat::default()
        })
    }

    /// Mean of a channel of a texture; 1 without one.
    fn mean_of_channel(&mut self, info: Option<&TextureInfo>, channel: usize) -> Result<f64, SceneError> {
        info.map_or(Ok(1.0), |info| Ok(self.mean_numbers(info)?[channel]))
    }
}

/// Notes that the coat of a material that is glass has no effect.
///
/// # Errors An extension that makes no sense.
pub fn note_coat_of_glass(document: &Document, json: &Json) -> Result<(), SceneError> {
    if clearcoat(document, json)?.is_some() {
        document.leave_out(
            "clearcoats of glass (KHR_materials_clearcoat) are not used: glass reflects by its index alone",
        );
    }
    Ok(())
}

fn clearcoat(document: &Document, json: &Json) -> Result<Option<Clearcoat>, SceneError> {
    let coat: Option<Clearcoat> = extension(document, &json.extensions, "KHR_materials_clearcoat")?;
    Ok(coat.filter(|coat| coat.clearcoat_factor > 0.0))
}
