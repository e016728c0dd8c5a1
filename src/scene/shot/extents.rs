//! Extents of a shot's models.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::{model, quadric};
use crate::scene::keys::ModelTable;
use crate::scene::keys::toml_text::{At, TomlText};
use crate::scene::render_space::Extent;
use crate::scene::{Mesh, Model, SceneError};

/// Maximum distance of models from the origin, in the units of the files.
const FARTHEST: f64 = 1e18;

/// Extent of all models as they stand at a frame, in the space of the files.
pub fn at_frame(models: &[Model], bounds: &MeshBounds, frame: i32) -> Extent {
    models.iter().filter(|model| counts(models, model)).fold(Extent::NONE, |all, model| {
        all.with_model_at(bounds[&Arc::as_ptr(&model.mesh)], &model.track, frame.into())
    })
}

/// Boxes around meshes, object space, by the meshes' addresses: models may share one.
pub type MeshBounds = HashMap<*const Mesh, (DVec3, DVec3)>;

/// Computes the boxes around the meshes of `models`.
pub fn bounds_of_meshes(models: &[Model]) -> MeshBounds {
    let mut bounds = HashMap::new();
    for model in models {
        bounds.entry(Arc::as_ptr(&model.mesh)).or_insert_with(|| model.mesh.bounds());
    }
    bounds
}

/// Returns true if a model counts for the size of the shot: planes have no size, and count only if there is
/// nothing else.
fn counts(models: &[Model], model: &Model) -> bool {
    !quadric::is_endless(model) || models.iter().all(quadric::is_endless)
}

/// Extent of all models at all their keys, in the space of the files.
///
/// # Errors With the table of a model that reaches too far.
pub fn over_time(
    text: TomlText<'_>,
    tables: &[&At<ModelTable>],
    models: &[Model],
    bounds: &MeshBounds,
) -> Result<Extent, SceneError> {
    let mut all = Extent::NONE;
    for (table, model) in tables.iter().zip(models) {
        let bounds = bounds[&Arc::as_ptr(&model.mesh)];
        if Extent::NONE.with_model(bounds, &model.track).reach() > FARTHEST {
            let message = "moved and scaled like this the model reaches too far from the origin (1e18)";
            return Err(text.fault(model::place_of(table), message));
        }
        if counts(models, model) {
            all = all.with_model(bounds, &model.track);
        }
    }
    Ok(all)
}
