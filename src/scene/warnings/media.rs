//! Warns of media that are not where they were meant to be: in meshes without an inside, or beside surfaces.

use std::path::Path;

use glam::Vec3;

use crate::media::{MediaOfShot, Unbounded};
use crate::scene::{Light, LightKind, Scene, SceneError, Warning};

/// Warnings about the shot at `path`.
pub fn warnings(path: &Path, scene: &Scene) -> Vec<Warning> {
    let told = |message: String| Warning(SceneError::new(path, message));
    let mut warnings = Vec::new();
    if scene.has_media() {
        for Unbounded { model, material, fault } in MediaOfShot::unbounded(scene) {
            warnings.push(told(format!(
                "the medium `{material}` is left out in the model `{model}`: {fault}, and what is inside is not known; close its \
                 mesh, with all faces the same way round, or use [fog]"
            )));
        }
    }
    if scene.fog.is_some_and(|fog| fog.extinction() != Vec3::ZERO) {
        let far = scene.environment.is_some() || scene.lights.iter().any(is_far);
        warnings.extend(far.then(|| {
            told(String::from(
                "no light of skies and suns comes through [fog], which is without end; put fog into a box: a closed mesh of a \
                 material with `volume_scatter` and `surface = false`",
            ))
        }));
    }
    for model in scene.models.iter().filter(|model| model.mesh.details.volume.is_some()) {
        let material =
            model.mesh.material_of.first().map(|material| &scene.materials[usize::from(*material)]);
        if let Some(material) = material {
            let name = (&model.name, &material.name);
            if material.has_surface {
                warnings.push(told(format!(
                    "the volume `{}` is shown as a box, as its material `{}` has a surface; write `surface = false` there",
                    name.0, name.1
                )));
            }
            if material.medium.is_none_or(|medium| medium.is_clear()) {
                warnings.push(told(format!(
                    "nothing of the volume `{}` is seen, as its material `{}` has no medium; write `volume_scatter`, `volume_absorb` or \
                     `volume_emit` there",
                    name.0, name.1
                )));
            }
        }
    }
    for model in &scene.models {
        let of = |material: &u16| &scene.materials[usize::from(*material)];
        let shown = model.mesh.material_of.iter().map(of).any(|material| material.has_surface);
        let alone = model.mesh.material_of.iter().map(of).find(|material| !material.has_surface);
        if let Some(alone) = alone.filter(|_| shown) {
            warnings.push(told(format!(
                "the material `{}` has no surface, but is a part of the model `{}`, which has others: its surface is shown; put \
                 it into a model of its own",
                alone.name, model.name
            )));
        }
    }
    warnings
}

/// Returns true if a light is at infinity.
fn is_far(light: &Light) -> bool {
    matches!(light.kind, LightKind::Directional { .. } | LightKind::Sun { .. })
}
