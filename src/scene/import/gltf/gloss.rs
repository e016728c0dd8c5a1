//! Materials of KHR_materials_pbrSpecularGlossiness, which older files have in place of metal and roughness.
//!
//! They state the colours of the diffuse and of the mirrored light apart. A metal mirrors in its own colour and is dark otherwise;
//! everything else mirrors little, and without a colour. The share of metal that explains both best is that of the conversion in the
//! extension's own examples.

use std::borrow::Cow;

use glam::DVec3;
use serde_json::{Value, json};

use super::document::extension;
use super::json::Material;
use super::reading::Reading;
use super::stated_gloss::{Gloss, NAME};
use crate::scene::SceneError;

/// Share of the light that what is no metal mirrors, seen head on.
const DIELECTRIC: f64 = 0.04;

/// Least share for which a colour is divided by it.
const LEAST: f64 = 1e-6;

impl Reading<'_> {
    /// The material in terms of metal and roughness.
    ///
    /// # Errors Those of its pictures.
    pub(super) fn as_metal_rough<'j>(
        &mut self,
        material: &'j Material,
    ) -> Result<Cow<'j, Material>, SceneError> {
        let Some(gloss) = extension::<Gloss>(self.document, &material.extensions, NAME)? else {
            return Ok(Cow::Borrowed(material));
        };
        let numbers =
            [&gloss.diffuse_factor[..], &gloss.specular_factor, &[gloss.glossiness_factor]].concat();
        if !numbers.iter().all(|number| *number >= 0.0 && number.is_finite()) {
            let message =
                format!("`{NAME}` has a value that is negative or not finite: export the file again");
            return Err(self.document.fault(message));
        }
        let of_texture = match &gloss.diffuse_texture {
            Some(info) => self.mean(info)?,
            None => DVec3::ONE,
        };
        let (mut specular, mut smooth) = (DVec3::from(gloss.specular_factor), gloss.glossiness_factor);
        if let Some(info) = &gloss.specular_glossiness_texture {
            self.document.leave_out(
                "pictures of specular colour and glossiness (KHR_materials_pbrSpecularGlossiness) count by their means",
            );
            let [red, green, blue, alpha] = self.mean_and_alpha(info)?;
            specular *= DVec3::new(red, green, blue);
            smooth *= alpha;
        }
        let [red, green, blue, alpha] = gloss.diffuse_factor;
        let diffuse = DVec3::new(red, green, blue) * of_texture;
        let (base, metallic) = metal_of(diffuse.min(DVec3::ONE), specular.min(DVec3::ONE));
        let factor = (base / of_texture.max(DVec3::splat(LEAST))).min(DVec3::ONE);
        let mut own = material.clone();
        let pbr = &mut own.pbr_metallic_roughness;
        pbr.base_color_factor = [factor.x, factor.y, factor.z, alpha];
        (pbr.metallic_factor, pbr.roughness_factor) = (metallic, (1.0 - smooth).clamp(0.0, 1.0));
        let mirrored = specular.element_sum() / 3.0;
        if mirrored < DIELECTRIC {
            let name = String::from("KHR_materials_specular");
            own.extensions.insert(name, json!({ "specularFactor": Value::from(mirrored / DIELECTRIC) }));
        }
        Ok(Cow::Owned(own))
    }
}

/// Base colour and share of metal of a surface with these colours of diffuse and mirrored light.
fn metal_of(diffuse: DVec3, specular: DVec3) -> (DVec3, f64) {
    let left = 1.0 - specular.max_element();
    // as bright as it looks: R. Finley, "HSP Color Model" (2006)
    let bright = |color: DVec3| (color * color).dot(DVec3::new(0.299, 0.587, 0.114)).sqrt();
    let (dull, shiny) = (bright(diffuse), bright(specular));
    let metallic = if shiny < DIELECTRIC {
        0.0
    } else {
        // both are mixtures of what a metal and another surface of one base colour show: that colour is left out
        let (a, c) = (DIELECTRIC, DIELECTRIC - shiny);
        let b = dull * left / (1.0 - DIELECTRIC) + shiny - 2.0 * DIELECTRIC;
        ((-b + (b * b - 4.0 * a * c).max(0.0).sqrt()) / (2.0 * a)).clamp(0.0, 1.0)
    };
    let of_diffuse = diffuse * (left / (1.0 - DIELECTRIC) / (1.0 - metallic).max(LEAST));
    let of_specular = (specular - DIELECTRIC * (1.0 - metallic)) / metallic.max(LEAST);
    let base = of_diffuse.lerp(of_specular, metallic * metallic);
    (base.clamp(DVec3::ZERO, DVec3::ONE), metallic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gold_is_a_metal_and_paint_is_none() {
        let gold = DVec3::new(1.0, 0.77, 0.34);
        let (base, metallic) = metal_of(DVec3::ZERO, gold);
        assert!(metallic > 0.99 && base.distance(gold) < 0.02, "{metallic} {base}");
        let paint = DVec3::new(0.8, 0.1, 0.1);
        let (base, metallic) = metal_of(paint, DVec3::splat(0.04));
        assert!(metallic < 1e-6 && base.distance(paint) < 1e-6, "{metallic} {base}");
        assert_eq!(metal_of(DVec3::ONE, DVec3::ZERO).1, 0.0);
    }
}
