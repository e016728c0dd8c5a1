//! Curves that a program has in memory.

use std::path::Path;
use std::sync::Arc;

use super::build::Built;
use super::meshes::{GivenMesh, NAME};
use crate::digest::Digest;
use crate::scene::SceneError;
use crate::scene::import::Import;
use crate::scene::import::curves::{self, CurveSet};
use crate::scene::import::faces::are_within_reach;

/// Checks that all numbers of curves fit together.
///
/// # Errors The first thing that does not, and what to do.
pub fn check(name: &str, set: &CurveSet) -> Result<(), String> {
    let in_curves = |what: String| Err(format!("curves `{name}`: {what}"));
    if set.points.is_empty() || set.counts.is_empty() {
        return in_curves(String::from("there are none: leave them out"));
    }
    if let Err(what) = set.check() {
        return in_curves(what);
    }
    let own = [(None, &set.points, &set.radii)].into_iter();
    let shapes = set.shapes.iter().map(|shape| (Some(shape.frame), &shape.points, &shape.radii));
    for (frame, points, radii) in own.chain(shapes) {
        let at = frame.map_or(String::new(), |frame| format!(" at frame {frame}"));
        if !are_within_reach(points) {
            return in_curves(format!("a point{at} is not finite, or farther than 1e18 from the origin"));
        }
        if radii.iter().any(|radius| !(0.0..=1e18).contains(radius)) {
            return in_curves(format!("a radius{at} is below 0, not finite, or above 1e18"));
        }
    }
    let lists = [
        ("normals", set.normals.as_flattened()),
        ("colors", set.colors.as_flattened()),
        ("uv", bytemuck::cast_slice(&set.uvs)),
    ];
    match lists.into_iter().find(|(_, numbers)| numbers.iter().any(|number| !number.is_finite())) {
        Some((what, _)) => in_curves(format!("`{what}` has a number that is not finite")),
        None => Ok(()),
    }
}

/// Makes the mesh of curves, and the track of its shapes; `None`, which is told, where no curve can be drawn.
///
/// # Errors In a strict load, that no curve can be drawn.
pub fn built(
    import: &mut Import,
    given: &GivenMesh,
    set: &CurveSet,
    material: u16,
) -> Result<Built, SceneError> {
    let bytes: [&[u8]; 3] = [
        bytemuck::cast_slice(&set.points),
        bytemuck::cast_slice(&set.radii),
        bytemuck::cast_slice(&set.counts),
    ];
    let shapes = set.shapes.iter().map(|shape| bytemuck::cast_slice(&shape.points));
    bytes.into_iter().chain(shapes).map(Digest::new).for_each(|digest| import.inputs.depend_on(digest));
    match curves::mesh_of(import, Path::new(NAME), set, (None, None), material) {
        Ok((mesh, shapes)) => Ok(Some((Arc::new(mesh), shapes))),
        Err(error) => {
            let message = format!("curves `{}`: {}", given.name, error.message);
            import.findings.stand_in(SceneError::new(NAME, message))?;
            Ok(None)
        }
    }
}
