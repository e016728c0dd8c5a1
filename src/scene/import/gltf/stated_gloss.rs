//! What KHR_materials_pbrSpecularGlossiness states of a material.

use serde::Deserialize;

use super::json::{Json, MetallicRoughness, TextureInfo};

/// Name of the extension.
pub const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

/// The extension.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Gloss {
    pub diffuse_factor: [f64; 4],
    pub diffuse_texture: Option<TextureInfo>,
    pub specular_factor: [f64; 3],
    pub glossiness_factor: f64,
    /// Colours of the mirrored light, and smoothness in alpha.
    pub specular_glossiness_texture: Option<TextureInfo>,
}

impl Default for Gloss {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// Gives materials with the extension its diffuse colour as base colour, which has the same texture, alpha and coordinates.
///
/// # Errors An extension that makes no sense. The text is a whole sentence.
pub fn state_base_colors(json: &mut Json) -> Result<(), String> {
    for material in &mut json.materials {
        let Some(value) = material.extensions.get(NAME) else { continue };
        let gloss = Gloss::deserialize(value).map_err(|error| {
            format!("the extension `{NAME}` makes no sense ({error}): it is damaged; export the file again")
        })?;
        material.pbr_metallic_roughness = MetallicRoughness {
            base_color_factor: gloss.diffuse_factor,
            base_color_texture: gloss.diffuse_texture,
            metallic_factor: 0.0,
            roughness_factor: 1.0 - gloss.glossiness_factor,
            metallic_roughness_texture: None,
        };
    }
    Ok(())
}
