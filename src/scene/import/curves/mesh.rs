//! Meshes of curves: round ones are curves, flat ones strips of triangles.

use std::path::Path;
use std::sync::Arc;

use super::ribbons;
use super::set::{BuiltCurves, CurveSet, Keys};
use crate::animation::ShapeTrack;
use crate::scene::details::Details;
use crate::scene::import::Import;
use crate::scene::material::Optics;
use crate::scene::{Geometry, Mesh, SceneError};

/// Makes the mesh of curves of one material, and notes what was left out. Returns, too, the track of its shapes, if they deform; `again`: see
/// [`ShapeTrack::through`].
///
/// # Errors Those of [`CurveSet::build`], in `path`.
pub(in crate::scene) fn mesh_of(
    import: &mut Import,
    path: &Path,
    set: &CurveSet,
    (tolerance, again): (Option<f64>, Option<f64>),
    material: u16,
) -> Result<(Mesh, Option<ShapeTrack>), SceneError> {
    if !set.normals.is_empty() {
        let (mesh, track, left_out) = ribbons::mesh_of(import, set, (tolerance, again), material)
            .map_err(|what| SceneError::new(path, what))?;
        left_out.into_iter().for_each(|what| import.findings.note(SceneError::new(path, what)));
        return Ok((mesh, track));
    }
    let BuiltCurves { curves, colors, left_out, keys } =
        set.build(tolerance).map_err(|what| SceneError::new(path, what))?;
    for what in left_out {
        import.findings.note(SceneError::new(path, what));
    }
    if !colors.is_empty() {
        import.surfaces.color_vertices(material);
    }
    let of = &import.surfaces.materials[usize::from(material)];
    if matches!(of.optics, Optics::Glass { .. }) {
        let message = format!(
            "curves of the material `{}` bend light where it enters them, and not where it leaves them: what is to look like glass must be a mesh",
            of.name
        );
        import.findings.note(SceneError::new(path, message));
    }
    let casts_shadow = import.surfaces.casts_shadow(material);
    let mesh = Mesh::plain(Geometry::Curved(Arc::new(curves)), material, casts_shadow);
    let details = Arc::new(Details { colors, ..Details::default() });
    Ok((import.arranger().with_details(Mesh { details, ..mesh }, &[]), track_of(keys, again)))
}

/// The track of curves with these keys; none if they have one shape. `again`: see [`ShapeTrack::through`].
fn track_of(keys: Keys, again: Option<f64>) -> Option<ShapeTrack> {
    let deforms = keys.iter().any(|(_, number)| *number != 0);
    deforms.then(|| ShapeTrack::through(keys, again)).flatten()
}
