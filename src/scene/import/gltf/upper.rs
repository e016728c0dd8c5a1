//! What is above the layer of a material of a glTF file: clear coats (KHR_materials_clearcoat) and fuzz (KHR_materials_sheen).

use glam::{DVec3, Vec3};
use serde::Deserialize;

use super::document::{Document, extension};
use super::json::{Material as Json, TextureInfo};
use super::reading::Reading;
use crate::scene::SceneError;
use crate::scene::import::surfaces::spread::as_open_pbr;
use crate::scene::surface::{Parameter, Surface, Value};

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Clearcoat {
    clearcoat_factor: f64,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: f64,
    clearcoat_roughness_texture: Option<TextureInfo>,
    clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Sheen {
    sheen_color_factor: [f64; 3],
    sheen_color_texture: Option<TextureInfo>,
    sheen_roughness_factor: f64,
    sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Anisotropy {
    anisotropy_strength: f64,
    anisotropy_rotation: f64,
    anisotropy_texture: Option<TextureInfo>,
}

/// Least width of a lobe whose shape is asked for.
const LEAST_WIDTH: f64 = 1e-4;

impl Reading<'_> {
    /// Sets what is above the layer of a surface, and how that spreads light.
    ///
    /// # Errors An extension that makes no sense; those of its pictures.
    pub(super) fn set_upper(&mut self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        self.set_coat(json, surface)?;
        self.set_fuzz(json, surface)?;
        self.set_anisotropy(json, surface)
    }

    /// Fuzz: that of glTF is another model of the same (Estevez and Kulla, 2017), whose roughness is alike.
    fn set_fuzz(&mut self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        let sheen: Option<Sheen> = extension(self.document, &json.extensions, "KHR_materials_sheen")?;
        let Some(sheen) = sheen.filter(|sheen| sheen.sheen_color_factor != [0.0; 3]) else { return Ok(()) };
        if sheen.sheen_color_texture.is_some() {
            self.document
                .leave_out("textures of the colour of sheen (KHR_materials_sheen) count by their means");
        }
        if sheen.sheen_roughness_texture.is_some() {
            self.document.leave_out("textures of the roughness of sheen (KHR_materials_sheen) are not used: the factor counts all over a material");
        }
        let tint = match &sheen.sheen_color_texture {
            Some(info) => self.mean(info)?,
            None => DVec3::ONE,
        };
        let color = DVec3::from(sheen.sheen_color_factor) * tint;
        surface[Parameter::FuzzWeight] = Value::ONE;
        surface[Parameter::FuzzColor] = color.as_vec3().clamp(Vec3::ZERO, Vec3::ONE).into();
        surface[Parameter::FuzzRoughness] = (sheen.sheen_roughness_factor as f32).into();
        Ok(())
    }

    /// Anisotropy, and the roughness that goes with it.
    fn set_anisotropy(&self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        let read: Option<Anisotropy> =
            extension(self.document, &json.extensions, "KHR_materials_anisotropy")?;
        let Some(read) = read.filter(|read| read.anisotropy_strength > 0.0) else { return Ok(()) };
        if read.anisotropy_texture.is_some() {
            self.document.leave_out(
                "textures of anisotropy are not used: strength and rotation count all over a material",
            );
        }
        let roughness = f64::from(surface[Parameter::SpecularRoughness].factor.x);
        let (across, strength) = (roughness * roughness, read.anisotropy_strength.min(1.0));
        let along = across + (1.0 - across) * strength * strength;
        let (amount, roughness) = as_open_pbr([along.max(LEAST_WIDTH), across.max(LEAST_WIDTH)]);
        surface[Parameter::SpecularRoughness] = (roughness as f32).into();
        surface[Parameter::SpecularRoughnessAnisotropy] = (amount as f32).into();
        surface.beyond.tangent_turn = read.anisotropy_rotation.to_degrees() as f32;
        Ok(())
    }

    /// Clear coat.
    fn set_coat(&mut self, json: &Json, surface: &mut Surface) -> Result<(), SceneError> {
        let Some(coat) = clearcoat(self.document, json)? else { return Ok(()) };
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
        surface[Parameter::CoatWeight] = (factor as f32).into();
        surface[Parameter::CoatRoughness] = (roughness as f32).into();
        Ok(())
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
